"""Slip zone and slip work of a coil whose wraps slide, in three dimensions: a picture rendered by pyvista."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from wroll_fem.plotting import style
from wroll_fem.plotting.coil_slip_space import STUCK, cut_coil, cut_roll, draw_pictures
from wroll_fem.plotting.mode_shapes import _cropped, _render
from wroll_fem.plotting.slip_work import DECADES, whole_coil
from wroll_fem.typing import FloatArray

_VIEWS = {"x": (0.25, -1.0, 0.45), "y": (1.0, 0.25, 0.45)}
"""Direction of the viewer who looks on a cut along x or along y."""


def plot_slip_work_in_coil(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Render the coil near its root: level from which its wraps slide, and slip work along and across the excitation.

    Parameters
    ----------
    dataset
        Result of the analysis slip_damping on a grid of points.
    path
        PNG to write; parent folders are created.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        If the Dataset holds no slip work, its points form no grid, or pyvista is missing.
    """
    style.require(dataset, ("slip_work_density", "tip_amplitude_at_slip", "volume"), "slip work of a coil")
    whole = whole_coil(dataset)
    along = str(whole.attrs.get("excitation_direction", "x"))
    along, across = ("x", "y") if along != "y" else ("y", "x")
    work = whole["slip_work_density"].values
    most = float(work.max()) or 1.0
    slid = np.isfinite(whole["slip_onset"].values)
    outer, length = (float(whole.attrs[f"{name}_m"]) for name in ("coil_outer_radius", "length"))
    top = min(length, max(1.3 * outer, 1.15 * float(whole["z_m"].values[slid].max(initial=0.0))))
    shown = np.where(work >= 10.0**-DECADES * most, np.log10(np.maximum(work, 1e-300) / most), np.nan)
    options = {"cmap": "magma_r", "clim": (-float(DECADES), 0.0), "nan_color": STUCK, "lighting": False}
    bending = whole.attrs.get("followed_mode", "bending") == "bending"
    headings = ("along the excitation", "across it") if bending else ("along x", "along y")
    zone, zone_top = cut_coil(whole, top, along)
    zone[0][1].update(lighting=False, ambient=0.0)
    pictures = {
        f"slip zone, cut {headings[0]}": _picture(zone, zone_top, _VIEWS[along], outer),
        f"slip work, cut {headings[0]}": _picture(*cut_roll(whole, top, along, shown, options), _VIEWS[along], outer),
        f"slip work, cut {headings[1]}": _picture(*cut_roll(whole, top, across, shown, options), _VIEWS[across], outer),
    }
    figure = Figure(figsize=(1.55 * style.WIDTH, 4.6), dpi=style.DPI, layout="constrained")
    panels = list(figure.subplots(1, 3))
    draw_pictures(
        figure, panels, {f"{name}, lowest {1e3 * top:.0f} mm": shot for name, shot in pictures.items()}, whole
    )
    scale = ScalarMappable(LogNorm(10.0**-DECADES * most, most), "magma_r")
    figure.colorbar(scale, ax=panels, pad=0.01, shrink=0.8).set_label("Slip work (J/m³ per cycle)")
    figure.suptitle(_finding(whole, slid), fontsize=10)
    return style.write_figure(figure, path)


def _picture(meshes: list[tuple[Any, dict[str, Any]]], top: float, view: tuple[float, ...], outer: float) -> FloatArray:
    extent = max(top, 2.0 * outer)
    return np.asarray(_cropped([_render(meshes, np.array([0.0, 0.0, 0.5 * top]), view, extent)])[0])


def _finding(whole: xr.Dataset, slid: npt.NDArray[np.bool_]) -> str:
    """Sentence on the place of the work; ``slid`` (n_points,): the points that slide."""
    work = float((whole["slip_work_density"] * whole["volume"]).sum())
    if not slid.any() or not work > 0.0:
        return "No slip between the wraps"
    depth = whole["r_m"].values - float(whole.attrs["mandrel_radius_m"])
    reach = [1e3 * float(values[slid].max()) for values in (whole["z_m"].values, depth)]
    tip = 1e3 * float(whole["tip_amplitude"][-1])
    return (
        f"At a tip motion of {tip:.3g} mm wraps slide up to {reach[0]:.3g} mm above the base and {reach[1]:.3g} mm "
        f"from the mandrel and dissipate {style.engineering(work, 'J')} per cycle"
    )
