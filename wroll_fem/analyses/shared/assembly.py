"""From a case to bodies and a system: the one place where both meet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.contact.interface import FrictionLaw, NormalPenalty
from wroll_fem.contact.registry import BY_NAME
from wroll_fem.dynamics.system.system import System
from wroll_fem.structure.body import Body

if TYPE_CHECKING:
    from wroll_fem.case.case import Case

DIRECTIONS = {"x": 0, "y": 1}


def normal_penalty(case: Case) -> float:
    """Normal contact stiffness in Pa/m: the case's, or the through-thickness one of the facing half shells.

    ``auto`` is physical: two half thicknesses in series, 1/k = t_m / (2 E_m) + t_l / (2 E_l). It is some
    thousand times the hoop stiffness E t / R^2 of a lab layer, so that the pressure split does not feel it.
    """
    penalty = case.contact.normal.penalty
    if not isinstance(penalty, str):
        return float(penalty)
    mandrel, layer = case.mandrel.material.E, case.coil.layer_material.E
    return 2.0 / (case.geometry.mandrel_thickness / mandrel + case.coil.layer_thickness / layer)


def uses_symmetry(case: Case) -> bool:
    """Half the circumference suffices: allowed by the case, excitation along x; the mesh decides the rest."""
    return bool(case.solver.symmetry and case.excitation.direction == "x" and case.solver.method != "full")


def build_bodies(case: Case, *, symmetric: bool | None = None) -> list[Body]:
    """Mesh and assemble the bodies of a case, inner first.

    A user's mesh that is not symmetric about the x-z plane is taken whole.
    """
    from wroll_fem.fem.body import assemble_bodies
    from wroll_fem.mesh.generate import build_mesh
    from wroll_fem.mesh.shells import mirror_nodes

    mesh = build_mesh(case)
    half = uses_symmetry(case) if symmetric is None else symmetric
    if half and symmetric is None and mirror_nodes(mesh.nodes) is None:
        half = False
    return assemble_bodies(case, mesh, symmetric=half)


def friction_law(case: Case) -> FrictionLaw:
    """Tangential law of every interface."""
    friction = case.contact.friction
    return BY_NAME[friction.law].from_section(friction)


def build_system(case: Case, bodies: Sequence[Body]) -> System:
    """Stack the bodies and their interfaces with the laws and loads of the case.

    With ``preload.kind: winding_tension`` the load is found here, by static solutions, where the analysis needs it.
    """
    from wroll_fem.winding.interface import external_pressures

    layers = len(bodies) - 1
    system = System.from_bodies(
        bodies,
        direction=DIRECTIONS[case.excitation.direction],
        friction=friction_law(case) if layers else None,
        normal=NormalPenalty(normal_penalty(case), case.contact.normal.separation) if layers else None,
        pressures=external_pressures(case) if layers else (),
    )
    unpressed = case.analysis == "modal" and case.modal.interface != "stuck"
    if not layers or case.preload.kind != "winding_tension" or unpressed:
        return system
    return _wound(case, bodies, system)


def _wound(case: Case, bodies: Sequence[Body], system: System) -> System:
    """System whose mean interface pressures are those of the wound roll."""
    from wroll_fem.dynamics.statics.pressure_matching import press_to
    from wroll_fem.winding.interface import refuse_pull, ring_split, target_pressures

    unit_loads, end = np.zeros((len(bodies) - 1, system.n_dofs)), bodies[0].n_dofs
    for load, body in zip(unit_loads, bodies[1:], strict=True):
        load[end : end + body.n_dofs] = body.pressure_force
        end += body.n_dofs
    pressed = press_to(system, unit_loads, target_pressures(case), ring_split(case), steps=case.preload.steps)
    refuse_pull(pressed.pressures)
    return pressed
