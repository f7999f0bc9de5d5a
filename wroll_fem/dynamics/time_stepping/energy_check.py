"""Check of the energy balance: a time history that creates energy is stopped."""

from __future__ import annotations

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.contact.point import normals
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.time_stepping.records import (
    CONTACT,
    FRICTION,
    IMPACT,
    INPUT,
    ITERATIONS,
    KINETIC,
    MODULATION,
    NUMERICAL,
    STRAIN,
    VISCOUS,
)
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray

ABSURD = 100.0
"""Energy created in one step, over the largest energy stored so far, that stops a run."""

LEAST = 1e-6
"""Share of the largest stored energy below which created energy is ignored (rounding at the start)."""

ROUNDING = 1e-12
"""The same, as a share of the energy that the preload has stored in the contact: its terms cancel in every step."""


def rounding_energy(laws: PointLaws, preload: ContactState) -> float:
    """Energy, J, below which a step that seems to create energy is one of rounding."""
    pressure = normals(preload.traction)
    return float(ROUNDING * 0.5 * np.sum(laws.area * pressure**2 / laws.kn)) if laws.n else 0.0


def check_energy(records: FloatArray, times: FloatArray, largest: float, rounding: float = 0.0) -> float:
    """Refuse steps that create far more energy than the system ever stored; return the largest stored energy, J.

    A point that turns round in the step after it opened gains a little energy (docs/theory.md). A step that creates a
    hundred times all stored energy is a solution of its equations without physical meaning. Impacts that in all
    created more energy than the system ever stored are an unstable integration.

    Parameters
    ----------
    records
        (k + 1, columns) in J: the last step checked before (not checked again), and k new ones.
    times
        (k + 1,) s, at which these steps end.
    largest
        Largest stored energy before, J.
    rounding
        `rounding_energy`, J.

    Raises
    ------
    ConvergenceError
        With the time at which the first such step starts.
    """
    stored = records[:, [KINETIC, STRAIN, CONTACT]].sum(axis=1)
    missed = records[:, INPUT] - stored - records[:, [FRICTION, MODULATION, NUMERICAL, VISCOUS, IMPACT]].sum(axis=1)
    most = np.maximum.accumulate(np.maximum(np.maximum(stored, np.abs(records[:, INPUT])), largest))
    made = np.abs(np.diff(missed)) + np.maximum(-np.diff(records[:, IMPACT]), 0.0)
    least = max(LEAST * float(most[-1]), rounding)
    bad = np.flatnonzero(
        (made > ABSURD * most[:-1]) & (made > least) | (-records[1:, IMPACT] > np.maximum(most[1:], rounding))
    )
    if bad.size:
        raise ConvergenceError(
            f"energy balance violated: a step created {made[bad[0]]:.2g} J, at most {most[bad[0]]:.2g} J was stored",
            time_s=float(times[bad[0]]),
            iterations=int(records[bad[0] + 1, ITERATIONS]),
            residual_history=[],
            advice="where surfaces open and impact, use a smaller contact.friction.elastic_slip, smaller steps "
            "(integrator.steps_per_cycle), a higher preload, or integrator.scheme: moderate_dissipation",
        )
    return float(most[-1])
