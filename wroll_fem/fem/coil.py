r"""The homogenised coil: a solid bonded to the outer surface of the mandrel's shell, without penalty.

The hexes are the mandrel's quads thickened outwards, so that the k-th node of their inner surface faces the k-th node
of the shell. It has no unknowns of its own but follows the wall, half a wall t/2 away from the mid-surface:

    u_inner = u + (t/2) theta x d.

All constraints are one map from the unknowns y = [shell, coil] to the coil's nodal values, u = T y, and

    K = K_shell + T^T K_coil T,     M = M_shell + T^T M_coil T.

Notes
-----
The shell is rigid through its wall; the coil's first element sees the wall's curvature change through theta alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from wroll_fem.errors import InputError
from wroll_fem.fem import compat
from wroll_fem.fem.constraints import Constraints
from wroll_fem.fem.shell import drop_small, radial_director
from wroll_fem.fem.solid import SolidModel, thicken
from wroll_fem.mesh.generate import axial_stations
from wroll_fem.mesh.shells import VTK_GRID, CylinderMesh, mirror_nodes
from wroll_fem.structure.body import Body, SolidPart
from wroll_fem.typing import FloatArray, IntArray

if TYPE_CHECKING:
    from wroll_fem.case import Case


_MIRROR_SIGN = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True)
class CoilMatrices:
    """What the coil adds to the shell's matrices, over the unknowns [shell, coil].

    Attributes
    ----------
    stiffness, mass
        (n, n) sparse symmetric, N/m and kg.
    component
        (n_coil,) which of x, y, z each of the coil's own unknowns is.
    part
        Mesh of the coil and its map from the unknowns.
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    component: IntArray
    part: SolidPart


def coil_heights(case: Case) -> FloatArray:
    """(2 mesh.radial + 1,) offsets in m of the coil's node layers from the mandrel's mid-surface."""
    wall = 0.5 * case.geometry.mandrel_thickness
    borders = axial_stations(case.coil.total_thickness, case.mesh.radial, case.mesh.radial_grading)
    levels = np.zeros(2 * len(borders) - 1)
    levels[::2], levels[1::2] = borders, 0.5 * (borders[1:] + borders[:-1])
    return wall + levels


def mesh_coil(case: Case, part: CylinderMesh) -> tuple[FloatArray, IntArray]:
    """Nodes (layer after layer, inner first) and 27-node cells (basix's order) of the coil around the mandrel."""
    return thicken(part.nodes, part.cells, list(coil_heights(case)))


def coil_hexes(case: Case, mesh: CylinderMesh) -> tuple[FloatArray, IntArray] | None:
    """Nodes and cells (VTK_TRIQUADRATIC_HEXAHEDRON order) of the solid coil for files, or None without one."""
    if case.coil.model != "solid":
        return None
    nodes, cells = mesh_coil(case, mesh.part("mandrel"))
    return nodes, in_vtk_order(nodes, cells)


def assemble_coil(case: Case, part: CylinderMesh, shell: Constraints, *, symmetric: bool) -> CoilMatrices:
    """Stiffness and mass of the coil bonded to the mandrel.

    Parameters
    ----------
    part
        Mesh of the mandrel's mid-surface.
    shell
        Constraints of the mandrel.
    symmetric
        Keep only motions symmetric about the x-z plane, as `shell` does.

    Raises
    ------
    InputError
        If the coil's base is held while the mandrel's is not.
    """
    if case.mandrel.base == "free" and case.coil.base != "free":
        raise InputError(
            f"the coil's base is held, the mandrel's is free (coil.base: {case.coil.base})",
            key="coil.base",
            remedy="use coil.base: free, or mandrel.base: clamped",
        )
    nodes, cells = mesh_coil(case, part)
    model = SolidModel(nodes, cells)
    bond = wall_offset(part.nodes, 0.5 * case.geometry.mandrel_thickness) @ shell.expand
    clamped = part.groups["base"] if case.coil.base == "clamped" else np.empty(0, np.int64)
    expand, component = bonded_map(part.nodes, len(nodes) // len(part.nodes), bond, clamped, symmetric=symmetric)
    material = case.coil.material.solid()
    ordered = in_vtk_order(nodes, cells)
    stiffness, mass = model.orthotropic_stiffness(material), model.mass(material.rho)
    return CoilMatrices(
        stiffness=(expand.T @ stiffness @ expand).tocsr(),
        mass=(expand.T @ mass @ expand).tocsr(),
        component=component,
        part=SolidPart(nodes, ordered, expand, material.rho * model.volume, skin_quads(ordered)),
    )


def in_vtk_order(nodes: FloatArray, cells: IntArray) -> IntArray:
    """(n_cells, 27) cells from basix's local order to that of VTK_TRIQUADRATIC_HEXAHEDRON, which is right-handed."""
    grid = [tuple(point) for point in np.rint(2 * compat.hexahedron_points()).astype(int).tolist()]
    corner, *ends = (nodes[cells[0, grid.index(point)]] for point in ((0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)))
    right_handed = np.linalg.det(np.array(ends) - corner) > 0
    order = [grid.index((a, b, c) if right_handed else (b, a, c)) for a, b, c in VTK_GRID]
    return np.asarray(cells[:, order])


def wall_offset(nodes: FloatArray, height: float) -> sp.csr_matrix:
    """(3 n, 6 n) displacement u + height theta x d of the points at `height` (m) above a shell's nodes."""
    d, n = radial_director(nodes), len(nodes)
    cross = np.zeros((n, 3, 6))
    cross[:, :, :3] = np.eye(3)
    for (i, j, k), sign in {
        (0, 1, 2): 1,
        (1, 2, 0): 1,
        (2, 0, 1): 1,
        (0, 2, 1): -1,
        (1, 0, 2): -1,
        (2, 1, 0): -1,
    }.items():
        cross[:, i, 3 + j] = sign * height * d[:, k]  # (theta x d)_i
    rows = np.broadcast_to((3 * np.arange(n)[:, None] + np.arange(3))[:, :, None], cross.shape)
    cols = np.broadcast_to((6 * np.arange(n)[:, None] + np.arange(6))[:, None, :], cross.shape)
    matrix = sp.csr_matrix((cross.ravel(), (rows.ravel(), cols.ravel())), shape=(3 * n, 6 * n))
    matrix.eliminate_zeros()
    return matrix


def bonded_map(
    nodes: FloatArray, layers: int, bond: sp.csr_matrix, clamped: IntArray, *, symmetric: bool
) -> tuple[sp.csr_matrix, IntArray]:
    """Map from the unknowns [shell, coil] to the coil's nodal values, and the component of each coil unknown.

    Parameters
    ----------
    nodes
        (n, 3) of the mandrel's mid-surface; node layer k of the coil holds its nodes k n to (k + 1) n - 1.
    layers
        Node layers of the coil; the innermost follows the mandrel.
    bond
        (3 n, n_shell) displacement of the mandrel's outer surface.
    clamped
        Nodes of the mandrel whose radial line of coil nodes is clamped.
    symmetric
        Keep only motions symmetric about the x-z plane.
    """
    n = len(nodes)
    source, sign, free = np.arange(n), np.ones((n, 3)), np.ones((n, 3), bool)
    if symmetric:
        partner = mirror_nodes(nodes)
        if partner is None:
            raise ValueError("the mandrel's constraints are symmetric, its nodes are not")
        below = nodes[:, 1] < -1e-9 * np.abs(nodes).max()
        source[below], sign[below] = partner[below], _MIRROR_SIGN
        free[partner == np.arange(n)] = _MIRROR_SIGN > 0
    free[clamped] = False
    own = free & (source == np.arange(n))[:, None]
    column = np.full((n, 3), -1, np.int64)
    column[own] = np.arange(own.sum())
    follows = column[source]
    k, c = np.nonzero((follows >= 0) & free)
    layer = sp.csr_matrix((sign[k, c], (3 * k + c, follows[k, c])), shape=(3 * n, int(own.sum())))
    rest = sp.block_diag([layer] * (layers - 1), format="csr")
    expand = sp.block_diag([bond, rest], format="csr")
    return expand, np.tile(np.nonzero(own)[1], layers - 1)


def bond_coil(body: Body, coil: CoilMatrices) -> Body:
    """The mandrel with the coil in its matrices; the coil's own unknowns come behind the mandrel's."""
    more = len(coil.component)
    influence = (coil.component[:, None] == np.arange(3)).astype(float)
    if body.symmetric:
        influence[:, 1] = 0.0
    return replace(
        body,
        stiffness=tidy(pad(body.stiffness, more, rows=True) + coil.stiffness),
        mass=tidy(pad(body.mass, more, rows=True) + coil.mass),
        influence=np.vstack([body.influence, influence]),
        expand=pad(body.expand, more),
        traces={side: replace(trace, operator=pad(trace.operator, more)) for side, trace in body.traces.items()},
        pressure_force=np.append(body.pressure_force, np.zeros(more)),
        probes={name: pad(probe, more) for name, probe in body.probes.items()},
        mass_total=body.mass_total + coil.part.mass,
        solid=coil.part,
        unknown_node=None,
        unknown_component=None,
    )


def pad(matrix: sp.spmatrix, columns: int, *, rows: bool = False) -> sp.csr_matrix:
    """Matrix with zero columns (and rows) for the coil's unknowns behind those of the shell."""
    padded = sp.csr_matrix(matrix, copy=True)
    padded.resize(padded.shape[0] + (columns if rows else 0), padded.shape[1] + columns)
    return padded


def tidy(matrix: sp.spmatrix) -> sp.csr_matrix:
    """Symmetric CSR with sorted indices and without rounding-error entries."""
    result = drop_small(((matrix + matrix.T) * 0.5).tocsr())
    result.sort_indices()
    return result


def skin_quads(cells: IntArray) -> IntArray:
    """(n, 9) outer faces in VTK_BIQUADRATIC_QUAD order: what is seen of the coil; the face on the mandrel is left out.

    Parameters
    ----------
    cells
        (n_cells, 27) in VTK_TRIQUADRATIC_HEXAHEDRON order, the third local axis outwards.
    """
    at = {point: k for k, point in enumerate(VTK_GRID)}
    corners = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    local = [[at[a, b, c] for a, b in corners] for c in (0, 2)]
    local += [[at[side, a, b] for a, b in corners] for side in (0, 2)]
    local += [[at[a, side, b] for a, b in corners] for side in (0, 2)]
    quads = np.concatenate([cells[:, nodes] for nodes in local])
    counts = np.bincount(quads[:, 8])
    on_mandrel = np.arange(len(quads)) < len(cells)
    return np.asarray(quads[(counts[quads[:, 8]] == 1) & ~on_mandrel])
