"""The mesh of a roll: concentric shells of order-2 quads, and how their nodes are counted and mirrored."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from wroll_fem.typing import FloatArray, IntArray

VTK_GRID: list[tuple[int, int, int]] = [
    (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1),
    (0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1),
]  # fmt: skip
"""Positions of the nodes of VTK_TRIQUADRATIC_HEXAHEDRON on the 3 x 3 x 3 grid of a cell."""


@dataclass(frozen=True)
class CylinderMesh:
    """Concentric shells as order-2 quads.

    Attributes
    ----------
    nodes
        (n_nodes, 3) Cartesian coordinates, m.
    cells
        (n_cells, 9) node numbers in gmsh's quad9 order (the same as VTK_BIQUADRATIC_QUAD).
    groups
        Cell numbers of the shells "mandrel", "layer_01", ...; node numbers of their end rings
        "mandrel_base", "mandrel_tip", "layer_01_base", "layer_01_tip", ...
    """

    nodes: FloatArray
    cells: IntArray
    groups: dict[str, IntArray]

    @property
    def parts(self) -> list[str]:
        """Names of the shells, inner first."""
        return sorted((n for n in self.groups if not n.endswith(("_base", "_tip"))), key=lambda n: (n != "mandrel", n))

    def part(self, name: str) -> CylinderMesh:
        """Mesh of one shell with its own compact node numbering; groups "base" and "tip" hold ring nodes."""
        cells = self.cells[self.groups[name]]
        used = np.unique(cells)
        renumber = np.full(len(self.nodes), -1, np.int64)
        renumber[used] = np.arange(len(used))
        rings = {end: renumber[self.groups[f"{name}_{end}"]] for end in ("base", "tip")}
        groups = {name: np.arange(len(cells))} | {end: ring[ring >= 0] for end, ring in rings.items()}
        return CylinderMesh(self.nodes[used], renumber[cells], groups)


def canonical_vertices(part: CylinderMesh) -> tuple[IntArray, FloatArray]:
    """Corner vertices of a shell in the order in which contact points are counted.

    Returns
    -------
    vertices : (n,) node numbers, sorted by z, then theta.
    points : (n, 3) theta in (-pi, pi] rad, z in m, r in m.
    """
    vertices = np.unique(part.cells[:, :4])
    x, y, z = part.nodes[vertices].T
    theta = np.arctan2(y, x)
    theta[theta < -np.pi + 1e-6] = np.pi
    by_height = np.argsort(z, kind="stable")
    level = np.empty(len(z), np.int64)  # heights that differ by rounding errors only are one level
    level[by_height] = np.cumsum(np.diff(z[by_height], prepend=z.min()) > 1e-7 * np.ptp(z))
    order = np.lexsort((theta, level))
    return vertices[order], np.column_stack([theta, z, np.hypot(x, y)])[order]


def mirror_nodes(nodes: FloatArray) -> IntArray | None:
    """For each node the node mirrored about the x-z plane, or None if the mesh is not symmetric."""
    distance, partner = cKDTree(nodes).query(nodes * np.array([1.0, -1.0, 1.0]))
    if distance.max() > 1e-7 * np.abs(nodes).max():
        return None
    return np.asarray(partner, np.int64)


def ring_edges(cells: IntArray, ring: IntArray) -> IntArray:
    """(n, 3) edges [end, end, middle] of the quads whose three nodes all lie on a ring."""
    edges = np.concatenate([cells[:, [i, (i + 1) % 4, 4 + i]] for i in range(4)])
    return edges[np.isin(edges, ring).all(axis=1)]
