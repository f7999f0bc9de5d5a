"""Regions that look like targets and are none: where and when they appear."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.typing import FloatArray

_MOST = 100


@dataclass(frozen=True)
class Double:
    """Region that meets all limits of a target and belongs to none.

    Attributes
    ----------
    first, last
        First and last frame in which it is seen.
    count
        Number of frames in which it is seen.
    x, y
        Mean column and row, px.
    near
        Target within whose search distance it appears; -1 if it is away from all targets.
    """

    first: int
    last: int
    count: int
    x: float
    y: float
    near: int


@dataclass
class _Track:
    first: int
    last: int
    count: int
    total: FloatArray
    at: FloatArray
    near: int


class Doubles:
    """Collection of such regions over a recording; neighbouring places count as one.

    Parameters
    ----------
    reach
        Largest distance between two sightings of one region, px.
    """

    def __init__(self, reach: float) -> None:
        self._reach = reach
        self._tracks: list[_Track] = []

    def add(self, frame: int, position: FloatArray, near: int) -> None:
        """Add a sighting at a position (2,), near a target or -1."""
        for track in self._tracks:
            if track.last < frame and np.hypot(*(track.at - position)) <= self._reach:
                track.last, track.at = frame, position
                track.count, track.total = track.count + 1, track.total + position
                track.near = max(track.near, near)
                return
        if len(self._tracks) < _MOST:
            self._tracks.append(_Track(frame, frame, 1, position.copy(), position, near))

    def found(self) -> tuple[Double, ...]:
        """Regions in the order of their appearance."""
        return tuple(
            Double(t.first, t.last, t.count, float(t.total[0] / t.count), float(t.total[1] / t.count), t.near)
            for t in self._tracks
        )
