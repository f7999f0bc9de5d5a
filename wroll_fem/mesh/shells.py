"""Mesh of a roll: concentric shells of order-2 quads, with their vertices, mirrored nodes and ring edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from wroll_fem.bodies.levels import levels
from wroll_fem.typing import FloatArray, IntArray

VTK_GRID: list[tuple[int, int, int]] = [
    (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1),
    (0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1),
]  # fmt: skip
"""Grid positions (0, 1 or 2 along each axis) of the 27 nodes of VTK_TRIQUADRATIC_HEXAHEDRON."""


@dataclass(frozen=True)
class CylinderMesh:
    """Concentric shells meshed with order-2 quads.

    Attributes
    ----------
    nodes
        (n_nodes, 3) Cartesian coordinates, m.
    cells
        (n_cells, 9) node numbers in the quad9 order of gmsh (the same as VTK_BIQUADRATIC_QUAD).
    groups
        Cell numbers of each shell ("mandrel", "layer_01", ...) and node numbers of each end ring ("mandrel_base",
        "mandrel_tip", "layer_01_base", "layer_01_tip", ...).
    """

    nodes: FloatArray
    cells: IntArray
    groups: dict[str, IntArray]

    @property
    def parts(self) -> list[str]:
        """Names of the shells, innermost first."""
        return sorted((n for n in self.groups if not n.endswith(("_base", "_tip"))), key=lambda n: (n != "mandrel", n))

    def part(self, name: str) -> CylinderMesh:
        """Mesh of one shell with its own node numbering; the groups "base" and "tip" are the nodes of its end rings."""
        cells = self.cells[self.groups[name]]
        used = np.unique(cells)
        renumber = np.full(len(self.nodes), -1, np.int64)
        renumber[used] = np.arange(len(used))
        rings = {end: renumber[self.groups[f"{name}_{end}"]] for end in ("base", "tip")}
        groups = {name: np.arange(len(cells))} | {end: ring[ring >= 0] for end, ring in rings.items()}
        return CylinderMesh(self.nodes[used], renumber[cells], groups)


def canonical_vertices(part: CylinderMesh) -> tuple[IntArray, FloatArray]:
    """Corner vertices of a shell in the order of the contact points.

    Returns
    -------
    vertices : (n,) node numbers, sorted by z, then theta.
    points : (n, 3) coordinates theta in (-pi, pi] (rad), z (m), r (m).
    """
    vertices = np.unique(part.cells[:, :4])
    x, y, z = part.nodes[vertices].T
    theta = np.arctan2(y, x)
    theta[theta < -np.pi + 1e-6] = np.pi
    order = np.lexsort((theta, levels(z)[1]))
    return vertices[order], np.column_stack([theta, z, np.hypot(x, y)])[order]


def mirror_nodes(nodes: FloatArray) -> IntArray | None:
    """Index of the mirror image of each node in the x-z plane, or None if the mesh is not symmetric."""
    distance, partner = cKDTree(nodes).query(nodes * np.array([1.0, -1.0, 1.0]))
    if distance.max() > 1e-7 * np.abs(nodes).max():
        return None
    return np.asarray(partner, np.int64)


def ring_edges(cells: IntArray, ring: IntArray) -> IntArray:
    """(n, 3) node numbers [end, end, midpoint] of the quad edges that lie on a ring."""
    edges = np.concatenate([cells[:, [i, (i + 1) % 4, 4 + i]] for i in range(4)])
    return edges[np.isin(edges, ring).all(axis=1)]
