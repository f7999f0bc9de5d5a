"""Branches of a response curve: followed from an end of the band, stepping over internal resonances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from wroll_fem.dynamics.periodic.harmonic_balance import BAND_SCALE, LARGEST_OVERTONES, FrequencyCurve
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.continuation import CurvePoint, StepControl, follow, solve_at
from wroll_fem.typing import FloatArray

MOST_SKIPPED = 8
"""Largest number of internal resonances that are stepped over in one curve."""

STEPS_BEYOND = (3e-4, 1e-3, 3e-3, 1e-2, 2e-2, 4e-2)
"""Frequency steps, relative to the width of the band, that are tried in turn to step over an internal resonance."""

STEEP = 0.4
"""Transmissibility, relative to `LARGEST_GROWTH`, that both edges of a gap in a response curve must exceed. The middle
of the gap is then the resonance frequency to within 0.5 %."""

SAME_BRANCH = 0.05
"""Largest relative difference of two motions at one frequency that count as the same point of a branch."""

LARGEST_JUMP = 0.5
"""Largest relative change of the motion that is accepted when an internal resonance is stepped over."""


@dataclass
class Branches:
    """Branches of one response curve.

    Attributes
    ----------
    problem, control
        Equations of the curve, and control of the step lengths.
    report
        Called with the points so far.
    skipped
        Frequencies, rad/s, just past the internal resonances that were stepped over.
    """

    problem: FrequencyCurve
    control: StepControl
    report: Callable[[list[CurvePoint]], None]
    skipped: list[float] = field(default_factory=list)

    def follow(self, motion: FloatArray, frequency: float, end: float) -> list[CurvePoint]:
        """Points of the branch from a motion (R, m) at a frequency, rad/s, to the scaled frequency ``end``.

        The branch ends earlier where the resonance is not bounded, or cannot be followed further at a response that is
        already a large part of the limit (`STEEP`).

        Raises
        ------
        ConvergenceError
            If the branch cannot be followed; ``partial`` holds its points.
        """
        problem = self.problem
        first = problem.solve(problem.scaled(motion, frequency), self.control)
        points: list[CurvePoint] = []
        while True:
            stopped = self._extend(points, first, end)
            last = points[-1].z
            drifts = problem.drifted(last)
            sound = not drifts and problem.overtones(last) <= LARGEST_OVERTONES
            if sound and stopped is None:
                return points
            beyond = None if drifts or len(self.skipped) == MOST_SKIPPED else self._stepped_over(points, end)
            if beyond is not None:
                points, first = beyond
                self.skipped.append(problem.motion(first)[1])
            elif sound and problem.growth(last) > STEEP:
                return points
            else:
                failure = stopped or (_drifting if drifts else _internal)(problem, points[-1])
                failure.partial = points
                raise failure

    def _extend(self, points: list[CurvePoint], first: FloatArray, end: float) -> ConvergenceError | None:
        """Append the points from the solution ``first`` on; the error that stopped them, or None."""
        try:
            points += follow(self.problem, first, end, self.control, on_point=self.report, ends=self.problem.ended)
        except ConvergenceError as error:
            points += error.partial or []
            del points[_end_of_way_out(points) :]
            return error
        return None

    def _stepped_over(self, points: list[CurvePoint], end: float) -> tuple[list[CurvePoint], FloatArray] | None:
        """Part of the branch before an internal resonance, and a solution (n + 1,) beyond it to continue from.

        Solutions are computed at frequencies increasingly far beyond the resonance (`STEPS_BEYOND`); the last point of
        this part is the initial guess. The first solution is returned whose higher harmonics are small and that differs
        from the guess by less than `LARGEST_JUMP`. None if there is no such solution, or if fewer than two points of
        the branch have small higher harmonics.
        """
        problem = self.problem
        forward = 1.0 if end > points[0].z[-1] else -1.0
        calm = [k for k, p in enumerate(points) if problem.overtones(p.z) <= 0.3 * LARGEST_OVERTONES]
        if len(calm) < 2:
            return None
        last = calm[-1] if calm[-1] < len(points) - 1 else max(calm[-1] - 2, 0)
        kept = points[: last + 1]
        here = kept[-1]
        furthest = max(forward * p.z[-1] for p in points)
        for step in STEPS_BEYOND:
            z = here.z.copy()
            place = max(furthest, forward * here.z[-1]) + step * BAND_SCALE
            if place > forward * end:
                return None
            z[-1] = forward * place
            try:
                found = solve_at(problem, z, self.control)
            except ConvergenceError:
                continue
            change = np.linalg.norm(found[:-1] - here.z[:-1]) / np.linalg.norm(here.z[:-1])
            if problem.overtones(found) <= 0.3 * LARGEST_OVERTONES and change < LARGEST_JUMP:
                return kept, found
        return None


def _end_of_way_out(points: list[CurvePoint]) -> int:
    """Number of points up to the turn of a branch that comes back the way it went; all of them on other branches.

    Near an undamped internal resonance the tangent can change its direction between two points of one branch.
    """
    place = np.array([p.z[-1] for p in points])
    if len(points) < 3:
        return len(points)
    place = place if place[1] > place[0] else -place
    turn = int(np.argmax(place))
    near = place[0] + 0.1 * (place[turn] - place[0])
    back = [k for k in range(turn + 1, len(points)) if place[0] <= place[k] <= near]
    if turn == 0 or not back:
        return len(points)
    after = int(np.searchsorted(np.maximum.accumulate(place[: turn + 1]), place[back[-1]], side="right"))
    out, size = points[after], float(np.linalg.norm(points[after].z[:-1]))
    share = (place[back[-1]] - place[after - 1]) / (place[after] - place[after - 1])
    there = points[after - 1].z + share * (out.z - points[after - 1].z)
    apart = float(np.linalg.norm(points[back[-1]].z[:-1] - there[:-1]))
    return turn + 1 if apart < SAME_BRANCH * size else len(points)


def _internal(problem: FrequencyCurve, point: CurvePoint) -> ConvergenceError:
    share = problem.overtones(point.z)
    bare = " without damping" if problem.balance.model.damping is None else ""
    return ConvergenceError(
        f"internal resonance{bare}: a harmonic of the motion excites a mode ({problem.describe(point.z)})",
        time_s=None, iterations=point.iterations, residual_history=[share],
        advice="change the band, or compute a sweep",
    )  # fmt: skip


def _drifting(problem: FrequencyCurve, point: CurvePoint) -> ConvergenceError:
    return ConvergenceError(
        f"the mean displacement of the layers is not determined ({problem.describe(point.z)})",
        time_s=None, iterations=point.iterations, residual_history=[], advice="compute a sweep",
    )  # fmt: skip
