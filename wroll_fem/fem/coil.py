r"""Homogenised coil: a solid bonded to the outer surface of the mandrel by elimination of unknowns, not by a penalty.

The hexahedra are the quads of the mandrel extruded outwards, so node k of their inner surface matches node k of the
shell. The inner surface has no unknowns of its own. It moves with the outer surface of the wall, at half the wall
thickness t/2 from the mid-surface:

    u_inner = u + (t/2) theta x d.

One map from the unknowns y = [shell, coil] to the nodal displacements of the coil, u = T y, contains all constraints:

    K = K_shell + T^T K_coil T,     M = M_shell + T^T M_coil T.

Notes
-----
The shell is rigid through its thickness; a change of its curvature acts on the coil through theta alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body, SolidPart
from wroll_fem.errors import InputError
from wroll_fem.fem import compat
from wroll_fem.fem.constraints import Constraints, base_influence, mirrored_values
from wroll_fem.fem.shell import radial_director
from wroll_fem.fem.solid import constrained_matrices, thicken, tidy
from wroll_fem.mesh.generate import annulus_borders, axial_stations, with_borders
from wroll_fem.mesh.shells import VTK_GRID, CylinderMesh
from wroll_fem.typing import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from wroll_fem.case.roll import RollSections


_MIRROR_SIGN = np.array([1.0, -1.0, 1.0])
"""Factor of the displacements ux, uy, uz under reflection in the x-z plane."""


@dataclass(frozen=True)
class CoilMatrices:
    """Contribution of the coil to the stiffness and mass matrices, for the unknowns [shell, coil].

    Attributes
    ----------
    stiffness, mass
        (n, n) sparse symmetric matrices of all n unknowns, N/m and kg.
    component
        (n_coil,) component (0, 1, 2 for x, y, z) of each unknown of the coil.
    part
        Mesh of the coil and the map from the unknowns to its nodal displacements.
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    component: IntArray
    part: SolidPart


def coil_heights(roll: RollSections) -> FloatArray:
    """Distances of the node layers of the coil from the mid-surface of the mandrel, m, ascending.

    There are 2 `mesh.radial` + 1 of them, and two more for each element that is divided near a clamped annulus.
    """
    wall = 0.5 * roll.geometry.mandrel_thickness
    borders = axial_stations(roll.coil.total_thickness, roll.mesh.radial, roll.mesh.radial_grading)
    near = annulus_borders(roll.clamped_width, borders[1] - borders[0])
    borders = with_borders(borders, [roll.clamped_width, *near] if roll.clamped_width else [])
    levels = np.zeros(2 * len(borders) - 1)
    levels[::2], levels[1::2] = borders, 0.5 * (borders[1:] + borders[:-1])
    return wall + levels


def mesh_coil(roll: RollSections, part: CylinderMesh) -> tuple[FloatArray, IntArray]:
    """Nodes (layer after layer, innermost first) and 27-node cells (basix's order) of the coil around the mandrel.

    `part` is the mesh of the mandrel's mid-surface.
    """
    return thicken(part.nodes, part.cells, list(coil_heights(roll)))


def coil_hexes(roll: RollSections, mesh: CylinderMesh) -> tuple[FloatArray, IntArray] | None:
    """Nodes and cells (VTK_TRIQUADRATIC_HEXAHEDRON order) of a solid coil for mesh files; None for other coils."""
    if roll.coil.model != "solid":
        return None
    nodes, cells = mesh_coil(roll, mesh.part("mandrel"))
    return nodes, in_vtk_order(nodes, cells)


def assemble_coil(roll: RollSections, part: CylinderMesh, shell: Constraints, *, symmetric: bool) -> CoilMatrices:
    """Assemble stiffness and mass of the coil bonded to the mandrel.

    With `coil.inside: slipping` the stiffness has no shear between the wraps (see `coiled_stiff.slipping_coil`).

    Parameters
    ----------
    roll
        Sections geometry, mandrel, coil and mesh, for example those of a case on a roll.
    part
        Mesh of the mandrel's mid-surface.
    shell
        Constraints of the mandrel.
    symmetric
        Keep only motions symmetric about the x-z plane, as `shell` does.

    Raises
    ------
    InputError
        If the base of the coil is clamped and that of the mandrel free.
    """
    if roll.mandrel.base == "free" and roll.coil.base != "free":
        raise InputError(
            f"the base of the coil is clamped ({roll.coil.base}) but the base of the mandrel is free",
            key="coil.base",
            remedy="use coil.base: free, or mandrel.base: clamped",
        )
    nodes, cells = mesh_coil(roll, part)
    bond = wall_offset(part.nodes, 0.5 * roll.geometry.mandrel_thickness) @ shell.expand
    clamped = part.groups["base"] if roll.coil.base == "clamped" else np.empty(0, np.int64)
    expand, component = bonded_map(part.nodes, len(nodes) // len(part.nodes), bond, clamped, symmetric=symmetric)
    material = roll.coil.solid()
    ordered = in_vtk_order(nodes, cells)
    stiffness, mass, volume = constrained_matrices(
        nodes, cells, expand, material, between_wraps=roll.coil.inside == "stiff", symmetric=symmetric
    )
    return CoilMatrices(
        stiffness=stiffness,
        mass=mass,
        component=component,
        part=SolidPart(
            nodes, len(nodes) // len(part.nodes), ordered, expand, material.rho * volume, skin_quads(ordered)
        ),
    )


def in_vtk_order(nodes: FloatArray, cells: IntArray) -> IntArray:
    """Reorder cell nodes (n_cells, 27) from basix's order to the right-handed VTK_TRIQUADRATIC_HEXAHEDRON order."""
    grid = [tuple(point) for point in np.rint(2 * compat.hexahedron_points()).astype(int).tolist()]
    corner, *ends = (nodes[cells[0, grid.index(point)]] for point in ((0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)))
    right_handed = np.linalg.det(np.array(ends) - corner) > 0
    order = [grid.index((a, b, c) if right_handed else (b, a, c)) for a, b, c in VTK_GRID]
    return np.asarray(cells[:, order])


def wall_offset(nodes: FloatArray, height: float) -> sp.csr_matrix:
    """(3 n, 6 n) operator for the displacement at a height (m) above the n shell nodes.

    The displacement is u + height theta x d, with the radial unit vector d.
    """
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
    """Map from the unknowns [shell, coil] to the nodal displacements of the coil.

    Parameters
    ----------
    nodes
        (n, 3) nodes of the mandrel's mid-surface, m; layer k of the coil consists of its nodes k n to (k + 1) n - 1.
    layers
        Number of node layers of the coil; the innermost moves with the mandrel.
    bond
        (3 n, n_shell) operator for the displacement of the mandrel's outer surface.
    clamped
        Nodes of the mandrel above which all coil nodes are clamped.
    symmetric
        Keep only motions symmetric about the x-z plane.

    Returns
    -------
    expand : (3 n layers, n_shell + n_coil) sparse map.
    component : (n_coil,) component (0, 1, 2 for x, y, z) of each unknown of the coil.

    Raises
    ------
    InputError
        If `symmetric` is set but the nodes are not symmetric about the x-z plane.
    """
    held = np.zeros(len(nodes), bool)
    held[clamped] = True
    rest, _, component = own_unknowns(nodes, layers - 1, np.tile(held, layers - 1), symmetric=symmetric)
    return sp.block_diag([bond, rest], format="csr"), component


def own_unknowns(
    nodes: FloatArray, layers: int, clamped: BoolArray, *, symmetric: bool
) -> tuple[sp.csr_matrix, IntArray, IntArray]:
    """Map from the unknowns of a solid coil to the displacements of its nodes.

    Parameters
    ----------
    nodes
        (n, 3) nodes of the mandrel's mid-surface, m; layer k of the coil consists of its nodes k n to (k + 1) n - 1.
    layers
        Number of node layers of the coil.
    clamped
        (n layers,) nodes without motion relative to the base.
    symmetric
        Keep only motions symmetric about the x-z plane.

    Returns
    -------
    expand : (3 n layers, n_unknowns) sparse map, node-major [ux, uy, uz].
    node, component : (n_unknowns,) node and component (0, 1, 2 for x, y, z) of each unknown.
    """
    n = len(nodes)
    source, sign, free = mirrored_values(nodes, _MIRROR_SIGN, symmetric=symmetric)
    start = n * np.arange(layers)[:, None]
    source = (start + source).ravel()
    sign, free = np.tile(sign, (layers, 1)), np.tile(free, (layers, 1)) & ~clamped[:, None]
    own = free & (source == np.arange(n * layers))[:, None]
    column = np.full(own.shape, -1, np.int64)
    column[own] = np.arange(own.sum())
    follows = column[source]
    k, c = np.nonzero((follows >= 0) & free)
    expand = sp.csr_matrix((sign[k, c], (3 * k + c, follows[k, c])), shape=(3 * n * layers, int(own.sum())))
    node, component = np.nonzero(own)
    return expand, node, component


def bond_coil(body: Body, coil: CoilMatrices) -> Body:
    """Add the matrices of the coil to those of the mandrel; the unknowns of the coil follow those of the mandrel."""
    more = len(coil.component)
    influence = base_influence(coil.component, body.symmetric)
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
    """Append zero columns for the unknowns of the coil to a matrix of the shell.

    Parameters
    ----------
    matrix
        (m, n) matrix over the unknowns of the shell.
    columns
        Number of unknowns of the coil.
    rows
        Append as many zero rows as well.
    """
    padded = sp.csr_matrix(matrix, copy=True)
    padded.resize(padded.shape[0] + (columns if rows else 0), padded.shape[1] + columns)
    return padded


def skin_quads(cells: IntArray) -> IntArray:
    """Cell faces on the free surface of the coil. Faces on the mandrel are left out.

    Parameters
    ----------
    cells
        (n_cells, 27) node numbers in VTK_TRIQUADRATIC_HEXAHEDRON order; the third local axis points outwards.

    Returns
    -------
    (n, 9) node numbers in VTK_BIQUADRATIC_QUAD order.
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
