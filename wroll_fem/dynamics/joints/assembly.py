"""Joints as interfaces of a system, and the force of a joint for a given displacement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from wroll_fem.contact.interface import Interface, NormalPenalty
from wroll_fem.contact.kernels import OPEN
from wroll_fem.contact.point import contact_dofs
from wroll_fem.contact.pointwise import PointwiseFriction
from wroll_fem.dynamics.joints.joint import At, Joint, Points, row_of
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray


def with_joints(system: System, joints: Sequence[Joint]) -> tuple[System, ContactState]:
    """System with an interface for each joint, and its state at rest, in which it is in equilibrium.

    Raises
    ------
    InputError
        If a joint is at a degree of freedom that does not exist, or the system has interfaces already.
    """
    n = system.n_dofs
    if system.interfaces:
        raise InputError("a system with interfaces cannot have joints", remedy="write the joints as interfaces")
    parts = [joint.points(n) for joint in joints]
    interfaces = tuple(_interface(joint, k, part) for k, (joint, part) in enumerate(zip(joints, parts, strict=True), 1))
    stiffness = system.stiffness
    for added in (joint.linear(n) for joint in joints):
        if added is not None:
            stiffness = (stiffness + added).tocsr()
    system = replace(system, stiffness=stiffness, interfaces=interfaces)
    state = ContactState.unloaded(system)
    if not parts:
        return system, state
    dofs = contact_dofs(system.n_points)
    force, kn = (np.concatenate([getattr(part, name) for part in parts]) for name in ("force", "stiffness"))
    gap = np.concatenate([part.gap for part in parts])
    state.jump[dofs[:, 2]] = np.where(gap > 0.0, gap, -force / kn)
    state.traction[dofs[:, 2]] = -force
    state.status[gap > 0.0] = OPEN
    return system, state


def joint_force(joint: Joint, displacement: npt.ArrayLike) -> FloatArray:
    """Quasi-static force (m,), N, of a joint for a history of its relative displacement (m,), m, from rest.

    With ``across``, with ``normal``, or with both, the displacements and the forces have one column for each of them,
    in this order after that of ``at``. The force is positive where it resists a positive displacement.
    """
    path = np.asarray(displacement, float)
    places = [joint.at, *(p for p in (getattr(joint, name, None) for name in ("across", "normal")) if p is not None)]
    if path.ndim != min(len(places), 2) or (path.ndim == 2 and path.shape[1] != len(places)):
        raise InputError(
            f"the displacement of a joint has the shape {path.shape}",
            remedy="give (m,), or one column for each of at, across and normal",
        )
    path = path.reshape(len(path), -1)
    n = 1 + max(_last(place) for place in places)
    directions = np.array([row_of(place, n) for place in places])
    plain = System(sp.csr_matrix((n, n)), sp.identity(n, format="csr"), np.zeros(n))
    system, state = with_joints(plain, [joint])
    # displacements of the degrees of freedom with these relative displacements
    moves = np.linalg.lstsq(directions, path.T, rcond=None)[0].T
    contact, force, rest = TrialContact(system), np.empty_like(path), state.jump.copy()
    onto = np.linalg.pinv(directions.T)
    for k, move in enumerate(moves):
        jump = rest + system.jump @ move
        traction = contact(jump, state)
        force[k] = onto @ (system.jump.T @ traction + system.stiffness @ move)
        state = contact.committed(move, jump)
    return force[:, 0] if len(places) == 1 else force


def _last(at: At) -> int:
    """Last degree of freedom of a place."""
    values = np.asarray(at, float)
    return int(values.max()) if values.ndim == 0 or isinstance(at, tuple) else len(values) - 1


def _interface(joint: Joint, number: int, part: Points) -> Interface:
    laws = list(dict.fromkeys(part.laws))
    index = np.array([laws.index(law) for law in part.laws])
    count = len(part.laws)
    return Interface(
        name=joint.name or f"{type(joint).__name__.lower()}_{number}",
        operator=sp.csr_matrix(part.rows.reshape(3 * count, -1)),
        areas=np.ones(count),
        points=np.full((count, 3), np.nan),
        friction=laws[0] if len(laws) == 1 else PointwiseFriction(tuple(laws), index),
        normal=NormalPenalty(part.stiffness, part.separation),
    )
