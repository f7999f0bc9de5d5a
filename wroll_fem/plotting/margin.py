"""Figure of the sizing of a mandrel: margin against yield versus wall, one curve per reading of the stress."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label

_WITHOUT = "_without_pressure"
_TOP = 2.0
"""Margins above this one, or above three times the wanted margin, are not drawn."""


def plot_margin(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the margin against yield versus the wall; dots mark the walls with the wanted margin.

    Curves of the same colour belong to one place of the stress; the dashed curve is without the pressure. A ring marks
    the wall for which buckling, stiffness and frequencies were computed.

    Raises
    ------
    InputError
        If the Dataset holds no sizing of a mandrel.
    """
    style.require(dataset, ("margin", "wall_thickness"), "sizing of a mandrel")
    ax = style.axes(ax, 4.8)
    walls = 1e3 * dataset["mandrel_thickness"].values
    wanted, attrs = float(dataset.attrs["wanted_margin"]), dataset.attrs
    margin, found = dataset["margin"], 1e3 * dataset["wall_thickness"]
    places = [name for name in map(str, margin["reading"].values) if not name.endswith(_WITHOUT)]
    handles: list[Line2D] = []
    for name, colour in zip(places, style.LINES, strict=False):
        for reading, dash in ((name, "-"), (name + _WITHOUT, "--")):
            curve = 100.0 * margin.sel(reading=reading).values
            ax.plot(walls, curve, dash, color=colour, lw=1.8 if dash == "-" else 1.2)
            if attrs["searched"]:
                ax.plot(float(found.sel(reading=reading)), 100.0 * wanted, "o", ms=4, color=colour, zorder=4)
        handles.append(Line2D([], [], color=colour, lw=1.8, label=name.replace("_", " ")))
    ax.axhline(100.0 * wanted, color="black", lw=0.8)
    handles.append(Line2D([], [], color="black", lw=0.8, label=f"wanted margin, {100.0 * wanted:.3g} %"))
    handles.append(Line2D([], [], color="grey", lw=1.2, ls="--", label="dashed: without the pressure"))
    own, at_own = 1e3 * attrs["design_wall_m"], attrs["wall_margins"][attrs["design_reading"]]
    said = f"wall of {own:.3g} mm"
    ax.plot(own, 100.0 * at_own, "o", ms=10, mfc="none", mec="black", mew=1.5)
    handles.append(Line2D([], [], marker="o", ms=8, mfc="none", mec="black", mew=1.5, ls="none", label=said))
    top = 100.0 * max(_TOP, 3.0 * wanted, 1.2 * at_own)
    shown = (margin.max("reading").values > -0.95) & (margin.min("reading").values < 0.01 * top)
    shown = shown if shown.any() else np.ones(len(walls), bool)
    ax.set_xscale("log")
    ax.set_xlim(min(walls[shown].min(), 0.9 * own), max(walls[shown].max(), 1.1 * own))
    ax.set_ylim(-100.0, top)
    ax.xaxis.set_major_formatter("{x:g}")
    ax.set_xlabel(label("mandrel_thickness", "mm"))
    ax.set_ylabel("Margin against yield (%)")
    ax.legend(handles=handles, fontsize=8, framealpha=0.9, loc="upper left")
    style.title(ax, _sentence(dataset))
    return ax


def _sentence(dataset: xr.Dataset) -> str:
    attrs, reading = dataset.attrs, str(dataset.attrs["design_reading"]).replace("_", " ")
    wall, wanted = 1e3 * attrs["design_wall_m"], 100.0 * attrs["wanted_margin"]
    if not attrs["searched"]:
        least = 100.0 * attrs["wall_margins"][attrs["design_reading"]]
        return f"{attrs['structure']}: a wall of {wall:.3g} mm has a margin of {least:.3g} % ({reading})"
    walls = 1e3 * dataset["wall_thickness"].drop_sel(reading=attrs["design_reading"]).values
    known = not np.isnan(walls).all()
    between = f"; the other readings need {np.nanmin(walls):.3g} to {np.nanmax(walls):.3g} mm" if known else ""
    return f"{attrs['structure']}: a margin of {wanted:.3g} % needs a wall of {wall:.3g} mm ({reading}){between}"
