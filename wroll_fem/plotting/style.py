"""Common style of all figures: colours, sizes, titles, saving."""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wroll_fem.errors import InputError
from wroll_fem.results.storage.atomic import make_folder, replacing
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from meshio import Mesh

DPI = 150
WIDTH = 7.2  # inch: 1080 pixels, legible when a README shows it at 800
# colours of Okabe and Ito, distinguishable for colour-blind readers
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, GREY = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#CC79A7",
    "#56B4E9",
    "#7F7F7F",
)
SLIP_MAP, SLIP_ARROWS = "viridis", "viridis_r"
"""Colour maps of slip: for areas, and for arrows on a white background."""
LINES = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY, "#000000")


def axes(ax: Axes | None, height: float = 4.2) -> Axes:
    """Set up the given axes; if None, set up axes in a new figure of `WIDTH` x `height` inches."""
    if ax is None:
        _, ax = plt.subplots(figsize=(WIDTH, height), dpi=DPI, layout="constrained")
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    ax.set_axisbelow(True)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    return ax


def title(ax: Axes, sentence: str, width: int = 92) -> None:
    """Set a left-aligned title, wrapped into lines of similar length with at most `width` characters each."""
    sentence = re.sub(r"(?<=\d) (?=[nµmkM]?(?:%|Hz|m|J|s|m/s²)(?![\w/]))|(?<=layer) (?=\d)", "\u00a0", sentence)
    sentence = sentence.replace(" -", " −")
    lines = len(textwrap.wrap(sentence, width))
    even = next(w for w in range(width // 2, width + 1) if len(textwrap.wrap(sentence, w)) <= lines)
    ax.set_title(textwrap.fill(sentence, even), loc="left", fontsize=10)


def figure_of(ax: Axes) -> Figure:
    """Figure that contains the axes, directly or in a subfigure.

    Raises
    ------
    InputError
        If the axes belong to no figure.
    """
    figure = ax.get_figure(root=True)
    if not isinstance(figure, Figure):
        raise InputError("the axes belong to no figure", remedy="pass axes made by matplotlib's subplots")
    return figure


def write_figure(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure in the format of the ending of ``path``, at 150 dpi; parent folders are created.

    Raises
    ------
    InputError
        If the format is unknown, or the path cannot be written.
    StorageError
        If the disk is full or fails.
    """
    place = Path(path)
    kind = place.suffix.lower().lstrip(".")
    if kind not in figure.canvas.get_supported_filetypes():
        raise InputError("is not a name of a figure", file=str(place), remedy="end it in .png, .pdf or .svg")
    make_folder(place.parent)
    with replacing(place) as file:
        figure.savefig(file, format=kind, dpi=DPI)
    return place


def write_mesh(mesh: Mesh, path: str | os.PathLike[str]) -> Path:
    """Write nodes, cells and fields as .vtu; parent folders are created; errors as for `write_figure`."""
    place = Path(path)
    make_folder(place.parent)
    with replacing(place) as file:
        mesh.write(file, "vtu")
    return place


def save_figure(ax: Axes, path: str | os.PathLike[str]) -> Path:
    """Write the figure of `ax` at 150 dpi, close it and return the path; parent folders are created."""
    figure = figure_of(ax)
    place = write_figure(figure, path)
    plt.close(figure)
    return place


def require(dataset: xr.Dataset, names: Sequence[str], figure: str) -> None:
    """Check that the results have all variables that a figure needs.

    Raises
    ------
    InputError
        If variables are missing; the message names them.
    """
    missing = [name for name in names if name not in dataset.variables]
    if missing:
        raise InputError(
            f"the {figure} needs {', '.join(missing)}, which the results do not contain",
            remedy="plot the results of an analysis that writes them",
        )


def line_envelope(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Envelope of a long oscillating signal: x, lowest value and highest value in bins longer than one cycle.

    A signal of fewer than 400 oscillations is returned as one line, reduced by `thinned` (``low is high``).
    """
    oscillations = np.count_nonzero(np.diff(np.signbit(np.diff(y)))) // 2
    if oscillations < 400:
        x, y = thinned(x, y)
        return x, y, y
    bins = min(1500, int(oscillations / 1.3))
    edges = np.linspace(0, x.size, bins + 1).astype(int)[:-1]
    return x[edges], np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)


def thinned(x: FloatArray, y: FloatArray, bins: int = 2000) -> tuple[FloatArray, FloatArray]:
    """Thin out a long line: keep its ends and the lowest and highest point of each bin, so that it looks the same."""
    width = x.size // bins
    if width < 4:
        return x, y
    whole = y[: bins * width].reshape(bins, width)
    first = width * np.arange(bins)
    ends = np.array([0, bins * width - 1]), np.arange(bins * width, x.size)  # fewer than a bin's points are left over
    keep = np.unique(np.concatenate([first + whole.argmin(axis=1), first + whole.argmax(axis=1), *ends]))
    return x[keep], y[keep]


def three_digits(value: float) -> str:
    """Number as text: integer if 100 or more, otherwise three significant digits, such as "1834", "12.3", "0.0123"."""
    return f"{value:.0f}" if abs(value) >= 99.95 else f"{value:.3g}"


def engineering(value: float, unit: str) -> str:
    """Quantity as text with three significant digits and an SI prefix, for example "12.3 mJ"."""
    if value == 0.0 or not np.isfinite(value):
        return f"{value:g} {unit}"
    exponent = int(np.clip(np.floor(np.log10(abs(value)) / 3.0) * 3, -9, 6))
    if abs(value) / 10.0**exponent >= 999.5:
        exponent += 3
    prefix = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}[exponent]
    return f"{three_digits(value / 10.0**exponent)} {prefix}{unit}"
