"""Figures of the laboratory evaluation `transmissibility`: curves, and frequency and damping over the level."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.typing import IntArray

COLOURS = (style.BLUE, style.RED, style.GREEN, style.ORANGE, style.PURPLE, style.SKY, style.GREY)
MARKS = ("o", "s", "^", "D", "v", "P", "X")


def plot_curves(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot the transmissibility of each condition versus frequency.

    Parameters
    ----------
    dataset
        Results of the evaluation `transmissibility`.

    Raises
    ------
    InputError
        If the Dataset has no curves.
    """
    style.require(dataset, ("family_real", "family_imag", "condition_name"), "figure of the curves")
    drawn = style.axes(ax)
    f = dataset["frequency"].values
    size = np.hypot(dataset["family_real"].values, dataset["family_imag"].values)
    for k, name in enumerate(dataset["condition_name"].values):
        colour = COLOURS[k % len(COLOURS)]
        drawn.semilogy(f, size[k], color=colour, lw=1.3, label=str(name))
        if "family_error" in dataset:
            error = 1.96 * dataset["family_error"].values[k] * size[k]
            low = np.maximum(size[k] - error, 0.2 * size[k])
            drawn.fill_between(f, low, size[k] + error, color=colour, alpha=0.2, lw=0)
    drawn.set_xlabel(label("frequency"))
    drawn.set_ylabel("Transmissibility, tip over base (–)")
    drawn.legend(fontsize=8, framealpha=0.9)
    drawn.margins(x=0.0)
    words = "H1 of the pooled trials; band: 95 %" if dataset.attrs.get("method") == "random" else "mean of the sweeps"
    style.title(drawn, f"Transmissibility of {len(size)} condition{'s' if len(size) > 1 else ''}, {words}")
    return drawn


def plot_levels(dataset: xr.Dataset) -> Axes:
    """Plot resonance frequency and damping ratio versus the level of the base, one line per tension.

    Parameters
    ----------
    dataset
        Results of the evaluation `transmissibility`.

    Returns
    -------
    Axes
        The upper of two panels.

    Raises
    ------
    InputError
        If the Dataset has no conditions.
    """
    style.require(dataset, ("condition_f_n", "condition_zeta", "base_level", "tension"), "figure over the level")
    size = (style.WIDTH, 6.0)
    _, rows = plt.subplots(2, 1, figsize=size, dpi=style.DPI, layout="constrained", sharex=True)
    frequency, damping = (style.axes(ax) for ax in rows)
    tension = np.nan_to_num(dataset["tension"].values, nan=-1.0)
    for k, value in enumerate(dict.fromkeys(sorted(tension))):
        at = np.flatnonzero(tension == value)
        at = at[np.argsort(dataset["base_level"].values[at])]
        words = f"{value:g} N" if value >= 0.0 else "tension not given"
        kind = {"color": COLOURS[k % len(COLOURS)], "marker": MARKS[k % len(MARKS)], "label": words}
        for panel, name, factor in ((frequency, "condition_f_n", 1.0), (damping, "condition_zeta", 100.0)):
            _with_bars(panel, dataset, name, at, factor, kind)
            _trials(panel, dataset, name.replace("condition", "trial"), at, factor, kind["color"])
    frequency.set_ylabel(label("condition_f_n"))
    damping.set_ylabel("Damping ratio (%)")
    damping.set_xlabel(label("base_level"))
    frequency.legend(fontsize=8, framealpha=0.9)
    style.title(frequency, "Resonance of each condition; bars: 95 % interval, small points: single trials")
    return frequency


def _with_bars(panel: Axes, dataset: xr.Dataset, name: str, at: IntArray, factor: float, kind: dict[str, Any]) -> None:
    """Line with error bars over the level; bars are left out where an interval is unknown."""
    x, y = dataset["base_level"].values[at], factor * dataset[name].values[at]
    bars = factor * np.nan_to_num(dataset[f"{name}_interval"].values[at])
    panel.errorbar(x, y, yerr=bars, lw=1.2, ms=5, capsize=3, **kind)


def _trials(panel: Axes, dataset: xr.Dataset, name: str, at: IntArray, factor: float, colour: str) -> None:
    """Points of the single trials."""
    own = np.isin(dataset["trial_condition"].values, at)
    x, y = dataset["trial_base_level"].values[own], factor * dataset[name].values[own]
    panel.plot(x, y, ".", color=colour, ms=3, alpha=0.7)
