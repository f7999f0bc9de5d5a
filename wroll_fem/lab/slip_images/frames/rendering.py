"""Rendered frames of discs and rings with known motion, to judge a measurement chain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from wroll_fem.lab.slip_images.frames.stream import Frame
from wroll_fem.typing import FloatArray

_LINES = 32


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


@njit(cache=True)
def add_disc(scene: Any, x: float, y: float, diameter: float, brightness: float) -> None:
    """Add a disc to a scene (rows, columns).

    Each pixel gets the share of its area that the disc covers. Pixels on the edge are divided into 32 lines; the length
    of each line within the circle is exact.
    """
    rows, columns = scene.shape
    radius = 0.5 * diameter
    for i in range(max(int(y - radius) - 1, 0), min(int(y + radius) + 3, rows)):
        for j in range(max(int(x - radius) - 1, 0), min(int(x + radius) + 3, columns)):
            distance = np.hypot(i - y, j - x)
            if distance > radius + 0.75:
                continue
            share = 1.0
            if distance > radius - 0.75:
                share = 0.0
                for line in range(_LINES):
                    across = i - 0.5 + (line + 0.5) / _LINES - y
                    half = np.sqrt(max(radius * radius - across * across, 0.0))
                    share += max(min(j + 0.5, x + half) - max(j - 0.5, x - half), 0.0) / _LINES
            scene[i, j] += brightness * share


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
        add_disc(scene, x, y, disc.diameter, disc.brightness)
        if disc.hole > 0.0:
            add_disc(scene, x, y, disc.hole, -disc.brightness)
    return (scene * light).astype(np.float32)


def recorded(frame: Frame, noise: FloatArray, bits: int = 8) -> np.ndarray:
    """Frame with noise (grey values, same shape) added, rounded and clipped to unsigned integers of ``bits`` bits."""
    top = 2**bits - 1
    return np.clip(np.rint(frame + noise), 0, top).astype(np.uint8 if bits <= 8 else np.uint16)
