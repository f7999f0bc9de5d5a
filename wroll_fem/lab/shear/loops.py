r"""Hysteresis loops of a cyclic record: energy per cycle, amplitudes, frequency (thesis, Figs. E.21 and E.22).

.. math:: E = \oint F\, dx

An ideal loop of friction with elastic slip has E = 4 F_c (X - F_c/K) at the amplitude X of the displacement. An elastic
fixture does not change the energy.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.numerics.inference import Estimate, mean_estimate
from wroll_fem.typing import FloatArray

BAND = 0.25
"""Half width of the band around the middle of the displacement, relative to its amplitude, that ends a cycle."""

SAMPLES = 40
"""Samples per cycle below which the energy is doubtful: the loop is a polygon."""


@dataclass(frozen=True, eq=False)
class Loops:
    """Hysteresis loops of a record.

    Attributes
    ----------
    energy
        (c,) energy dissipated per cycle, J, by both stacks.
    displacement, force
        (c,) amplitudes of displacement, m, and force, N: half of the range in a cycle.
    start, stop
        (c,) first sample of each cycle, and first sample after it.
    duration
        (c,) s.
    doubts
        Doubts, one sentence each.
    """

    energy: FloatArray
    displacement: FloatArray
    force: FloatArray
    start: FloatArray
    stop: FloatArray
    duration: FloatArray
    doubts: tuple[str, ...] = ()

    def after(self, skip: int) -> Loops:
        """Cycles without the first ``skip``."""
        names = ("energy", "displacement", "force", "start", "stop", "duration")
        return replace(self, **{name: getattr(self, name)[skip:] for name in names})

    @property
    def means(self) -> tuple[Estimate, Estimate, Estimate]:
        """Means of energy, J, displacement amplitude, m, and force amplitude, N, over the cycles."""
        return mean_estimate(self.energy), mean_estimate(self.displacement), mean_estimate(self.force)


def loops(record: ShearRecord) -> Loops:
    """Cut a record into cycles of its displacement and measure each.

    Raises
    ------
    InputError
        If there is no complete cycle.
    """
    x, force, time = record.displacement, record.force, record.time
    ends = crossings(x)
    if len(ends) < 2:
        raise InputError(
            "no complete cycle of the displacement", file=record.source,
            remedy="record two passages of the middle in the same direction, or use test: ramp",
        )  # fmt: skip
    rows = []
    for one, other in pairwise(ends):
        at = np.concatenate([[one], np.arange(int(np.ceil(one)), int(np.floor(other)) + 1), [other]])
        index = np.arange(len(x))
        own_x, own_f = np.interp(at, index, x), np.interp(at, index, force)
        energy = np.sum(0.5 * (own_f[1:] + own_f[:-1]) * np.diff(own_x))
        duration = np.interp(other, index, time) - np.interp(one, index, time)
        rows.append((energy, np.ptp(own_x) / 2.0, np.ptp(own_f) / 2.0, np.ceil(one), np.ceil(other), duration))
    table = np.array(rows).T
    doubts = []
    fewest = int(np.min(table[4] - table[3]))
    if fewest < SAMPLES:
        doubts.append(f"{fewest} samples per cycle: the energy of a loop needs {SAMPLES} or more")
    if np.any(table[0] < 0.0):
        doubts.append("a loop runs backwards: check the signs of force and displacement")
    energy, displacement, amplitude, start, stop, duration = table
    return Loops(energy, displacement, amplitude, start, stop, duration, tuple(doubts))


def crossings(x: FloatArray) -> FloatArray:
    """Places, in samples, at which x passes its middle upwards, with the swings in between beyond a band around it."""
    middle, reach = 0.5 * (x.max() + x.min()), 0.5 * np.ptp(x)
    high, low = x > middle + BAND * reach, x < middle - BAND * reach
    found, was_low = [], False
    side = np.where(high, 1, np.where(low, -1, 0))
    changes = np.flatnonzero(side)
    for k in changes:
        if side[k] < 0:
            was_low = True
        elif was_low:
            before = k - 1 - int(np.argmax(x[k - 1 :: -1] <= middle))
            share = (middle - x[before]) / (x[before + 1] - x[before])
            found.append(before + share)
            was_low = False
    return np.array(found)
