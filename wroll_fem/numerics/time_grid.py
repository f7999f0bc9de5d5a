"""Times of the steps of a history: constant steps, or longer steps where the frequency of a sweep is low."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.numerics.step_limit import MOST_STEPS
from wroll_fem.typing import FloatArray, IntArray

LEAST_STEPS = 16
"""Smallest number of steps per cycle of the main mode of a structure, with stuck interfaces, in the longer steps of a
sweep. HHT lengthens its period by 1.3 % there, where the frequency of the base is below it by a factor."""


def _count(duration: float, dt: float) -> int:
    """Number of steps of ``dt`` (s) that reach ``duration`` (s).

    Raises
    ------
    InputError
        If there are more than `MOST_STEPS`.
    """
    count = duration / dt - 1e-9 if dt > 0.0 else np.inf
    if not count <= MOST_STEPS:
        problem = f"the motion takes {count:.3g} time steps, at most {MOST_STEPS:.0e} are possible"
        raise InputError(problem, key="excitation", remedy="shorten it, or lower integrator.steps_per_cycle")
    return int(np.ceil(count))


@dataclass(frozen=True)
class TimeGrid:
    """Steps of a time history.

    Attributes
    ----------
    times
        (k + 1,) ends of the steps, s, from 0.
    steps
        (k,) lengths of the steps, s.
    ends
        Ascending indices of `times` at which a length ends, the last index included.
    """

    times: FloatArray
    steps: FloatArray
    ends: IntArray

    @classmethod
    def constant(cls, duration: float, dt: float) -> TimeGrid:
        """Steps of ``dt`` (s) up to or just beyond ``duration`` (s)."""
        count = _count(duration, dt)
        return cls(dt * np.arange(count + 1), np.full(count, dt), np.array([count]))

    @classmethod
    def of_levels(cls, duration: float, dt: float, levels: Sequence[int], changes: FloatArray) -> TimeGrid:
        """Steps of 2^level dt, with the level of the m + 1 ``levels`` that changes at the m ascending ``changes`` (s).

        All times are multiples of ``dt``. A step is never longer than its level at any time within it allows.
        """
        count = _count(duration, dt)
        index, here = [0], 0
        bounds = [*np.clip(np.asarray(changes) / dt, 0.0, count), float(count)]
        for level, bound, after in zip(levels, bounds, [*levels[1:], levels[-1]], strict=True):
            length, left = 2**level, bound - here
            last = level == after or bound >= count  # the end of the motion may lie within a step
            whole = int(np.ceil(left / length - 1e-9) if last or after > level else np.floor(left / length + 1e-9))
            index += [here + length * (k + 1) for k in range(max(whole, 0))]
            here = index[-1]
        lengths = np.diff(index)
        ends = np.flatnonzero(np.diff(lengths)) + 1
        return cls(dt * np.array(index), dt * lengths, np.append(ends, len(lengths)))

    @property
    def count(self) -> int:
        """Number of steps."""
        return len(self.steps)

    def left(self, done: int) -> int:
        """Number of steps of equal length from step ``done`` on."""
        return int(self.ends[np.searchsorted(self.ends, done, side="right")]) - done
