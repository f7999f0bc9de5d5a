"""Arc-length continuation: corrector with kept factors, tolerance, points of a circle through its folds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from wroll_fem.dynamics.periodic.harmonic_balance import BAND_SCALE
from wroll_fem.numerics import continuation
from wroll_fem.numerics.continuation import LARGE, StepControl, correct, follow
from wroll_fem.typing import FloatArray


class Circle:
    """Unit circle with a linear equation beside it: y^2 + p^2 = 1 and 3 x - y = 0; unknowns (x, y, p)."""

    zero = -np.inf

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


class Resonance:
    """Damped oscillator with the unknowns and scales of a response curve: motion over its size at 1 % damping."""

    def __init__(self, damping_ratio: float, low: float, high: float) -> None:
        self.zeta, self.low, self.per_unit = damping_ratio, low, (high - low) / BAND_SCALE
        self.zero = -low / self.per_unit

    def _matrix(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Dynamic stiffness (2, 2) for the natural frequency 1, and its derivative with respect to p."""
        w = self.low + z[-1] * self.per_unit
        damping, slope = 2.0 * self.zeta * w, 2.0 * self.zeta
        matrix = np.array([[1.0 - w**2, damping], [-damping, 1.0 - w**2]])
        return matrix, np.array([[-2.0 * w, slope], [-slope, -2.0 * w]]) * self.per_unit

    def residual(self, z: FloatArray) -> FloatArray:
        return self._matrix(z)[0] @ z[:2] - np.array([0.04, 0.0])

    def jacobian(self, z: FloatArray) -> FloatArray:
        matrix, slope = self._matrix(z)
        return np.column_stack([matrix, slope @ z[:2]])

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


def test_points_keep_their_factors_up_to_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    start, control = np.array([0.2, 0.6, -0.8]), StepControl(largest=0.2, chord=0.02, keeps=True)
    points = follow(Circle(), start, 0.8, control)
    assert points[0].factors is None
    assert all(p.factors is not None for p in points[1:])
    for p in points[1:]:  # the tangent is that of the factors
        tangent = p.factors.solve(ROW)
        np.testing.assert_allclose(tangent / np.linalg.norm(tangent), p.tangent, atol=1e-12)
    monkeypatch.setattr(continuation, "KEPT_BYTES", 3.5 * points[1].factors.bytes)
    few = follow(Circle(), start, 0.8, control)
    assert [p.factors is not None for p in few] == [1 <= k <= 3 for k in range(len(few))]
    assert not any(p.factors for p in follow(Circle(), start, 0.8, replace(control, keeps=False)))


def test_large_problems_get_more_iterations() -> None:
    control = StepControl()
    assert control.suited_to(LARGE - 1) == control
    large = control.suited_to(LARGE)
    assert large.usual > control.usual
    assert large.max_iterations > control.max_iterations
    assert large.tolerance == control.tolerance


@pytest.mark.parametrize("factor", [1.0, 2.5])
def test_no_resonance_is_passed_over(factor: float) -> None:
    """Bands of 0.05 to 3 times the resonance frequency, damping ratios of 0.2 to 5 %; 120 oscillators, seed 5."""
    rng, counts = np.random.default_rng(5), []
    for _ in range(120):
        zeta, width = np.exp(rng.uniform(np.log([0.002, 0.05]), np.log([0.05, 3.0])))
        low = 1.0 - rng.uniform(0.05, 0.95) * min(width, 1.0)
        problem = Resonance(zeta, low, low + width)
        start = np.append(np.linalg.solve(problem._matrix(np.zeros(3))[0], [0.04, 0.0]), 0.0)
        points = follow(problem, start, BAND_SCALE, StepControl().longer(factor))
        highest = max(float(np.linalg.norm(p.z[:2])) for p in points)
        assert highest > 0.6 * 0.04 / (2.0 * zeta)
        counts.append(len(points))
    assert np.mean(counts) < 70 / factor**0.5


def test_a_rough_curve_has_a_rough_tolerance() -> None:
    control = StepControl()
    assert control.longer(1.0) == control
    assert control.longer(2.0).tolerance == 100.0 * control.tolerance
