"""Figures of a solid coil: shear stress relative to the friction capacity, slip zone, and tip response."""

from __future__ import annotations

from typing import Literal

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.patches import Circle, Patch
from scipy.constants import g as GRAVITY

from wroll_fem.errors import InputError
from wroll_fem.mesh.point_grid import CoilGrid, coil_grid, largest_along
from wroll_fem.plotting import style
from wroll_fem.typing import FloatArray

_POINTS = ("theta_rad", "z_m", "r_m", "shear_resultant", "friction_capacity", "capacity_profile", "amplitude_g")
_CAPACITY = "#C00000"
_MANDREL = "#BDBDBD"
_NEVER = 100.0
"""Onset of slip, relative to the highest level, that stands for points that do not slip."""
_LINEAR_UP_TO = 5.0  # times the capacity; beyond this the axis is logarithmic, so that the crossing can be read


def points_of(dataset: xr.Dataset) -> FloatArray:
    """(n_points, 3) coordinates theta (rad), z (m) and r (m) of the quadrature points."""
    return np.stack([dataset[name].values for name in ("theta_rad", "z_m", "r_m")], axis=1)


def has_grid(dataset: xr.Dataset) -> bool:
    """Whether the quadrature points form a grid; maps of cross-sections need one."""
    return coil_grid(points_of(dataset)) is not None


def grid_of(dataset: xr.Dataset) -> CoilGrid:
    """Grid of the quadrature points.

    Raises
    ------
    InputError
        If the points do not form a grid (a mesh supplied by the user).
    """
    grid = coil_grid(points_of(dataset))
    if grid is None:
        raise InputError("the quadrature points of the coil do not form a grid", remedy="use the generated mesh")
    return grid


def level_colours(count: int) -> list[str]:
    """Colours of `count` excitation levels, from light to dark."""
    return [to_hex(colormaps["viridis_r"](share)) for share in np.linspace(0.15, 1.0, count)]


def levels_to_draw(levels: FloatArray, most: int = 8) -> list[int]:
    """Indices of at most `most` evenly spaced excitation levels, including the first and the last."""
    return sorted(set(np.linspace(0, levels.size - 1, min(most, levels.size)).round().astype(int).tolist()))


def plot_shear_along(dataset: xr.Dataset, along: Literal["z", "r"], ax: Axes | None = None) -> Axes:
    """Plot the largest shear resultant and the friction capacity versus height or radius (thesis, Fig. 2.14).

    There is one curve per excitation level, for at most eight levels.

    Parameters
    ----------
    dataset
        Results of `modal_transient`.
    along
        "z": versus z/L, the largest value of all angles and radii; "r": versus r/r_m, the largest value of all angles
        and heights.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset lacks a field.

    Notes
    -----
    All values are divided by the capacity at the mandrel, which is the largest. The capacity depends only on the
    radius, so the plot versus height shows only its largest value.
    """
    style.require(dataset, _POINTS, "shear distribution")
    attrs, levels = dataset.attrs, dataset["amplitude_g"].values
    most, shear = float(attrs["capacity_mandrel_pa"]), dataset["shear_resultant"].values
    position, largest = _largest(dataset, along, shear)
    scale = float(attrs["length_m" if along == "z" else "mandrel_radius_m"])
    ax = style.axes(ax, 4.0)
    drawn = levels_to_draw(levels)
    for number, colour in zip(drawn, level_colours(len(drawn)), strict=True):
        g = levels[number]
        ax.plot(position / scale, g * largest / most, color=colour, lw=1.5, label=f"{g:g} g")
    if along == "z":
        ax.axhline(1.0, color=_CAPACITY, lw=1.8, ls=":", label="largest capacity")
        ax.set_xlim(0.0, 1.0)
        ax.set_xlabel("Height above the base / length, z/L")
    else:
        radius, capacity = dataset["capacity_radius"].values, dataset["capacity_profile"].values
        positive = capacity > 0.0  # a logarithmic axis cannot show the zero at the surface
        ax.plot(radius[positive] / scale, capacity[positive] / most, color=_CAPACITY, lw=1.8, label="capacity")
        ax.set_xlim(1.0, radius[-1] / scale)
        ax.set_xlabel("Radius / mandrel radius, r/r_m")
    highest = max(1.0, levels[-1] * float(largest.max()) / most)
    if highest > _LINEAR_UP_TO:
        ax.set_yscale("log")
        ax.set_ylim(0.01, 1.3 * highest)
    else:
        ax.set_ylim(0.0, 1.08 * highest)
    ax.set_ylabel("Largest shear resultant\n/ largest capacity (–)")
    ax.legend(fontsize=8, ncol=2, framealpha=0.95, loc="upper right")
    peak = int(np.argmax(largest))
    style.title(
        ax,
        f"Largest shear resultant {style.engineering(levels[-1] * largest[peak], 'Pa')} at "
        f"{levels[-1]:g}\u00a0g, {_place(along, position[peak], scale)}",
        48,
    )
    return ax


def _largest(dataset: xr.Dataset, along: str, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distinct coordinates z or r (``along``) of the points, and the largest value at each coordinate."""
    grid = coil_grid(points_of(dataset))
    if grid is None:
        return largest_along(dataset[f"{along}_m"].values, values)
    table = values[grid.numbers]
    return (grid.z, table.max(axis=(0, 2))) if along == "z" else (grid.r, table.max(axis=(1, 2)))


def _place(along: str, position: float, scale: float) -> str:
    if along == "z":
        return f"{1e3 * position:.2g} mm above the base"
    return f"{1e3 * (position - scale):.2f} mm from the mandrel"


def plot_root_section(
    dataset: xr.Dataset, component: Literal["rz", "rt"], ax: Axes | None = None, height: float = 0.0
) -> Axes:
    """Plot the amplitude of one shear component on a cross-section at the highest excitation level (thesis, Fig. 2.15).

    Parameters
    ----------
    dataset
        Results of `modal_transient` on a grid of points.
    component
        "rz": axial shear; "rt": hoop shear.
    ax
        Axes to draw in; a new figure if None.
    height
        Height above the base, m; the nearest row of points is drawn. 0 selects the lowest row, which lies above the
        end face (a free surface without axial shear).

    Returns
    -------
    Axes
        The axes drawn in; the colour scale is the same for both components.

    Raises
    ------
    InputError
        When the Dataset lacks a field or its points form no grid.

    Notes
    -----
    Values are interpolated linearly between the quadrature points. A dashed line bounds the part of the section that
    slips.
    """
    style.require(dataset, (*_POINTS, "shear_rz", "shear_rt"), "root section")
    grid, top = grid_of(dataset), float(dataset["amplitude_g"].values[-1])
    most, r_m = float(dataset.attrs["capacity_mandrel_pa"]), float(dataset.attrs["mandrel_radius_m"])
    row = int(np.abs(grid.z - height).argmin())
    root = grid.numbers[:, row, :]
    shown = {name: top * dataset[f"shear_{name}"].values[root] / most for name in ("rz", "rt")}
    margin = dataset["slip_onset"].values[root]
    if ax is None:
        _, ax = plt.subplots(figsize=(4.6, 4.6), dpi=style.DPI, layout="constrained")
    theta = np.append(grid.theta, grid.theta[0] + 2.0 * np.pi)
    radius, angle = np.meshgrid(1e3 * grid.r, theta, indexing="ij")
    x, y = radius * np.cos(angle), radius * np.sin(angle)

    def closed(values: FloatArray) -> FloatArray:
        return np.concatenate([values, values[:, :1]], axis=1)

    ax.pcolormesh(
        x, y, closed(shown[component]), shading="gouraud", cmap="magma_r", vmin=0.0,
        vmax=max(float(values.max()) for values in shown.values()), rasterized=True,
    )  # fmt: skip
    if margin.min() < top < margin.max():
        ax.contour(x, y, closed(np.minimum(margin, 10 * top)), levels=[top], colors="#00A0FF", linewidths=1.3,
                   linestyles="--")  # fmt: skip
    outer = 1e3 * float(dataset.attrs["coil_outer_radius_m"])
    ax.add_patch(Circle((0, 0), 1e3 * r_m, facecolor=_MANDREL, edgecolor="#555555", lw=0.8, zorder=3))
    ax.add_patch(Circle((0, 0), outer, facecolor="none", edgecolor="#555555", lw=0.8))
    excitation_arrow(ax, str(dataset.attrs.get("excitation_direction", "x")), 0.6e3 * r_m)
    ax.set_xlim(-1.08 * outer, 1.08 * outer)
    ax.set_ylim(-1.08 * outer, 1.08 * outer)
    ax.set_aspect("equal")
    ax.set_xlabel("x (mm)")
    ax.set_ylabel("y (mm)")
    peak = np.unravel_index(int(shown[component].argmax()), root.shape)
    name = {"rz": "Axial shear σ_rz", "rt": "Hoop shear σ_rθ"}[component]
    style.title(
        ax,
        f"{name} {1e3 * grid.z[row]:.2g} mm above the base, {top:g}\u00a0g: largest {shown[component][peak]:.3g} times "
        f"the capacity, at {abs(np.degrees(grid.theta[peak[1]])):.0f}° from x",
        44,
    )
    return ax


def excitation_arrow(ax: Axes, direction: str, half: float) -> None:
    """Draw a double arrow along the excitation, "x" or "y", in the middle of a cross-section, ``half`` as long."""
    tip = (half, 0.0) if direction == "x" else (0.0, half)
    ax.annotate(
        "", xy=tip, xytext=(-tip[0], -tip[1]), arrowprops={"arrowstyle": "<->", "color": "black", "lw": 1.4}, zorder=4
    )


def plot_shear_distribution(dataset: xr.Dataset) -> Axes:
    """Plot the shear resultant versus height and radius, side by side (thesis, Fig. 2.14); return the first axes."""
    _, panels = plt.subplots(1, 2, figsize=(1.35 * style.WIDTH, 4.0), dpi=style.DPI, layout="constrained")
    plot_shear_along(dataset, "z", panels[0])
    plot_shear_along(dataset, "r", panels[1])
    return panels[0]


def plot_root_sections(dataset: xr.Dataset) -> Axes:
    """Plot both shear components at the root and at 1 % of the length above the base (thesis, Fig. 2.15).

    Returns
    -------
    Axes
        The first panel: axial shear on the lowest row of points.
    """
    figure, panels = plt.subplots(2, 2, figsize=(1.35 * style.WIDTH, 9.2), dpi=style.DPI, layout="constrained")
    for row, height in zip(panels, (0.0, 0.01 * float(dataset.attrs["length_m"])), strict=True):
        plot_root_section(dataset, "rz", row[0], height)
        plot_root_section(dataset, "rt", row[1], height)
        bar = figure.colorbar(row[0].collections[0], ax=list(row), pad=0.01)
        bar.set_label("Amplitude / capacity at the mandrel\n(dashed: border of the slip zone)")
    first: Axes = panels[0, 0]
    return first


def plot_slip_zone(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the slip zone versus distance from the mandrel and height, one colour per excitation level.

    A point of the plot lies in the slip zone if the coil slips there at any angle.

    Parameters
    ----------
    dataset
        Results of `modal_transient` on a grid of points.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset lacks a field or its points form no grid.

    Notes
    -----
    The logarithm of the slip onset is interpolated linearly between the quadrature points. It is constant between the
    outermost points and the surfaces of the coil.
    """
    style.require(dataset, (*_POINTS, "slip_onset"), "slip zone")
    levels = dataset["amplitude_g"].values
    onset = dataset["slip_onset"].values
    reach = tuple(1e3 * float(dataset[f"slip_zone_{name}"].values[-1]) for name in ("height", "depth"))
    ax = draw_slip_zone(dataset, onset, levels, (reach[0], reach[1]), ax)
    share = 100 * float(dataset["slipping_volume_fraction"].values[-1])
    found = (
        f"At {levels[-1]:g}\u00a0g the slip zone is {reach[0]:.3g} mm high and {reach[1]:.3g} mm deep, "
        f"{share:.3g} % of the coil's volume; slip starts above {onset.min():.3g}\u00a0g"
    )
    if share == 0.0:
        found = f"No slip up to {levels[-1]:g}\u00a0g"
        never = _NEVER * float(levels[-1])
        found += f"; it would start above {onset.min():.3g}\u00a0g" if onset.min() < never else ""
    style.title(ax, found)
    return ax


def draw_slip_zone(
    dataset: xr.Dataset, onset: FloatArray, levels: FloatArray, reach: tuple[float, float], ax: Axes | None
) -> Axes:
    """Draw the zone in which the points of a coil slip at any angle, one colour per level, over distance and height.

    Parameters
    ----------
    dataset
        Coordinates of the points, which form a grid, and the size of the coil.
    onset
        (n,) base acceleration above which a point slips, g; inf for a point that never slips.
    levels
        Levels, g; at most eight are drawn.
    reach
        Height and depth of the slip zone at the highest level, mm, for the range of the axes.
    ax
        Axes to draw in; a new figure if None.

    Raises
    ------
    InputError
        When the points form no grid.
    """
    grid, attrs = grid_of(dataset), dataset.attrs
    levels = levels[levels_to_draw(levels)]
    r_m, r_o, length = (1e3 * float(attrs[f"{name}_m"]) for name in ("mandrel_radius", "coil_outer_radius", "length"))
    lowest = np.pad(np.minimum(onset, _NEVER * float(levels[-1]))[grid.numbers].min(axis=2), 1, mode="edge")
    depth = np.concatenate([[0.0], 1e3 * grid.r - r_m, [r_o - r_m]])
    height = np.concatenate([[0.0], 1e3 * grid.z, [length]])
    ax = style.axes(ax, 4.6)
    ax.grid(False)
    ax.set_facecolor("#E4E4E4")
    colours = level_colours(levels.size)[::-1]
    edges = np.concatenate([[0.0], levels])
    if lowest.min() < levels[-1]:
        ax.contourf(depth, height, np.log(lowest.T + 1e-12), levels=np.log(edges + 1e-12), colors=colours)
    handles = [Patch(facecolor=colour, label=f"slips at {g:g} g") for g, colour in zip(levels, colours, strict=True)]
    handles.append(Patch(facecolor="#E4E4E4", label=f"no slip up to {levels[-1]:g} g"))
    ax.legend(handles=handles, fontsize=8, framealpha=0.95, loc="upper right")
    ax.set_ylim(0.0, min(length, max(1.4 * reach[0], 0.1 * length)))
    ax.set_xlim(0.0, min(r_o - r_m, max(2.0 * reach[1], 0.3 * (r_o - r_m))))
    ax.set_xlabel("Distance from the mandrel (mm)")
    ax.set_ylabel("Height above the base (mm)")
    return ax


def plot_steady_response(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Plot the absolute tip acceleration versus time, from rest to the steady state, with the exact steady amplitude.

    Parameters
    ----------
    dataset
        Results of `modal_transient`, whose time history belongs to the highest excitation level.
    ax
        Axes to draw in; a new figure if None.

    Returns
    -------
    Axes
        The axes drawn in.

    Raises
    ------
    InputError
        When the Dataset lacks a history.
    """
    style.require(dataset, ("time", "tip_acceleration_absolute", "change_per_cycle"), "steady response")
    ax = style.axes(ax, 3.8)
    attrs, g = dataset.attrs, float(dataset["amplitude_g"].values[-1])
    x, low, high = style.line_envelope(dataset["time"].values, dataset["tip_acceleration_absolute"].values / GRAVITY)
    if low is high:
        ax.plot(x, low, color=style.BLUE, lw=0.8)
    else:
        ax.fill_between(x, low, high, color=style.BLUE, lw=0)
    exact = g * float(attrs["transmissibility"])
    for side in (exact, -exact):
        ax.axhline(side, color=_CAPACITY, lw=1.3, ls=":", label="exact steady amplitude" if side > 0 else None)
    ax.set_xlim(0.0, x[-1])
    ax.set_xlabel("Time (s)")
    ax.set_ylabel("Absolute tip acceleration (g)")
    ax.legend(loc="upper left", fontsize=8, framealpha=0.95)
    ax.set_ylim(-1.25 * exact, 1.25 * exact)
    style.title(
        ax,
        f"{g:g} g at {float(attrs['excitation_frequency_hz']):.1f} Hz: steady state after "
        f"{dataset.sizes['cycle']} cycles, transmissibility {float(attrs['transmissibility']):.1f}",
    )
    return ax
