"""Damped Newton iteration that reuses the factorised Jacobian, and the thresholds at which each solver renews it.

A solver keeps its factorised matrix from one iteration to the next. It factorises a new one if the residual after an
iteration, divided by the residual before, exceeds the renewal threshold. The more expensive a factorisation is relative
to an iteration, the larger is the best threshold. The threshold changes converged results only within the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from wroll_fem.typing import FloatArray

FULL_RENEWAL = 0.1
"""Ratio of successive residuals above which a time step of the full model factorises a new matrix (sparse)."""
STATIC_RENEWAL = 0.1
"""Ratio of successive residuals above which a static step of the full model factorises a new matrix (sparse)."""
CONDENSED_RENEWAL = 0.3
"""Ratio of successive residuals above which a condensed time step factorises a new matrix (dense, for the
points that slip)."""
SLIDING_RENEWAL = 0.15
"""The same for a matrix that starts from the compliance without tangential springs, which is smaller."""
REDUCED_RENEWAL = 0.12
"""Ratio of successive residuals above which a reduced time step factorises a new matrix (small and dense)."""
CHORD_RENEWAL = 0.25
"""Ratio of successive residuals above which the corrector of a continuation factorises a new Jacobian (dense)."""

STALLED = 6
"""Number of iterations. If the residual is not halved during them and the equations have a potential, `zero_slope`
damps the following steps."""

PATIENCE = 6
"""Factor by which the largest number of iterations is multiplied if `zero_slope` damps the steps. Many iterations are
then needed, because only few contact points change state in each of them."""

NO_RENEWAL = 0.0
"""Renewal threshold of a full Newton iteration: a new matrix is factorised in every iteration."""


class NewtonProblem(Protocol):
    """Equations r(x) = 0. `residual` may store the trial state of ``x``, because its last call is at the solution."""

    def residual(self, x: FloatArray) -> tuple[FloatArray, float]:
        """Residual r at ``x`` and a scalar measure of its size."""
        ...

    def linearise(self, x: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """Function that solves J(x) step = r for the step; `linearise` is called directly after ``residual(x)``."""
        ...

    def converged(self, size: float, previous: float) -> bool:
        """Whether the residual measure ``size`` is small enough; ``previous`` is its value one iteration earlier."""
        ...


LineSearch = Callable[[Callable[[float], float], float], float]
"""Function that returns the damping factor of a step. Arguments: function from damping factor to size of the residual;
current size of the residual."""

Slope = Callable[[FloatArray, FloatArray], float]
"""Function that returns the slope of a potential at a point against a step. Arguments: step, residual at the point."""


def gradient_slope(step: FloatArray, r: FloatArray) -> float:
    """Slope of the potential whose gradient is the residual ``r``, against ``step``."""
    return float(step @ r)


def best_of_halvings(
    size_at: Callable[[float], float], size: float, *, most: int = 8, least_gain: float = 0.1
) -> float:
    """First damping factor d of 1, 1/2, 1/4, ... that reduces the residual by more than the fraction ``least_gain`` d.

    If none of the first ``most`` factors does, the one with the smallest residual.
    """
    damping, best = 1.0, (float("inf"), 0.0)
    for _ in range(most):
        found = size_at(damping)
        best = min(best, (found, damping), key=lambda pair: pair[0])
        if found < (1.0 - least_gain * damping) * size:
            break
        damping *= 0.5
    return best[1]


def first_decrease(size_at: Callable[[float], float], size: float, *, least: float = 0.01) -> float:
    """First damping factor of 1, 1/2, 1/4, ... above ``least`` that reduces the residual.

    If none of them does, the next factor of the sequence, without a trial.
    """
    damping = 1.0
    while damping > least and not size_at(damping) < size:
        damping *= 0.5
    return damping


def zero_slope(slope_at: Callable[[float], float], slope: float, *, most: int = 12, share: float = 0.1) -> float:
    """Damping factor, at most 1, at which the slope of a potential along a step is approximately zero.

    Parameters
    ----------
    slope_at
        Function from the damping to the scalar product of residual and step at x - damping step. This is the slope of
        the potential, because the residual is the gradient of the potential.
    slope
        Slope at damping 0, positive. A convex potential has one zero of the slope; the full step is taken if it
        ends before this zero.
    most
        Largest number of iterations of the false position.
    share
        Largest magnitude of the slope that counts as zero, relative to ``slope``.
    """
    low, high = (0.0, slope), (1.0, slope_at(1.0))
    damping, side = high[0], 0
    if high[1] >= 0.0:
        return damping
    for _ in range(most):
        damping = low[0] + (high[0] - low[0]) * low[1] / (low[1] - high[1])
        found = slope_at(damping)
        if abs(found) <= share * slope:
            break
        # Illinois variant of the false position: the slope at the end that stays is halved
        if found > 0.0:
            low = (damping, found)
            high = (high[0], 0.5 * high[1]) if side > 0 else high
            side = 1
        else:
            high = (damping, found)
            low = (low[0], 0.5 * low[1]) if side < 0 else low
            side = -1
    return damping


def damped_newton(
    problem: NewtonProblem, x: FloatArray, *, max_iterations: int, search: LineSearch, renewal: float,
    slope: Slope | None = None,
) -> tuple[FloatArray | None, list[float]]:  # fmt: skip
    """Solve r(x) = 0 by Newton's method with a reused factorisation; only steps with a new factorisation are damped.

    Parameters
    ----------
    problem
        Equations.
    x
        (n,) initial guess.
    max_iterations
        Largest number of iterations.
    search
        Line search for the steps with a new factorisation.
    renewal
        Renewal threshold, see the module.
    slope
        Slope of a convex potential against a step, if the equations have one (apart from the dependence of friction on
        a varying pressure); `gradient_slope` if the residual is its gradient. Steps are then damped by `zero_slope`
        once the norm of the residual stalls. This norm need not decrease on the way to the minimum, for example where
        all points reach the friction limit together.

    Returns
    -------
    (n,) solution, or None without convergence, and the size of the residual in each iteration
    """
    r, size = problem.residual(x)
    history, previous = [size], float("inf")
    solve: Callable[[FloatArray], FloatArray] | None = None
    best, since, descends = size, 0, False
    for count in range(PATIENCE * max_iterations):
        if problem.converged(size, previous):
            return x, history
        if count >= max_iterations and not descends:
            break
        since = 0 if size < 0.5 * best else since + 1
        best = min(best, size) if since == 0 else best
        descends = descends or (slope is not None and since >= STALLED)
        if descends:
            solve = None
        fresh = solve is None
        if solve is None:
            solve = problem.linearise(x)
        step, start = solve(r), x
        steep = slope(step, r) if descends and slope is not None else 0.0
        if slope is not None and steep > 0.0:
            damping = zero_slope(lambda share: slope(step, problem.residual(start - share * step)[0]), steep)  # noqa: B023
        else:
            damping = search(lambda share: problem.residual(start - share * step)[1], size) if fresh else 1.0  # noqa: B023
        trial = x - damping * step
        r_new, new = problem.residual(trial)
        if not new <= renewal * size:
            solve = None
            if not fresh and not new < size:  # the old factorisation failed: repeat from here with a new one
                r, size = problem.residual(x)
                continue
        x, r, previous, size = trial, r_new, size, new
        history.append(size)
    return None, history
