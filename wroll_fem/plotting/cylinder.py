"""Slip of an interface on the cylinder: pictures, and files for three-dimensional viewers."""

from __future__ import annotations

import os
import textwrap
from pathlib import Path

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.slip import in_small_unit, interface_name, over_wraps
from wroll_fem.results.dataset import label
from wroll_fem.results.interface_slip import cylinder_cells, interface_radius, raster, slipping_area_fraction, surface
from wroll_fem.typing import FloatArray

_FIELDS = ("cumulative_slip", "max_slip", "slipped", "peak_slip_hoop", "peak_slip_axial", "pressure")
GREY = (0.824, 0.824, 0.824)
ELEVATION = np.radians(14.0)  # of the viewer
AMBIENT, DIFFUSE, INSIDE = 0.6, 0.42, 0.85  # light from the viewer, and the part of it that reaches the inside


def slip_surface(
    dataset: xr.Dataset, interface: int
) -> tuple[FloatArray, npt.NDArray[np.int64], dict[str, FloatArray]]:
    """Surface of an interface in three dimensions, with its slip fields.

    Returns
    -------
    points, cells, fields
        (n, 3) Cartesian coordinates (m), (m, 4) quads or (m, 3) triangles, and name -> (n,) values of each slip field
        in the results.

    Raises
    ------
    InputError
        If the Dataset lacks the interface.
    """
    names = [name for name in _FIELDS if name in dataset]
    points = surface(dataset, interface, *names)
    radius = interface_radius(dataset, interface)
    xyz = np.stack([radius * np.cos(points.theta), radius * np.sin(points.theta), points.z], axis=1)
    return xyz, cylinder_cells(points, radius), points.values


def write_slip_vtu(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write all interfaces with their slip fields as one .vtu file (ParaView, pyvista).

    Parameters
    ----------
    dataset
        Data per contact point, with dimensions (`interface`, `point`).
    path
        File to write; parent folders are created.

    Returns
    -------
    Path
        The file written. Point data: the slip fields in SI and `interface` (0 innermost).

    Raises
    ------
    InputError
        When the Dataset holds no interface.
    """
    import meshio

    count = dataset.sizes.get("interface", 0)
    if count == 0:
        raise InputError("the results contain no interface", remedy="run an analysis with interfaces")
    parts = [slip_surface(dataset, k) for k in range(count)]
    sizes = [part[0].shape[0] for part in parts]
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    cells = [
        ("quad" if part[1].shape[1] == 4 else "triangle", part[1] + start)
        for part, start in zip(parts, starts, strict=True)
    ]
    data = {name: np.concatenate([part[2][name] for part in parts]) for name in parts[0][2]}
    data["interface"] = np.repeat(np.arange(count, dtype=float), sizes)
    return style.write_mesh(meshio.Mesh(np.concatenate([part[0] for part in parts]), cells, point_data=data), path)


def draw_tube(
    ax: Axes, colours: FloatArray, height: FloatArray, radius: float, azimuth: float, elevation: float
) -> None:
    """Draw an upright open tube in parallel projection; all lengths are in the unit of ``radius``.

    Parameters
    ----------
    ax
        Two-dimensional axes.
    colours
        (n_z, n_theta, 3) RGB colours of the cells. All cells span equal angles, from -pi to pi. n_theta is a multiple
        of 4.
    height
        (n_z + 1,) heights of the cell borders.
    azimuth, elevation
        Direction of the viewer, rad.

    Notes
    -----
    A point at angle phi from the viewer appears at x = R sin(phi), y = z cos(e) - R sin(e) cos(phi), with the elevation
    e. The far half is drawn first; its inner surface is seen through the open end.
    """
    count = colours.shape[1]
    quarter = count // 4
    turn = np.arange(-quarter, quarter + 1) * 2.0 * np.pi / count
    middle = 0.5 * (turn[1:] + turn[:-1])
    for side, order, brightest in ((-1.0, 1, INSIDE), (1.0, 3, 1.0)):
        x = side * radius * np.sin(turn)
        y = height[:, None] * np.cos(elevation) - side * radius * np.sin(elevation) * np.cos(turn)
        centre = azimuth if side > 0.0 else azimuth + np.pi
        first = round((centre + np.pi) / (2.0 * np.pi) * count)
        cells = colours[:, (first + np.arange(-quarter, quarter)) % count]
        light = brightest * np.minimum(1.0, AMBIENT + DIFFUSE * np.cos(elevation) * np.cos(middle))
        mesh = ax.pcolormesh(np.broadcast_to(x, y.shape), y, np.zeros(cells.shape[:2]), rasterized=True, zorder=order)
        mesh.set_array(None)  # colours instead of values
        mesh.set_facecolor((cells * light[:, None]).reshape(-1, 3))
        outline = np.r_[x, x[::-1], x[:1]], np.r_[y[0], y[-1, ::-1], y[0, :1]]
        ax.plot(*outline, color="#777777", lw=0.6, zorder=order + 1)
    ax.set_aspect("equal")
    ax.axis("off")


def _cell_means(nodes: FloatArray) -> FloatArray:
    """Mean of the values at the four corners of each raster cell."""
    return np.asarray(0.25 * (nodes[1:, 1:] + nodes[:-1, 1:] + nodes[1:, :-1] + nodes[:-1, :-1]))


def plot_slip_on_cylinder(
    dataset: xr.Dataset, path: str | os.PathLike[str], interface: int = 0, quantity: str = "cumulative_slip"
) -> Path:
    """Draw the slip of an interface on the cylinder, seen at 0, 45 and 90 degrees to the direction of excitation.

    Parameters
    ----------
    dataset
        Data per contact point, with dimensions (`interface`, `point`): `quantity`, `slipped`, `theta_rad`, `z_m`,
        `area`.
    path
        PNG to write; parent folders are created.
    interface
        Index of the interface; 0 is the innermost.
    quantity
        "cumulative_slip" (grey where the interface never slipped) or another variable of the results that is a length.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        When the Dataset lacks a field or the interface.
    """
    points = surface(dataset, interface, quantity, "slipped")
    radius = interface_radius(dataset, interface)
    _, z, values = raster(points, quantity, radius=radius)
    shown, unit = in_small_unit(values)
    slipped = np.ones_like(values)
    if quantity == "cumulative_slip":
        slipped = raster(points, "slipped", radius=radius)[2]
    largest = float(np.nanmax(np.where(slipped >= 0.5, shown, 0.0), initial=0.0)) or 1.0
    colours = colormaps[style.SLIP_MAP](_cell_means(shown) / largest)[..., :3]
    colours[~(_cell_means(slipped) >= 0.5)] = GREY
    direction = dataset.attrs.get("excitation_direction", "x")
    faces, across = ("90°", "0°") if direction == "y" else ("0°", "90°")
    along, over = (90.0, 0.0) if direction == "y" else (0.0, 90.0)
    known = direction in ("x", "y")  # unknown for a structure from a file
    faces = f"along the excitation ({faces})" if known else f"from {faces}"
    across = f"across the excitation ({across})" if known else f"from {across}"
    views = {f"seen {faces}": along, "seen from 45°": 45.0, f"seen {across}": over}
    figure = Figure(figsize=(style.WIDTH, 5.2), dpi=style.DPI, layout="constrained")
    panels = figure.subplots(1, len(views))
    for ax, (heading, azimuth) in zip(panels, views.items(), strict=True):
        draw_tube(ax, colours, z, radius, np.radians(azimuth), ELEVATION)
        ax.set_title(heading, fontsize=9)
    scale = ScalarMappable(Normalize(0.0, largest), style.SLIP_MAP)
    bar = figure.colorbar(scale, ax=list(panels), location="bottom", shrink=0.6, aspect=35, pad=0.02)
    grey = "; grey: never slipped" if quantity == "cumulative_slip" else ""
    bar.set_label(label(quantity, unit) + over_wraps(dataset, interface) + grey)
    fraction = float(slipping_area_fraction(dataset).isel(interface=interface))
    found = f"No slip between {interface_name(interface, dataset)}"
    if fraction > 0.0:
        most = f"{style.three_digits(largest)} {unit}"
        share = f"{100 * fraction:.0f} % of the interface between {interface_name(interface, dataset)} slipped"
        found = f"{share}; largest accumulated slip {most}"
    figure.suptitle(textwrap.fill(found, 92), fontsize=10)
    return style.write_figure(figure, path)
