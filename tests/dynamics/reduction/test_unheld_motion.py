"""A basis with a motion that has no stiffness: an error with a remedy, not NaN."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wroll_fem.dynamics.reduction.reduced_model import ritz_vectors
from wroll_fem.errors import ConvergenceError


def structure_and_vectors(share: float) -> tuple[Any, np.ndarray]:
    """Ten modes, the first without stiffness, and four vectors with a ``share`` of it."""
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(10, 4))
    vectors[0] *= share
    return SimpleNamespace(eigenvalues=np.concatenate([[0.0], 10.0 ** rng.uniform(0.0, 4.0, 9)])), vectors


@pytest.mark.parametrize("share", [0.0, 1.0, 1e3])
def test_a_small_share_of_it_leaves_the_basis_orthonormal(share: float) -> None:
    basis, _ = ritz_vectors(*structure_and_vectors(share))
    np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-12)


@pytest.mark.parametrize("share", [1e9, 1e12, 1e16, 1e20])
def test_a_share_whose_mass_hides_the_other_motions_is_told(share: float) -> None:
    with pytest.raises(ConvergenceError, match="no reduced model found for a motion without stiffness") as error:
        ritz_vectors(*structure_and_vectors(share))
    assert "hold every body" in error.value.advice
