"""Assembly of the bodies and the system of a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.bodies.base_loads import base_rotation
from wroll_fem.bodies.body import Body
from wroll_fem.bodies.laminate import Laminate
from wroll_fem.bodies.probe import Probe, probe_row, unit_vector
from wroll_fem.case.contact import Normal
from wroll_fem.case.kinds import ModalCase
from wroll_fem.case.probes import ProbePoint
from wroll_fem.case.structural import OnRoll
from wroll_fem.contact.interface import NormalPenalty
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.dynamics.reduction.kept_structure import kept_bodies
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError

if TYPE_CHECKING:
    from wroll_fem.case.roll import RollSections
    from wroll_fem.case.structural import StructuralCase
    from wroll_fem.typing import FloatArray

DIRECTIONS = {"x": 0, "y": 1}


UNUSED_LAW = PenaltyCoulomb(0.0, 1e-6)
"""Placeholder friction law for linear modes of a case without `contact`."""

ELEMENT_FACTOR = 10.0
"""Contact stiffness of a solid over that of half of its surface element. The element is elastic itself: with a factor
of 1, its half counts twice and a coil that sticks is up to 0.8 % below the bonded one. Harder contact rattles more."""


def normal_penalty(roll: RollSections, normal: Normal) -> float:
    """Normal contact stiffness in Pa/m, from the case or from the through-thickness stiffness of mandrel and layer.

    ``auto`` is the stiffness of the two half thicknesses in series, 1/k = t_m / (2 E_m) + t_l / (2 E_l). It is about a
    thousand times the hoop stiffness E t / R^2 of the lab layer, so the split of the pressure hardly depends on it.
    Under a solid coil, the second term is half of its first element with `ELEMENT_FACTOR` times the radial modulus.
    """
    if not isinstance(normal.penalty, str):
        return float(normal.penalty)
    compliance = 0.5 * roll.geometry.mandrel_thickness / roll.mandrel.material.in_plane.E_theta
    if roll.coil.rubs:
        from wroll_fem.fem.coil import coil_heights

        heights = coil_heights(roll)
        compliance += 0.5 * (heights[2] - heights[0]) / (ELEMENT_FACTOR * roll.coil.solid().E_r)
    else:
        compliance += 0.5 * roll.coil.layer_thickness / roll.coil.layer_material.in_plane.E_theta
    return float(1.0 / compliance)


def uses_symmetry(case: StructuralCase) -> bool:
    """Whether case and excitation allow a model of half the circumference; the mesh must be symmetric as well."""
    allowed = case.solver.symmetry and case.direction == "x" and case.solver.method != "full"
    return bool(allowed and (not isinstance(case, OnRoll) or is_mirrored(case)))


def is_mirrored(roll: RollSections) -> bool:
    """Whether the walls are their own mirror images about the x-z plane: no ply couples stretching and shear."""
    mandrel, coil = roll.mandrel, roll.coil
    walls = [(mandrel.material, roll.geometry.mandrel_thickness)] if mandrel.is_layered else []
    walls += [(coil.layer_material, coil.layer_thickness)] if coil.is_layered else []
    return all(Laminate(material.as_plies(thickness)).is_mirrored for material, thickness in walls)


def build_bodies(case: OnRoll, *, symmetric: bool | None = None) -> list[Body]:
    """Mesh and assemble the bodies of a case, inner first.

    With a mesh file that is not symmetric about the x-z plane, the whole circumference is modelled. In a series
    (`keeping_structure`) the bodies of the last run are used again if the sections of the roll are the same.
    """
    from wroll_fem.fem.body import assemble_bodies
    from wroll_fem.mesh.generate import build_mesh
    from wroll_fem.mesh.shells import mirror_nodes

    wanted = uses_symmetry(case) if symmetric is None else symmetric

    def build() -> list[Body]:
        mesh = build_mesh(case)
        half = wanted and (symmetric is not None or mirror_nodes(mesh.nodes) is not None)
        return assemble_bodies(case, mesh, symmetric=half)

    return kept_bodies(case, wanted, build)


def build_system(case: OnRoll, bodies: Sequence[Body]) -> System:
    """Assemble bodies and interfaces into a system, with the laws and loads of the case.

    If the preload prescribes pressures of the interfaces, the load is computed here, if the analysis needs it: with
    ``winding_stress`` in one step, otherwise by static solutions.

    Raises
    ------
    InputError
        If the analysis includes contact between shells and the case has no section `contact`.
    """
    from wroll_fem.winding.interface import external_pressures, prescribed_pressures

    direction, points = DIRECTIONS[case.direction], case.probes or {}
    if len(bodies) == 1:
        system = with_probes(System.from_bodies(bodies, direction=direction), bodies, points, direction)
        return with_base_loads(system, bodies, direction, case.geometry.length)
    linear = isinstance(case, ModalCase) and case.modal.interface != "stuck"
    contact, preload, bonded = case.contact, case.preload, case.coil.model == "bonded"
    if contact is None and not bonded and not isinstance(case, ModalCase):
        raise InputError(
            "required section is missing", key="contact",
            remedy=f"add it: analysis {case.analysis} includes contact between all bodies; a case with "
            "coil.model: solid needs no section contact if its coil is bonded to the mandrel",
        )  # fmt: skip
    normal = Normal() if contact is None or bonded else contact.normal
    system = System.from_bodies(
        bodies,
        direction=direction,
        friction=UNUSED_LAW if contact is None else case.interface_laws,
        normal=NormalPenalty(normal_penalty(case, normal), normal.separation),
        pressures=() if preload is None else external_pressures(case, preload, case.wound),
    )
    system = with_probes(system, bodies, points, direction)
    system = with_base_loads(system, bodies, direction, case.geometry.length)
    if preload is None or preload.kind == "external_pressure" or linear:
        return system
    targets = prescribed_pressures(case, preload, case.wound)
    return system.pressed(targets) if preload.kind == "winding_stress" else _matched(case, targets, bodies, system)


def named_probes(points: Mapping[str, ProbePoint] | None) -> dict[str, Probe]:
    """Probes of the case section `probes`, by name; the tip is not included."""
    return {name: Probe(at.theta, at.z, at.direction, at.body) for name, at in (points or {}).items()}


def with_probes(system: System, bodies: Sequence[Body], points: Mapping[str, ProbePoint], direction: int) -> System:
    """System with the tip and the named points of the case as probes.

    Parameters
    ----------
    system, bodies
        System with the probe "tip", and its bodies.
    points
        Name -> point and direction of a probe.
    direction
        Axis of the excitation: 0, 1 or 2.
    """
    starts = np.concatenate([[0], np.cumsum([body.n_dofs for body in bodies])])
    rows, rigid = dict(system.probes), {}
    for name, probe in named_probes(points).items():
        index = next(k for k, body in enumerate(bodies) if body.name == probe.body)
        row = np.zeros(system.n_dofs)
        row[starts[index] : starts[index + 1]] = probe_row(bodies[index], probe)
        rows[name] = row
        rigid[name] = float(unit_vector(probe)[direction])
    return replace(system, probes=rows, probe_base=rigid)


def with_base_loads(system: System, bodies: Sequence[Body], direction: int, length: float) -> System:
    """System that records the base shear and, where the nodes of all unknowns are known, the base moment."""
    turns = [base_rotation(body, direction, length) for body in bodies]
    rotation = None if any(turn is None for turn in turns) else np.concatenate([t for t in turns if t is not None])
    return system.with_base_loads(rotation, sum(body.mass_total for body in bodies))


def _matched(case: OnRoll, targets: FloatArray, bodies: Sequence[Body], system: System) -> System:
    """System with external pressures that produce the mean pressures ``targets`` (n_interfaces,) in the interfaces."""
    from wroll_fem.dynamics.statics.pressure_matching import match_interface_pressure
    from wroll_fem.winding.interface import pressure_split, refuse_pull

    unit_loads, end = np.zeros((len(bodies) - 1, system.n_dofs)), bodies[0].n_dofs
    for load, body in zip(unit_loads, bodies[1:], strict=True):
        load[end : end + body.n_dofs] = body.pressure_force
        end += body.n_dofs
    split, steps = pressure_split(case), case.preload_steps
    pressed = match_interface_pressure(system, unit_loads, targets, split, steps=steps)
    if case.preload is not None:
        refuse_pull(pressed.pressures, case.preload)
    return pressed
