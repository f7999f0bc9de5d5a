"""Slip on the interfaces: fields on the whole circumference, unrolled raster, slipping area.

Point data of a result (dims `interface`, `point`) cover half a roll, theta in [0, pi], if the run used the symmetry
plane of the excitation. The areas then already represent the whole roll; hoop components are odd in theta, all other
fields even. The functions of this module return the whole circumference in either case.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.interpolate import LinearNDInterpolator, RegularGridInterpolator
from scipy.spatial import Delaunay

from wroll_fem.bodies.levels import levels
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

ODD_FIELDS = frozenset({"peak_slip_hoop", "traction_hoop"})  # change sign under theta -> -theta
_SAME_ANGLE = 1e-6  # rad; points at the same angle lie above each other


class Surface(NamedTuple):
    """Fields at the points of an interface, on the whole circumference.

    Attributes
    ----------
    theta
        (n,) rad in (-pi, pi].
    z
        (n,) m.
    values
        Field name -> (n,) values.
    """

    theta: FloatArray
    z: FloatArray
    values: dict[str, FloatArray]


def _require(dataset: xr.Dataset, *names: str) -> None:
    missing = [name for name in names if name not in dataset.variables]
    if missing:
        raise InputError(
            f"the results have no {', '.join(missing)}",
            remedy="run an analysis with interfaces (coil.model: layers; sweep or dwell)",
        )


def _along_interface(dataset: xr.Dataset, name: str, interface: int) -> npt.NDArray:
    variable = dataset[name]
    if "interface" not in variable.dims:
        return variable.values
    count = variable.sizes["interface"]
    if not 0 <= interface < count:
        raise InputError(f"there is no interface {interface}", remedy=f"choose 0 (innermost) to {count - 1}")
    return variable.isel(interface=interface).values


def surface(dataset: xr.Dataset, interface: int, *names: str) -> Surface:
    """Fields of an interface on the whole circumference; results of half a roll are mirrored.

    Parameters
    ----------
    dataset
        Results with `theta_rad` and `z_m` over `point`, and the fields over (`interface`, `point`).
    interface
        0 is the innermost.
    names
        Names of the fields.

    Raises
    ------
    InputError
        For a missing field or interface.
    """
    _require(dataset, "theta_rad", "z_m", *names)
    theta, z = (_along_interface(dataset, name, interface).astype(float) for name in ("theta_rad", "z_m"))
    values = {name: _along_interface(dataset, name, interface).astype(float) for name in names}
    here = np.isfinite(theta)  # an interface with fewer points than another ends in NaN
    theta, z, values = theta[here], z[here], {name: field[here] for name, field in values.items()}
    near = 1e-6
    theta = np.where(theta <= -np.pi + near, theta + 2.0 * np.pi, theta)
    if theta.min() > -near and np.ptp(theta) <= np.pi + near:
        off_plane = (theta > near) & (theta < np.pi - near)
        for name, field in values.items():
            mirrored = field[off_plane] * (-1.0 if name in ODD_FIELDS else 1.0)
            values[name] = np.concatenate([field, mirrored])
        theta, z = np.concatenate([theta, -theta[off_plane]]), np.concatenate([z, z[off_plane]])
    return Surface(theta, z, values)


def has_surface(dataset: xr.Dataset, interface: int) -> bool:
    """Whether the points of an interface span a cylinder: at least three angles and two heights."""
    if "theta_rad" not in dataset.variables or fills_body(dataset, interface):
        return False
    points = surface(dataset, interface)
    around = levels(points.theta, _SAME_ANGLE)[0].size
    return bool(around > 2 and np.ptp(points.z) > 0.0 and points.theta.size > 3)


def fills_body(dataset: xr.Dataset, interface: int) -> bool:
    """Whether the points of an interface fill a body, as those between the wraps of a coil."""
    return "r_m" in dataset.variables and bool(np.isfinite(_along_interface(dataset, "r_m", interface)).any())


def wrap_interfaces(dataset: xr.Dataset, interface: int) -> float:
    """Number of wrap interfaces for which an interface stands; its slip is the sum of theirs (`coil.per_wrap`)."""
    counts = dataset.attrs.get("wrap_interfaces")
    return 1.0 if counts is None else float(counts[interface])


def structured(theta: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, npt.NDArray[np.int64]] | None:
    """Angles (n_t,), heights (n_z,) and point indices (n_z, n_t) if the points form a full grid, else None."""
    angles, column = levels(theta, _SAME_ANGLE)
    heights, row = levels(z)
    if angles.size * heights.size != theta.size or angles.size < 3 or heights.size < 2:
        return None
    numbers = np.full((heights.size, angles.size), -1, dtype=np.int64)
    numbers[row, column] = np.arange(theta.size)
    if np.any(numbers < 0):
        return None
    return theta[numbers[0]], z[numbers[:, 0]], numbers


def wrapped(theta: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, npt.NDArray[np.int64]]:
    """Angle, height and point index, (m,) each, on the surface extended periodically by half a turn on each side."""
    number = np.arange(theta.size)
    left, right = theta < 0.0, theta >= 0.0
    angle = np.concatenate([theta, theta[left] + 2.0 * np.pi, theta[right] - 2.0 * np.pi])
    copies = np.concatenate([number, number[left], number[right]])
    return angle, z[copies], copies


def raster(
    points: Surface, name: str, *, n_theta: int = 361, n_z: int = 241, radius: float = 1.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Interpolate a field to a uniform raster of the unrolled surface, periodic at +-180 degrees.

    Parameters
    ----------
    points
        Fields at the points of an interface.
    name
        Field to interpolate.
    n_theta, n_z
        Numbers of raster points in angle and height.
    radius
        Radius in m, for the triangulation of scattered points.

    Returns
    -------
    theta, z, values
        (n_theta,) rad from -pi to pi, (n_z,) m, (n_z, n_theta). Bilinear between the points of a grid,
        linear on triangles between scattered ones; nan outside the points.
    """
    angle = np.linspace(-np.pi, np.pi, n_theta)
    height = np.linspace(points.z.min(), points.z.max(), n_z)
    where = np.stack(np.meshgrid(height, angle, indexing="ij"), axis=-1)
    grid = structured(points.theta, points.z)
    if grid is not None:
        theta, z, numbers = grid
        values = points.values[name][numbers]
        theta = np.concatenate([[theta[-1] - 2.0 * np.pi], theta, [theta[0] + 2.0 * np.pi]])
        values = np.concatenate([values[:, -1:], values, values[:, :1]], axis=1)
        inside = np.clip(where, [z[0], theta[0]], [z[-1], theta[-1]])
        return angle, height, RegularGridInterpolator((z, theta), values)(inside)
    theta, z, copies = wrapped(points.theta, points.z)
    nodes = np.stack([z, radius * theta], axis=1)
    values = LinearNDInterpolator(nodes, points.values[name][copies])(where * [1.0, radius])
    return angle, height, values


def cylinder_cells(points: Surface, radius: float) -> npt.NDArray[np.int64]:
    """Cells between the points of an interface around the cylinder: quads (m, 4) of a grid, or triangles (m, 3)."""
    grid = structured(points.theta, points.z)
    if grid is not None:
        numbers = grid[2]
        next_column = np.roll(numbers, -1, axis=1)
        corners = [numbers[:-1], next_column[:-1], next_column[1:], numbers[1:]]
        return np.stack([c.ravel() for c in corners], axis=1)
    theta, z, copies = wrapped(points.theta, points.z)
    triangles = Delaunay(np.stack([radius * theta, z], axis=1)).simplices
    centre = theta[triangles].mean(axis=1)
    cells = copies[triangles[(centre >= -np.pi) & (centre < np.pi)]]
    _, first = np.unique(np.sort(cells, axis=1), axis=0, return_index=True)  # no triangle twice at the seam
    return np.asarray(cells[np.sort(first)])


def interface_radius(dataset: xr.Dataset, interface: int) -> float:
    """Radius of an interface in m: the coordinate `radius` if present, else area / (2 pi height)."""
    if "radius" in dataset.variables:
        return float(np.mean(_along_interface(dataset, "radius", interface)))
    _require(dataset, "area", "z_m")
    return float(_along_interface(dataset, "area", interface).sum() / (2.0 * np.pi * np.ptp(dataset["z_m"].values)))


def open_area_fraction(dataset: xr.Dataset) -> xr.DataArray:
    """Fraction of the area of each interface that was open at any time of the motion; dimension `interface`."""
    _require(dataset, "open_time_fraction", "area")
    fraction = ((dataset["open_time_fraction"] > 0.0) * dataset["area"]).sum("point") / dataset["area"].sum("point")
    return fraction.rename("open_area_fraction")


def least_pressure_ratio(dataset: xr.Dataset) -> xr.DataArray:
    """Smallest ratio of the pressure in the motion to the preload at the same point; dimension `interface`.

    Points that the preload leaves open do not count; the ratio is NaN where it leaves all of them open.
    """
    _require(dataset, "least_pressure", "pressure")
    pressed = dataset["pressure"].where(dataset["pressure"] > 0.0)
    return (dataset["least_pressure"] / pressed).min("point").rename("min_pressure_over_preload")


def slipping_area_fraction(dataset: xr.Dataset) -> xr.DataArray:
    """Fraction of the area of each interface that slipped at any time; dimension `interface`."""
    _require(dataset, "slipped", "area")
    fraction = (dataset["slipped"] * dataset["area"]).sum("point") / dataset["area"].sum("point")
    return fraction.rename("slipping_area_fraction")
