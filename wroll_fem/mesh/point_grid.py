"""Quadrature points of a coil arranged as a grid of angles, heights and radii; one hexahedron around each point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wroll_fem.bodies.levels import levels
from wroll_fem.typing import FloatArray, IntArray

# Points of one element row agree in height and radius within rounding errors on straight edges, and within the error of
# the quadratic arcs around the circumference. The smallest of these relative tolerances that gives a full grid is used.
_TOLERANCES = (1e-7, 1e-5, 1e-4, 1e-3)


class CoilGrid(NamedTuple):
    """Grid of points at all combinations of given angles, heights and radii.

    Attributes
    ----------
    theta, z, r
        (n_theta,) angles in rad, (n_z,) heights and (n_r,) radii in m, ascending.
    numbers
        (n_r, n_z, n_theta) index of the point at each combination.
    """

    theta: FloatArray
    z: FloatArray
    r: FloatArray
    numbers: IntArray


def coil_grid(points: FloatArray) -> CoilGrid | None:
    """Grid formed by points (n_points, 3) with coordinates theta (rad), z, r (m); None if they do not form a grid."""
    for tolerance in _TOLERANCES:
        found = [levels(column, tolerance * max(float(np.ptp(column)), 1e-12)) for column in points.T]
        (theta, column), (z, row), (r, layer) = found
        if theta.size * z.size * r.size != len(points):
            continue
        numbers = np.full((r.size, z.size, theta.size), -1, dtype=np.int64)
        numbers[layer, row, column] = np.arange(len(points))
        if np.all(numbers >= 0):
            return CoilGrid(theta, z, r, numbers)
    return None


def largest_along(positions: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Largest value among the points at each position along one coordinate.

    Positions closer than a thousandth of the span count as one.

    Parameters
    ----------
    positions
        (n,) coordinate of each point.
    values
        (n,) value at each point.

    Returns
    -------
    positions : (m,) distinct positions (means of the merged coordinates), ascending.
    largest : (m,) largest value at each position.
    """
    place, which = levels(positions, 1e-3 * max(float(np.ptp(positions)), 1e-12))
    largest = np.full(place.size, -np.inf)
    np.maximum.at(largest, which, values)
    return place, largest


def coil_cells(grid: CoilGrid, r: tuple[float, float], z: tuple[float, float]) -> tuple[FloatArray, IntArray]:
    """Hexahedra that fill the coil, one around each point, with faces halfway between neighbouring points.

    Parameters
    ----------
    grid
        Grid of points around the whole circumference.
    r, z
        Inner and outer radius, and lower and upper end of the coil, m.

    Returns
    -------
    nodes, cells
        (m, 3) Cartesian coordinates, m; (n_points, 8) node numbers in VTK order, one cell per point.
    """
    step = np.diff(grid.theta, append=grid.theta[0] + 2.0 * np.pi)
    faces = [
        np.concatenate([[low], 0.5 * (x[1:] + x[:-1]), [high]])
        for x, (low, high) in ((grid.r, r), (grid.z, z))
    ]  # fmt: skip
    angle = grid.theta + 0.5 * step  # face after each point; the first point lies between the last and the first face
    radius, height, turn = np.meshgrid(*faces, angle, indexing="ij")
    nodes = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=-1).reshape(-1, 3)
    label = np.arange(len(nodes)).reshape(radius.shape)
    before = np.roll(label, 1, axis=2)
    corners = [side[i : i + grid.r.size, j : j + grid.z.size] for j in (0, 1) for i, side in
               ((0, before), (1, before), (1, label), (0, label))]  # fmt: skip
    cells = np.empty((grid.numbers.size, 8), dtype=np.int64)
    cells[grid.numbers.ravel()] = np.stack(corners, axis=-1).reshape(-1, 8)
    return nodes, cells
