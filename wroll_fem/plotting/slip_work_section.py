"""Slip zone and slip work of a coil whose wraps slide, on cross-sections near the root."""

from __future__ import annotations

from typing import Any, Literal

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.patches import Circle, Patch

from wroll_fem.mesh.point_grid import CoilGrid
from wroll_fem.plotting import style
from wroll_fem.plotting.coil_slip import excitation_arrow, grid_of, level_colours, levels_to_draw
from wroll_fem.plotting.slip_work import DECADES, slip_onset_g, whole_coil
from wroll_fem.typing import FloatArray, IntArray

_MANDREL, _STUCK = "#BDBDBD", "#E4E4E4"

_REACH = 1.7
"""Depth shown around the mandrel, relative to that of the slip zone."""


def plot_slip_work_section(
    dataset: xr.Dataset, quantity: Literal["level", "work"], ax: Axes | None = None, height: float = 0.0
) -> Axes:
    """Plot the level from which the wraps slide, or the slip work per cycle and volume, on a cross-section of a coil.

    Parameters
    ----------
    dataset
        Result of the analysis slip_damping on a grid of points.
    quantity
        "level": lowest level of `amplitude_g` at which each point slides; "work": slip work at the largest amplitude.
    ax
        Axes to draw in; a new figure if None.
    height
        Height above the base, m; the nearest row of points is drawn. 0 selects the lowest row.

    Returns
    -------
    Axes
        The axes drawn in; the colour scale of the work is that of the whole coil.

    Raises
    ------
    InputError
        If the Dataset holds no slip work, or its points form no grid.

    Notes
    -----
    Each point has the colour of its part of the section: values are not interpolated.
    """
    style.require(dataset, ("slip_work_density", "tip_amplitude_at_slip", "volume"), "slip work of a coil")
    whole = whole_coil(dataset)
    grid = grid_of(whole)
    row = int(np.abs(grid.z - height).argmin())
    here = grid.numbers[:, row, :]
    if ax is None:
        _, ax = plt.subplots(figsize=(5.4, 4.6), dpi=style.DPI, layout="constrained")
    place = f"{1e3 * grid.z[row]:.2g} mm above the base"
    x, y = _corners(whole, grid)
    text = _draw_levels(whole, here, (x, y), ax) if quantity == "level" else _draw_work(whole, here, (x, y), ax)
    _frame(whole, grid, ax)
    style.title(ax, f"{place[0].upper()}{place[1:]}: {text}", 44)
    return ax


def _draw_levels(whole: xr.Dataset, here: IntArray, corners: tuple[FloatArray, FloatArray], ax: Axes) -> str:
    levels = whole["amplitude_g"].values
    levels = levels[levels_to_draw(levels)]
    onset = slip_onset_g(whole)[here]
    colours = [*level_colours(levels.size)[::-1], _STUCK]
    ax.pcolormesh(
        *corners, np.searchsorted(levels, onset).astype(float), cmap=ListedColormap(colours),
        norm=BoundaryNorm(np.arange(levels.size + 2) - 0.5, levels.size + 1), rasterized=True,
    )  # fmt: skip
    names = [f"slips at {g:g} g" for g in levels] + [f"no slip up to {levels[-1]:g} g"]
    handles = [Patch(facecolor=colour, label=name) for name, colour in zip(names, colours, strict=True)]
    ax.legend(handles=handles, fontsize=7, frameon=False, loc="upper center", ncol=3, bbox_to_anchor=(0.5, -0.11))
    volume = whole["volume"].values[here]
    share = 100.0 * float(volume[onset <= levels[-1]].sum() / volume.sum())
    return f"at {levels[-1]:g}\u00a0g {share:.2g} % of the section slips"


def _draw_work(whole: xr.Dataset, here: IntArray, corners: tuple[FloatArray, FloatArray], ax: Axes) -> str:
    work = whole["slip_work_density"].values
    most = float(work.max())
    style.axes(ax).grid(False)
    if not most > 0.0:
        return "no slip work"
    shown: Any = ax.pcolormesh(
        *corners, np.ma.masked_less(work[here], 10.0**-DECADES * most), cmap="magma_r",
        norm=LogNorm(10.0**-DECADES * most, most), rasterized=True,
    )  # fmt: skip
    style.figure_of(ax).colorbar(shown, ax=ax, pad=0.02).set_label("Slip work (J/m³ per cycle)")
    at = np.unravel_index(int(work[here].argmax()), here.shape)
    angle = abs(np.degrees(whole["theta_rad"].values[here][at]))
    text = f"slip work up to {style.engineering(float(work[here].max()), 'J/m³')} per cycle, at {angle:.0f}° from x"
    return text if work[here].max() > 0.0 else "no slip work"


def _corners(whole: xr.Dataset, grid: CoilGrid) -> tuple[FloatArray, FloatArray]:
    """(n_r + 1, n_theta + 1) coordinates x and y, mm, of the faces between the points of a section."""
    inner, outer = (1e3 * float(whole.attrs[f"{name}_m"]) for name in ("mandrel_radius", "coil_outer_radius"))
    r = np.concatenate([[inner], 0.5e3 * (grid.r[1:] + grid.r[:-1]), [outer]])
    step = np.diff(grid.theta, append=grid.theta[0] + 2.0 * np.pi)
    after = grid.theta + 0.5 * step
    radius, angle = np.meshgrid(r, np.append(after[-1] - 2.0 * np.pi, after), indexing="ij")
    return radius * np.cos(angle), radius * np.sin(angle)


def _frame(whole: xr.Dataset, grid: CoilGrid, ax: Axes) -> None:
    """Mandrel, outline of the coil, direction of the motion, and axes that show the slip zone."""
    inner, outer = (1e3 * float(whole.attrs[f"{name}_m"]) for name in ("mandrel_radius", "coil_outer_radius"))
    ax.add_patch(Circle((0, 0), inner, facecolor=_MANDREL, edgecolor="#555555", lw=0.8, zorder=3))
    ax.add_patch(Circle((0, 0), outer, facecolor=_STUCK, edgecolor="#555555", lw=0.8, zorder=0))
    if whole.attrs.get("followed_mode", "bending") == "bending":
        excitation_arrow(ax, str(whole.attrs.get("excitation_direction", "x")), 0.6 * inner)
    slid = whole["r_m"].values[np.isfinite(slip_onset_g(whole))]
    depth = _REACH * (1e3 * float(slid.max()) - inner) if slid.size else outer - inner
    reach = min(1.04 * outer, inner + max(depth, 0.25 * inner))
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="x (mm)", ylabel="y (mm)", aspect="equal")


def plot_slip_work_sections(dataset: xr.Dataset) -> Axes:
    """Plot slip zone and slip work at the root and at 1 % of the length above the base; return the first panel."""
    _, panels = plt.subplots(2, 2, figsize=(1.3 * style.WIDTH, 9.4), dpi=style.DPI, layout="constrained")
    for row, height in zip(panels, (0.0, 0.01 * float(dataset.attrs["length_m"])), strict=True):
        plot_slip_work_section(dataset, "level", row[0], height)
        plot_slip_work_section(dataset, "work", row[1], height)
    first: Axes = panels[0, 0]
    return first
