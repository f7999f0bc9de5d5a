"""Damped Newton iteration with kept factors."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from wroll_fem.numerics.newton import NO_RENEWAL, best_of_halvings, damped_newton, first_decrease
from wroll_fem.typing import FloatArray


class Scalar:
    """f(x) = 0 of one unknown; counts the factors, and keeps the last x evaluated."""

    def __init__(self, f: Callable[[float], float], slope: Callable[[float], float], limit: float = 1e-12):
        self.f, self.slope, self.limit = f, slope, limit
        self.factors, self.last = 0, np.nan

    def residual(self, x: FloatArray) -> tuple[FloatArray, float]:
        self.last = float(x[0])
        value = np.array([self.f(self.last)])
        return value, float(abs(value[0]))

    def linearise(self, x: FloatArray) -> Callable[[FloatArray], FloatArray]:
        assert self.last == x[0]  # the trial state is that of x
        self.factors += 1
        slope = self.slope(float(x[0]))
        return lambda r: r / slope

    def converged(self, size: float, previous: float) -> bool:
        return size <= self.limit


SEARCHES = pytest.mark.parametrize("search", [best_of_halvings, first_decrease])


@SEARCHES
def test_damping_finds_the_root_that_full_steps_miss(search) -> None:
    """Full Newton steps on arctan diverge from |x| > 1.39."""
    problem = Scalar(np.arctan, lambda x: 1.0 / (1.0 + x * x))
    x, history = damped_newton(problem, np.array([10.0]), max_iterations=30, search=search, renewal=NO_RENEWAL)
    assert x is not None
    assert abs(x[0]) < 1e-12
    assert problem.last == x[0]  # the last evaluation is that of the solution
    assert all(b < a for a, b in pairwise(history))


def test_a_factor_is_kept_while_it_pays() -> None:
    """sqrt(2) from 1.5: with a renewal rate of one half one factor does, without keeping each iteration has its own."""
    found = {}
    for renewal in (0.5, NO_RENEWAL):
        problem = Scalar(lambda x: x * x - 2.0, lambda x: 2.0 * x)
        x, history = damped_newton(
            problem, np.array([1.5]), max_iterations=40, search=best_of_halvings, renewal=renewal
        )
        assert x is not None
        assert x[0] == pytest.approx(np.sqrt(2.0), rel=1e-12)
        found[renewal] = problem.factors, len(history)
    assert found[0.5][0] == 1
    assert found[NO_RENEWAL][0] == found[NO_RENEWAL][1] - 1
    assert found[0.5][1] > found[NO_RENEWAL][1]


def test_a_kept_factor_that_fails_is_renewed_where_it_failed() -> None:
    """A slope that is far too small behind a kink: the step of the kept factor overshoots and is taken back."""
    problem = Scalar(lambda x: x - 2.0 if x < 1.0 else 50.0 * (x - 1.0) - 1.0, lambda x: 1.0 if x < 1.0 else 50.0)
    x, history = damped_newton(problem, np.array([-5.0]), max_iterations=40, search=first_decrease, renewal=0.99)
    assert x is not None
    assert x[0] == pytest.approx(1.02, rel=1e-12)
    assert problem.factors > 1
    assert all(b < a for a, b in pairwise(history))


@SEARCHES
def test_no_root_is_reported_with_the_history(search) -> None:
    problem = Scalar(lambda x: x * x + 1.0, lambda x: 2.0 * x if x else 1.0)
    x, history = damped_newton(problem, np.array([3.0]), max_iterations=12, search=search, renewal=0.1)
    assert x is None
    assert min(history) >= 1.0
    assert len(history) > 2
