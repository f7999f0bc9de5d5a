"""Points of a response curve at its peak and its half-power points, so that readings depend less on its steps."""

from __future__ import annotations

from bisect import bisect_left
from math import sqrt

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.numerics.continuation import CurvePoint, StepControl, point_near
from wroll_fem.typing import FloatArray

PEAK_SPACING = 0.02
"""Distance between the points at the peak, as a share of the arc between the half-power points. The vertex of the
parabola through three points is then accurate to some 1e-6 of the height."""

SAME_PLACE = 2e-4
"""Distance, relative to the same arc, below which a point counts as being at a place already."""

ASTRAY = 0.2
"""Largest distance between a computed point and its first guess, relative to the step of the curve there. Farther away
lies another motion."""


def with_reading_points(
    curve: HarmonicCurve, control: StepControl, quick: HarmonicContact | None = None
) -> HarmonicCurve:
    """Curve with up to seven more points: at the peak, beside it, and at both half-power points.

    Between two points the curve is interpolated by the cubic with the tangents of both. The places are found on this
    cubic, solved for, and found once more on the finer curve. A place outside the band, in a gap, or without
    convergence is left out. Half-power points and peak of the curve then are accurate to the tolerance of the equations
    instead of the length of the steps. The frequency of a flat top also depends on the ripples that the finite number
    of samples per period leaves on the curve (docs/limits.md).

    ``quick`` is the same contact with an approximate Newton's matrix, which is tried first. The tangents are as
    approximate.
    """
    if curve.gap is not None or len(curve.frequencies) < 3:
        return curve
    places = _Places(curve, quick)
    for share in (0.0, PEAK_SPACING):
        peak = places.peak()
        if peak is None:
            return curve
        level = places.height(peak) / sqrt(2.0)
        sides = [places.crossing(peak, level, step) for step in (-1, 1)]
        ends = [at for at in sides if at is not None]
        wide = sum(abs(at - peak) for at in ends) * 2.0 / len(ends) if ends else places.ends[-1]
        beside = [peak] if share == 0.0 else [peak - share * wide, peak + share * wide]
        for at in (*ends, *beside):
            places.add(at, control, SAME_PLACE * wide)
    return HarmonicCurve.of_points(curve.problem, places.points, skipped=curve.skipped)


class _Places:
    """Points of a curve and the cubics between them; a place is the length of the chords up to it."""

    def __init__(self, curve: HarmonicCurve, quick: HarmonicContact | None):
        self.curve, self.problem = curve, curve.problem
        self.problems = [self.problem] if quick is None else [curve.problem_of(quick), self.problem]
        motions = zip(curve.coefficients, curve.frequencies, strict=True)
        self.points = [
            CurvePoint(self.problem.scaled(q, w), tangent, int(count), bool(stable) or tangent[-1] <= 0.0)
            for (q, w), tangent, count, stable in zip(
                motions, curve.tangents, curve.iterations, curve.stable, strict=True
            )
        ]
        lengths = [np.linalg.norm(b.z - a.z) for a, b in zip(self.points[:-1], self.points[1:], strict=True)]
        self.ends: list[float] = np.concatenate([[0.0], np.cumsum(lengths)]).tolist()

    def interpolated(self, place: float) -> tuple[FloatArray, FloatArray]:
        """First guess (n + 1,) and unit tangent (n + 1,) at a place."""
        k = min(max(bisect_left(self.ends, place), 1), len(self.ends) - 1)
        a, b, h = self.points[k - 1], self.points[k], self.ends[k] - self.ends[k - 1]
        x = (place - self.ends[k - 1]) / h
        z = (1 + 2 * x) * (1 - x) ** 2 * a.z + x * x * (3 - 2 * x) * b.z
        z += h * x * (1 - x) * ((1 - x) * a.tangent - x * b.tangent)
        along = 6 * x * (1 - x) / h * (b.z - a.z) + (1 - x) * (1 - 3 * x) * a.tangent + x * (3 * x - 2) * b.tangent
        return z, along / np.linalg.norm(along)

    def height(self, place: float) -> float:
        """|T| at a place."""
        q, w = self.problem.motion(self.interpolated(place)[0])
        balance = self.curve.balance
        tip = q[1:3] @ balance.model.tip
        rigid = balance.model.condensation.rigid_tip
        return float(np.hypot(rigid - w**2 * tip[0] / balance.acceleration, w**2 * tip[1] / balance.acceleration))

    def peak(self) -> float | None:
        """Place of the highest point; None if it is an end of the curve."""
        heights = [self.height(at) for at in self.ends]
        k = int(np.argmax(heights))
        if k in (0, len(heights) - 1):
            return None
        around = self.ends[k - 1], self.ends[k + 1]
        found = minimize_scalar(lambda at: -self.height(at), bounds=around, method="bounded", options={"xatol": 1e-7})
        return float(found.x) if -found.fun >= heights[k] else self.ends[k]

    def crossing(self, peak: float, level: float, step: int) -> float | None:
        """First place before (``step`` -1) or behind (1) the peak where |T| falls to a level; None if there is none."""
        inner = peak
        for at in self.ends if step > 0 else reversed(self.ends):
            if step * (at - peak) <= 0.0:
                continue
            if self.height(at) < level:
                return float(brentq(lambda s: self.height(s) - level, inner, at, xtol=1e-9))
            inner = at
        return None

    def add(self, place: float, control: StepControl, apart: float) -> None:
        """Add the point at a place, unless there is one or the solution is not found."""
        k = bisect_left(self.ends, place)
        if not 0 < k < len(self.ends) or min(place - self.ends[k - 1], self.ends[k] - place) < apart:
            return
        guess, along = self.interpolated(place)
        for problem in self.problems:
            point = point_near(problem, guess, along, control, regular=self.points[k - 1].regular)
            if point is not None and np.linalg.norm(point.z - guess) <= ASTRAY * (self.ends[k] - self.ends[k - 1]):
                self.points.insert(k, point)
                self.ends.insert(k, place)
                return
