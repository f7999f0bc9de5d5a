r"""Solid coil that rubs on its mandrel: a body of hexahedra with a surface trace on its inner face.

The hexahedra are the quads of the mandrel extruded outwards, as in `coil`, but the nodes of their inner face have
unknowns of their own. The inner face and the outer surface of the mandrel's wall have the same contact points and the
same shape functions psi_k (`trace`). Node k of the face lies above node k of the shell, and the face is a radial
scaling of the mid-surface. The weighted means of the displacement are therefore those of the mid-surface,

    motion[k, c] = 1 / A_k  int psi_k u . e_c dA,

so that the two sides of the interface are averaged in the same way, and tractions do the same work on both.

The base of the coil is free, clamped, or clamped on an annulus next to the mandrel. A clamped line (width 0) is no
support in three dimensions: its stiffness falls with the logarithm of the element size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body, SolidPart, Trace
from wroll_fem.fem.coil import MIRROR_SIGN, in_vtk_order, mesh_coil, skin_quads, tidy
from wroll_fem.fem.constraints import mirrored_values
from wroll_fem.fem.shell import ShellModel, radial_director
from wroll_fem.fem.solid import SolidModel
from wroll_fem.fem.trace import SurfaceTrace, half_circumference
from wroll_fem.mesh.contact_points import ContactPoints
from wroll_fem.mesh.shells import CylinderMesh
from wroll_fem.typing import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from wroll_fem.case.roll import RollSections

NAME = "coil"
"""Name of the body."""

_EDGE = 1e-9
"""Tolerance of the width of the clamped annulus, relative to the thickness of the coil."""


def assemble_rubbing_coil(
    roll: RollSections, part: CylinderMesh, shell: ShellModel, contact: ContactPoints, *, symmetric: bool
) -> Body:
    """Assemble the solid coil of a roll as a body of its own.

    Parameters
    ----------
    roll
        Sections geometry, mandrel, coil and mesh, for example those of a case on a roll.
    part, shell
        Mesh and shell model of the mandrel's mid-surface.
    contact
        Contact points of the mandrel.
    symmetric
        Keep only motions symmetric about the x-z plane, and contact points with theta in [0, pi].
    """
    nodes, cells = mesh_coil(roll, part)
    n, layers = len(part.nodes), len(nodes) // len(part.nodes)
    clamped = np.zeros(len(nodes), bool)
    clamped[clamped_nodes(roll, part, nodes)] = True
    expand, node, component = own_unknowns(part.nodes, layers, clamped, symmetric=symmetric)
    model, material = SolidModel(nodes, cells), roll.coil.solid()
    face = sp.hstack([sp.identity(3 * n), sp.csr_matrix((3 * n, 3 * n * (layers - 1)))], format="csr") @ expand
    outer = sp.hstack([sp.csr_matrix((3 * n, 3 * n * (layers - 1))), sp.identity(3 * n)], format="csr") @ expand
    middle = float(np.hypot(*part.nodes[:, :2].T).mean())
    inner_radius = 0.5 * roll.geometry.mandrel_outer_diameter
    outward = shell.area_load(-(inner_radius + roll.coil.total_thickness) / middle * radial_director(part.nodes))
    ordered = in_vtk_order(nodes, cells)
    mass, influence = material.rho * model.volume, (component[:, None] == np.arange(3)).astype(float)
    if symmetric:
        influence[:, 1] = 0.0
    return Body(
        name=NAME,
        stiffness=tidy(expand.T @ model.orthotropic_stiffness(material) @ expand),
        mass=tidy(expand.T @ model.mass(material.rho) @ expand),
        influence=influence,
        expand=sp.csr_matrix((0, expand.shape[1])),
        nodes=np.empty((0, 3)),
        cells=np.empty((0, 9), np.int64),
        traces={"inner": _inner_trace(shell, contact, face, inner_radius, middle, symmetric)},
        pressure_force=np.asarray(outer.T @ outward.reshape(-1, 6)[:, :3].ravel()),
        mass_total=mass,
        symmetric=symmetric,
        solid=SolidPart(nodes, layers, ordered, expand, mass, skin_quads(ordered)),
        unknown_node=node,
        unknown_component=component,
    )


def clamped_nodes(roll: RollSections, part: CylinderMesh, nodes: FloatArray) -> IntArray:
    """Nodes at the base of the coil that are clamped, by `coil.base` and `coil.base_width`.

    ``nodes`` are those of the coil, layer after layer; `part` is the mesh of the mandrel's mid-surface.
    """
    if roll.coil.base == "free":
        return np.empty(0, np.int64)
    n = len(part.nodes)
    base = (np.arange(0, len(nodes), n)[:, None] + part.groups["base"]).ravel()
    if roll.coil.base == "clamped":
        return base
    distance = np.hypot(*nodes[base, :2].T) - 0.5 * roll.geometry.mandrel_outer_diameter
    return np.asarray(base[distance <= roll.clamped_width + _EDGE * roll.coil.total_thickness])


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
    source, sign, free = mirrored_values(nodes, MIRROR_SIGN, symmetric=symmetric)
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


def _inner_trace(
    shell: ShellModel, contact: ContactPoints, face: sp.csr_matrix, radius: float, middle: float, symmetric: bool
) -> Trace:
    """Trace of the inner face at ``radius``; ``face`` maps the unknowns to its nodal displacements.

    ``middle`` is the radius of the mandrel's mid-surface, m.
    """
    surface = SurfaceTrace(shell, contact)
    keep, weight = half_circumference(contact.points, symmetric)
    rows = (3 * np.flatnonzero(keep)[:, None] + np.arange(3)).ravel()
    displacements = (6 * np.arange(len(shell.nodes))[:, None] + np.arange(3)).ravel()
    operator = (surface.operator(0.0)[rows][:, displacements] @ face).tocsr()
    at = contact.points[keep] * np.array([1.0, 1.0, 0.0]) + np.array([0.0, 0.0, radius])
    return Trace(operator, at, (surface.areas(radius / middle) * weight)[keep])
