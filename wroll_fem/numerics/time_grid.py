"""Times of the steps of a history: constant steps, or longer steps where the frequency of a sweep is low."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.typing import FloatArray, IntArray

LEAST_STEPS = 16
"""Smallest number of steps per cycle of the main mode of a structure, with stuck interfaces, in the longer steps of a
sweep. HHT lengthens its period by 1.3 % there, where the frequency of the base is below it by a factor."""


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
        count = int(np.ceil(duration / dt - 1e-9))
        return cls(dt * np.arange(count + 1), np.full(count, dt), np.array([count]))

    @classmethod
    def of_levels(cls, duration: float, dt: float, changes: FloatArray) -> TimeGrid:
        """Steps of 2^m dt, 2^(m-1) dt, ..., dt, which are halved at the m ascending times ``changes`` (s).

        All times are multiples of ``dt``, and a length ends at the first of its steps that reaches its time.
        """
        count = int(np.ceil(duration / dt - 1e-9))
        pieces, here = [], 0
        for level, change in zip(range(len(changes), 0, -1), changes, strict=True):
            length = 2**level
            last = min(count, int(np.ceil(change / dt - 1e-9)))
            piece = np.arange(here, max(here, last), length)
            pieces.append(piece)
            here = int(piece[-1]) + length if len(piece) else here
        pieces.append(np.arange(here, max(count, here)))
        index = np.concatenate([*pieces, [max(count, here)]])
        lengths = np.diff(index)
        ends = np.flatnonzero(np.diff(lengths)) + 1
        return cls(dt * index, dt * lengths, np.append(ends, len(lengths)))

    @property
    def count(self) -> int:
        """Number of steps."""
        return len(self.steps)

    def left(self, done: int) -> int:
        """Number of steps of equal length from step ``done`` on."""
        return int(self.ends[np.searchsorted(self.ends, done, side="right")]) - done
