"""Bordered equations of a curve: GMRES with older factors against dense solutions, and when factors are renewed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from wroll_fem.numerics import bordered
from wroll_fem.numerics.bordered import NEWTON, Bordered, newton_step, tangent_at
from wroll_fem.numerics.continuation import StepControl, follow
from wroll_fem.typing import FloatArray

COUNT = 700


class Springs:
    """Unknowns y with stiffnesses that a parameter p changes: (1 + p a) y + c tanh(y) = f + p g."""

    zero = -np.inf

    def __init__(self, *, sudden: float = 0.0) -> None:
        rng = np.random.default_rng(3)
        self.change = rng.uniform(-0.2, 0.2, COUNT)
        self.coupling = 0.3 * rng.standard_normal((COUNT, COUNT)) / np.sqrt(COUNT)
        self.load, self.growth = rng.standard_normal((2, COUNT))
        self.change[0] -= sudden  # of one spring, whose stiffness becomes negative if this is large
        self.jacobians = 0

    def residual(self, z: FloatArray) -> FloatArray:
        y, p = z[:-1], z[-1]
        return np.asarray((1.0 + p * self.change) * y + self.coupling @ np.tanh(y) - self.load - p * self.growth)

    def _matrix(self, z: FloatArray) -> FloatArray:
        y, p = z[:-1], z[-1]
        inner = np.diag(1.0 + p * self.change) + self.coupling / np.cosh(y) ** 2
        return np.column_stack([inner, self.change * y - self.growth])

    def jacobian(self, z: FloatArray) -> FloatArray:
        self.jacobians += 1
        return self._matrix(z)

    def derivative(self, z: FloatArray) -> Callable[[FloatArray], FloatArray]:
        matrix = self._matrix(z)
        return lambda v: matrix @ v

    def describe(self, z: FloatArray) -> str:
        return f"p = {z[-1]:.3g}"


LAST = np.eye(COUNT + 1)[-1]


def test_a_newton_step_with_factors_of_a_near_point_needs_no_others() -> None:
    problem, rng = Springs(), np.random.default_rng(4)
    z = rng.standard_normal(COUNT + 1)
    kept = Bordered(problem.jacobian(z), LAST)
    beside, row = z + 1.0, LAST + 0.01 * rng.standard_normal(COUNT + 1)
    step, factors, renewed = newton_step(problem, beside, row, problem.residual(beside), kept)
    assert factors is kept
    assert not renewed
    assert problem.jacobians == 1
    whole = np.vstack([problem._matrix(beside), row])
    rhs = np.append(-problem.residual(beside), 0.0)
    assert np.linalg.norm(whole @ step - rhs) <= NEWTON * np.linalg.norm(rhs)
    # the kept factors alone are worse than this
    assert np.linalg.norm(whole @ kept.solve(rhs) - rhs) > NEWTON * np.linalg.norm(rhs)


def test_factors_that_do_not_help_are_renewed() -> None:
    problem, rng = Springs(), np.random.default_rng(5)
    z = rng.standard_normal(COUNT + 1)
    useless = Bordered(rng.standard_normal((COUNT, COUNT + 1)), LAST)
    step, factors, renewed = newton_step(problem, z, LAST, problem.residual(z), useless)
    assert renewed
    assert factors is not useless
    expected = np.linalg.solve(np.vstack([problem._matrix(z), LAST]), np.append(-problem.residual(z), 0.0))
    np.testing.assert_allclose(step, expected, atol=1e-9 * np.abs(expected).max())


def test_the_tangent_with_kept_factors_is_that_of_a_factorisation() -> None:
    problem, z = Springs(), np.random.default_rng(6).standard_normal(COUNT + 1)
    kept = Bordered(problem.jacobian(z), LAST)
    expected, _, sign = tangent_at(problem, z + 0.1, LAST, None)
    before = problem.jacobians
    tangent, factors, same = tangent_at(problem, z + 0.1, LAST, kept)
    assert factors is kept
    assert problem.jacobians == before
    assert same == sign
    np.testing.assert_allclose(tangent, expected, atol=3e-4)


def test_a_change_of_sign_of_the_determinant_renews_the_factors() -> None:
    """A spring of stiffness 1 - 5 p is negative at p = 0.5; the kept factors have the sign of p = 0."""
    problem = Springs(sudden=5.0)
    z = np.append(np.random.default_rng(7).standard_normal(COUNT), 0.0)
    _, kept, positive = tangent_at(problem, z, LAST, None)
    z[-1] = 0.5
    expected = np.sign(np.linalg.slogdet(np.vstack([problem._matrix(z), LAST]))[0])
    assert expected == -positive
    _, factors, sign = tangent_at(problem, z, LAST, kept)
    assert factors is not kept
    assert sign == expected


def test_a_curve_is_the_same_with_few_factorisations(monkeypatch: pytest.MonkeyPatch) -> None:
    start = np.append(np.zeros(COUNT), 0.0)
    control, curves, counts = StepControl(largest=0.1), [], []
    for fewest in (0, 10**6):
        monkeypatch.setattr(bordered, "FEWEST", fewest)
        problem = Springs()
        for _ in range(40):
            start[:-1] -= np.linalg.solve(problem._matrix(start)[:, :-1], problem.residual(start))
        problem.jacobians = 0
        points = follow(problem, start, 1.0, control)
        assert all(p.regular for p in points)
        assert max(np.abs(problem.residual(p.z)).max() for p in points) < 1e-7
        curves.append(points[-1].z)
        counts.append(problem.jacobians / len(points))
    np.testing.assert_allclose(curves[0], curves[1], atol=1e-6)
    assert counts[0] < 0.5
    assert counts[1] >= 1.0
