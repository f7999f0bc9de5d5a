"""Figure of the laboratory evaluation `fit`: measured and computed values."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.plotting.laboratory.transmissibility import COLOURS
from wroll_fem.results.dataset import label

_NEEDS = ("datum_condition", "datum_frequency", "datum_level", "datum_quantity", "fit_measured", "fit_computed")


def plot_fit(dataset: xr.Dataset) -> Axes:
    """Plot measured and computed values: curves of two masses, or frequencies and levels of backbones.

    Returns
    -------
    Axes
        The axes, or the upper of two panels.

    Raises
    ------
    InputError
        If the Dataset has no fit.
    """
    style.require(dataset, _NEEDS, "figure of the fit")
    if str(dataset["datum_quantity"].values[0]) == "transmissibility":
        return _curves(dataset)
    return _resonances(dataset)


def _curves(dataset: xr.Dataset) -> Axes:
    drawn = style.axes(None)
    for k, name in enumerate(dataset["condition_name"].values):
        own = dataset["datum_condition"].values == k
        f, colour = dataset["datum_frequency"].values[own], COLOURS[k % len(COLOURS)]
        drawn.semilogy(f, dataset["fit_measured"].values[own], "o", ms=4, color=colour, label=str(name))
        drawn.semilogy(f, dataset["fit_computed"].values[own], "-", lw=1.2, color=colour)
    drawn.set_xlabel(label("frequency"))
    drawn.set_ylabel("Transmissibility, tip over base (–)")
    drawn.legend(fontsize=8, framealpha=0.9)
    style.title(drawn, "Two masses fitted to measured curves; points: measured, lines: model")
    return drawn


def _resonances(dataset: xr.Dataset) -> Axes:
    size = (style.WIDTH, 6.0)
    _, rows = plt.subplots(2, 1, figsize=size, dpi=style.DPI, layout="constrained", sharex=True)
    upper, lower = (style.axes(ax) for ax in rows)
    level, quantity = dataset["datum_level"].values, dataset["datum_quantity"].values
    measured, computed = dataset["fit_measured"].values, dataset["fit_computed"].values
    first = np.char.startswith(quantity.astype(str), "f_n")
    upper.semilogx(level[first], measured[first], "o", ms=5, color=style.BLUE, label="measured")
    upper.semilogx(level[first], computed[first], "x", ms=6, color=style.RED, label="fitted backbones")
    lower.semilogx(level[~first], 100.0 * (computed[~first] / measured[~first] - 1.0), "x", ms=6, color=style.RED)
    lower.axhline(0.0, color=style.GREY, lw=0.8)
    upper.set_ylabel(label("condition_f_n"))
    lower.set_ylabel("Level of the model\nabove the measured one (%)")
    lower.set_xlabel("Base acceleration at the resonance (m/s², 0-peak)")
    upper.legend(fontsize=8, framealpha=0.9)
    style.title(upper, "Backbones of the roll fitted to its resonances over level and tension")
    return upper
