"""Interface springs in linear analyses: bonded, frictionless or stuck."""

from __future__ import annotations

import numpy as np

from wroll_fem.case.structural import OnRoll, OnStructure
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray


def linear_springs(case: OnRoll | OnStructure, system: System, state: ContactState | None = None) -> FloatArray:
    """Spring stiffness (3 n_points,) of the contact degrees of freedom in a linear analysis, Pa/m.

    Parameters
    ----------
    case
        `modal.interface` of the case selects the springs. frictionless: bilateral normal contact only; bonded: no
        relative motion; stuck: normal penalty and stick stiffness mu p / gamma* of the preloaded interface.
    system
        System of the case.
    state
        Preload state for stuck; if None, it is computed.
    """
    bonded = isinstance(case, OnRoll) and case.coil.model == "bonded"
    kind = "bonded" if bonded else case.modal.interface
    if kind == "frictionless":
        return np.concatenate([np.zeros(2 * system.n_points), system.laws.kn])
    if kind == "bonded":
        return system.tie_springs
    return stick_springs(system, solve_preload(system, steps=case.preload_steps) if state is None else state)
