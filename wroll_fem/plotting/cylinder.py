"""Slip on the cylinder: pictures, drawn pixel by pixel, and files for three-dimensional viewers."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from scipy.ndimage import map_coordinates

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.slip import in_small_unit, interface_name
from wroll_fem.results.dataset import label
from wroll_fem.results.interface_slip import cylinder_cells, interface_radius, raster, slipping_area_fraction, surface
from wroll_fem.typing import FloatArray

_FIELDS = ("cumulative_slip", "max_slip", "slipped", "peak_slip_hoop", "peak_slip_axial", "pressure")
GREY = (0.824, 0.824, 0.824, 1.0)
AMBIENT, DIFFUSE, SHADOW = 0.6, 0.42, 0.85  # light from the viewer, and what of it reaches the inside
PIXELS = (620, 330)  # height and width that a view may take; each pixel is the mean of 2 x 2 rays


class Sight(NamedTuple):
    """What the rays of a parallel projection see of an upright tube that is open at both ends.

    Attributes
    ----------
    theta, z
        (rows, columns) angle in rad in [-pi, pi] and share of the height in [0, 1] of the point hit; NaN where none is.
    brightness
        (rows, columns) of the surface there.
    """

    theta: FloatArray
    z: FloatArray
    brightness: FloatArray


def slip_surface(
    dataset: xr.Dataset, interface: int
) -> tuple[FloatArray, npt.NDArray[np.int64], dict[str, FloatArray]]:
    """Return an interface as a surface in space.

    Returns
    -------
    points, cells, fields
        (n, 3) Cartesian m, (m, 4) quads or (m, 3) triangles, and name -> (n,) of the slip fields the results hold.
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
        Per-point data over (`interface`, `point`).
    path
        Target; parents are made.

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
        raise InputError("the results hold no interface", remedy="run an analysis with interfaces")
    parts = [slip_surface(dataset, k) for k in range(count)]
    sizes = [part[0].shape[0] for part in parts]
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    cells = [
        ("quad" if part[1].shape[1] == 4 else "triangle", part[1] + start)
        for part, start in zip(parts, starts, strict=True)
    ]
    data = {name: np.concatenate([part[2][name] for part in parts]) for name in parts[0][2]}
    data["interface"] = np.repeat(np.arange(count, dtype=float), sizes)
    target = style.target(path)
    meshio.Mesh(np.concatenate([part[0] for part in parts]), cells, point_data=data).write(target, file_format="vtu")
    return target


def line_of_sight(direction: Sequence[float], radius: float, height: float) -> Sight:
    """Points of a tube about z seen from ``direction`` (3,), a ray for each half pixel of `PIXELS`.

    On the screen (x to the right, y upward, the tube's middle at 0) a point at angle phi from the viewer lies at
    x = R sin(phi), y = (z - H/2) cos(e) - R sin(e) cos(phi), e being the viewer's elevation; each ray meets the
    cylinder at the front, cos(phi) > 0, and at the back, which is seen through an open end.
    """
    towards = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    azimuth, sin_e, cos_e = np.arctan2(towards[1], towards[0]), towards[2], np.hypot(towards[0], towards[1])
    half_width, half_height = radius, 0.5 * height * cos_e + radius * abs(sin_e)
    scale = 2.0 * min(PIXELS[0] / (2.0 * half_height), PIXELS[1] / (2.0 * half_width))  # rays per m
    rows, columns = (2 * int(np.ceil(0.5 * scale * size)) for size in (2.0 * half_height, 2.0 * half_width))
    x = (np.arange(columns) + 0.5 - 0.5 * columns) / scale
    y = (0.5 * rows - 0.5 - np.arange(rows))[:, None] / scale
    sine = np.clip(x / radius, -1.0, 1.0)
    cosine = np.sqrt(1.0 - sine**2)
    front = (y + radius * sin_e * cosine) / (cos_e * height) + 0.5
    back = (y - radius * sin_e * cosine) / (cos_e * height) + 0.5
    outside, inside = ((z >= 0.0) & (z <= 1.0) & (np.abs(x) <= radius) for z in (front, back))
    z = np.where(outside, front, np.where(inside, back, np.nan))
    phi = np.where(outside, np.arcsin(sine), np.pi - np.arcsin(sine))
    theta = np.where(np.isnan(z), np.nan, np.mod(phi + azimuth + np.pi, 2.0 * np.pi) - np.pi)
    return Sight(theta, z, np.where(outside, 1.0, SHADOW) * np.minimum(1.0, AMBIENT + DIFFUSE * cos_e * cosine))


def sample(values: FloatArray, sight: Sight) -> FloatArray:
    """Values (rows, columns) of a raster (n_z, n_theta) from base to tip and -pi to pi at the points seen."""
    where = [sight.z * (values.shape[0] - 1), (sight.theta + np.pi) / (2.0 * np.pi) * (values.shape[1] - 1)]
    return np.asarray(map_coordinates(values, np.nan_to_num(where), order=1, mode="nearest"))


def shaded(colours: FloatArray, sight: Sight) -> FloatArray:
    """Picture (rows / 2, columns / 2, 3) of coloured points (rows, columns, 4) on white, with smooth edges."""
    picture = colours[..., :3] * sight.brightness[..., None]
    picture[np.isnan(sight.z)] = 1.0
    rows, columns = sight.z.shape
    return np.asarray(picture.reshape(rows // 2, 2, columns // 2, 2, 3).mean(axis=(1, 3)))


def plot_slip_on_cylinder(
    dataset: xr.Dataset, path: str | os.PathLike[str], interface: int = 0, quantity: str = "cumulative_slip"
) -> Path:
    """Draw an interface with its slip in space, from the excitation direction and from across.

    Parameters
    ----------
    dataset
        Per-point data over (`interface`, `point`): `quantity`, `slipped`, `theta_rad`, `z_m`, `area`.
    path
        PNG to write; parents are made.
    interface
        0 is the innermost.
    quantity
        "cumulative_slip" (grey where the interface stuck) or another length of the field table.

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
    stuck = np.zeros_like(values)
    if quantity == "cumulative_slip":
        stuck = 1.0 - raster(points, "slipped", radius=radius)[2]
    largest = float(np.nanmax(np.where(stuck <= 0.5, shown, 0.0), initial=0.0)) or 1.0
    direction = dataset.attrs.get("excitation_direction", "x")
    faces, across = ("90°", "0°") if direction == "y" else ("0°", "90°")
    along, over = (1.0, 0.0, 0.25), (0.0, 1.0, 0.25)
    if direction == "y":
        along, over = over, along
    known = direction in ("x", "y")  # a structure from a file does not say
    faces = f"along the excitation ({faces})" if known else f"from {faces}"
    across = f"from across ({across})" if known else f"from {across}"
    views = {f"seen {faces}": along, "seen from 45°": (1.0, 1.0, 0.35), f"seen {across}": over}
    figure = Figure(figsize=(style.WIDTH, 5.2), dpi=style.DPI, layout="constrained")
    panels = figure.subplots(1, len(views), subplot_kw={"xticks": [], "yticks": []})
    height = float(z[-1] - z[0])
    for ax, (heading, direction) in zip(panels, views.items(), strict=True):
        sight = line_of_sight(direction, radius, height)
        colours = colormaps["viridis"](sample(shown, sight) / largest)
        colours[~(sample(stuck, sight) <= 0.5)] = GREY
        ax.imshow(shaded(colours, sight))
        ax.set_title(heading, fontsize=9)
        ax.axis("off")
    scale = ScalarMappable(Normalize(0.0, largest), "viridis")
    bar = figure.colorbar(scale, ax=list(panels), location="bottom", shrink=0.6, aspect=35, pad=0.02)
    grey = "; grey: never slipped" if quantity == "cumulative_slip" else ""
    bar.set_label(label(quantity, unit) + grey)
    fraction = float(slipping_area_fraction(dataset).isel(interface=interface))
    found = f"Nothing slipped between {interface_name(interface, dataset)}"
    if fraction > 0.0:
        most = f"{style.three_digits(largest)} {unit}"
        share = f"{100 * fraction:.0f} % of the area slipped"
        found = f"Between {interface_name(interface, dataset)}, {share}; longest slip path {most}"
    figure.suptitle(found, fontsize=10)
    target = style.target(path)
    figure.savefig(target)
    return target
