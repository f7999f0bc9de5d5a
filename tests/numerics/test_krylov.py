"""GMRES for arrays of any shape."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.numerics.krylov import gmres
from wroll_fem.typing import FloatArray


@pytest.fixture
def matrix() -> FloatArray:
    """Well-conditioned, not symmetric, (60, 60)."""
    return np.eye(60) + 0.04 * np.random.default_rng(0).normal(size=(60, 60))


def test_gmres_solves_for_arrays_to_its_tolerance(matrix: FloatArray) -> None:
    b = np.random.default_rng(1).normal(size=(20, 3))

    def apply(z: FloatArray) -> FloatArray:
        assert z.shape == b.shape
        return (matrix @ z.ravel()).reshape(z.shape)

    exact = np.linalg.solve(matrix, b.ravel()).reshape(b.shape)
    np.testing.assert_allclose(gmres(apply, b, tolerance=1e-12, iterations=60), exact, rtol=0, atol=1e-10)
    loose = gmres(apply, b, tolerance=1e-2, iterations=60)
    assert 1e-6 < np.linalg.norm(apply(loose) - b) / np.linalg.norm(b) <= 1e-2


def test_gmres_minimises_the_residual_over_the_krylov_space(matrix: FloatArray) -> None:
    b = np.random.default_rng(2).normal(size=60)
    space = np.column_stack([b, matrix @ b, matrix @ (matrix @ b)])
    best = space @ np.linalg.lstsq(matrix @ space, b, rcond=None)[0]
    found = gmres(lambda z: matrix @ z, b, tolerance=1e-14, iterations=3)
    np.testing.assert_allclose(found, best, rtol=0, atol=1e-12)


def test_gmres_of_a_zero_right_side_is_zero() -> None:
    np.testing.assert_array_equal(gmres(lambda z: 2.0 * z, np.zeros((4, 2)), tolerance=1e-3, iterations=5), 0.0)


def test_the_residual_never_grows_even_where_the_map_is_nearly_singular() -> None:
    """Identity with four directions 1e13 times larger: the loss of orthogonality must not spoil the solution."""
    rng = np.random.default_rng(1)
    matrix = np.eye(150) + 1e13 * rng.normal(size=(150, 4)) @ rng.normal(size=(4, 150))
    b = rng.normal(size=150)
    found = gmres(lambda z: matrix @ z, b, tolerance=1e-3, iterations=80)
    assert np.linalg.norm(matrix @ found - b) < np.linalg.norm(b)
