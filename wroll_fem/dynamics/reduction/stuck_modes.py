"""Modes of a structure with stuck interfaces, as a basis of reduced models."""

from __future__ import annotations

import numpy as np

from wroll_fem.dynamics.reduction.condensation import Condensation, condense, enough_moments
from wroll_fem.dynamics.statics.contact_springs import reference_stiffness
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.typing import FloatArray

MANY_DOFS = 10_000
"""Number of DOFs of a structure above which it is not represented by all its modes, but by those that its loads excite
(`enough_moments`). This takes a tenth of the modes of a solid coil."""


def modes_to_reduce(system: System, preload: ContactState, scheme: Scheme, dt: float) -> Condensation:
    """Modes of the structure with stuck interfaces, in which a reduced model has its basis; see `MANY_DOFS`."""
    springs = reference_stiffness(system, preload, dt)
    moments = enough_moments(system, springs) if system.n_dofs > MANY_DOFS else 0
    return condense(system, springs, scheme, dt, moments=moments)


def most_excited(condensation: Condensation, count: int) -> FloatArray:
    """(r, count) unit vectors of the modes with the largest static response to the base, in r modal coordinates.

    There are fewer columns if there are fewer modes.
    """
    participation = np.abs(condensation.base) / condensation.eigenvalues
    modes = np.argsort(-participation)[:count]
    unit = np.zeros((len(participation), len(modes)))
    unit[modes, np.arange(len(modes))] = 1.0
    return unit
