"""Figures of the laboratory evaluation `shear`."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.typing import FloatArray

MARKS = {"constant": "s", "steps": "o", "sine": "^"}
"""Profile of a test -> marker."""

MOST_NAMED = 10
"""Records up to which each has an entry in the legend."""


def error_bars(data: xr.Dataset, name: str, scale: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Values (n,) and distances to the ends of their intervals (2, n), 0 for infinite ends."""
    value, low, high = (scale * data[key].values for key in (name, f"{name}_low", f"{name}_high"))
    reach = np.array([value - low, high - value])
    return value, np.where(np.isfinite(reach), reach, 0.0)


def plot_curves(data: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot force versus displacement of all records, ramps in the left panel, the others in the right one."""
    ramps = data["record_profile"].values == "ramp"
    groups = [(title, chosen) for title, chosen in (("Ramps", ramps), ("Sliding and loops", ~ramps)) if chosen.any()]
    if ax is not None:
        groups, panels = [("Records", np.ones(len(ramps), dtype=bool))], [style.axes(ax)]
    else:
        _, drawn = plt.subplots(
            1, len(groups), figsize=(style.WIDTH, 3.8), dpi=style.DPI, layout="constrained", squeeze=False
        )
        panels = [style.axes(one) for one in drawn[0]]
    for panel, (title, chosen) in zip(panels, groups, strict=True):
        numbers = np.flatnonzero(chosen)
        for place, k in enumerate(numbers):
            x, force = (data[name].values[k] for name in ("curve_displacement", "curve_force"))
            color = style.LINES[place % len(style.LINES)]
            name = str(data["test_record"].values[k]) if len(numbers) <= MOST_NAMED else None
            panel.plot(1e6 * (x - x[0]), force, color=color, lw=0.9, label=name)
            level = data["shear_capacity"].values[k]
            if np.isfinite(level):
                panel.axhline(level, color=color, lw=0.8, ls=":")
        style.title(panel, f"{title}{'; dotted: capacity' if title != 'Sliding and loops' else ''}", 40)
        panel.set_xlabel("Displacement (µm)")
        panel.set_ylabel("Shear force (N)")
        if len(numbers) <= MOST_NAMED:
            panel.legend(fontsize=8, frameon=False)
    return panels[0]


def plot_capacity(data: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot shear capacity versus preload, with 95 % intervals."""
    drawn = style.axes(ax)
    preload, rule = data["normal_force"].values, data["onset_rule"].values
    value, reach = error_bars(data, "shear_capacity")
    for name, color, mark in (("force_drop", style.BLUE, "o"), ("displacement_jump", style.ORANGE, "s")):
        own = (rule == name) & np.isfinite(preload)
        if own.any():
            text = name.replace("_", " ")
            drawn.errorbar(preload[own], value[own], reach[:, own], fmt=mark, color=color, ms=5, capsize=3, label=text)
    own = np.isfinite(preload) & np.isfinite(value)
    if own.any():
        slope = float(preload[own] @ value[own] / (preload[own] @ preload[own]))
        ends = np.array([0.0, 1.05 * preload[own].max()])
        drawn.plot(ends, slope * ends, color=style.GREY, lw=1.0, label=f"$F_c = 2 \\mu F_N$, $\\mu$ = {slope / 2:.3f}")
        drawn.legend(fontsize=9, frameon=False)
    drawn.set_xlabel("Normal force of one piston $F_N$ (N)")
    drawn.set_ylabel("Shear capacity $F_c$ (N)")
    style.title(drawn, "Force at the onset of slip, by the rule that found it; bars: 95 % interval.")
    return drawn


def plot_points(data: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot coefficient of friction versus slip rate, by profile of the test, with 95 % intervals."""
    drawn = style.axes(ax)
    draw_points(data, drawn)
    drawn.legend(fontsize=9, frameon=False)
    style.title(drawn, "Coefficient of friction in steady sliding; bars: 95 % interval.")
    return drawn


def draw_points(data: xr.Dataset, drawn: Axes) -> None:
    """Draw the points of coefficient versus slip rate."""
    profile, rate = data["point_profile"].values, data["point_slip_rate"].values
    value, reach = error_bars(data, "point_coefficient")
    for k, (name, mark) in enumerate(MARKS.items()):
        own = profile == name
        if own.any():
            text = {"constant": "constant rate", "steps": "velocity steps", "sine": "sine"}[name]
            drawn.errorbar(
                rate[own],
                value[own],
                reach[:, own],
                fmt=mark,
                color=style.LINES[k],
                ms=5,
                capsize=2,
                lw=1.0,
                label=text,
            )
    drawn.set_xscale("log")
    drawn.set_xlabel("Slip rate (m/s)")
    drawn.set_ylabel("Coefficient of friction (-)")
