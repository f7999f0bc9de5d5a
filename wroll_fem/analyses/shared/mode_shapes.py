"""Dataset variables of the mode shapes and of their mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wroll_fem.bodies.body import Body
from wroll_fem.typing import FloatArray


def shape_variables(bodies: Sequence[Body], vectors: FloatArray) -> dict[str, Any]:
    """Dataset variables: mode shapes, node positions, quadrilaterals and, for a solid coil, hexahedra.

    Parameters
    ----------
    bodies
        Bodies whose unknowns are concatenated.
    vectors
        (n_dofs, n_modes) modes.
    """
    return {
        "mode_shape": (("mode", "node", "component"), _shapes(bodies, vectors)),
        "node_position": (("node", "component"), np.vstack([part for body in bodies for part in _parts(body)])),
        "cell_nodes": (("cell", "corner"), _cells(bodies)),
        **_solid_cells(bodies),
    }


def _shapes(bodies: Sequence[Body], vectors: FloatArray) -> FloatArray:
    """Mode shapes (n_modes, n_nodes, 3): nodal displacements, scaled to a largest displacement of 1."""
    ends = np.cumsum([body.n_dofs for body in bodies])[:-1]
    parts = []
    for body, part in zip(bodies, np.split(vectors, ends), strict=True):
        parts.append((body.expand @ part).reshape(-1, 6, vectors.shape[1])[:, :3])  # none without a shell
        if body.solid is not None:
            parts.append((body.solid.expand @ part).reshape(-1, 3, vectors.shape[1]))
    shapes = np.moveaxis(np.vstack(parts), 2, 0)
    largest = np.linalg.norm(shapes, axis=2).max(axis=1)
    return np.asarray(shapes / largest[:, None, None])


def _parts(body: Body) -> list[FloatArray]:
    """Nodes of a body, followed by the nodes of its solid coil."""
    return [body.nodes] if body.solid is None else [body.nodes, body.solid.nodes]


def _starts(bodies: Sequence[Body]) -> list[int]:
    """Index of the first node of each body in the list of all nodes."""
    return np.concatenate([[0], np.cumsum([sum(map(len, _parts(body))) for body in bodies])]).tolist()


def _cells(bodies: Sequence[Body]) -> np.ndarray:
    """Quadrilaterals (n, 9) of the shells and of the outer surface of the solid coil."""
    quads = []
    for body, start in zip(bodies, _starts(bodies), strict=False):
        quads.append(body.cells + start)
        if body.solid is not None:
            quads.append(body.solid.skin + start + len(body.nodes))
    return np.vstack(quads)


def _solid_cells(bodies: Sequence[Body]) -> dict[str, tuple[tuple[str, str], np.ndarray]]:
    """Variable with the hexahedra of the solid coil; empty without a solid coil."""
    cells = [
        body.solid.cells + start + len(body.nodes)
        for body, start in zip(bodies, _starts(bodies), strict=False)
        if body.solid is not None
    ]
    return {"solid_cell_nodes": (("solid_cell", "solid_corner"), np.vstack(cells))} if cells else {}
