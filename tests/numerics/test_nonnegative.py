"""Sparse nonnegative least squares: against scipy, early end, positive combinations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from wroll_fem.numerics.nonnegative import sparse_nonnegative


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_without_early_end_the_factors_are_those_of_scipy(seed: int) -> None:
    """1e-6: the ridge on the normal equations."""
    random = np.random.default_rng(seed)
    matrix, target = random.normal(size=(40, 25)), random.normal(size=40)
    expected, _ = nnls(matrix, target)
    assert (expected == 0.0).any()
    np.testing.assert_allclose(sparse_nonnegative(matrix, target, 0.0), expected, atol=1e-6)


def test_it_ends_at_the_tolerance_with_few_columns() -> None:
    """A sum of 300 smooth columns, of which few are independent."""
    places = np.linspace(0.0, 1.0, 300)
    matrix = np.cos(np.outer(np.arange(30), places)) * (1.0 + places)
    target = matrix.sum(axis=1)
    factors = sparse_nonnegative(matrix, target, 1e-3)
    assert (factors >= 0.0).all()
    assert np.linalg.norm(matrix @ factors - target) <= 1e-3 * np.linalg.norm(target)
    assert 0 < np.count_nonzero(factors) < 30


def test_a_target_that_no_column_helps_has_factors_of_zero() -> None:
    assert not sparse_nonnegative(np.eye(3), -np.ones(3), 0.1).any()


def test_it_goes_on_until_each_equation_with_a_limit_is_met() -> None:
    """Four equations out of thirty have to be met to 1e-6, with a loose tolerance of the norm."""
    places = np.linspace(0.0, 1.0, 300)
    matrix = np.cos(np.outer(np.arange(30), places)) * (1.0 + places)
    target = matrix.sum(axis=1)
    limits = np.full(30, np.inf)
    limits[:4] = 1e-6 * np.abs(target[:4]).max()
    loose, close = (
        np.abs(matrix @ sparse_nonnegative(matrix, target, 0.1, given) - target) for given in (np.inf, limits)
    )
    assert (close[:4] <= limits[:4]).all()
    assert (loose[:4] > limits[:4]).any()
