"""Connected regions of a frame: area, outline, circularity, diameter, and intensity-weighted centroid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.stream import Frame
from wroll_fem.lab.slip_images.regions import kernels
from wroll_fem.typing import BoolArray, FloatArray, IntArray

MOST = 1000
"""Regions of a frame at most that have the least area."""


@dataclass(frozen=True, eq=False)
class Regions:
    """Regions of a frame, in the order of their first pixels.

    Attributes
    ----------
    centroid
        (n, 2) intensity-weighted centroid: column x and row y, px; whole numbers are the centres of pixels.
    area
        (n,) number of pixels above the threshold, px^2.
    filled_area
        (n,) area within the outer outline, holes included, px^2.
    perimeter
        (n,) length of the outer outline, px.
    box
        (n, 4) first and last row, first and last column.
    at_border
        (n,) whether the region touches the border of the frame.
    """

    centroid: FloatArray
    area: FloatArray
    filled_area: FloatArray
    perimeter: FloatArray
    box: FloatArray
    at_border: BoolArray

    def __len__(self) -> int:
        return len(self.area)

    @property
    def diameter(self) -> FloatArray:
        """Diameter of the circle with the area within the outer outline, (n,), px."""
        return np.sqrt(4.0 / np.pi * self.filled_area)

    @property
    def circularity(self) -> FloatArray:
        """4 pi times the area within the outer outline over the square of its length, (n,); 1 for a circle."""
        return 4.0 * np.pi * self.filled_area / self.perimeter**2

    @property
    def fill(self) -> FloatArray:
        """Share of the area within the outer outline that is above the threshold, (n,); below 1 for rings."""
        return self.area / self.filled_area

    def chosen(self, which: BoolArray | IntArray) -> Regions:
        """Regions for which ``which`` (n,) is true, or those at these places in their order."""
        return Regions(
            self.centroid[which], self.area[which], self.filled_area[which], self.perimeter[which], self.box[which],
            self.at_border[which],
        )  # fmt: skip


class RegionFinder:
    """Search for regions in frames of one size; holds the working memory.

    Parameters
    ----------
    shape
        Rows and columns, px.
    least_area
        Least number of pixels of a region.
    margin
        Pixels around a region whose light counts for its centroid: as wide as the blurred edge.
    smoothing
        Passes of the filter 1/4, 1/2, 1/4 before the threshold; the centroid uses the signal without the filter.
    """

    def __init__(self, shape: tuple[int, int], *, least_area: float, margin: int = 2, smoothing: int = 1) -> None:
        self._least, self._margin, self._smoothing = least_area, margin, smoothing
        self._labels = np.zeros(shape, np.int32)
        self._stamp = np.zeros(shape, np.int8)
        self._parent = np.zeros(shape[0] * shape[1] + 1, np.int32)
        self._row = np.zeros(shape[1], np.float32)
        self._smooth = [np.zeros(shape, np.float32) for _ in range(min(smoothing, 2))]

    def smoothed(self, signal: Frame) -> Frame:
        """Signal after the filter; the memory is used again for the next frame."""
        source = signal
        for k in range(self._smoothing):
            target = self._smooth[k % 2]
            kernels.smooth(source, self._row, target)
            source = target
        return source

    def find(self, signal: Frame, level: Frame) -> Regions:
        """Regions in which the smoothed signal exceeds the level.

        Parameters
        ----------
        signal
            (rows, columns) signal, zero in the ground and positive on targets.
        level
            (rows, columns) threshold.

        Raises
        ------
        InputError
            If there are too many regions, as when the threshold lies in the noise.
        """
        table = kernels.label_regions(self.smoothed(signal), level, self._labels, self._parent)
        wanted = np.flatnonzero(table[:, kernels.AREA] >= self._least)
        if wanted.size > MOST:
            raise InputError(
                f"{wanted.size} regions of at least {self._least:g} px^2 in one frame (at most {MOST}): the threshold "
                "lies in the noise", remedy="raise threshold, smoothing or the least area",
            )  # fmt: skip
        return self._measured(signal, table, wanted)

    def largest(self, signal: Frame, level: Frame, count: int) -> Regions:
        """Largest regions in which the smoothed signal exceeds the level, whatever their area; for messages."""
        table = kernels.label_regions(self.smoothed(signal), level, self._labels, self._parent)
        wanted = np.argsort(-table[:, kernels.AREA], kind="stable")[:count]
        return self._measured(signal, table, wanted)

    def _measured(self, signal: Frame, table: IntArray, wanted: IntArray) -> Regions:
        outline = kernels.outlines(self._labels, table[:, kernels.FIRST], wanted)
        number = np.zeros(len(table) + 1, np.int32)
        number[wanted + 1] = np.arange(1, wanted.size + 1)
        total = kernels.sums(signal, self._labels, number, self._margin, self._stamp)
        box = table[wanted, kernels.TOP : kernels.RIGHT + 1].astype(float)
        rows, columns = signal.shape
        border = (box[:, 0] == 0) | (box[:, 1] == rows - 1) | (box[:, 2] == 0) | (box[:, 3] == columns - 1)
        with np.errstate(invalid="ignore", divide="ignore"):
            centroid = total[:, 1:] / total[:, :1]
        return Regions(
            centroid, table[wanted, kernels.AREA].astype(float), outline[:, 0], outline[:, 1], box, border
        )  # fmt: skip
