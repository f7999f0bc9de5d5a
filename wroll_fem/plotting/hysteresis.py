"""Figure of the hysteresis loops of joints."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style

MOST = 6
"""Largest number of joints in the figure; those with the largest loss are drawn."""


def plot_hysteresis(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot force versus relative displacement of each joint during one period at the peak, with the loss per cycle.

    Parameters
    ----------
    dataset
        Result of the analysis harmonic for matrices without coordinates of the points, for example joints.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        If the Dataset holds no loops.
    """
    style.require(dataset, ("loop_displacement", "loop_force", "interface_name"), "hysteresis loops")
    ax = style.axes(ax)
    x, f = dataset["loop_displacement"].values, dataset["loop_force"].values
    loss = 0.5 * np.sum((f + np.roll(f, -1, axis=1)) * (np.roll(x, -1, axis=1) - x), axis=1)
    largest = max(float(np.abs(x).max()), 1e-300)
    power = max(0, int(np.ceil(-np.log10(largest) / 3.0)))
    unit, factor = ("m", "mm", "µm", "nm")[min(power, 3)], 1e3 ** min(power, 3)
    chosen = np.sort(np.argsort(-np.abs(loss), kind="stable")[:MOST])
    for k in chosen:
        name = str(dataset["interface_name"].values[k])
        closed = np.append(np.arange(x.shape[1]), 0)
        ax.plot(factor * x[k, closed], f[k, closed], lw=1.5, label=f"{name}: {loss[k]:.3g} J per cycle")
    ax.set_xlabel(f"Relative displacement ({unit})")
    ax.set_ylabel("Force (N)")
    ax.axhline(0.0, color=style.GREY, lw=0.6)
    ax.axvline(0.0, color=style.GREY, lw=0.6)
    ax.legend(frameon=False, fontsize=8)
    hertz = dataset.attrs.get("fields_at_frequency_hz")
    left = f", {len(x) - len(chosen)} joints with a smaller loss not shown" if len(chosen) < len(x) else ""
    place = "" if hertz is None else f" at {hertz:.4g} Hz"
    style.title(ax, f"Force of the joints during one period at the peak{place}{left}")
    return ax
