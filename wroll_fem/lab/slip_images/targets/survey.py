"""First look at a recording: light, threshold and targets, from its first frames."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.stream import Frame, Frames
from wroll_fem.lab.slip_images.regions.contrast import TargetContrast
from wroll_fem.lab.slip_images.regions.light import Background, Evening, Light, Targets, estimate_light
from wroll_fem.lab.slip_images.regions.regions import RegionFinder, Regions
from wroll_fem.lab.slip_images.regions.threshold import Method, threshold_level
from wroll_fem.lab.slip_images.targets.targets import Filters, in_reading_order, no_target
from wroll_fem.lab.slip_images.targets.tracking import Tracker

FRAMES = 64
"""Frames from which the light is taken: its error falls with the square root of their number."""


@dataclass(frozen=True)
class Search:
    """How targets are found in a frame.

    Attributes
    ----------
    filters
        Limits that a region meets to be a target.
    targets, background, background_window
        Parameters of `light.estimate_light`.
    evening
        By what the signal is divided against uneven light: the contrast of the targets (`contrast.TargetContrast`), the
        ground, or nothing.
    threshold, threshold_window
        Parameters of `threshold.threshold_level`; window None: 1.5 times the largest diameter of the filters, at most
        a quarter of the frame.
    smoothing, margin
        Parameters of `regions.RegionFinder`.
    gate
        Largest distance of a target from its prediction, px; None: from the distances of the targets.
    """

    filters: Filters
    targets: Targets = "auto"
    background: Background = "surface"
    background_window: int = 128
    evening: Evening = "targets"
    threshold: Method | float = "otsu"
    threshold_window: int | None = None
    smoothing: int = 1
    margin: int = 2
    gate: float | None = None

    def window(self, shape: tuple[int, int]) -> int:
        """Window of the local threshold, px."""
        if self.threshold_window is not None:
            return self.threshold_window
        return max(int(min(1.5 * self.filters.diameter[1], min(shape) / 4)), 3)


@dataclass(frozen=True, eq=False)
class Survey:
    """What is known after the first frames.

    Attributes
    ----------
    frame
        First frame.
    light
        Light on ground and targets.
    finder
        Search for regions.
    level
        (rows, columns) threshold, grey values of the signal.
    targets
        Targets of the first frame.
    """

    frame: Frame
    light: Light
    finder: RegionFinder
    level: Frame
    targets: Regions


def survey(frames: Frames, search: Search, first: int, count: int) -> Survey:
    """Take light, threshold and targets from the first frames.

    Parameters
    ----------
    frames
        Recording.
    search
        How targets are found.
    first, count
        First frame, from 0, and number of frames that are used.

    Raises
    ------
    InputError
        If no target is found, or a frame is damaged.
    """
    few = min(count, FRAMES)
    total, frame = np.zeros(frames.shape), np.zeros(frames.shape, np.float32)
    for k, one in enumerate(islice(iter(frames), first, first + few)):
        total += one
        if k == 0:
            frame = one
    light = estimate_light(
        frame, (total / few).astype(np.float32), background=search.background, window=search.background_window,
        divide=search.evening == "ground", targets=search.targets,
    )  # fmt: skip
    finder = RegionFinder(
        frames.shape, least_area=search.filters.area[0], margin=search.margin, smoothing=search.smoothing
    )
    level, targets = _first(frame, light, finder, search, frames.name)
    if search.evening == "targets":
        looked = islice(iter(frames), first, first + few)
        contrast = TargetContrast(frames.shape, len(targets))
        tracker = Tracker(targets, search.filters, search.gate)
        for k, one in enumerate(looked):
            signal = light.signal(one)
            try:
                regions = finder.find(signal, level)
                place = tracker.step(regions).place if k else np.arange(len(targets))
            except InputError:
                break  # told when the frames are followed
            boxes = np.full((len(targets), 4), np.nan)
            boxes[place >= 0] = (regions if k else targets).box[place[place >= 0]]
            contrast.add(signal, finder.smoothed(signal) > level, boxes)
        light = light.evened(contrast.surface())
        level, targets = _first(frame, light, finder, search, frames.name)
    return Survey(frame, light, finder, level, targets)


def _first(frame: Frame, light: Light, finder: RegionFinder, search: Search, name: str) -> tuple[Frame, Regions]:
    """Threshold, and targets of the first frame."""
    signal = light.signal(frame)
    smoothed = finder.smoothed(signal)
    noise = float(np.std(smoothed.ravel()[light.samples], dtype=float))
    level = threshold_level(smoothed, noise, search.threshold, search.window((frame.shape[0], frame.shape[1])))
    regions = finder.find(signal, level)
    targets = regions.chosen(search.filters.passes(regions))
    if not len(targets):
        raise no_target(finder.largest(signal, level, 3), name)
    return level, in_reading_order(targets)
