"""Springs that replace the interfaces in the linear structure: stick stiffness and reference contact stiffness."""

from __future__ import annotations

import numpy as np

from wroll_fem.contact.point import EVERY, per_dof, stick_stiffness
from wroll_fem.contact.pointwise import different_laws
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray


def reference_stiffness(system: System, state: ContactState, dt: float) -> FloatArray:
    """(3 n_points,) reference contact stiffness D_0, Pa/m: tangent of a step ``dt`` (s) from rest at constant pressure.

    Any D_0 gives the same solution; a suitable one leaves few points to be solved for. Points that stick have their
    stick stiffness, open points have zero stiffness. With a law without memory no point sticks: below its reference
    speed V_0, regularised friction is a dashpot mu p / (2 V_0), whose tangent is mu p / (2 V_0 dt). With this stiffness
    no body can drift freely.
    """
    points, pressure = system.laws, state.pressure
    laws, which = different_laws([i.friction for i in system.interfaces], [i.n_points for i in system.interfaces])
    length = np.array([law.rest_length(dt) for law in laws])[which]
    closed = (pressure > 0) | ~points.separation
    stick = stick_stiffness(EVERY, pressure, points._replace(gamma=length))
    return per_dof(stick, np.where(closed, points.kn, 0.0))


def stick_springs(system: System, state: ContactState) -> FloatArray:
    """(3 n_points,) stiffness of the sticking contact at ``state``, Pa/m.

    It is zero at open points. Its tangential components are zero for a law without memory, which transmits no traction
    at rest.
    """
    return reference_stiffness(system, state, np.inf)
