"""Points of one ring or row: equal coordinates but for rounding."""

from __future__ import annotations

import numpy as np

from wroll_fem.typing import FloatArray, IntArray

SAME = 1e-6
"""Neighbouring coordinates closer than this share of their range are one level; meshes are coarser by far."""


def levels(values: FloatArray, tolerance: float | None = None) -> tuple[FloatArray, IntArray]:
    """Group values that differ by less than a tolerance from the next one.

    Parameters
    ----------
    values
        (n,) values.
    tolerance
        Largest difference between neighbours of one group, in the unit of the values; `SAME` of their range by default.

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
