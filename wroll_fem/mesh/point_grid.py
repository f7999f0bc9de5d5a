"""Quadrature points of a coil as a grid of angles, heights and radii; the cells they stand for. FEM-free."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wroll_fem.typing import FloatArray, IntArray

# Points of one element row agree in height and radius to rounding on straight edges, and to the error of
# quadratic arcs around the circumference; the finest of these shares of the span that finds a full grid is taken.
_TOLERANCES = (1e-7, 1e-5, 1e-4, 1e-3)


class CoilGrid(NamedTuple):
    """Points on every combination of some angles, heights and radii.

    Attributes
    ----------
    theta, z, r
        (n_theta,) rad, (n_z,) m, (n_r,) m, ascending.
    numbers
        (n_r, n_z, n_theta) number of the point at each.
    """

    theta: FloatArray
    z: FloatArray
    r: FloatArray
    numbers: IntArray


def stations(values: FloatArray, tolerance: float) -> tuple[FloatArray, IntArray]:
    """Values that lie closer than `tolerance` to the next taken as one: their means (m,), and which each is (n,)."""
    order = np.argsort(values, kind="stable")
    number = np.concatenate([[0], np.cumsum(np.diff(values[order]) > tolerance)])
    which = np.empty(values.size, dtype=np.int64)
    which[order] = number
    return np.bincount(which, weights=values) / np.bincount(which), which


def coil_grid(points: FloatArray) -> CoilGrid | None:
    """Grid of the points (n_points, 3) of theta, z, r; None when they form none."""
    for tolerance in _TOLERANCES:
        found = [stations(column, tolerance * max(float(np.ptp(column)), 1e-12)) for column in points.T]
        (theta, column), (z, row), (r, layer) = found
        if theta.size * z.size * r.size != len(points):
            continue
        numbers = np.full((r.size, z.size, theta.size), -1, dtype=np.int64)
        numbers[layer, row, column] = np.arange(len(points))
        if np.all(numbers >= 0):
            return CoilGrid(theta, z, r, numbers)
    return None


def largest_along(positions: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Positions (m,) of the rows of points along one coordinate, and the largest value (m,) in each row.

    Rows closer than a thousandth of the span count as one.
    """
    place, which = stations(positions, 1e-3 * max(float(np.ptp(positions)), 1e-12))
    largest = np.full(place.size, -np.inf)
    np.maximum.at(largest, which, values)
    return place, largest


def coil_cells(grid: CoilGrid, r: tuple[float, float], z: tuple[float, float]) -> tuple[FloatArray, IntArray]:
    """Hexahedra that fill the coil, one around each point, with faces half way between neighbours.

    Parameters
    ----------
    grid
        Points around the whole circumference.
    r, z
        Inner and outer radius, lower and upper end of the coil, m.

    Returns
    -------
    nodes, cells
        (m, 3) Cartesian, m; (n_points, 8) in VTK's order, in the order of the points.
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
