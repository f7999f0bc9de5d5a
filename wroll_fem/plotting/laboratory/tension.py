"""Figures of the laboratory evaluation `tension`."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.plotting.laboratory.shear import error_bars


def plot_tension(data: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot tension versus voltage, one line per current, with the scatter of all samples and each trial (Fig. 3.6)."""
    drawn = style.axes(ax)
    voltage, current = data["motor_voltage"].values, data["roller_current"].values
    mean, scatter = data["winding_tension"].values, data["tension_scatter"].values
    levels = np.unique(current)
    width = 0.01 * max(float(np.ptp(voltage)), 1.0)
    of_trial = data["trial_setting"].values
    for k, level in enumerate(levels):
        own = np.flatnonzero(current == level)
        color = style.LINES[k % len(style.LINES)]
        x = voltage[own] + (k - 0.5 * (len(levels) - 1)) * width
        text = f"{level:g} A"
        drawn.errorbar(x, mean[own], scatter[own], fmt="o-", color=color, ms=5, capsize=3, lw=1.2, label=text)
        for place, setting in zip(x, own, strict=True):
            trials = data["trial_tension"].values[of_trial == setting]
            drawn.plot(np.full(len(trials), place + 0.5 * width), trials, ".", color=color, ms=4, alpha=0.6)
    drawn.set_xlabel("Voltage of the winding motor (V)")
    drawn.set_ylabel("Tension of the web (N)")
    drawn.set_ylim(bottom=min(0.0, float(np.min(mean - scatter))))
    drawn.legend(title="Current of the roller", fontsize=9, frameon=False)
    style.title(drawn, "Winding tension; bars: standard deviation within and between trials together; dots: trials.")
    return drawn


def plot_pressure(data: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot the pressure at the mandrel versus tension, with the 95 % intervals of both."""
    drawn = style.axes(ax)
    tension, across = error_bars(data, "winding_tension")
    for name, text, color in (
        ("wound_pressure", "at the mandrel", style.BLUE), ("wound_pressure_mean", "mean between the wraps", style.GREEN)
    ):  # fmt: skip
        pressure, along = error_bars(data, name, 1e-3)
        drawn.errorbar(tension, pressure, along, across, fmt="o", color=color, ms=4, capsize=2, lw=1.0, label=text)
    drawn.set_xlabel("Tension of the web (N)")
    drawn.set_ylabel("Pressure (kPa)")
    drawn.set_xlim(left=0.0)
    drawn.set_ylim(bottom=0.0)
    drawn.legend(fontsize=9, frameon=False)
    style.title(drawn, "Pressure after winding at each setting; bars: 95 % intervals of tension and pressure.")
    return drawn
