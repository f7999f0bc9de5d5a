"""Contrast of the targets over the frame: uneven light on large targets pulls their centroids to the brighter side."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from wroll_fem.lab.slip_images.frames.stream import Frame
from wroll_fem.typing import FloatArray

_SPREAD = 5.0
"""Largest ratio of the contrast to its mean, and of the mean to it."""

_PASSES, _LEAST = 20, 8
_BIN = 0.5
"""Width of a class of distances from the centre of a target, px."""

_TERMS = ((0, 0), (0, 1), (1, 0), (0, 2), (1, 1), (2, 0))


class TargetContrast:
    """Contrast of the targets as a smooth surface, collected over several frames.

    Parameters
    ----------
    shape
        Rows and columns of the frames, px.
    count
        Number of targets.

    Notes
    -----
    A centroid that is weighted with the light L lies off the centre by r^2 L'/L, where r^2 is the mean squared distance
    from the centre along the gradient, and it follows a motion with the gain 1 + r^2 (L'/L)'. For rings of 130 px under
    a light that falls by half over 512 px these are 2 px and some per cent.

    The surface is a polynomial of degree 2 through the brightness inside the targets. Pixels of one target at one
    distance from its centre have a brightness of their own, so that targets may differ, and pixels that the edge covers
    in part have no influence: only the variation around the centre counts.
    """

    def __init__(self, shape: tuple[int, int], count: int) -> None:
        self._shape = shape
        size, bins = len(_TERMS), int(max(shape) / _BIN) + 2
        self._square = np.zeros((count, bins, size, size))  # sums of products of the terms over pixels of one distance
        self._product = np.zeros((count, bins, size))  # sums of signal times terms

    def add(self, signal: Frame, above: np.ndarray, boxes: FloatArray) -> None:
        """Add a frame.

        Parameters
        ----------
        signal
            (rows, columns).
        above
            (rows, columns) whether the smoothed signal exceeds the threshold.
        boxes
            (targets, 4) first and last row, first and last column of each target; nan where it is lost.
        """
        labels, _ = ndimage.label(above, np.ones((3, 3)))
        found = ndimage.find_objects(labels)
        place = {(r.start, r.stop - 1, c.start, c.stop - 1): k for k, (r, c) in enumerate(found)}
        for target, box in enumerate(boxes):
            k = place.get(tuple(box)) if np.isfinite(box).all() else None
            if k is None:
                continue
            rows, columns = found[k]
            own = np.pad(labels[rows, columns] == k + 1, 1)
            core = ndimage.binary_erosion(own, np.ones((3, 3)))
            if core.any():
                offset = np.array([rows.start, columns.start]) - 1
                centre = np.mean(np.nonzero(own), axis=1) + offset
                self._collect(target, signal, np.stack(np.nonzero(core), axis=1) + offset, centre)

    def _collect(self, target: int, signal: Frame, pixels: np.ndarray, centre: np.ndarray) -> None:
        """Add pixels (n, 2) of a target."""
        v, u = (2.0 * pixels / self._shape - 1.0).T
        terms = np.stack([v**p * u**q for p, q in _TERMS], axis=1)
        distance = (np.hypot(*(pixels - centre).T) / _BIN).astype(np.int64)
        order = np.argsort(distance, kind="stable")
        bins, starts = np.unique(distance[order], return_index=True)
        terms, values = terms[order], signal[pixels[order, 0], pixels[order, 1]].astype(float)
        self._square[target, bins] += np.add.reduceat(terms[:, :, None] * terms[:, None, :], starts)
        self._product[target, bins] += np.add.reduceat(terms * values[:, None], starts)

    def surface(self) -> Frame:
        """Contrast, (rows, columns), mean 1 over the targets; 1 everywhere if no target is wide enough."""
        square, product = (sums.reshape(-1, *sums.shape[2:]) for sums in (self._square, self._product))
        seen = (square[:, 0, 0] >= _LEAST) & (product[:, 0] > 0.0)
        if not seen.any():
            return np.ones(self._shape, np.float32)
        square, product = square[seen], product[seen]
        pixels = square[:, 0, 0]
        bright = product[:, 0] / pixels  # noise is the same everywhere: bright pixels count more
        square, product = square * (bright**2)[:, None, None], product * bright[:, None]
        pixels = square[:, 0, 0]
        middle = square[:, 0] / pixels[:, None]
        spread = np.sum(square - pixels[:, None, None] * middle[:, :, None] * middle[:, None, :], axis=0)[1:, 1:]
        inverse = np.linalg.pinv(spread, rcond=1e-9, hermitian=True)
        slope = product - pixels[:, None] * middle  # sums of (relative signal - 1) times (terms - middle)
        found = np.zeros(len(_TERMS) - 1)
        for _ in range(_PASSES):  # the signal of a target is relative to the surface at its place
            local = np.maximum(1.0 + middle[:, 1:] @ found, 1.0 / _SPREAD)
            found = inverse @ (local @ slope[:, 1:])
        powers = [np.stack([(2.0 * np.arange(n) / n - 1.0) ** p for p in range(3)]) for n in self._shape]
        table = np.zeros((3, 3))
        table[0, 0] = 1.0
        for (p, q), value in zip(_TERMS[1:], found, strict=True):
            table[p, q] = value
        surface = powers[0].T @ table @ powers[1]
        mean = float(np.average(1.0 + middle[:, 1:] @ found, weights=pixels))
        return np.clip(surface / max(mean, 1e-3), 1.0 / _SPREAD, _SPREAD).astype(np.float32)
