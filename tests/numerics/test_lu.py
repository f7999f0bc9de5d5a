"""LU factors in compiled loops against numpy's solver."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.numerics import lu


@pytest.mark.parametrize("size", [0, 1, 2, 7, 64, 65, 300])
def test_solution_is_that_of_numpy(size: int) -> None:
    rng = np.random.default_rng(size)
    matrix = rng.standard_normal((size, size)) + 3.0 * np.eye(size)[rng.permutation(size)]
    right = rng.standard_normal((2, size))
    factors = matrix.astype(np.float32)
    pivots = lu.factor(factors)
    for b in right:
        x = b.astype(np.float32)
        lu.solve(factors, pivots, x)
        expected = np.linalg.solve(matrix, b)
        allowed = 1e-6 * max(float(np.linalg.cond(matrix)), 1.0) if size else 0.0
        assert np.linalg.norm(x - expected) <= allowed * np.linalg.norm(expected)


def test_rows_are_exchanged() -> None:
    factors = np.array([[0, 2, 0], [0, 0, 4], [8, 0, 0]], np.float32)
    x = np.array([2, 4, 8], np.float32)
    pivots = lu.factor(factors)
    lu.solve(factors, pivots, x)
    np.testing.assert_array_equal(x, [1, 1, 1])


def test_a_singular_matrix_gives_no_finite_solution() -> None:
    factors = np.ones((3, 3), np.float32)
    x = np.array([1, 2, 3], np.float32)
    pivots = lu.factor(factors)
    lu.solve(factors, pivots, x)
    assert not np.isfinite(x).all()
