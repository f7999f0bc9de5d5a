"""Motions of a curve in another reduced model: first guesses, and the solution from the first one that converges."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import replace

import numpy as np

from wroll_fem.numerics.bordered import Bordered, CurveProblem
from wroll_fem.numerics.continuation import Corrected, CurvePoint, StepControl, correct
from wroll_fem.typing import FloatArray


def first_guesses(motion: FloatArray, shift: FloatArray, starts: FloatArray | None, number: int) -> list[FloatArray]:
    """Motions (R, m) from which a motion is sought in another model, the most promising one first.

    Parameters
    ----------
    motion
        (R, k) Fourier coefficients in the model before.
    shift
        (k, m) map from its coordinates to those of the other model.
    starts, number
        (p, R, m) further guesses, and the number of the motion among them; None without any.
    """
    same = motion @ shift
    if starts is None:
        return [same]
    other = starts[number]
    return [same] if np.allclose(other, same, atol=0.0) else [other, same]


def corrected_from(
    problems: Sequence[CurveProblem], places: Sequence[FloatArray], row: FloatArray, control: StepControl, *,
    kept: Bordered | None, chord: bool,
) -> Corrected:  # fmt: skip
    """Solution from the first of the ``places`` (n + 1,) that converges; see `correct` for the other arguments.

    ``problems`` have the same equations. Where the first, with an approximate Jacobian, converges from no place, the
    next one is tried.
    """
    found = Corrected(None, [], places[-1], kept)
    for number, problem in enumerate(problems):
        for place in places:
            found = correct(problem, place, row, control, kept=found.factor, chord=chord and number == 0)
            if found.z is not None:
                return found
    return found


def carried_along(points: list[CurvePoint], places: FloatArray, solved: Container[int]) -> list[CurvePoint]:
    """Points of a curve of which some are ``solved``: the others are shifted like their solved neighbours.

    ``places`` (p, n + 1) are the p points before; shifts are interpolated over the length of their polygon.
    """
    known = [k for k in range(len(points)) if k in solved]
    if len(known) < 2 or len(points) < len(places):
        return points
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1)))
    shifts = np.array([points[k].z - places[k] for k in known])
    out = list(points)
    for k, point in enumerate(points):
        if k not in solved:
            after = min(max(int(np.searchsorted(known, k)), 1), len(known) - 1)
            a, b = length[known[after - 1]], length[known[after]]
            share = float(np.clip((length[k] - a) / (b - a), 0.0, 1.0)) if b > a else 0.5
            out[k] = replace(point, z=places[k] + (1.0 - share) * shifts[after - 1] + share * shifts[after])
    return out
