"""Springs that a solver builds into the linear structure in place of the interfaces."""

from __future__ import annotations

import numpy as np

from wroll_fem.contact.laws import SMOOTHED
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray


def stick_springs(system: System, state: ContactState) -> FloatArray:
    """(3 n_points,) stiffness per slot of the contact that sticks at ``state``, Pa/m.

    Open points have none, nor has the smoothed law along the surface: it holds nothing at rest.
    """
    law, pressure = system.laws, state.pressure
    closed = (pressure > 0) | ~law.separation
    stick = np.where(law.kind == SMOOTHED, 0.0, law.mu * pressure / law.gamma)
    return np.concatenate([np.repeat(stick, 2), np.where(closed, law.kn, 0.0)])


def built_in_springs(system: System, state: ContactState, dt: float) -> FloatArray:
    """(3 n_points,) springs D_0 per slot, Pa/m, near the tangents that Newton meets in steps of ``dt`` (s).

    Any D_0 gives the same solution; a good one leaves few points to solve for. Points that stick have their stick
    stiffness. The smoothed law sticks nowhere: below its reference speed V_0 it is the dashpot mu p / (2 V_0), whose
    tangent in a step is mu p / (2 V_0 dt). Unlike no spring at all, that also leaves no body free to drift.
    """
    law, springs = system.laws, stick_springs(system, state)
    smoothed = law.kind == SMOOTHED
    if smoothed.any():
        dashpot = law.mu * state.pressure / (2.0 * law.speed * dt)
        n = law.n
        springs[: 2 * n] = np.where(np.repeat(smoothed, 2), np.repeat(dashpot, 2), springs[: 2 * n])
    return springs
