"""Comparison of the damping estimates of a transmissibility curve."""

from __future__ import annotations

import numpy as np
import xarray as xr

from wroll_fem.report.html import Markup, paragraph, table
from wroll_fem.signals.estimators import (
    ESTIMATORS,
    DampingEstimate,
    choose,
    lower_bound,
)

_HEAD = ("method", "f_n", "zeta", "standard error", "at least", "misfit")
_METHODS = {
    "half_power": "half power",
    "gaussian_fit": "Gaussian fit (narrowest window, centre free)",
    "rational_fraction": "rational fraction (linear structure)",
}


def damping_table(dataset: xr.Dataset) -> Markup:
    """Table of the damping estimates by half power, Gaussian fit and rational fraction.

    Empty if the results do not contain exactly one complex transmissibility curve, or if the curve has fewer than 8
    points or frequencies that do not increase.
    """
    if "transmissibility_real" not in dataset or dataset["transmissibility_real"].dims != ("frequency",):
        return Markup()
    frequency = dataset["frequency"].values
    if frequency.size < 8 or np.any(np.diff(frequency) <= 0.0):
        return Markup()
    T = dataset["transmissibility_real"].values + 1j * dataset["transmissibility_imag"].values
    found = {method: ESTIMATORS[method](frequency, T) for method in _METHODS}
    chosen = choose(frequency, T, fits=found)
    choice = f"From the shape of the peak: {chosen.method}; {chosen.reason}." if chosen.found else ""
    limits = (
        "Standard errors come from the scatter of the curve alone. The misfit is the distance between fit and "
        "curve, divided by the peak. If it is large, or the methods differ, the curve is not the response of a single "
        f"linear mode, and zeta depends on the definition. summary.json contains "
        "the value by "
        f"{str(dataset.attrs.get('zeta_method', 'half power')).split(',')[0]} "
        "(output.damping)."
    )
    rows = [(_METHODS[method], *_cells(estimate)) for method, estimate in found.items()]
    return (
        table(_HEAD, rows, numbers=range(1, len(_HEAD)))
        + (paragraph(choice) if choice else Markup())
        + paragraph(limits)
    )


def _cells(estimate: DampingEstimate) -> tuple[str, ...]:
    if not estimate.found:
        return "", estimate.reason, "", "", ""
    low = lower_bound(estimate)
    return (
        f"{estimate.f_n:.6g} Hz",
        f"{100.0 * estimate.zeta:.4g} %",
        f"{100.0 * estimate.zeta_error:.2g} %" if np.isfinite(estimate.zeta_error) else "",
        f"{100.0 * low:.4g} %" if np.isfinite(low) else "",
        f"{100.0 * estimate.misfit:.2g} %" if np.isfinite(estimate.misfit) else "",
    )
