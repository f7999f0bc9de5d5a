r"""Contact points of a shell, and the shape functions of the contact tractions.

If the cells form rows (as in generated meshes), every vertex of a row has two contact points, at the heights of the two
Gauss points of the row. Along the axis the shape function psi_k of the traction at point k is linear between the two
heights and discontinuous from row to row. Around the circumference it is the cubic interpolation of the values at the
vertices:

    psi_k = 1 at vertex k, 9/16 halfway to its neighbours, -1/16 halfway between its first and its second neighbours

For quadratic displacements, the average weighted with psi_k is the value at the height of the Gauss point, and at the
angle of the vertex up to errors of fourth order in the width of the cells. The psi_k sum to 1, so that a uniform
traction is exact; those of a row reproduce tractions linear in z. With hat functions at the vertices, half a cell at a
free edge could slide (1.7 % in the first bending frequency of a bonded layer, tests/fem/test_trace.py).

These psi_k apply to the tangential traction. The pressure is linear between the vertices along the axis (hat
functions). The two points next to a vertex, one in each row, share its pressure in proportion to their areas. If the
pressure were linear in each row but discontinuous between rows, it would have too many degrees of freedom for the
quadratic displacements of two stiff surfaces, and would alternate from point to point (by 30 % on uniform cells longer
than the boundary layers at the ends). Only in the first and the last row, where free edges peel, the pressure has the
shape functions of the tangential traction.

On other meshes the shape functions are these hat functions, and the points are the vertices.

Notes
-----
The points are those at which reduced integration of quadratic elements evaluates strains (J. Barlow, 1976,
doi:10.1002/nme.1620100202).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.levels import SAME, levels
from wroll_fem.mesh.shells import CylinderMesh, canonical_vertices
from wroll_fem.typing import FloatArray, IntArray

_GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)  # heights in a cell of unit height
_CUBIC = {-1: -1 / 16, 0: 9 / 16, 1: 9 / 16, 2: -1 / 16}  # vertex, counted from the one before the middle: weight
_HAT = np.vstack(
    [np.eye(4), 0.5 * (np.eye(4) + np.roll(np.eye(4), 1, axis=1)), np.full((1, 4), 0.25)]
)  # of the corners at the nodes of a quad9


@dataclass(frozen=True)
class ContactPoints:
    """Contact points of a shell and their shape functions.

    Attributes
    ----------
    points
        (n, 3) coordinates theta in (-pi, pi] (rad), z (m), r (m), sorted by z, then theta.
    shapes
        (9 n_cells, n) shape functions of the tangential traction, one column for each contact point. Row 9 c + a is the
        value at node `cells[c, a]` in cell c.
    normal_shapes
        (9 n_cells, n) shape functions of the normal traction. Both shape functions of a point have the same integral
        over the surface.
    """

    points: FloatArray
    shapes: sp.csr_matrix
    normal_shapes: sp.csr_matrix


def contact_points(part: CylinderMesh) -> ContactPoints:
    """Contact points of one shell: at the heights of Gauss points if the cells form rows, otherwise at the vertices."""
    columns = _columns(part)
    return _vertex_points(part) if columns is None else _gauss_points(part, columns)


def contact_points_between(part: CylinderMesh, low: float, high: float) -> ContactPoints:
    """Contact points on the part of a shell between two heights, m, which are borders of its elements.

    Cells outside have no shape functions.
    """
    middle = part.nodes[part.cells[:, 8], 2]
    inside = np.flatnonzero((middle > low) & (middle < high))
    if len(inside) == len(part.cells):
        return contact_points(part)
    used, cells = np.unique(part.cells[inside], return_inverse=True)
    found = contact_points(CylinderMesh(part.nodes[used], cells.reshape(-1, 9), {}))
    place = (9 * inside[:, None] + np.arange(9)).ravel()
    spread = sp.csr_matrix((np.ones(len(place)), (place, np.arange(len(place)))), shape=(part.cells.size, len(place)))
    return ContactPoints(found.points, (spread @ found.shapes).tocsr(), (spread @ found.normal_shapes).tocsr())


def has_rows(part: CylinderMesh) -> bool:
    """Whether the cells of a shell form circumferential rows in which all cells have the same angular width.

    If so, the contact points lie at the heights of Gauss points, otherwise at the vertices.
    """
    return _columns(part) is not None


def _columns(part: CylinderMesh) -> FloatArray | None:
    """(C,) angles of the vertices, rad, ascending in (-pi, pi], if the cells form rows of C equal cells; else None."""
    vertices, points = canonical_vertices(part)
    heights, row = levels(points[:, 1])
    count = len(vertices) // len(heights)
    if count < 4 or count * len(heights) != len(vertices) or len(part.cells) != count * (len(heights) - 1):
        return None
    if np.any(np.bincount(row) != count):
        return None
    theta = points[:, 0].reshape(-1, count)
    expected = theta[0, 0] + 2 * np.pi * np.arange(count) / count
    if np.abs(theta - expected).max() > SAME:
        return None
    z, width = part.nodes[part.cells[:, :4], 2], 2 * np.pi / count
    low, high = z.min(axis=1), z.max(axis=1)
    flat = np.minimum(z - low[:, None], high[:, None] - z).max() <= SAME * np.ptp(z)
    angle = _turn(part, theta[0])
    narrow = np.abs(np.ptp(angle[:, :4], axis=1) - width).max() <= SAME * np.pi
    return theta[0] if flat and narrow else None


def _turn(part: CylinderMesh, theta: FloatArray) -> FloatArray:
    """(n_cells, 9) angles of the nodes, rad, measured from the angle ``theta[0]``; no cell has a jump of 2 pi."""
    x, y = part.nodes[part.cells, 0], part.nodes[part.cells, 1]
    middle = np.arctan2(y[:, 8], x[:, 8])[:, None]
    offset = np.angle(np.exp(1j * (np.arctan2(y, x) - middle)))
    return np.asarray(np.mod(middle - theta[0], 2 * np.pi) + offset)


def _gauss_points(part: CylinderMesh, theta: FloatArray) -> ContactPoints:
    count = len(theta)
    z = part.nodes[part.cells, 2]
    low, high = z[:, :4].min(axis=1, keepdims=True), z[:, :4].max(axis=1, keepdims=True)
    row = levels(low[:, 0])[1]
    along = (z - low) / (high - low)
    step = _turn(part, theta) * count / (2 * np.pi)  # in cells
    first = np.rint(step.min(axis=1, keepdims=True)).astype(int)
    local = np.rint(2 * (step - first)).astype(int)  # 0, 1 or 2: vertex, middle, vertex

    borders = np.stack([levels(low[:, 0])[0], levels(high[:, 0])[0]], axis=1)
    size = np.ptp(borders, axis=1)
    heights = (borders[:, :1] + size[:, None] * _GAUSS).ravel()
    radius = float(np.hypot(*part.nodes[:, :2].T).mean())
    points = np.column_stack(
        [np.tile(theta, len(heights)), np.repeat(heights, count), np.full(count * len(heights), radius)]
    )
    around = _Around(first, local, count)
    linear = {
        (0, gauss): (along - _GAUSS[1 - gauss]) / (_GAUSS[gauss] - _GAUSS[1 - gauss]) for gauss in (0, 1)
    }  # (row of the point minus row of the cell, Gauss point): values at the nodes
    # the hat of the lower vertex belongs to the first point of this row and to the second one of the row below
    below, above = (_share(size, step)[row][:, None] for step in (-1, 1))
    end = ((row == 0) | (row == len(size) - 1))[:, None]
    hats = {
        (0, 0): np.where(end, linear[0, 0], (1.0 - along) * below),
        (-1, 1): np.where(end, 0.0, (1.0 - along) * (1.0 - below)),
        (0, 1): np.where(end, linear[0, 1], along * above),
        (1, 0): np.where(end, 0.0, along * (1.0 - above)),
    }
    return ContactPoints(points, around.shapes(row, linear, len(points)), around.shapes(row, hats, len(points)))


def _share(size: FloatArray, step: int) -> FloatArray:
    """Divide the hat function of a vertex between the contact points above and below, in proportion to row height.

    Returns
    -------
    (n_rows,) fraction for the contact point in each row, if the vertex is on the lower (step -1) or upper (step 1)
    border of the row. The contact point in the adjacent row gets the rest. If the adjacent row is the first or the last
    one, the fraction is 1. The fractions of the first and the last row themselves are not used.
    """
    other = np.zeros_like(size)
    if step < 0:
        other[2:] = size[1:-1]
    else:
        other[:-2] = size[1:-1]
    return np.asarray(size / (size + other))


@dataclass(frozen=True)
class _Around:
    """Circumferential position of each node: the vertex column at which its cell begins, and its place in the cell.

    Attributes
    ----------
    first
        (n_cells, 1) number of the vertex column (vertices at one angle) at which each cell begins.
    local
        (n_cells, 9) 0 for nodes on this column, 1 in the middle of the cell, 2 on the next column.
    count
        Number of vertex columns.
    """

    first: IntArray
    local: IntArray
    count: int

    def shapes(self, row: IntArray, along: dict[tuple[int, int], FloatArray], n_points: int) -> sp.csr_matrix:
        """(9 n_cells, n_points) shape functions: cubic functions of the angle multiplied by the functions `along` of z.

        The keys of `along` are the row of the contact point minus the row of the cell, and the Gauss point. The values
        of `along` (n_cells, 9) are the values of the function of z at the nodes of each cell.
        """
        entries: list[tuple[IntArray, IntArray, FloatArray]] = []
        nodes = np.arange(self.local.size).reshape(self.local.shape)
        for (step, gauss), values in along.items():
            numbers = (2 * (row[:, None] + step) + gauss) * self.count
            for place, weights in ((0, {0: 1.0}), (1, _CUBIC), (2, {1: 1.0})):
                here = (self.local == place) & (values != 0.0)
                for vertex, weight in weights.items():
                    columns = np.broadcast_to(numbers + (self.first + vertex) % self.count, values.shape)
                    entries.append((nodes[here], columns[here], weight * values[here]))
        node, point, value = (np.concatenate(part) for part in zip(*entries, strict=True))
        return sp.csr_matrix((value, (node, point)), shape=(nodes.size, n_points))


def _vertex_points(part: CylinderMesh) -> ContactPoints:
    vertices, points = canonical_vertices(part)
    number = np.full(len(part.nodes), -1, np.int64)
    number[vertices] = np.arange(len(vertices))
    node, corner = np.nonzero(_HAT)
    rows = (9 * np.arange(len(part.cells))[:, None] + node).ravel()
    columns = number[part.cells[:, corner]].ravel()
    values = np.tile(_HAT[node, corner], len(part.cells))
    shapes = sp.csr_matrix((values, (rows, columns)), shape=(9 * len(part.cells), len(vertices)))
    return ContactPoints(points, shapes, shapes)
