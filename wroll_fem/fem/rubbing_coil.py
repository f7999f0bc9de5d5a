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
from wroll_fem.fem.coil import in_vtk_order, mesh_coil, own_unknowns, skin_quads
from wroll_fem.fem.constraints import base_influence
from wroll_fem.fem.shell import ShellModel, radial_director
from wroll_fem.fem.solid import constrained_matrices
from wroll_fem.fem.trace import SurfaceTrace, half_circumference
from wroll_fem.mesh.contact_points import ContactPoints
from wroll_fem.mesh.shells import CylinderMesh
from wroll_fem.typing import FloatArray, IntArray

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

    With `coil.inside: slipping` its stiffness has no shear between the wraps (see `coiled_stiff.slipping_coil`).

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
    material = roll.coil.solid()
    stiffness, mass, volume = constrained_matrices(
        nodes, cells, expand, material, between_wraps=not roll.coil.slips, symmetric=symmetric
    )
    face = sp.hstack([sp.identity(3 * n), sp.csr_matrix((3 * n, 3 * n * (layers - 1)))], format="csr") @ expand
    outer = sp.hstack([sp.csr_matrix((3 * n, 3 * n * (layers - 1))), sp.identity(3 * n)], format="csr") @ expand
    middle = float(np.hypot(*part.nodes[:, :2].T).mean())
    inner_radius = 0.5 * roll.geometry.mandrel_outer_diameter
    outward = shell.area_load(-(inner_radius + roll.coil.total_thickness) / middle * radial_director(part.nodes))
    ordered = in_vtk_order(nodes, cells)
    total = material.rho * volume
    return Body(
        name=NAME,
        stiffness=stiffness,
        mass=mass,
        influence=base_influence(component, symmetric),
        expand=sp.csr_matrix((0, expand.shape[1])),
        nodes=np.empty((0, 3)),
        cells=np.empty((0, 9), np.int64),
        traces={"inner": _inner_trace(shell, contact, face, inner_radius, middle, symmetric)},
        pressure_force=np.asarray(outer.T @ outward.reshape(-1, 6)[:, :3].ravel()),
        mass_total=total,
        symmetric=symmetric,
        solid=SolidPart(nodes, layers, ordered, expand, total, skin_quads(ordered)),
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
