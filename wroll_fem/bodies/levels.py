"""Grouping of coordinates that are equal within rounding, such as the heights of the points of one ring."""

from __future__ import annotations

import numpy as np

from wroll_fem.typing import FloatArray, IntArray

SAME = 1e-6
"""Largest difference of coordinates that count as equal, relative to the range of all coordinates. It is far below the
element size."""


def levels(values: FloatArray, tolerance: float | None = None) -> tuple[FloatArray, IntArray]:
    """Group values: neighbours in ascending order belong to the same group if they differ by at most a tolerance.

    Parameters
    ----------
    values
        (n,) values.
    tolerance
        Largest difference between consecutive values of one group, in the unit of the values; by default `SAME` times
        their range.

    Returns
    -------
    means : (m,) mean of each group, ascending.
    group : (n,) group of each value.
    """
    if tolerance is None:
        tolerance = SAME * max(float(np.ptp(values)), 1e-12)
    order = np.argsort(values, kind="stable")
    group = np.empty(values.size, dtype=np.int64)
    group[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > tolerance)])
    return np.bincount(group, weights=values) / np.bincount(group), group
