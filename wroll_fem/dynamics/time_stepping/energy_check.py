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
"""Energy created in one step, relative to the largest stored energy or input work so far, above which a run stops."""

LEAST = 1e-6
"""Created energy, relative to the largest stored energy or input work, below which it is ignored as rounding."""

STORED = [KINETIC, STRAIN, CONTACT]
"""Columns of the records with stored energies."""

ROUNDING = 1e-12
"""Created energy, relative to the energy that the preload stores in the contact, below which it is ignored. The terms
of the preload energy cancel in every step, which leaves rounding errors."""


def rounding_energy(laws: PointLaws, preload: ContactState) -> float:
    """Energy created in a step, J, below which it counts as rounding error."""
    pressure = normals(preload.traction)
    return float(ROUNDING * 0.5 * np.sum(laws.area * pressure**2 / laws.kn)) if laws.n else 0.0


def largest_energies(records: FloatArray) -> FloatArray:
    """(k,) stored energy or absolute input work after each step of ``records`` (k, columns), the larger one, J."""
    return np.asarray(np.maximum(records[:, STORED].sum(axis=1), np.abs(records[:, INPUT])))


def check_energy(records: FloatArray, times: FloatArray, largest: float, rounding: float = 0.0) -> float:
    """Largest stored energy or input work so far, J; raises an error if steps create too much energy.

    A point that reverses its motion in the step after it opened gains a little energy (docs/theory.md); this is
    accepted. A step that creates more than `ABSURD` times this largest value solves its equations, but has no physical
    meaning. If all impacts together have created more energy than the largest value, the integration is unstable.

    Parameters
    ----------
    records
        (k + 1, columns) in J: the last step of the previous check, which is not checked again, and k new steps.
    times
        (k + 1,) times at which these steps end, s.
    largest
        Largest stored energy or input work before these steps, J.
    rounding
        `rounding_energy`, J.

    Raises
    ------
    ConvergenceError
        If there is such a step; its time is the start of the first one.
    """
    stored = records[:, STORED].sum(axis=1)
    missed = records[:, INPUT] - stored - records[:, [FRICTION, MODULATION, NUMERICAL, VISCOUS, IMPACT]].sum(axis=1)
    most = np.maximum.accumulate(np.maximum(largest_energies(records), largest))
    made = np.abs(np.diff(missed)) + np.maximum(-np.diff(records[:, IMPACT]), 0.0)
    least = max(LEAST * float(most[-1]), rounding)
    bad = np.flatnonzero(
        (made > ABSURD * most[:-1]) & (made > least) | (-records[1:, IMPACT] > np.maximum(most[1:], rounding))
    )
    if bad.size:
        first = int(bad[0])
        created, stored_most = (f"{value:.2g} J" for value in (made[first], most[first]))
        what = (
            f"a step created {created}"
            if made[first] > ABSURD * most[first]
            else (f"all impacts together have created {-records[first + 1, IMPACT]:.2g} J")
        )
        raise ConvergenceError(
            f"energy balance violated: {what}; at most {stored_most} was stored",
            time_s=float(times[first]),
            iterations=int(records[first + 1, ITERATIONS]),
            residual_history=[],
            advice="where surfaces open and impact, use a smaller contact.friction.elastic_slip, smaller steps "
            "(integrator.steps_per_cycle), or integrator.scheme: moderate_dissipation",
        )
    return float(most[-1])
