"""Figure of a design map: frequency disparity between stiffest and softest coil versus mandrel radius."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes

from wroll_fem.plotting import style
from wroll_fem.results.dataset import label


def plot_design_map(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the frequency disparity versus mandrel radius, one line per wall thickness (thesis, Fig. 2.16).

    A black ring marks the mandrel of the case. Mandrels whose fundamental mode is not bending are omitted; the title
    gives their number.

    Raises
    ------
    InputError
        If the Dataset holds no design map.
    """
    style.require(dataset, ("frequency_disparity",), "design map")
    disparity = dataset["frequency_disparity"].transpose("mandrel_radius", "mandrel_thickness")
    radii, walls = 1e3 * disparity["mandrel_radius"].values, 1e3 * disparity["mandrel_thickness"].values
    ax = style.axes(ax, 4.6)
    colours = colormaps["viridis"](np.linspace(0.0, 0.9, len(walls)))
    for k, (wall, colour) in enumerate(zip(walls, colours, strict=True)):
        ax.plot(radii, disparity.values[:, k], "o-", ms=4, lw=1.8, color=colour, label=f"{wall:.3g} mm")
    attrs = dataset.attrs
    own = attrs["own_frequency_tightest"] - attrs["own_frequency_loosest"]
    if np.isfinite(own):
        text = f"this case: {1e3 * attrs['own_mandrel_thickness']:.3g} mm, {own:.1f} Hz"
        at = 1e3 * attrs["own_mandrel_radius"], own
        ax.plot(*at, "o", ms=10, mfc="none", mec="black", mew=1.5, label=text, ls="none")
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(label("mandrel_radius", "mm"))
    ax.set_ylabel("Frequency disparity (Hz)")
    ax.legend(title="Wall of the mandrel", fontsize=8, title_fontsize=8, framealpha=0.9, loc="upper left", ncols=2)
    style.title(ax, _sentence(disparity))
    return ax


def _sentence(disparity: xr.DataArray) -> str:
    missing = int(disparity.isnull().sum())
    if missing == disparity.size:
        return "No mandrel has bending as its fundamental mode"
    top = disparity.isel(disparity.argmax(...))  # type: ignore[arg-type]
    where = f"radius {1e3 * float(top['mandrel_radius']):.3g} mm, wall {1e3 * float(top['mandrel_thickness']):.3g} mm"
    said = f"Stiffest and softest coil differ by up to {float(top):.0f} Hz ({where})"
    values = disparity.values
    if missing == 0 and min(values.shape) > 1:
        wider, thinner = bool((np.diff(values, axis=0) > 0).all()), bool((np.diff(values, axis=1) < 0).all())
        if wider and thinner:
            said += "; the disparity grows with the radius and with a thinner wall"
    return said + (
        f"; {missing} of {disparity.size} mandrels have a fundamental mode other than bending" if missing else ""
    )
