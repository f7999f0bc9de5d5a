"""Rendered frames of discs and rings with known motion, to judge a measurement chain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.lab.slip_images.frames.stream import Frame
from wroll_fem.typing import FloatArray

_SUBPIXELS = 8


@dataclass(frozen=True)
class Disc:
    """Round target, or ring.

    Attributes
    ----------
    x, y
        Column and row of the centre at rest, px; whole numbers are the centres of pixels.
    diameter
        Outer diameter, px.
    hole
        Diameter of the hole of a ring, px; 0 for a disc.
    brightness
        Grey values that the target adds to the ground, relative to the light.
    """

    x: float
    y: float
    diameter: float
    hole: float = 0.0
    brightness: float = 1.0


def coverage(shape: tuple[int, int], x: float, y: float, diameter: float) -> tuple[slice, slice, FloatArray]:
    """Share of each pixel that a disc covers.

    Returns
    -------
    tuple
        Rows and columns of the pixels around the disc, and their shares. Pixels on the edge are divided into lines;
        the length of each line within the circle is exact.
    """
    reach = 0.5 * diameter + 1.5
    rows = slice(max(int(y - reach), 0), min(int(y + reach) + 2, shape[0]))
    columns = slice(max(int(x - reach), 0), min(int(x + reach) + 2, shape[1]))
    share = np.zeros((rows.stop - rows.start, columns.stop - columns.start))
    left = np.arange(columns.start, columns.stop) - 0.5
    fine = (np.arange(_SUBPIXELS) + 0.5) / _SUBPIXELS - 0.5
    for n, row in enumerate(range(rows.start, rows.stop)):
        square = 0.25 * diameter**2 - (row + fine - y) ** 2
        half = np.sqrt(np.maximum(square, 0.0))[:, None]
        inside = np.minimum(left + 1.0, x + half) - np.maximum(left, x - half)
        share[n] = np.mean(np.clip(inside, 0.0, 1.0), axis=0)
    return rows, columns, share


def render(
    shape: tuple[int, int],
    discs: tuple[Disc, ...],
    shift: FloatArray,
    *,
    light: Frame | float = 100.0,
    ground: float = 0.2,
    shown: tuple[bool, ...] | None = None,
) -> Frame:
    """Frame of discs under a light.

    Parameters
    ----------
    shape
        Rows and columns, px.
    discs
        Targets.
    shift
        (n, 2) displacement of each target along columns and rows, px.
    light
        Light on each pixel, grey values.
    ground
        Brightness of the ground relative to the light.
    shown
        Whether each target is visible; all by default.

    Returns
    -------
    ndarray
        (rows, columns) grey values without noise.
    """
    scene = np.full(shape, ground, np.float32)
    for k, disc in enumerate(discs):
        if shown is not None and not shown[k]:
            continue
        x, y = disc.x + shift[k, 0], disc.y + shift[k, 1]
        rows, columns, share = coverage(shape, x, y, disc.diameter)
        scene[rows, columns] += (disc.brightness * share).astype(np.float32)
        if disc.hole > 0.0:
            rows, columns, share = coverage(shape, x, y, disc.hole)
            scene[rows, columns] -= (disc.brightness * share).astype(np.float32)
    return (scene * light).astype(np.float32)


def recorded(frame: Frame, noise: FloatArray, bits: int = 8) -> np.ndarray:
    """Frame with noise (grey values, same shape) added, rounded and clipped to unsigned integers of ``bits`` bits."""
    top = 2**bits - 1
    return np.clip(np.rint(frame + noise), 0, top).astype(np.uint8 if bits <= 8 else np.uint16)
