"""Figures of the laboratory evaluation `transmissibility`."""

from __future__ import annotations

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label
from wroll_fem.signals.transmissibility import magnitude


def plot_coherence(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Plot |H1| versus frequency."""
    drawn = style.axes(ax) if ax is not None else style.axes(plt.subplots(figsize=(style.WIDTH, 4.0))[1])
    drawn.semilogy(dataset["frequency"].values, magnitude(dataset).values, color=style.BLUE)
    drawn.set_xlabel(label("frequency"))
    drawn.set_ylabel("Transmissibility |H1| (-)")
    return drawn
