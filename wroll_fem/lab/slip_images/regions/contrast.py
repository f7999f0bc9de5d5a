"""Contrast of the targets over the frame: uneven light on large targets pulls their centroids to the brighter side."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from wroll_fem.lab.slip_images.frames.stream import Frame
from wroll_fem.typing import FloatArray

_SPREAD = 5.0
"""Largest ratio of the contrast to its mean, and of the mean to it."""

_PASSES = 20
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
    a light that falls by half over 512 px these are 2 px and some per cent. The surface is a polynomial of degree 2
    through the brightness inside the targets, away from their edges; each target has a brightness of its own.
    """

    def __init__(self, shape: tuple[int, int], count: int) -> None:
        self._shape = shape
        size = len(_TERMS)
        self._square = np.zeros((count, size, size))  # sums of products of the terms over the pixels of each target
        self._product = np.zeros((count, size))  # sums of signal times terms

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
            core = next((c for c in (ndimage.binary_erosion(own, np.ones((3, 3)), n) for n in (2, 1)) if c.any()), None)
            if core is not None:
                i, j = np.nonzero(core[1:-1, 1:-1])
                self._collect(target, signal, i + rows.start, j + columns.start)

    def _collect(self, target: int, signal: Frame, rows: np.ndarray, columns: np.ndarray) -> None:
        v, u = 2.0 * rows / self._shape[0] - 1.0, 2.0 * columns / self._shape[1] - 1.0
        terms = np.stack([v**p * u**q for p, q in _TERMS], axis=1)
        self._square[target] += terms.T @ terms
        self._product[target] += signal[rows, columns].astype(float) @ terms

    def surface(self) -> Frame:
        """Contrast, (rows, columns), mean 1 over the targets; 1 everywhere if no target is wide enough."""
        pixels = self._square[:, 0, 0]
        seen = (pixels > 0) & (self._product[:, 0] > 0.0)
        if not seen.any():
            return np.ones(self._shape, np.float32)
        pixels, square, product = pixels[seen], self._square[seen], self._product[seen]
        product = product / (product[:, :1] / pixels[:, None])  # brightness of each target 1
        middle = square[:, 0] / pixels[:, None]
        spread = np.sum(square - pixels[:, None, None] * middle[:, :, None] * middle[:, None, :], axis=0)[1:, 1:]
        inverse = np.linalg.pinv(spread, rcond=1e-9, hermitian=True)
        slope = product - pixels[:, None] * middle  # sums of (signal - 1) times (terms - middle)
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
