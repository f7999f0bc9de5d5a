"""Identity of targets from frame to frame: lost and found again, doubles beside a target, and targets that merge."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.regions.regions import Regions
from wroll_fem.lab.slip_images.targets.targets import Filters, number_words, smallest_gap
from wroll_fem.typing import BoolArray, FloatArray, IntArray

SIZE_CHANGE = 0.2
"""Largest change of a target's diameter, and of the share of its outline that it fills, as logarithm of the ratio."""

_SEARCH, _FORGET, _WIDEN = 8.0, 0.05, 20.0
"""Search radius over the rms distance to the prediction; weight of the last frame in it; frames of loss that double the
radius."""

_FORBIDDEN = 1e6


class Step(NamedTuple):
    """One frame.

    Attributes
    ----------
    place
        (n_targets,) region of each target; -1 if it is lost.
    merged
        (n_targets,) whether the target is lost because it has grown together with something else.
    extra
        Regions that meet the limits and belong to no target.
    """

    place: IntArray
    merged: BoolArray
    extra: IntArray


@dataclass
class Tracker:
    """Assignment of the regions of each frame to the targets of the first one.

    Attributes
    ----------
    first
        Targets of the first frame.
    filters
        Limits that a region meets to be a target.
    gate
        Largest distance between a target and its prediction, px; None: 0.45 times the smallest distance between two
        targets of similar size, at most the smallest diameter.
    frame
        Number of the last frame.

    Notes
    -----
    The prediction is the last position plus the median displacement of all targets since then, so that a lost target
    follows the motion of the body. A target is searched within 8 times the rms distance between its positions and their
    predictions so far (at least 1 px, at most the gate), and farther the longer it is lost. If this finds less than
    half of the targets, as after a jump of the camera, they are searched within the gate.

    The cost of a pair is the squared distance over the radius of the search plus the squared changes of diameter and
    filled share over their limits: concentric targets have one position and differ in size. Where a target has several
    candidates, or a region several targets, the sum of the costs is minimised (Hungarian method).
    """

    first: Regions
    filters: Filters
    gate: float | None = None
    frame: int = 0
    _last: FloatArray = field(init=False)
    _at: FloatArray = field(init=False)
    _common: FloatArray = field(init=False)
    _speed: FloatArray = field(init=False)
    _square: FloatArray = field(init=False)
    _lost: IntArray = field(init=False)

    def __post_init__(self) -> None:
        if self.gate is None:
            gap = smallest_gap(self.first, np.exp(SIZE_CHANGE))
            self.gate = min(0.45 * gap, float(self.first.diameter.min()))
        self._last = self.first.centroid.copy()
        self._at = np.zeros_like(self._last)  # common displacement when each target was seen last
        self._common, self._speed = np.zeros(2), np.zeros(2)
        self._square = np.full(len(self._last), (self._gate / _SEARCH) ** 2)  # of the distances to the predictions
        self._lost = np.zeros(len(self._last), dtype=np.int64)  # frames since each target was seen

    def predicted(self) -> FloatArray:
        """Positions of the targets in the next frame, (n_targets, 2), px."""
        return self._last + (self._common + self._speed - self._at)

    def step(self, regions: Regions) -> Step:
        """Assign the regions of the next frame.

        Raises
        ------
        InputError
            If two targets merge into one region.
        """
        self.frame += 1
        predicted = self.predicted()
        passing = np.flatnonzero(self.filters.passes(regions))
        radius = np.clip(_SEARCH * np.sqrt(self._square), 1.0, self._gate) * (1.0 + self._lost / _WIDEN)
        place = self._assigned(predicted, regions, passing, np.minimum(radius, self._gate))
        if 2 * np.count_nonzero(place >= 0) < min(len(place), passing.size):
            place = self._assigned(predicted, regions, passing, np.full(len(place), self._gate))
        lost = np.flatnonzero(place < 0)
        merged = np.zeros(len(predicted), dtype=bool)
        if lost.size:
            merged[lost] = self._merged(regions, predicted, lost, place)
        extra = np.setdiff1d(passing, place)
        self._follow(regions, place, predicted)
        return Step(place, merged, extra)

    def near(self, position: FloatArray) -> int:
        """Target within whose gate a position (2,) lies, nearest first; -1 if there is none."""
        distance = np.hypot(*(self._last - position).T)
        k = int(np.argmin(distance))
        return k if distance[k] < self._gate else -1

    @property
    def _gate(self) -> float:
        assert self.gate is not None  # set by __post_init__
        return self.gate

    def _assigned(self, predicted: FloatArray, regions: Regions, passing: IntArray, radius: FloatArray) -> IntArray:
        """Region of each target, (n_targets,), -1 if there is none."""
        place = np.full(len(predicted), -1, dtype=np.int64)
        rows, columns = _cheapest(self._cost(predicted, regions, passing, radius))
        place[rows] = passing[columns]
        return place

    def _cost(self, predicted: FloatArray, regions: Regions, passing: IntArray, radius: FloatArray) -> FloatArray:
        """Cost of each pair of target and passing region; `_FORBIDDEN` beyond the limits."""
        offset = (predicted[:, None] - regions.centroid[passing][None]) / radius[:, None, None]
        diameter = np.log(regions.diameter[passing][None] / self.first.diameter[:, None]) / SIZE_CHANGE
        fill = np.log(regions.fill[passing][None] / self.first.fill[:, None]) / SIZE_CHANGE
        terms = (np.einsum("ijk,ijk->ij", offset, offset), diameter**2, fill**2)
        allowed = (terms[0] <= 1.0) & (terms[1] <= 1.0) & (terms[2] <= 1.0)
        return np.where(allowed, terms[0] + terms[1] + terms[2], _FORBIDDEN)

    def _merged(self, regions: Regions, predicted: FloatArray, lost: IntArray, place: IntArray) -> BoolArray:
        """Whether each lost target lies in a region of its size or more that belongs to no target."""
        free = np.setdiff1d(np.arange(len(regions)), place)
        top, bottom, left, right = regions.box[free].T
        x, y = predicted[lost, :1], predicted[lost, 1:]
        within = (x >= left) & (x <= right) & (y >= top) & (y <= bottom)
        within &= regions.area[free][None] > self.first.area[lost, None]
        for n in range(free.size):
            both = lost[within[:, n]]
            if both.size > 1 and regions.area[free[n]] > 0.8 * self.first.area[both].sum():
                raise InputError(
                    f"{number_words(both)} merge into one region of {regions.area[free[n]]:.0f} px^2 in frame "
                    f"{self.frame}", remedy="raise threshold, lower smoothing, or use the frames before",
                )  # fmt: skip
        return within.any(axis=1)

    def _follow(self, regions: Regions, place: IntArray, predicted: FloatArray) -> None:
        """Update the positions, and the median displacement of the targets that are seen."""
        seen = place >= 0
        self._lost[~seen] += 1
        self._lost[seen] = 0
        if not seen.any():
            return
        now = regions.centroid[place[seen]]
        square = np.sum((now - predicted[seen]) ** 2, axis=1)
        self._square[seen] += _FORGET * (square - self._square[seen])
        common = np.median(now - self._last[seen] + self._at[seen], axis=0)
        self._speed, self._common = common - self._common, common
        self._last[seen], self._at[seen] = now, common


def _cheapest(cost: FloatArray) -> tuple[IntArray, IntArray]:
    """Pairs of rows and columns with the least total cost, forbidden ones left out."""
    allowed = cost < _FORBIDDEN
    if (allowed.sum(axis=0) <= 1).all() and (allowed.sum(axis=1) <= 1).all():
        rows, columns = np.nonzero(allowed)
        return rows, columns
    rows, columns = linear_sum_assignment(cost)
    kept = allowed[rows, columns]
    return rows[kept], columns[kept]
