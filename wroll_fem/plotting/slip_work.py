"""Figure of a coil whose wraps slide: slip zone, slip work over radius and height, and where this work is done."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from scipy.constants import g as GRAVITY

from wroll_fem.mesh.point_grid import CoilGrid
from wroll_fem.plotting import style
from wroll_fem.plotting.coil_slip import draw_slip_zone, grid_of
from wroll_fem.typing import FloatArray

DECADES = 4
"""Decades of the colour scale of the slip work."""


def slip_onset_g(dataset: xr.Dataset) -> FloatArray:
    """(n,) base acceleration, g, of the load at which each point of the path is first seen to slip; inf if never."""
    base = dataset["resonant_base_acceleration"].values / GRAVITY
    onset = dataset["tip_amplitude_at_slip"].values
    return np.where(np.isnan(onset), np.inf, np.interp(onset, dataset["tip_amplitude"].values, base))


def whole_coil(dataset: xr.Dataset) -> xr.Dataset:
    """Points of the whole circumference, from those of the whole or of half of it, with their onset of slip, g."""
    dataset = dataset.assign(slip_onset=("point", slip_onset_g(dataset)))
    if not float(dataset["theta_rad"].min()) > 0.0:
        return dataset
    half = dataset.assign(volume=0.5 * dataset["volume"])
    return xr.concat(
        [half, half.assign(theta_rad=-half["theta_rad"])], "point", data_vars="minimal", coords="minimal",
        compat="override", combine_attrs="override",
    )  # fmt: skip


def plot_slip_work(dataset: xr.Dataset) -> Axes:
    """Plot the slip zone by level, the slip work over radius and height, and the share of it near mandrel and base.

    Parameters
    ----------
    dataset
        Result of the analysis slip_damping on a grid of points.

    Returns
    -------
    Axes
        The first panel: the slip zone.

    Raises
    ------
    InputError
        If the Dataset holds no slip work, or its points form no grid.

    Notes
    -----
    Zones are as fine as the steps of the load, some 18 %. The slip work is that at the largest amplitude of the path,
    the mean around the circumference.
    """
    style.require(dataset, ("slip_work_density", "tip_amplitude_at_slip", "volume"), "slip work of a coil")
    _, panels = plt.subplots(1, 3, figsize=(1.9 * style.WIDTH, 4.4), dpi=style.DPI, layout="constrained")
    levels = dataset["amplitude_g"].values
    onset = slip_onset_g(dataset)
    slips, r_m = onset <= levels[-1], float(dataset.attrs["mandrel_radius_m"])
    reach = [
        1e3 * float(values[slips].max(initial=0.0)) for values in (dataset["z_m"].values, dataset["r_m"].values - r_m)
    ]
    draw_slip_zone(dataset, onset, levels, (reach[0], reach[1]), panels[0])
    share = 100.0 * float(dataset["volume"].values[slips].sum() / dataset["volume"].values.sum())
    style.title(panels[0], f"At {levels[-1]:g}\u00a0g {share:.2g} % of the volume slips", 44)
    _work_panel(dataset, panels[1])
    panels[1].set(xlim=panels[0].get_xlim(), ylim=panels[0].get_ylim())
    _share_panel(dataset, panels[2])
    first: Axes = panels[0]
    return first


def _faces(dataset: xr.Dataset, grid: CoilGrid) -> tuple[FloatArray, FloatArray]:
    """Distances from the mandrel and heights that separate the points of a grid, mm."""
    r_m, r_o, length = (float(dataset.attrs[f"{name}_m"]) for name in ("mandrel_radius", "coil_outer_radius", "length"))
    depth, height = (
        1e3 * np.concatenate([[low], 0.5 * (x[1:] + x[:-1]), [high]])
        for x, low, high in ((grid.r - r_m, 0.0, r_o - r_m), (grid.z, 0.0, length))
    )
    return depth, height


def _work_panel(dataset: xr.Dataset, ax: Axes) -> None:
    """Slip work per cycle and volume, mean around the circumference."""
    grid = grid_of(dataset)
    volume = dataset["volume"].values[grid.numbers]
    mean = (dataset["slip_work_density"].values[grid.numbers] * volume).sum(axis=2) / volume.sum(axis=2)
    most = float(mean.max())
    style.axes(ax).grid(False)
    ax.set_facecolor("#E4E4E4")
    if most > 0.0:
        shown = ax.pcolormesh(
            *_faces(dataset, grid), np.ma.masked_less(mean, 10.0**-DECADES * most).T, cmap="magma_r",
            norm=LogNorm(10.0**-DECADES * most, most), rasterized=True,
        )  # fmt: skip
        style.figure_of(ax).colorbar(shown, ax=ax, pad=0.02).set_label("Slip work (J/m³ per cycle)")
    ax.set_xlabel("Distance from the mandrel (mm)")
    ax.set_ylabel("Height above the base (mm)")
    tip = 1e3 * float(dataset["tip_amplitude"][-1])
    title = f"Slip work at a tip motion of {tip:.3g} mm: up to {style.engineering(most, 'J/m³')} per cycle"
    style.title(ax, title + _directions(dataset), 44)


def _directions(dataset: xr.Dataset) -> str:
    """Share of the slip work around the roll and along the axis; results before these were stored have none."""
    if "slip_work_density_rt" not in dataset:
        return ""
    around, along = (float((dataset[f"slip_work_density_{name}"] * dataset["volume"]).sum()) for name in ("rt", "rz"))
    if not around + along > 0.0:
        return ""
    return f", {100.0 * around / (around + along):.0f}\u00a0% of the work around the roll, the rest along the axis"


def _share_panel(dataset: xr.Dataset, ax: Axes) -> None:
    """Share of the slip work within a distance from the mandrel, and below a height."""
    grid = grid_of(dataset)
    work = (dataset["slip_work_density"].values * dataset["volume"].values)[grid.numbers]
    depth, height = _faces(dataset, grid)
    style.axes(ax)
    total, half = float(work.sum()), []
    rows = (("distance from the mandrel", depth, (1, 2), style.BLUE, "-"), ("height", height, (0, 2), style.RED, "--"))
    for name, faces, others, colour, line in rows:
        share = np.append(0.0, np.cumsum(work.sum(axis=others))) / (total if total > 0.0 else 1.0)
        all_of_it = float(faces[np.searchsorted(share, 0.999 * share[-1])]) or float(faces[-1])
        half.append(float(np.interp(0.5, share, faces)))
        ax.plot(faces / all_of_it, 100.0 * share, line, color=colour, lw=1.8, label=f"{name} / {all_of_it:.3g} mm")
    ax.set_xlim(0.0, 1.2)
    ax.set_ylim(0.0, 102.0)
    ax.set_xlabel("Place relative to the slip zone (–)")
    ax.set_ylabel("Share of the slip work (%)")
    ax.legend(fontsize=8, framealpha=0.95, loc="lower right")
    if total > 0.0:
        text = f"Half of the slip work is done within {half[0]:.3g} mm of the mandrel, and half below {half[1]:.3g} mm"
        style.title(ax, text, 44)
