"""What all figures share: colours, sizes, titles that state what is seen, saving."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wroll_fem.errors import InputError

FloatArray = npt.NDArray[np.float64]
DPI = 150
WIDTH = 7.2  # inch: 1080 pixels, legible when a README shows it at 800
# Okabe and Ito's colours, told apart by colour-blind readers
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, GREY = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#CC79A7",
    "#56B4E9",
    "#7F7F7F",
)
LINES = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY, "#000000")


def axes(ax: Axes | None, height: float = 4.2) -> Axes:
    """Return the axes given, or those of a new figure (inches: `WIDTH` x `height`)."""
    if ax is None:
        _, ax = plt.subplots(figsize=(WIDTH, height), dpi=DPI, layout="constrained")
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    ax.set_axisbelow(True)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    return ax


def title(ax: Axes, sentence: str, width: int = 84) -> None:
    """Left-aligned title sentence, broken into lines that fit the figure."""
    ax.set_title(textwrap.fill(sentence, width), loc="left", fontsize=10)


def figure_of(ax: Axes) -> Figure:
    """Figure that holds the axes, also when they sit in a subfigure."""
    figure = ax.get_figure(root=True)
    if not isinstance(figure, Figure):
        raise InputError("axes without a figure", remedy="pass axes made by matplotlib's subplots")
    return figure


def save_figure(ax: Axes, path: str | os.PathLike[str]) -> Path:
    """Write the figure of `ax` at 150 dpi (parents are made), close it and return the path."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    figure = figure_of(ax)
    figure.savefig(target, dpi=DPI)
    plt.close(figure)
    return target


def require(dataset: xr.Dataset, names: Sequence[str], figure: str) -> None:
    """Raise an InputError that names what the Dataset lacks for this figure."""
    missing = [name for name in names if name not in dataset.variables]
    if missing:
        raise InputError(
            f"the {figure} needs {', '.join(missing)}, which the results do not hold",
            remedy="plot the results of an analysis that writes them",
        )


def line_envelope(x: FloatArray, y: FloatArray, bins: int = 1500) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Lowest and highest value of a long oscillating series per bin: (x, low, high), at most `bins` each."""
    if x.size <= 2 * bins:
        return x, y, y
    edges = np.linspace(0, x.size, bins + 1).astype(int)[:-1]
    return x[edges], np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)


def engineering(value: float, unit: str) -> str:
    """Three significant digits with an SI prefix, "12.3 mJ"."""
    if value == 0.0 or not np.isfinite(value):
        return f"{value:g} {unit}"
    exponent = int(np.clip(np.floor(np.log10(abs(value)) / 3.0) * 3, -9, 6))
    if abs(value) / 10.0**exponent >= 999.5:
        exponent += 3
    prefix = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}[exponent]
    return f"{value / 10.0**exponent:.3g} {prefix}{unit}"
