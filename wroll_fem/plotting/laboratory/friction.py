"""Figures of the laboratory evaluation `friction`."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.plotting.laboratory.shear import draw_points, error_bars


def plot_rate(data: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot the measured coefficients and the fitted mu(V), linear between the rows of its table."""
    drawn = style.axes(ax)
    draw_points(data, drawn)
    rate, value = data["rate_table_slip_rate"].values, data["rate_table_coefficient"].values
    low, high = (data[f"rate_table_coefficient_{end}"].values for end in ("low", "high"))
    tested = data["point_slip_rate"].values
    fine = np.geomspace(0.5 * tested.min(), 2.0 * tested.max(), 400)
    lines = [np.interp(fine, rate, row) for row in (value, low, high)]
    drawn.plot(fine, lines[0], color="black", lw=1.4, label="fitted, for the case file")
    if np.all(np.isfinite(lines)):
        drawn.fill_between(fine, lines[1], lines[2], color=style.GREY, alpha=0.25, lw=0, label="95 % interval")
    drawn.legend(fontsize=9, frameon=False)
    style.title(drawn, "Coefficient of friction over slip rate: tests with 95 % intervals, and the fitted law.")
    return drawn


def plot_state(data: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot the coefficient over slip of the first step test, with both laws of the state."""
    drawn = style.axes(ax)
    slip = 1e3 * data["step_slip"].values
    drawn.plot(slip, data["step_coefficient"].values, ".", color=style.GREY, ms=2.5, label="measured")
    for name, text, color, dash in (
        ("step_ageing", "ageing law", style.BLUE, "-"), ("step_slip_law", "slip law", style.RED, "--"),
    ):  # fmt: skip
        drawn.plot(slip, data[name].values, color=color, ls=dash, lw=1.3, label=text)
    drawn.set_xlabel("Slip (mm)")
    drawn.set_ylabel("Coefficient of friction (-)")
    drawn.legend(fontsize=9, frameon=False)
    style.title(drawn, "Velocity steps: measured coefficient, and both laws of rate and state fitted to it.")
    return drawn


def plot_elastic_slip(data: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot compliance versus 1/preload and, beside it, capacity versus preload, with the fitted lines."""
    if ax is None:
        _, panels = plt.subplots(1, 2, figsize=(style.WIDTH, 3.8), dpi=style.DPI, layout="constrained")
    else:
        panels = np.array([ax])
    force = data["preload_force"].values
    order = np.argsort(force)
    rows = (
        ("preload_compliance", 1e9, 1.0 / force, "1/Preload (1/N)", "Compliance 1/K (nm/N)"),
        ("preload_capacity", 1.0, force, "Preload $F_N$ (N)", "Shear capacity $F_c$ (N)"),
    )
    for panel, (name, scale, x, x_label, y_label) in zip(panels, rows, strict=False):
        drawn = style.axes(panel)
        value, reach = error_bars(data, name, scale)
        drawn.errorbar(x, value, reach, fmt="o", color=style.BLUE, ms=5, capsize=3, label="ramps")
        drawn.plot(x[order], scale * data[f"{name}_fitted"].values[order], color="black", lw=1.2, label="fitted")
        drawn.set_xlabel(x_label)
        drawn.set_ylabel(y_label)
        drawn.set_xlim(left=0.0)
        drawn.set_ylim(bottom=0.0)
        drawn.legend(fontsize=9, frameon=False)
    style.title(panels[0], "Slope: elastic slip", 40)
    if len(panels) > 1:
        style.title(panels[1], "Slope: coefficient of friction", 40)
    return panels[0]
