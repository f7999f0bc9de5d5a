"""Parts of a record with constant rates of the displacement: constant-rate tests and velocity steps."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.typing import FloatArray, IntArray

FEWEST = 10
"""Samples of a part at least."""

SHORT = 20
"""Samples below which a part is joined with a neighbour."""

ALIKE = 1.2
"""Ratio of the rates of two neighbours below which they are one part."""

RESOLUTION = 1e-5
"""Deviation from straight lines that is not looked at, relative to the range of the displacement."""


class Part(NamedTuple):
    """Part of a record: first sample, first sample after it, rate (m/s), and times of its start and end (s)."""

    start: int
    stop: int
    rate: float
    begin: float
    end: float


def constant_rates(record: ShearRecord) -> list[Part]:
    """Cut a record where the rate of the displacement changes.

    The displacement over time is approximated by straight lines, cut in two where this lowers the squares most, until
    noise explains the rest. Neighbours with rates that differ by less than `ALIKE` are joined. Parts begin and end
    where their lines meet.

    Raises
    ------
    InputError
        If the displacement does not rise.
    """
    t = (record.time - record.time[0]) / (record.time[-1] - record.time[0])
    x = record.displacement - record.displacement[0]
    if not x[-1] > 0.0:
        raise InputError(
            "the displacement ends where it started, or below", file=record.source,
            remedy="use a sliding record in one direction with positive displacement, or profile: loops",
        )  # fmt: skip
    second = np.diff(x, 2)
    noise = np.median(np.abs(second)) / 0.6745 / np.sqrt(6.0)
    sums = _Sums.of(t, x, max(float(noise), RESOLUTION * float(np.ptp(x))))
    bounds = sorted({0, len(t), *sums.cuts(0, len(t))})
    while True:
        bounds = sums.placed(bounds)
        wrong = _needless(sums, bounds)
        if wrong is None:
            return _parts(record, sums, bounds)
        bounds.pop(wrong)


def _needless(sums: _Sums, bounds: list[int]) -> int | None:
    """Index of a cut beside a part that is too short, or between two parts of nearly the same rate."""
    if len(bounds) < 3:
        return None
    lengths = np.diff(bounds)
    k = int(np.argmin(lengths))
    if lengths[k] < SHORT:
        return min(max(k, 1), len(bounds) - 2)
    slopes = [sums.line(a, b)[1] for a, b in pairwise(bounds)]
    ratios = [_ratio(a, b) for a, b in pairwise(slopes)]
    return 1 + int(np.argmin(ratios)) if min(ratios) < ALIKE else None


def _ratio(one: float, other: float) -> float:
    low, high = sorted((abs(one), abs(other)))
    return high / low if low > 0.0 else np.inf


def _parts(record: ShearRecord, sums: _Sums, bounds: list[int]) -> list[Part]:
    whole = record.time[-1] - record.time[0]
    lines = [sums.line(a, b) for a, b in pairwise(bounds)]
    edges = [float(record.time[0])]
    for at, (c0, r0), (c1, r1) in zip(bounds[1:-1], lines[:-1], lines[1:], strict=True):
        meet = record.time[0] + whole * (c0 - c1) / (r1 - r0)
        # the lines meet near the cut, unless the displacement jumps there
        edges.append(float(np.clip(meet, record.time[max(0, at - FEWEST)], record.time[at + FEWEST - 1])))
    edges.append(float(record.time[-1]))
    starts = [0, *np.searchsorted(record.time, edges[1:-1], side="right").tolist(), len(record.time)]
    return [
        Part(starts[k], starts[k + 1], float(rate / whole), edges[k], edges[k + 1]) for k, (_, rate) in enumerate(lines)
    ]


class _Sums(NamedTuple):
    """Running sums of t, x, t^2, t x, x^2, for lines through any range of samples."""

    table: FloatArray
    floor: float

    @classmethod
    def of(cls, t: FloatArray, x: FloatArray, floor: float) -> _Sums:
        rows = np.array([np.ones_like(t), t, x, t * t, t * x, x * x])
        return cls(np.concatenate([np.zeros((6, 1)), np.cumsum(rows, axis=1)], axis=1), floor)

    def line(self, start: int, stop: int) -> tuple[float, float]:
        """Offset and slope of the line through samples ``start`` to ``stop`` - 1."""
        n, t, x, tt, tx, _ = self.table[:, stop] - self.table[:, start]
        slope = (tx - t * x / n) / (tt - t * t / n)
        return float((x - slope * t) / n), float(slope)

    def squares(self, start: IntArray, stop: IntArray) -> FloatArray:
        """Sum of the squared distances from the line of each range, at least what the floor gives."""
        n, t, x, tt, tx, xx = self.table[:, stop] - self.table[:, start]
        with np.errstate(divide="ignore", invalid="ignore"):
            rest = xx - x * x / n - (tx - t * x / n) ** 2 / (tt - t * t / n)
        return np.maximum(rest, 0.0) + n * self.floor**2

    def placed(self, bounds: list[int]) -> list[int]:
        """Bounds with each cut at its best place between its neighbours."""
        found = list(bounds)
        for k in range(1, len(found) - 1):
            places = np.arange(found[k - 1] + 3, found[k + 1] - 2)
            if len(places):
                left = self.squares(np.full_like(places, found[k - 1]), places)
                found[k] = int(places[np.argmin(left + self.squares(places, np.full_like(places, found[k + 1])))])
        return found

    def cuts(self, start: int, stop: int) -> list[int]:
        """Places at which the samples ``start`` to ``stop`` - 1 are cut."""
        count = stop - start
        if count < 2 * FEWEST:
            return []
        places = np.arange(start + FEWEST, stop - FEWEST + 1)
        split = self.squares(np.full_like(places, start), places) + self.squares(places, np.full_like(places, stop))
        best = int(np.argmin(split))
        whole = float(self.squares(np.array([start]), np.array([stop]))[0])
        if count * np.log(whole / split[best]) < 20.0 + 4.0 * np.log(count):
            return []
        at = int(places[best])
        return [*self.cuts(start, at), at, *self.cuts(at, stop)]
