"""Geometric stiffness due to the preload of a case: loads, static state, stiffness matrix, buckling load."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body
from wroll_fem.bodies.mode_shapes import ModeKind, classify_mode
from wroll_fem.contact.point import normals, per_dof, tangentials
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import LEAST_TANGENT, ContactState
from wroll_fem.dynamics.statics.preload import equilibrium_force, solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.numerics.linear import factorise
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wroll_fem.case.structural import OnRoll
    from wroll_fem.fem.prestress.roll import PrestressedRoll


@dataclass(frozen=True)
class Stability:
    """Lowest buckling load, as a multiple of the preload.

    Attributes
    ----------
    factor
        Load at which the roll buckles, divided by the preload.
    kind
        Shape of the buckling mode and its circumferential wave number.
    """

    factor: float
    kind: ModeKind


def prestressed_roll(case: OnRoll, bodies: Sequence[Body]) -> PrestressedRoll | None:
    """Bodies and preload of a case with geometric stiffness; None if the case does not request geometric stiffness."""
    from wroll_fem.fem.prestress.roll import PrestressedRoll

    if not case.has_geometric_stiffness or case.preload is None:
        return None
    return PrestressedRoll(case, bodies, web_tension=case.preload.kind == "winding_tension")


def body_pressures(case: OnRoll, system: System) -> list[float]:
    """(n_bodies,) external pressure on each body, Pa; zero on the mandrel unless it is the only body."""
    if system.interfaces or case.preload is None:
        return [0.0, *system.pressures]
    return [sum(case.preload.per_layer(1))]


def contact_state(case: OnRoll, roll: PrestressedRoll, system: System) -> tuple[System, ContactState]:
    """System with its preload, and its static state with frictional or bonded interfaces.

    Interfaces are bonded if the case has no `contact`, or has `coil.model: bonded`. The external pressure
    of a case without layers acts on the mandrel.
    """
    if not system.interfaces:
        force = body_pressures(case, system)[0] * roll.bodies[0].pressure_force
        system = replace(system, loads={**system.loads, "preload": force})
    bonded = case.contact is None or case.coil.model == "bonded"
    if not system.interfaces or not bonded:
        return system, solve_preload(system, steps=case.preload_steps)
    springs = system.tie_springs
    u = factorise(system.with_interface_springs(springs)).solve(system.loads["preload"])
    jump, state = system.jump @ u, ContactState.unloaded(system)
    return system, replace(state, displacement=u, jump=jump, traction=springs * jump)


def stiffened(system: System, geometric: sp.csr_matrix, state: ContactState) -> System:
    """System with the geometric stiffness added; its preload is changed so that `state` stays in equilibrium."""
    found = replace(system, stiffness=sp.csr_matrix(system.stiffness + geometric))
    return replace(found, loads={**system.loads, "preload": equilibrium_force(found, state)})


def held_springs(system: System, state: ContactState, *, sticks: bool = True) -> FloatArray:
    """(3 n_points,) spring stiffness of sticking contact, Pa/m; at least `LEAST_TANGENT` times the normal stiffness.

    If `sticks` is False, the tangential springs have this smallest stiffness.
    """
    springs, least = stick_springs(system, state), LEAST_TANGENT * system.laws.kn
    along = np.maximum(tangentials(springs)[:, 0], least) if sticks else least
    return per_dof(along, np.maximum(normals(springs), least))


def stability(
    bodies: Sequence[Body], system: System, geometric: sp.csr_matrix, springs: FloatArray
) -> Stability | None:
    """Lowest buckling load with interface springs (3 n_points,), Pa/m; None if the roll does not buckle."""
    from wroll_fem.fem.prestress.buckling import load_factors

    factors, modes = load_factors(system.with_interface_springs(springs), geometric, 1)
    return Stability(float(factors[0]), classify_mode(bodies, modes[:, 0])) if len(factors) else None


def add_geometric_stiffness(
    case: OnRoll, roll: PrestressedRoll, system: System, state: ContactState, springs: FloatArray | None = None
) -> tuple[System, float]:
    """System with the geometric stiffness of its preload, and its lowest buckling load divided by the preload.

    Parameters
    ----------
    case, roll, system, state
        A case, its bodies, its system and its static state.
    springs
        (3 n_points,) interface springs for the buckling load, Pa/m; None takes the springs of sticking contact. A
        point without a spring gets a negligible stiffness.

    Returns
    -------
    system : System
    factor : float
        Infinite if the roll does not buckle.

    Raises
    ------
    InputError
        If the preload exceeds the linear buckling load.
    """
    geometric = roll.geometric_stiffness(system, state, body_pressures(case, system))
    if springs is None:
        springs = held_springs(system, state)
    elif system.interfaces:
        springs = np.maximum(springs, held_springs(system, state, sticks=False))
    found = stability(roll.bodies, system, geometric, springs)
    if found is not None and found.factor <= 1.0:
        raise InputError(
            f"the preload exceeds the linear buckling load: at {found.factor:.3g} times the preload the roll buckles "
            f"with {found.kind.wave_number} circumferential waves",
            key="preload.geometric_stiffness",
            remedy="lower the preload, use kind: winding_tension (self-equilibrated), or leave the key out",
        )
    return stiffened(system, geometric, state), math.inf if found is None else found.factor
