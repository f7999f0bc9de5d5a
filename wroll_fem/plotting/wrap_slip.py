"""Figure of a shaken coil whose wraps slide: slip between neighbouring wraps over radius and height."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from wroll_fem.errors import InputError
from wroll_fem.mesh.point_grid import CoilGrid, coil_grid
from wroll_fem.plotting import style
from wroll_fem.results.interface_slip import fills_body
from wroll_fem.typing import FloatArray

_DECADES = 4
"""Decades of the colour scale."""

_REACH = 1.4
"""Range of the axes, relative to the depth and the height up to which wraps slide."""


def has_wraps(dataset: xr.Dataset) -> bool:
    """Whether a result has slip between wraps at points that form a grid."""
    return "cumulative_slip" in dataset and _grid(dataset) is not None


def plot_wrap_slip(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the accumulated slip between neighbouring wraps over radius and height, the largest around the roll.

    Parameters
    ----------
    dataset
        Result of harmonic, backbone, sweep or dwell with `coil.inside: slipping`.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        If the result has no slip between wraps, or its points form no grid.

    Notes
    -----
    The slip of a periodic motion is that of one period, that of a history is that of all of it.
    """
    number, grid = _interface(dataset), _grid(dataset)
    if number is None or grid is None:
        remedy = "use a result with coil.inside: slipping on a generated mesh"
        raise InputError("the results have no slip between wraps on a grid of points", remedy=remedy)
    slip = 1e6 * dataset["cumulative_slip"].isel(interface=number).values[grid.numbers].max(axis=2)
    most = float(slip.max())
    ax = style.axes(ax, 4.6)
    ax.grid(False)
    ax.set_facecolor("#E4E4E4")
    depth, height = (1e3 * (faces - faces[0]) for faces in (_faces(grid.r), _faces(grid.z)))
    if most > 0.0:
        shown = ax.pcolormesh(
            depth, height, np.ma.masked_less(slip, 10.0**-_DECADES * most).T, cmap="magma_r",
            norm=LogNorm(10.0**-_DECADES * most, most), rasterized=True,
        )  # fmt: skip
        style.figure_of(ax).colorbar(shown, ax=ax, pad=0.02).set_label(f"Slip between two wraps (µm{_per(dataset)})")
        slides = slip > 10.0**-_DECADES * most
        ax.set_xlim(0.0, min(_REACH * depth[1:][slides.any(axis=1)].max(), depth[-1]))
        ax.set_ylim(0.0, min(_REACH * height[1:][slides.any(axis=0)].max(), height[-1]))
    ax.set_xlabel("Distance from the mandrel (mm)")
    ax.set_ylabel("Height above the base (mm)")
    area = dataset["area"].isel(interface=number).values
    share = 100.0 * float(area[dataset["slipped"].isel(interface=number).values.astype(bool)].sum() / area.sum())
    text = f"Wraps slide in {share:.2g}\u00a0% of the coil, by up to {most:.3g}\u00a0µm{_per(dataset)}"
    style.title(ax, text if most > 0.0 else "No wraps slide", 60)
    return ax


def _per(dataset: xr.Dataset) -> str:
    return "" if "time" in dataset.dims else " per period"


def _interface(dataset: xr.Dataset) -> int | None:
    """Number of the interface between the wraps; None without one."""
    numbers = range(dataset.sizes.get("interface", 0))
    return next((number for number in numbers if fills_body(dataset, number)), None)


def _grid(dataset: xr.Dataset) -> CoilGrid | None:
    """Grid of the points between the wraps; None without wraps that slide, or where the points form none."""
    number = _interface(dataset)
    if number is None:
        return None
    place = [dataset[name] for name in ("theta_rad", "z_m", "r_m")]
    rows = [p.isel(interface=number).values if "interface" in p.dims else p.values for p in place]
    return coil_grid(np.stack(rows, axis=1))


def _faces(at: FloatArray) -> FloatArray:
    """(n + 1,) coordinates that separate n points; the outer ones are as far from the points as their neighbours."""
    middle = 0.5 * (at[1:] + at[:-1])
    return np.concatenate([[2.0 * at[0] - middle[0]], middle, [2.0 * at[-1] - middle[-1]]])
