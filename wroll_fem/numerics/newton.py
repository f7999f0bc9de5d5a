"""Damped Newton iteration with kept factors, and the renewal rates of all solvers.

A solver keeps its factored matrix and renews it after an iteration that leaves more than a fraction of the residual:
the renewal rate. The more a factorisation costs relative to an iteration, the larger the best rate. The rate changes
converged results only within the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from wroll_fem.typing import FloatArray

FULL_RENEWAL = 0.1
"""Renewal rate of a time step of the whole structure (sparse factor)."""
STATIC_RENEWAL = 0.1
"""Renewal rate of a static step of the whole structure (sparse factor)."""
CONDENSED_RENEWAL = 0.3
"""Renewal rate of a condensed time step (dense factor of the points that slip)."""
REDUCED_RENEWAL = 0.12
"""Renewal rate of a reduced time step (small dense matrix, updated point by point)."""
CHORD_RENEWAL = 0.25
"""Renewal rate of the corrector of a continuation (dense Jacobian of the harmonic balance)."""

STALLED = 6
"""Iterations without a halving of the residual after which a solve with a potential follows its slope."""

PATIENCE = 6
"""Factor on the number of iterations of a solve that follows the slope: points change their state a few at a time."""

NO_RENEWAL = 0.0
"""Renewal rate of a solver that factors a new matrix in every iteration."""


class NewtonProblem(Protocol):
    """Equations r(x) = 0. An evaluation may store its trial state; the last evaluation is at the result."""

    def residual(self, x: FloatArray) -> tuple[FloatArray, float]:
        """Residual r at ``x`` and a scalar measure of its size."""
        ...

    def linearise(self, x: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """Function that solves J(x) step = r; called directly after ``residual(x)``."""
        ...

    def converged(self, size: float, previous: float) -> bool:
        """Whether a residual of ``size`` is small enough; ``previous`` is the size one iteration earlier."""
        ...


LineSearch = Callable[[Callable[[float], float], float], float]
"""Maps the function size(damping) of the residual and its present size to the damping factor of a step."""


def best_of_halvings(
    size_at: Callable[[float], float], size: float, *, most: int = 8, least_gain: float = 0.1
) -> float:
    """First d of 1, 1/2, 1/4, ... that reduces the residual by a fraction ``least_gain`` d, else the best d."""
    damping, best = 1.0, (float("inf"), 0.0)
    for _ in range(most):
        found = size_at(damping)
        best = min(best, (found, damping), key=lambda pair: pair[0])
        if found < (1.0 - least_gain * damping) * size:
            break
        damping *= 0.5
    return best[1]


def first_decrease(size_at: Callable[[float], float], size: float, *, least: float = 0.01) -> float:
    """First damping factor 1, 1/2, 1/4, ... above ``least`` that reduces the residual, else the next one, untried."""
    damping = 1.0
    while damping > least and not size_at(damping) < size:
        damping *= 0.5
    return damping


def zero_slope(slope_at: Callable[[float], float], slope: float, *, most: int = 12, share: float = 0.1) -> float:
    """Damping factor at which the slope of a potential along a step has fallen to ``share`` of its start, or is zero.

    Parameters
    ----------
    slope_at
        Residual times step at x - damping step: the slope of the potential whose gradient the residual is.
    slope
        Its value at damping 0, positive. Convex potentials have one zero; the full step is taken before it.
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
        # Illinois variant of the false position: the end that stays is weighted down
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
    potential: bool = False,
) -> tuple[FloatArray | None, list[float]]:  # fmt: skip
    """Solve r(x) = 0 by Newton's method with kept factors; only steps with a new factor are damped.

    Parameters
    ----------
    problem
        Equations.
    x
        (n,) initial guess.
    max_iterations
        Largest number of iterations.
    search
        Line search for the steps with a new factor.
    renewal
        Renewal rate of the factor.
    potential
        Whether the residual is, but for the dependence of friction on a varying pressure, the gradient of a convex
        potential. Steps then follow `zero_slope` once the norm of the residual stalls: it need not fall on the way to
        the minimum, for example where all points reach the limit of friction together.

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
        descends = descends or (potential and since >= STALLED)
        if descends:
            solve = None
        fresh = solve is None
        if solve is None:
            solve = problem.linearise(x)
        step, start = solve(r), x
        slope = float(step @ r)
        if descends and slope > 0.0:
            damping = zero_slope(lambda share: float(step @ problem.residual(start - share * step)[0]), slope)  # noqa: B023
        else:
            damping = search(lambda share: problem.residual(start - share * step)[1], size) if fresh else 1.0  # noqa: B023
        trial = x - damping * step
        r_new, new = problem.residual(trial)
        if not new <= renewal * size:
            solve = None
            if not fresh and not new < size:  # the kept factor failed: again from here with a new one
                r, size = problem.residual(x)
                continue
        x, r, previous, size = trial, r_new, size, new
        history.append(size)
    return None, history
