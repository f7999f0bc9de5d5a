"""Interlayer pressure versus radius of a wound roll."""

from __future__ import annotations

import numpy as np
import xarray as xr


def middle_slope(dataset: xr.Dataset) -> float:
    """Mean pressure gradient in the middle half of the roll, Pa/m; positive if the pressure decreases outwards.

    Parameters
    ----------
    dataset
        Result of the analysis winding: `pressure_pa` over `r`.
    """
    r, pressure = dataset["r"].values, dataset["pressure_pa"].values
    ends = r[0] + np.array([0.25, 0.75]) * (r[-1] - r[0])
    values = np.interp(ends, r, pressure)
    return float((values[0] - values[1]) / (ends[1] - ends[0]))
