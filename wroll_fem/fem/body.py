"""Bodies of a roll: mandrel and coil layers, assembled with dolfinx into scipy sparse matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI

from wroll_fem.bodies.body import Body, Trace
from wroll_fem.bodies.rigid_ends import rigid_mass, spring_matrix
from wroll_fem.bodies.wall import LayeredSection, WallTable
from wroll_fem.case.material import IsotropicMaterial
from wroll_fem.case.supports import TipInertia
from wroll_fem.errors import InputError
from wroll_fem.fem.coil import assemble_coil, bond_coil
from wroll_fem.fem.constraints import Constraints, base_influence, build_constraints
from wroll_fem.fem.layered_shell import shell_model
from wroll_fem.fem.rubbing_coil import assemble_rubbing_coil
from wroll_fem.fem.shell import AnySection, ShellModel, ShellSection, radial_director
from wroll_fem.fem.solid import tidy
from wroll_fem.fem.trace import SurfaceTrace, half_circumference
from wroll_fem.mesh.contact_points import ContactPoints, contact_points_between
from wroll_fem.mesh.generate import build_mesh, shell_layout
from wroll_fem.mesh.shells import CylinderMesh, ring_edges
from wroll_fem.typing import FloatArray, IntArray

if TYPE_CHECKING:
    from wroll_fem.case.mandrel import Mandrel
    from wroll_fem.case.roll import RollSections


def assemble_bodies(
    roll: RollSections, meshes: CylinderMesh | None = None, *, symmetric: bool, comm: MPI.Comm = MPI.COMM_SELF
) -> list[Body]:
    """Assemble the shells of a roll, innermost first: mandrel, layer_01, ...

    Parameters
    ----------
    roll
        Sections geometry, mandrel, coil and mesh, for example those of a case on a roll.
    meshes
        Mesh with the groups of every shell; None generates or reads the mesh of `roll.mesh`.
    symmetric
        Keep only motions symmetric about the x-z plane (excitation along x) and contact points with theta in [0, pi].
        Matrices, forces and areas remain those of the whole roll.
    comm
        Communicator of one process; bodies are not distributed.

    Returns
    -------
    list of Body
        For the coil models "none" and "nonstructural_mass" only the mandrel; the latter distributes the mass of the
        coil over the mid-surface of the mandrel. For "solid" the mandrel with the coil bonded to it, as one body, or
        the mandrel and the coil, if the interface has friction.

    Raises
    ------
    InputError
        If the mesh does not match the roll, is not symmetric although `symmetric` is set, or if the base of a solid
        coil is clamped and that of the mandrel free.
    ValueError
        If `comm` has more than one process.
    """
    if comm.size != 1:
        raise ValueError(f"bodies are assembled on one process, got a communicator of {comm.size}; use MPI.COMM_SELF")
    mesh = build_mesh(roll) if meshes is None else meshes
    missing = [name for name, _, _ in shell_layout(roll) if name not in mesh.groups]
    if missing:
        raise InputError(
            f"mesh lacks the shells {', '.join(missing)}",
            key="coil.layers",
            remedy=f"it has {', '.join(mesh.parts)}; mesh every layer of the case",
        )
    shells = [
        _assemble_shell(roll, index, name, radius, thickness, mesh.part(name), symmetric)
        for index, (name, radius, thickness) in enumerate(shell_layout(roll))
    ]
    return [*shells, _rubbing_coil(roll, mesh.part("mandrel"), symmetric)] if roll.coil.rubs else shells


def shell_section(roll: RollSections, index: int, thickness: float) -> AnySection:
    """Shell section of the mandrel or of a layer: homogeneous, or of plies.

    Parameters
    ----------
    roll
        The sections geometry, mandrel and coil are used.
    index
        0 for the mandrel, k > 0 for layer k, counted from the inside.
    thickness
        Thickness of the shell, m.
    """
    bending, extra, m, table = 1.0, 0.0, roll.mandrel.material, None
    if index > 0:
        m, bending = roll.coil.layer_material, 1.0 if roll.coil.bending else 0.0
    elif roll.coil.model == "nonstructural_mass":
        outer = 0.5 * roll.geometry.mandrel_outer_diameter
        radius, t = outer - 0.5 * thickness, roll.coil.total_thickness
        extra = roll.coil.material.rho * t * (outer + 0.5 * t) / radius
    if index == 0 and roll.mandrel.wall is not None:
        table = WallTable(*(tuple(getattr(row, key) for row in roll.mandrel.wall) for key in ("z", "thickness")))
    if isinstance(m, IsotropicMaterial) and table is None:
        return ShellSection(m.E, m.nu, m.rho, thickness, bending, extra)
    radius = shell_layout(roll)[index][1]
    return LayeredSection(m.as_plies(thickness), radius, table, bending, extra)


def _rubbing_coil(roll: RollSections, part: CylinderMesh, symmetric: bool) -> Body:
    section = shell_section(roll, 0, roll.geometry.mandrel_thickness)
    shell, contact = shell_model(part.nodes, part.cells, section), contact_points_between(part, *roll.coil_span)
    return assemble_rubbing_coil(roll, part, shell, contact, symmetric=symmetric)


def _base_is_clamped(roll: RollSections, index: int) -> bool:
    if index == 0:
        return bool(roll.mandrel.base == "clamped")
    return bool(roll.coil.base == "clamped" or (roll.coil.base == "inner_edge" and index == 1))


def _assemble_shell(
    roll: RollSections, index: int, name: str, radius: float, thickness: float, part: CylinderMesh, symmetric: bool
) -> Body:
    section = shell_section(roll, index, thickness)
    model = shell_model(part.nodes, part.cells, section)
    rigid_tip = index == 0 and roll.mandrel.tip == "rigid"
    centre = np.array([0.0, 0.0, roll.geometry.length])
    base = part.groups["base"]
    guided = index > 0 and roll.coil.base == "guided"
    springs = roll.mandrel.springs if index == 0 else None
    constraints = build_constraints(
        part.nodes,
        clamped=base if _base_is_clamped(roll, index) else np.empty(0, np.int64),
        base=None if springs is None else (base, np.array([k is not None for k in springs.six])),
        guided=base if guided else None,
        rigid=part.groups["tip"] if rigid_tip else None,
        centre=centre,
        symmetric=symmetric,
    )
    tip_mass = roll.mandrel.tip_mass if index == 0 else 0.0
    tip = tip_probe(constraints, part)
    nodal_mass = model.mass(section)
    if tip_mass and not rigid_tip:
        nodal_mass = nodal_mass + ring_mass(part, tip_mass)
    nodal_stiffness = model.stiffness(section)
    if guided and roll.coil.base_stiffness:
        nodal_stiffness = nodal_stiffness + ring_spring(part, base, roll.coil.base_stiffness)
    E = constraints.expand
    stiffness, mass = E.T @ nodal_stiffness @ E, E.T @ nodal_mass @ E
    if constraints.master is not None and index == 0:
        stiffness, mass = _with_tip(roll.mandrel, constraints, stiffness, mass)
    if springs is not None and constraints.base_master is not None:
        stiffness = stiffness + on_master(spring_matrix(springs.six), constraints.base_master, E.shape[1])
    outward = radial_director(part.nodes)
    scale = (radius + 0.5 * thickness) / radius
    body = Body(
        name=name,
        stiffness=tidy(stiffness),
        mass=tidy(mass),
        influence=base_influence(constraints.component, symmetric),
        expand=E,
        nodes=part.nodes,
        cells=part.cells,
        traces=_traces(model, constraints, contact_points_between(part, *roll.coil_span), radius, thickness, symmetric),
        pressure_force=np.asarray(E.T @ model.area_load(-scale * outward)),
        probes={"tip": tip},
        mass_total=model.mass_total(section) + tip_mass,
        symmetric=symmetric,
        unknown_node=constraints.node,
        unknown_component=constraints.component,
    )
    if index == 0 and roll.coil.model == "solid" and not roll.coil.rubs:
        return bond_coil(body, assemble_coil(roll, part, constraints, symmetric=symmetric))
    return body


def ring_weights(part: CylinderMesh, ring: IntArray) -> FloatArray:
    """(n_nodes,) weight of each node in the mean of a nodal field along a ring of quadratic edges; sums to 1.

    The mean is integrated with Simpson's rule, whose points are the nodes of an edge.
    """
    edges = ring_edges(part.cells, ring)
    length = np.linalg.norm(part.nodes[edges[:, 2]] - part.nodes[edges[:, 0]], axis=1)
    length += np.linalg.norm(part.nodes[edges[:, 1]] - part.nodes[edges[:, 2]], axis=1)
    weights = np.zeros(len(part.nodes))
    for column, share in ((0, 1 / 6), (1, 1 / 6), (2, 4 / 6)):
        np.add.at(weights, edges[:, column], share * length)
    return weights / weights.sum()


def ring_spring(part: CylinderMesh, ring: IntArray, stiffness: float) -> sp.csr_matrix:
    """(6 n_nodes, 6 n_nodes) stiffness of axial springs (N/m per m of circumference) between a ring and the base.

    Integrated over the quadratic edges with Simpson's rule, whose points are the nodes.
    """
    edges = ring_edges(part.cells, ring)
    first, last, middle = (part.nodes[edges[:, k]] for k in range(3))
    slopes = (-3.0 * first + 4.0 * middle - last, first - 4.0 * middle + 3.0 * last, last - first)
    springs = np.zeros((len(part.nodes), 6))
    for column, (share, slope) in enumerate(zip((1 / 6, 1 / 6, 4 / 6), slopes, strict=True)):
        np.add.at(springs[:, 2], edges[:, column], stiffness * share * np.linalg.norm(slope, axis=1))
    return sp.diags(springs.ravel()).tocsr()


def tip_probe(constraints: Constraints, part: CylinderMesh) -> sp.csr_matrix:
    """(3, n) operator from the n unknowns to the tip displacement.

    It is the displacement of the centre of a rigid tip, or the mean over a deformable end ring.
    """
    n = constraints.expand.shape[1]
    if constraints.master is not None:
        alive = np.flatnonzero(constraints.master[:3] >= 0)
        return sp.csr_matrix((np.ones(len(alive)), (alive, constraints.master[alive])), shape=(3, n))
    weights = ring_weights(part, part.groups["tip"])
    ring = np.flatnonzero(weights)
    rows, cols = np.tile(np.arange(3), len(ring)), (6 * ring[:, None] + np.arange(3)).ravel()
    mean = sp.csr_matrix((np.repeat(weights[ring], 3), (rows, cols)), shape=(3, 6 * len(part.nodes)))
    return (mean @ constraints.expand).tocsr()


def ring_mass(part: CylinderMesh, mass: float) -> sp.csr_matrix:
    """(6 n_nodes, 6 n_nodes) lumped mass matrix of a tip mass (kg) that is distributed over the tip ring."""
    weights = ring_weights(part, part.groups["tip"])
    return sp.diags(np.outer(mass * weights, [1, 1, 1, 0, 0, 0]).ravel()).tocsr()


def on_master(matrix: FloatArray, master: IntArray, n: int) -> sp.csr_matrix:
    """(n, n) matrix with a (6, 6) ``matrix`` at the unknowns ``master`` (6,) of a rigid ring; -1 is left out."""
    alive = np.flatnonzero(master >= 0)
    rows, cols = np.meshgrid(master[alive], master[alive], indexing="ij")
    return sp.csr_matrix((matrix[np.ix_(alive, alive)].ravel(), (rows.ravel(), cols.ravel())), shape=(n, n))


def _with_tip(
    mandrel: Mandrel, constraints: Constraints, stiffness: sp.csr_matrix, mass: sp.csr_matrix
) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Stiffness and mass with the springs and the mass of a rigid tip."""
    master, n = constraints.master, stiffness.shape[0]
    assert master is not None
    if mandrel.tip_mass or mandrel.tip_inertia is not None:
        turn = mandrel.tip_inertia or TipInertia()
        body = rigid_mass(mandrel.tip_mass, turn.transverse, turn.polar, mandrel.tip_offset or 0.0)
        mass = mass + on_master(body, master, n)
    if mandrel.tip_springs is not None:
        stiffness = stiffness + on_master(spring_matrix(mandrel.tip_springs.six), master, n)
    return stiffness, mass


def _traces(
    model: ShellModel,
    constraints: Constraints,
    contact: ContactPoints,
    radius: float,
    thickness: float,
    symmetric: bool,
) -> dict[str, Trace]:
    points, surface = contact.points, SurfaceTrace(model, contact)
    keep, weight = half_circumference(points, symmetric)
    rows = (3 * np.flatnonzero(keep)[:, None] + np.arange(3)).ravel()
    traces = {}
    for side, height in (("inner", -0.5 * thickness), ("outer", 0.5 * thickness)):
        scale = (radius + height) / radius
        operator = (surface.operator(height)[rows] @ constraints.expand).tocsr()
        operator.data[np.abs(operator.data) < 1e-16] = 0.0
        operator.eliminate_zeros()
        at = points[keep] * np.array([1.0, 1.0, 0.0]) + np.array([0.0, 0.0, radius + height])
        traces[side] = Trace(operator, at, (surface.areas(scale) * weight)[keep])
    return traces
