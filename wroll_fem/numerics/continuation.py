"""Arc-length continuation past folds: tangent predictor, Newton corrector, adaptive steps.

The problem is F(z) = 0 with n equations for n + 1 unknowns z = (y, p); the curve parameter p is the last. The
problem scales its unknowns so that unit steps of y and of p are of equal importance.

References
----------
Allgower, Georg (1990), Numerical Continuation Methods, chapters 2 and 6, doi:10.1007/978-3-642-61257-2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.bordered import Bordered, CurveProblem, newton_step, tangent_at
from wroll_fem.numerics.newton import CHORD_RENEWAL
from wroll_fem.typing import FloatArray


@dataclass(frozen=True)
class StepControl:
    """Step control of the continuation; step lengths are measured in the scaled unknowns z.

    Attributes
    ----------
    first, smallest, largest : step lengths along the arc; ``largest`` is multiplied by the norm of y if this
        norm is above 1
    ratio : largest change of the physical parameter in one step, relative to its value. A longer step could pass over
        a narrow resonance, because the tangent is nearly the same on both sides of it.
    angle : target rotation of the tangent per step, rad
    blunt : step length up to which a step is accepted at any rotation (the onset of slip is a kink); multiplied by the
        norm of y if this norm is above 1
    tolerance : largest Newton correction at convergence
    usual : number of corrector iterations that leaves the step length unchanged; more iterations shorten the next step.
        Where points slip or open, every step passes kinks that cost iterations.
    max_iterations : largest number of corrector iterations; a step that needs more is shortened
    max_points : largest number of points on a curve; beyond it the continuation stops with an error
    chord : target distance between the end of a step and the tangent, relative to the norm of y; near or below it a
        step is accepted at any rotation
    renewal : ratio of successive residuals above which the corrector factorises a new Jacobian
    keeps : whether the points of a curve keep their LU factors, up to `KEPT_BYTES`
    """

    first: float = 0.05
    smallest: float = 1e-4
    largest: float = 0.3
    ratio: float = 0.3
    angle: float = 0.2
    blunt: float = 0.01
    tolerance: float = 1e-7
    usual: float = 7.0
    max_iterations: int = 12
    max_points: int = 1000
    chord: float = 0.01
    renewal: float = CHORD_RENEWAL
    keeps: bool = False

    def longer(self, factor: float) -> StepControl:
        """Control with ``factor`` times longer steps and a looser tolerance, for approximate curves (1: no change).

        ``ratio`` becomes smaller: a step may then turn the tangent by a larger angle, and between two points far from
        a resonance, on both sides of it, the tangent turns by less.
        """
        return replace(
            self, first=factor * self.first, largest=factor * self.largest, ratio=self.ratio / factor,
            angle=factor * self.angle, chord=factor**2 * self.chord,
            tolerance=(ROUGH if factor > 1.0 else 1.0) * self.tolerance,
        )  # fmt: skip

    def suited_to(self, unknowns: int) -> StepControl:
        """Control for a problem with a number of ``unknowns``: from `LARGE` on, more iterations for longer steps.

        The factorisation at every point costs as much as tens of iterations there.
        """
        if unknowns < LARGE:
            return self
        return replace(self, usual=MORE * self.usual, max_iterations=MORE * self.max_iterations)


@dataclass(frozen=True)
class CurvePoint:
    """Point of a curve: solution z (n + 1,), unit tangent (n + 1,), number of Newton iterations, bifurcation flag.

    ``regular`` is False beyond a bifurcation that the curve has crossed (the determinant of the bordered Jacobian has
    changed its sign). The last entry of the tangent changes its sign at each fold. ``factors`` are the LU factors with
    which the tangent was solved, if they are kept (`StepControl`).
    """

    z: FloatArray
    tangent: FloatArray
    iterations: int
    regular: bool
    factors: Bordered | None = None


ROUGH = 100.0
"""Factor on the tolerance, for curves and motions that are only approximate."""
LARGE, MORE = 800, 2
"""Number of unknowns of a large problem, and the factor by which it multiplies the numbers of iterations."""
LEAPS = (0.5, 1.0, 2.0, 4.0)
"""Step lengths, relative to `StepControl.first`, that are tried in turn after the smallest step has failed."""
KEPT_BYTES = 1e8
"""Largest memory of the LU factors that the points of a curve keep."""
CREEPING = 150, 0.1
"""Number of points over which a curve must advance by the given distance, relative to the norm of y if this is above 1.
Otherwise it runs along kinks in the smallest steps, and ends."""
LEAST_STEP = 0.05
"""Damping factor at or below which a Newton step is taken even if it does not reduce the residual."""


class Corrected(NamedTuple):
    """Result of the corrector.

    Attributes
    ----------
    z : (n + 1,) solution; None without convergence
    history : norms of the corrections
    near : (n + 1,) last point at which the equations were evaluated; after convergence within the tolerance of z
    factor : last LU factors, which can be reused for the next solution nearby
    """

    z: FloatArray | None
    history: list[float]
    near: FloatArray
    factor: Bordered | None


def correct(
    problem: CurveProblem,
    z: FloatArray,
    row: FloatArray,
    control: StepControl,
    *,
    kept: Bordered | None = None,
    chord: bool = True,
) -> Corrected:
    """Solve F(z) = 0 and row . (z - start) = 0 by Newton's method with Broyden updates between factorisations.

    The LU factors are reused while the residual decreases fast. Until the next factorisation each full step updates
    them by Broyden's method. With many unknowns, Newton steps are solved by GMRES with older factors (`bordered`).

    Parameters
    ----------
    problem
        Equations.
    z
        (n + 1,) initial guess, the start.
    row
        (n + 1,) normal vector of the plane in which the solution is sought.
    control
        Tolerance and largest number of iterations.
    kept
        LU factors of an earlier point.
    chord
        Whether the first steps are solved with the ``kept`` factors alone. The plane of these factors then replaces the
        plane of ``row``.

    References
    ----------
    Kelley (1995), Iterative Methods for Linear and Nonlinear Equations, section 7.3, doi:10.1137/1.9781611970944.
    """
    history: list[float] = []
    steps: list[FloatArray] = []
    factors, chord, fresh = kept, chord and kept is not None, False
    residual = problem.residual(z)
    norm = float(np.linalg.norm(residual))
    for _ in range(control.max_iterations):
        if chord and factors is not None:
            step = _updated(-factors.solve(np.append(residual, 0.0)), steps)
        else:
            step, factors, chord = newton_step(problem, z, row, residual, factors)
            fresh, steps = True, []
        size = float(np.linalg.norm(step))
        history.append(size)
        if not np.isfinite(size):
            return Corrected(None, history, z, None)
        if size <= control.tolerance:
            return Corrected(z + step, history, z, factors)
        trial = problem.residual(z + step)
        new, stretch = float(np.linalg.norm(trial)), 1.0
        # slip, stick and opening make F piecewise smooth: a kept Jacobian may point elsewhere, full steps may alternate
        if not new < norm and not fresh:
            chord = False
            continue
        while stretch > LEAST_STEP and not new < norm:
            stretch *= 0.5
            trial = problem.residual(z + stretch * step)
            new = float(np.linalg.norm(trial))
        z, residual = z + stretch * step, trial
        steps.append(step)
        chord = chord and new <= control.renewal * norm and stretch == 1.0
        norm, fresh = new, False
    return Corrected(None, history, z, None)


def _updated(step: FloatArray, steps: list[FloatArray]) -> FloatArray:
    """Correct ``step`` (n + 1,), solved with old LU factors, by Broyden updates from the ``steps`` taken with them."""
    for before, after in pairwise(steps):
        step = step + after * (float(before @ step) / float(before @ before))
    if not steps:
        return step
    last = steps[-1]
    # the last step cut the residual to CHORD_RENEWAL or less, so the quotient is small; the bound prevents a reversal
    return step / max(1.0 - float(last @ step) / float(last @ last), LEAST_STEP)


def solve_at(problem: CurveProblem, z: FloatArray, control: StepControl) -> FloatArray:
    """Solve F(z) = 0 by damped Newton steps; the curve parameter keeps its value in the initial guess ``z`` (n + 1,).

    Raises
    ------
    ConvergenceError
        If the iteration does not converge; the error holds the residual history and, in ``last``, the last iterate.
    """
    row = np.zeros(len(z))
    row[-1] = 1.0
    many = StepControl(tolerance=control.tolerance, max_iterations=5 * control.max_iterations)
    solution, history, near, _ = correct(problem, z, row, many)
    if solution is None:
        failure = _stalled("no periodic motion found", problem.describe(z), history)
        failure.last = near
        raise failure
    return solution


def point_near(
    problem: CurveProblem, z: FloatArray, row: FloatArray, control: StepControl, *, regular: bool = True
) -> CurvePoint | None:
    """Point of a curve in the plane through ``z`` (n + 1,) with the unit normal ``row`` (n + 1,); None if not found.

    ``row`` gives the direction of the curve. ``regular`` is the flag of the neighbouring point.
    """
    solution, history, near, factors = correct(problem, z, row, control)
    if solution is None:
        return None
    return CurvePoint(solution, tangent_at(problem, near, row, factors)[0], len(history), regular)


def follow(
    problem: CurveProblem,
    start: FloatArray,
    end: float,
    control: StepControl,
    *,
    on_point: Callable[[list[CurvePoint]], None] | None = None,
    ends: Callable[[FloatArray], bool] | None = None,
) -> list[CurvePoint]:
    """Follow a curve from one of its points until the curve parameter reaches a given value.

    Parameters
    ----------
    problem
        Equations.
    start
        (n + 1,) solution at which the curve starts.
    end
        Value of the curve parameter at the end.
    control
        Step control.
    on_point
        Function called before each step with the points computed so far.
    ends
        Function that tells whether the curve ends at a solution (n + 1,) before its parameter has reached ``end``.

    Raises
    ------
    ConvergenceError
        If the steps become too small, the curve turns back past its start, or it has too many points. Its attribute
        ``partial`` contains the points computed so far (list of CurvePoint).
    """
    control = control.suited_to(len(start))
    direction = 1.0 if end >= start[-1] else -1.0
    border = np.zeros(len(start))
    border[-1] = direction
    tangent, factor, sign = tangent_at(problem, start, border, None)
    points = [CurvePoint(start, tangent, 0, True)]
    step, leaps = control.first, list(LEAPS)
    history: list[float] = []
    while direction * (end - points[-1].z[-1]) > 1e-12:
        if on_point is not None:
            on_point(points)
        last = points[-1]
        if ends is not None and ends(last.z):
            break
        size = float(np.linalg.norm(last.z[:-1]))
        long = max(1.0, size)
        step = min(step, control.largest * long, _reach(problem, last, control))
        found = _next(problem, last, step, end, border, factor, control)
        history = found.history
        if found.z is not None:
            tangent, factor, new_sign = tangent_at(problem, found.near, last.tangent, found.factor)
            turn = _turn(last, found.z, tangent)
            strays = 0.5 * turn * step / (control.chord * size) if size > 0.0 else np.inf
            if turn <= 1.6 * control.angle or strays <= 1.6 or step <= control.blunt * long or len(leaps) < len(LEAPS):
                kept = factor if control.keeps and len(points) * factor.bytes < KEPT_BYTES else None
                points.append(CurvePoint(found.z, tangent, len(history), new_sign == sign, kept))
                bend = max(control.angle / max(turn, 1e-6), np.sqrt(1.0 / max(strays, 1e-6)))
                growth = min(bend, np.sqrt(control.usual / len(history)))
                step, leaps = step * float(np.clip(growth, 0.4, 1.7)), list(LEAPS)
                if what := _lost(points, direction, long, control):
                    raise _with_points(_stalled(what, problem.describe(found.z), history), points)
                continue
            tangent, factor, _ = tangent_at(problem, last.z, last.tangent, factor)
        step *= 0.4
        if step < control.smallest or len(leaps) < len(LEAPS):
            # at a kink small steps may fail where a longer step passes over it
            if not leaps:
                what = "the curve could not be followed"
                raise _with_points(_stalled(what, problem.describe(last.z), history), points)
            step = leaps.pop(0) * control.first
    return points


def _turn(last: CurvePoint, z: FloatArray, tangent: FloatArray) -> float:
    """Largest angle, rad, between the tangents at two points and their chord.

    On a smooth curve the chord lies between the tangents. Where it does not, the step has left its branch.
    """
    chord = (z - last.z) / np.linalg.norm(z - last.z)
    return float(np.arccos(np.clip(min(tangent @ last.tangent, chord @ last.tangent, chord @ tangent), -1.0, 1.0)))


def _reach(problem: CurveProblem, last: CurvePoint, control: StepControl) -> float:
    """Step length that changes the physical parameter by `StepControl.ratio`."""
    value = abs(last.z[-1] - problem.zero)
    return control.ratio * value / max(abs(float(last.tangent[-1])), 1e-300)


def _next(
    problem: CurveProblem, last: CurvePoint, step: float, end: float, border: FloatArray, factor: Bordered | None,
    control: StepControl,
) -> Corrected:  # fmt: skip
    """Point one ``step`` behind the ``last`` one, or the point at ``end`` if the step reaches it."""
    direction = float(border[-1])
    ahead = last.z[-1] + step * last.tangent[-1] - end
    if last.tangent[-1] * direction > 0.0 and direction * ahead > -1e-3 * abs(step * last.tangent[-1]):
        z = last.z + (end - last.z[-1]) / last.tangent[-1] * last.tangent
        return correct(problem, z, np.abs(border), control)
    return correct(problem, last.z + step * last.tangent, last.tangent, control, kept=factor)


def _lost(points: list[CurvePoint], direction: float, long: float, control: StepControl) -> str:
    """What is wrong with the last point of a curve, or nothing; ``long`` is the length of a long step."""
    if direction * (points[-1].z[-1] - points[0].z[-1]) < 0.0:
        return "the curve turns back past its start"
    if _creeps(points, long):
        return "the curve could not be followed"
    if len(points) > control.max_points:
        return "the curve does not end; the resonance may be unbounded"
    return ""


def _creeps(points: list[CurvePoint], size: float) -> bool:
    """Whether the last points of a curve hardly advance (`CREEPING`); ``size`` is the length of a long step."""
    count, least = CREEPING
    return len(points) > count and float(np.linalg.norm(points[-1].z - points[-1 - count].z)) < least * size


def _stalled(what: str, where: str, history: list[float]) -> ConvergenceError:
    advice = "use more samples per period or more harmonics"
    if history and not np.isfinite(history[-1]):
        advice = (
            "the equations are singular: nothing holds a body that slides, and its mean displacement is undetermined"
        )
    return ConvergenceError(
        f"{what} ({where})",
        time_s=None,
        iterations=len(history),
        residual_history=[size for size in history if np.isfinite(size)],
        advice=advice,
    )


def _with_points(error: ConvergenceError, points: list[CurvePoint]) -> ConvergenceError:
    error.partial = points
    return error
