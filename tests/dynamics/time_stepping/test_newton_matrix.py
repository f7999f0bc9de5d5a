"""Newton's matrix of the condensed steps: solutions, and no subnormal numbers, which are slow on some processors."""

import numpy as np

from wroll_fem.dynamics.time_stepping.condensed_kernel import _factor
from wroll_fem.numerics import lu


def test_entries_that_symmetry_makes_zero_are_zero() -> None:
    """Two groups of points that a roll decouples by symmetry: rounding leaves 1e-40 of the couplings."""
    rng, n = np.random.default_rng(3), 20
    stiffness, tiny = 1.0, np.finfo(np.float32).tiny
    compliance = rng.normal(size=(3 * n, 3 * n))
    compliance = compliance @ compliance.T / (200.0 * n * stiffness)
    group = np.r_[np.repeat(np.arange(n) % 2, 2), np.arange(n) % 2]
    apart = group[:, None] != group
    compliance[apart] *= 1e-37
    single, springs = compliance.astype(np.float32), np.full(3 * n, stiffness)
    tangent = np.zeros((n, 3, 3))  # all points slide or are open, with a rest of stiffness from rounding
    tangent[:, 0, 0] = 1e-30 * stiffness
    active = np.arange(3 * n)
    factors = _factor(active, tangent, springs, single)
    size = np.abs(factors.matrix)
    assert np.mean((single[apart] != 0.0) & (np.abs(single[apart]) < tiny)) > 0.9
    assert not np.any((size > 0.0) & (size < tiny))
    right = rng.normal(size=3 * n)
    solution = right.astype(np.float32)
    lu.solve(factors.matrix, factors.pivots, solution)
    np.testing.assert_allclose(solution, np.linalg.solve(np.eye(3 * n) - stiffness * compliance, right), rtol=2e-4)
