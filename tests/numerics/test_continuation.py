"""Arc-length continuation: corrector with kept factors, tolerance, points of a circle through its folds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from wroll_fem.numerics.continuation import LARGE, StepControl, correct, follow
from wroll_fem.typing import FloatArray


class Circle:
    """Unit circle with a linear equation beside it: y^2 + p^2 = 1 and 3 x - y = 0; unknowns (x, y, p)."""

    def __init__(self) -> None:
        self.jacobians = 0

    def residual(self, z: FloatArray) -> FloatArray:
        return np.array([3.0 * z[0] - z[1], z[1] ** 2 + z[2] ** 2 - 1.0])

    def jacobian(self, z: FloatArray) -> FloatArray:
        self.jacobians += 1
        return np.array([[3.0, -1.0, 0.0], [0.0, 2.0 * z[1], 2.0 * z[2]]])

    def derivative(self, z: FloatArray) -> Callable[[FloatArray], FloatArray]:
        matrix = self.jacobian(z)
        return lambda v: matrix @ v

    def describe(self, z: FloatArray) -> str:
        return str(z)


ROW = np.array([0.0, 0.0, 1.0])


def test_kept_factors_are_corrected_by_the_steps() -> None:
    """The factors of a point far away, 20 % off: chord steps would gain a factor of 5 each, Broyden's gain more."""
    problem, control = Circle(), StepControl(tolerance=1e-10)
    near = correct(problem, np.array([0.3, 1.0, 0.0]), ROW, control)
    assert near.z is not None
    before = problem.jacobians
    found = correct(problem, np.array([0.33, 1.0, 0.6]), ROW, control, kept=near.factor)
    assert found.z is not None
    np.testing.assert_allclose(found.z, [0.8 / 3.0, 0.8, 0.6], rtol=1e-9)
    assert problem.jacobians == before
    assert len(found.history) <= 7
    assert np.linalg.norm(found.z - found.near) <= control.tolerance


def test_the_curve_passes_the_fold_of_a_circle() -> None:
    problem = Circle()
    points = follow(problem, np.array([0.2, 0.6, -0.8]), 0.8, StepControl(largest=0.2, chord=0.02))
    found = np.array([p.z for p in points])
    np.testing.assert_allclose(found[:, 1] ** 2 + found[:, 2] ** 2, 1.0, rtol=1e-6)
    assert found[-1, 2] == pytest.approx(0.8, abs=1e-9)
    # one factorisation per point for its tangent, and hardly any for the corrector
    assert problem.jacobians <= 1.4 * len(points)


def test_large_problems_get_more_iterations() -> None:
    control = StepControl()
    assert control.suited_to(LARGE - 1) == control
    large = control.suited_to(LARGE)
    assert large.usual > control.usual
    assert large.max_iterations > control.max_iterations
    assert large.tolerance == control.tolerance


def test_a_rough_curve_has_a_rough_tolerance() -> None:
    control = StepControl()
    assert control.longer(1.0) == control
    assert control.longer(2.0).tolerance == 100.0 * control.tolerance
