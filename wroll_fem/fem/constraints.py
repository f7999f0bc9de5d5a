"""Constraints of a shell by elimination of unknowns: clamped or guided nodes, rigid tip, symmetry plane.

One sparse map from the remaining unknowns y to the nodal values contains all constraints,

    q = E y,     K_y = E^T K E,     M_y = E^T M E,

so the matrices contain neither penalty numbers nor Dirichlet rows. Nodal values are node-major
[ux, uy, uz, rx, ry, rz]; the unknowns of a rigid tip, [U, Omega], come last.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.errors import InputError
from wroll_fem.mesh.shells import mirror_nodes
from wroll_fem.typing import BoolArray, FloatArray, IntArray

_MIRROR_SIGN = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""Signs of [u, theta] under reflection y -> -y: displacement is a polar vector, rotation an axial vector."""


@dataclass(frozen=True)
class Constraints:
    """Constraints of a shell, as a map from the remaining unknowns to the nodal values.

    Attributes
    ----------
    expand
        (6 n_nodes, n) sparse map E.
    master
        (6,) indices of the unknowns [Ux, Uy, Uz, Omega_x, Omega_y, Omega_z] of the rigid tip, -1 if eliminated; None
        without a rigid tip.
    component
        (n,) component of each unknown, 0 to 5.
    node
        (n,) node of each unknown, -1 for the rigid tip, -2 for the rigid base ring.
    base_master
        (6,) as ``master``, for a rigid base ring; None without it.
    """

    expand: sp.csr_matrix
    master: IntArray | None
    component: IntArray
    node: IntArray
    base_master: IntArray | None = None


def build_constraints(
    nodes: FloatArray,
    *,
    clamped: IntArray,
    guided: IntArray | None = None,
    rigid: IntArray | None = None,
    centre: FloatArray | None = None,
    symmetric: bool = False,
    base: tuple[IntArray, BoolArray] | None = None,
) -> Constraints:
    """Eliminate clamped nodes, tie rings rigidly to their centres and impose symmetry about the x-z plane.

    Parameters
    ----------
    nodes
        (n_nodes, 3) coordinates, m.
    clamped
        Nodes whose six values are zero relative to the base.
    guided
        Nodes whose displacements along x and y are zero relative to the base.
    rigid
        Nodes with u = U + Omega x (x - centre) and theta = Omega; None for a deformable end.
    centre
        (3,) reference point of the rigid nodes, m; it must lie on the x-z plane if `symmetric`.
    symmetric
        Keep only motions symmetric about the x-z plane.
    base
        Nodes of a rigid base ring about the origin, and (6,) which of its motions [U, Omega] are free; None without it.

    Raises
    ------
    InputError
        If `symmetric` is set but the nodes are not symmetric about the x-z plane.
    """
    n = len(nodes)
    source, sign, free = mirrored_values(nodes, _MIRROR_SIGN, symmetric=symmetric)
    free[clamped] = False
    if guided is not None:
        free[guided, :2] = False
    rings: list[tuple[int, IntArray, FloatArray, BoolArray]] = []
    if rigid is not None:
        rings.append((-1, rigid, np.zeros(3) if centre is None else centre, np.ones(6, bool)))
    if base is not None:
        rings.append((-2, base[0], np.zeros(3), base[1]))
    tied = np.zeros(n, bool)
    for _, ring, _, _ in rings:
        tied[ring] = True
    tied[clamped] = False
    own = free & ~tied[:, None] & (source == np.arange(n))[:, None]
    column = np.full((n, 6), -1, np.int64)
    column[own] = np.arange(own.sum())
    node, component = np.nonzero(own)

    follows = column[source]
    rows, comps = np.nonzero((follows >= 0) & free & ~tied[:, None])
    entries = [(6 * rows + comps, follows[rows, comps], sign[rows, comps])]
    count, masters = int(own.sum()), {}
    for label, ring, about, moves in rings:
        alive = moves & (_MIRROR_SIGN > 0) if symmetric else moves
        master = masters[label] = np.where(alive, count + np.cumsum(alive) - 1, -1)
        component = np.concatenate([component, np.flatnonzero(alive)])
        node = np.concatenate([node, np.full(int(alive.sum()), label)])
        count += int(alive.sum())
        entries.append(_rigid_entries(nodes, np.setdiff1d(ring, clamped), about, master))
    row, col, value = (np.concatenate(part) for part in zip(*entries, strict=True))
    expand = sp.csr_matrix((value, (row, col)), shape=(6 * n, count))
    return Constraints(expand, masters.get(-1), component, node, masters.get(-2))


def mirrored_values(
    nodes: FloatArray, parity: FloatArray, *, symmetric: bool
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Symmetry about the x-z plane: for each node, the source node of its values, their signs, and the free components.

    Parameters
    ----------
    nodes
        (n, 3) coordinates, m.
    parity
        (k,) sign of each component of the nodal values under reflection y -> -y.
    symmetric
        Impose the symmetry; otherwise every node determines itself.

    Returns
    -------
    source : (n,) node whose values determine the values of each node.
    sign : (n, k) factor by which these values are multiplied.
    free : (n, k) False for components that vanish on the symmetry plane.

    Raises
    ------
    InputError
        If `symmetric` is set but the nodes are not symmetric about the x-z plane.
    """
    n, k = len(nodes), len(parity)
    source, sign, free = np.arange(n), np.ones((n, k)), np.ones((n, k), bool)
    if symmetric:
        partner = mirror_nodes(nodes)
        if partner is None:
            raise InputError(
                "the nodes of the mesh are not symmetric about the x-z plane",
                key="solver.symmetry",
                remedy="set solver.symmetry: false, or mesh with a node at theta = 0 and symmetric divisions",
            )
        below = nodes[:, 1] < -1e-9 * np.abs(nodes).max()
        source[below], sign[below] = partner[below], parity
        free[partner == np.arange(n)] = parity > 0
    return source, sign, free


def base_influence(component: IntArray, symmetric: bool) -> FloatArray:
    """Displacement of the unknowns under unit translations of the base along x, y and z.

    Clamped nodes move with the base and have no unknowns. A translation along y has no part that is symmetric about the
    x-z plane, so its column is zero in a symmetric model.

    Parameters
    ----------
    component
        (n,) component of each unknown: 0 to 5 for [ux, uy, uz, rx, ry, rz].
    symmetric
        Whether the model keeps only motions symmetric about the x-z plane.

    Returns
    -------
    (n, 3) influence vectors.
    """
    influence = (component[:, None] == np.arange(3)).astype(float)
    if symmetric:
        influence[:, 1] = 0.0
    return influence


def rigid_motions(nodes: FloatArray, centre: FloatArray) -> FloatArray:
    """(6 n_nodes, 6) nodal values of unit translations and of unit rotations about `centre` (3,), m."""
    n = len(nodes)
    modes = np.zeros((n, 6, 6))
    modes[:, :3, :3] = np.eye(3)
    modes[:, 3:, 3:] = np.eye(3)
    arm = nodes - centre
    for axis in range(3):
        modes[:, :3, 3 + axis] = np.cross(np.eye(3)[axis], arm)
    return modes.reshape(6 * n, 6)


def _rigid_entries(
    nodes: FloatArray, tied: IntArray, centre: FloatArray, master: IntArray
) -> tuple[IntArray, IntArray, FloatArray]:
    block = rigid_motions(nodes[tied], centre)
    block[:, master < 0] = 0.0
    rows, comps = np.nonzero(block)
    return 6 * tied[rows // 6] + rows % 6, master[comps], block[rows, comps]
