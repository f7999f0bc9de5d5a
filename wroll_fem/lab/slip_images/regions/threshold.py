"""Threshold between ground and targets: fixed, of Otsu, or local."""

from __future__ import annotations

from typing import Literal

import numpy as np

from wroll_fem.lab.slip_images.frames.stream import Frame

Method = Literal["otsu", "local"]

_LEAST = 4.0
"""Standard deviations of the noise in the ground that a threshold exceeds."""


def otsu(values: np.ndarray, bins: int = 512) -> float:
    """Threshold that maximises the variance between two classes.

    Parameters
    ----------
    values
        Grey values, any shape.
    bins
        Number of intervals of the histogram.

    Returns
    -------
    float
        Middle between the means of both classes, grey values. The variance is largest where the threshold is this
        middle; the middle itself does not depend on the intervals.

    References
    ----------
    N. Otsu, IEEE Trans. Systems, Man, and Cybernetics 9 (1979), https://doi.org/10.1109/TSMC.1979.4310076
    """
    count, edges = np.histogram(values, bins=bins)
    middle = 0.5 * (edges[1:] + edges[:-1])
    below = np.cumsum(count)
    mass = np.cumsum(count * middle)
    above = below[-1] - below
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = mass / below, (mass[-1] - mass) / above
        between = np.nan_to_num(below * above * (low - high) ** 2)
    best = int(np.argmax(between))
    return float(0.5 * (low[best] + high[best])) if above[best] else float(middle[best])


def threshold_level(smoothed: Frame, noise: float, method: Method | float, window: int = 0) -> Frame:
    """Threshold of each pixel, from the first frame.

    Parameters
    ----------
    smoothed
        (rows, columns) signal of the first frame as it is compared with the threshold.
    noise
        Standard deviation of this signal in the ground, grey values.
    method
        A number: this value everywhere, grey values. Otsu: one value for the frame (`otsu`), half of the contrast of
        the targets. Local: half of the largest signal within a window, for targets of different contrast.
    window
        Width of the window of the local threshold, px: at least that of a target.

    Returns
    -------
    ndarray
        (rows, columns) grey values. Otsu and local are at least 4 standard deviations of the noise.

    Notes
    -----
    Otsu's threshold splits the noise if targets cover a small part of the frame. Where it lies within the noise, it is
    replaced by half of the mean signal above it, repeated until it stays (Ridler and Calvard 1978,
    https://doi.org/10.1109/TSMC.1978.4310039).
    """
    least = _LEAST * noise
    if isinstance(method, str) and method == "local":
        from scipy.ndimage import maximum_filter, uniform_filter

        highest = maximum_filter(uniform_filter(smoothed, 3), size=window, mode="nearest")
        return np.maximum(0.5 * highest, max(least, 0.1 * float(highest.max()))).astype(np.float32)
    if not isinstance(method, str):
        return np.full_like(smoothed, method)
    level = otsu(smoothed)
    if level < least:
        level = least
        for _ in range(50):
            above = smoothed[smoothed > level]
            if above.size == 0:
                break
            level, last = max(0.5 * float(np.mean(above, dtype=float)), least), level
            if abs(level - last) < 1e-3 * level:
                break
    return np.full_like(smoothed, level)
