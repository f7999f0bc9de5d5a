"""Rigid motions of a body with its base: for base shear and moment, and for a base that turns about the axis."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from wroll_fem.bodies.body import Body
from wroll_fem.typing import FloatArray

RIGID_BASE = -2
"""Node number of the unknowns of a rigid base ring."""

_UP = np.array([0.0, 0.0, 1.0])


def base_rotation(body: Body, direction: int, length: float) -> FloatArray | None:
    """Displacement of the unknowns under a unit rotation of the base, which moves points above it along +direction.

    The axis of rotation passes through the centre of the base, normal to the roll axis and to the direction.

    Parameters
    ----------
    direction
        0 for x, 1 for y.
    length
        Height of the centre of a rigid tip, m.

    Returns
    -------
    (n,) displacement (m or rad per rad); None for an axial direction, or if the nodes of the unknowns are not known.
    """
    node, component = body.unknown_node, body.unknown_component
    if node is None or component is None or direction == 2:
        return None
    axis = np.cross(_UP, np.eye(3)[direction])
    places = np.where((node >= 0)[:, None], body.places[np.maximum(node, 0)], length * _UP)
    places[node == RIGID_BASE] = 0.0
    moved = np.column_stack([np.cross(axis, places), np.tile(axis, (len(node), 1))])
    return np.asarray(moved[np.arange(len(node)), component])


def axial_rotation(body: Body) -> FloatArray:
    """(n,) displacement of the unknowns under a unit rotation of the base about the axis of the roll, m or rad per rad.

    Clamped nodes move with the base and have no unknowns. The unknowns are those whose nodal displacements are the
    rotation; a symmetric model has none.
    """
    maps = [body.expand] if len(body.nodes) else []
    turned = [np.column_stack([np.cross(_UP, body.nodes), np.tile(_UP, (len(body.nodes), 1))])] if maps else []
    if body.solid is not None:
        maps.append(body.solid.expand)
        turned.append(np.cross(_UP, body.solid.nodes))
    expand, moved = sp.vstack(maps, format="csr"), np.concatenate([values.ravel() for values in turned])
    return np.asarray(spla.spsolve((expand.T @ expand).tocsc(), expand.T @ moved))
