"""Paths of the targets over a recording: every frame is read once and forgotten."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.stream import Frame, Frames
from wroll_fem.lab.slip_images.regions.light import Light
from wroll_fem.lab.slip_images.regions.regions import Regions
from wroll_fem.lab.slip_images.targets.doubles import Double, Doubles
from wroll_fem.lab.slip_images.targets.survey import Search, Survey, survey
from wroll_fem.lab.slip_images.targets.tracking import Tracker
from wroll_fem.progress import Progress, SilentProgress
from wroll_fem.typing import BoolArray, FloatArray

LEAST_FRAMES = 16


@dataclass(frozen=True, eq=False)
class Paths:
    """Positions of the targets over a recording.

    Attributes
    ----------
    position
        (frames, targets, 2) column x and row y of each centroid, px, y downwards; nan where a target is lost.
    merged
        (frames, targets) whether a target is lost because it has grown together with something else.
    diameter
        (targets,) mean diameter of the outer outline, px.
    first
        Targets of the first frame.
    doubles
        Regions that meet all limits of a target and are none.
    frame
        First frame, for figures.
    light
        Light of the first frame.
    level
        Mean threshold, grey values of the signal.
    """

    position: FloatArray
    merged: BoolArray
    diameter: FloatArray
    first: Regions
    doubles: tuple[Double, ...]
    frame: Frame
    light: Light
    level: float

    @property
    def seen(self) -> BoolArray:
        """Whether each target is seen in each frame, (frames, targets)."""
        return np.isfinite(self.position[:, :, 0])


def follow(
    frames: Frames, search: Search, *, first: int = 0, count: int | None = None, progress: Progress | None = None
) -> Paths:
    """Follow the targets of the first frame through a recording.

    Parameters
    ----------
    frames
        Recording.
    search
        How targets are found.
    first, count
        First frame, from 0, and number of frames that are used; None: all from the first.
    progress
        Receiver of progress reports.

    Raises
    ------
    InputError
        If there are too few frames, a frame is damaged, no target is found, or targets merge.
    """
    total = max(len(frames) - first, 0) if count is None else min(count, len(frames) - first)
    if total < LEAST_FRAMES:
        raise InputError(
            f"{max(total, 0)} frames from frame {first}, at least {LEAST_FRAMES} are needed", file=frames.name,
            remedy="give more frames",
        )  # fmt: skip
    walk = _Walk(survey(frames, search, first, total), search, frames.name, total)
    stream = islice(iter(frames), first + 1, first + total)
    with (progress or SilentProgress()).stage("frames", total, "frames") as stage:
        for k, frame in enumerate(stream, start=1):
            walk.add(k, frame)
            stage.update(k + 1)
    return walk.paths()


class _Walk:
    """State of `follow`: the working memory of one frame, and the paths so far."""

    def __init__(self, look: Survey, search: Search, name: str, total: int) -> None:
        self._look, self._name = look, name
        self._targets = look.targets
        self._tracker = Tracker(self._targets, search.filters, search.gate)
        n = len(self._targets)
        self._position = np.full((total, n, 2), np.nan)
        self._merged = np.zeros((total, n), dtype=bool)
        self._position[0] = self._targets.centroid
        self._area = self._targets.filled_area.copy()
        self._doubles = Doubles(float(self._targets.diameter.max()))

    def add(self, k: int, frame: Frame) -> None:
        """Find the targets in frame k."""
        try:
            regions = self._look.finder.find(self._look.light.signal(frame), self._look.level)
            step = self._tracker.step(regions)
        except InputError as error:
            raise InputError(error.problem, key=error.key, remedy=error.remedy, file=error.file or self._name) from None
        seen = step.place >= 0
        self._position[k, seen] = regions.centroid[step.place[seen]]
        self._area[seen] += regions.filled_area[step.place[seen]]
        self._merged[k] = step.merged
        for n in step.extra:
            self._doubles.add(k, regions.centroid[n], self._tracker.near(regions.centroid[n]))

    def paths(self) -> Paths:
        """Paths of all frames so far."""
        count = np.isfinite(self._position[:, :, 0]).sum(axis=0)
        diameter = np.sqrt(4.0 / np.pi * self._area / count)
        return Paths(
            self._position, self._merged, diameter, self._targets, self._doubles.found(), self._look.frame,
            self._look.light, float(np.mean(self._look.level, dtype=float)),
        )  # fmt: skip
