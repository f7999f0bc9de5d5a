"""Targets among the regions of a frame: filters, their number, and the message if there is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.regions.regions import Regions
from wroll_fem.typing import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Filters:
    """Limits that a region meets to be a target.

    Attributes
    ----------
    area
        Least and largest number of pixels, px^2.
    diameter
        Least and largest diameter of the circle with the area within the outer outline, px.
    circularity
        Least circularity.
    """

    area: tuple[float, float]
    diameter: tuple[float, float]
    circularity: float

    def passes(self, regions: Regions) -> BoolArray:
        """Whether each region meets all limits and does not touch the border of the frame, (n,)."""
        within = regions.circularity >= self.circularity
        for value, (low, high) in ((regions.area, self.area), (regions.diameter, self.diameter)):
            within &= (value >= low) & (value <= high)
        return within & ~regions.at_border


def in_reading_order(targets: Regions) -> Regions:
    """Targets from the top to the bottom; concentric ones (a disc and rings) are neighbours, the smallest first."""
    return targets.chosen(_reading_order(targets.centroid, targets.diameter))


def no_target(largest: Regions, source: str) -> InputError:
    """Error if no region of the first frame is a target; the message has its largest regions."""
    told = [
        f"{largest.area[k]:.0f} px^2 (diameter {largest.diameter[k]:.1f} px, circularity "
        f"{largest.circularity[k]:.2f}{', at the border' if largest.at_border[k] else ''})"
        for k in range(len(largest))
    ]
    seen = f"the largest regions have {', '.join(told)}" if told else "nothing is above the threshold"
    return InputError(
        f"no target found in the first frame: {seen}", file=source,
        remedy="set targets, threshold, area, diameter or circularity so that the targets pass",
    )  # fmt: skip


def _reading_order(centroid: FloatArray, diameter: FloatArray) -> IntArray:
    """Order by row of the group, by column within it, then by size; a group is what shares a centre."""
    group = concentric_groups(centroid, diameter)
    middle = np.stack([np.mean(centroid[group == g], axis=0) for g in range(group.max() + 1)])
    wide = float(np.median(diameter))
    line = np.zeros(len(middle), dtype=np.int64)
    by_row = np.argsort(middle[:, 1], kind="stable")
    for last, place in pairwise(by_row):
        line[place] = line[last] + (middle[place, 1] - middle[last, 1] > 0.5 * wide)
    return np.lexsort((diameter, middle[group, 0], line[group]))


def concentric_groups(centroid: FloatArray, diameter: FloatArray) -> IntArray:
    """Group of each target, (n,) from 0: targets whose centre lies within a larger one belong to its group."""
    group = np.full(len(centroid), -1, dtype=np.int64)
    count = 0
    for k in np.argsort(-diameter, kind="stable"):
        if group[k] < 0:
            near = np.hypot(*(centroid - centroid[k]).T) < 0.25 * diameter[k]
            group[near & (group < 0)] = count
            count += 1
    return group


def smallest_gap(regions: Regions, similar: float) -> float:
    """Smallest distance between two targets of similar size, px; infinite for a single target.

    Parameters
    ----------
    regions
        Targets.
    similar
        Ratio of two diameters up to which they are similar.
    """
    distance = np.hypot(*(regions.centroid[:, None] - regions.centroid[None]).T)
    ratio = regions.diameter[:, None] / regions.diameter[None]
    alike = np.maximum(ratio, 1.0 / ratio) <= similar
    np.fill_diagonal(alike, False)
    return float(distance[alike].min()) if alike.any() else float("inf")


def number_words(numbers: Sequence[int] | IntArray) -> str:
    """Numbers of targets as words, counted from 1: "target 3" or "targets 3 and 4"."""
    words = [str(int(n) + 1) for n in numbers]
    return f"target {words[0]}" if len(words) == 1 else f"targets {', '.join(words[:-1])} and {words[-1]}"
