"""The energy ledger as a watchdog: a time history that makes energy out of nothing is not one."""

from __future__ import annotations

import numpy as np

from ..body import FloatArray
from ..errors import ConvergenceError
from .stepper import CONTACT, FRICTION, INPUT, ITERATIONS, KINETIC, MODULATION, NUMERICAL, STRAIN, VISCOUS

ABSURD = 100.0
"""Energy from nothing in one step, over the largest the system has held, that stops a run."""

LEAST = 1e-6
"""Part of the largest energy held at the end below which nothing is judged (the start, all rounding)."""


def check_energy(records: FloatArray, first: int, times: FloatArray) -> None:
    """Refuse steps whose ledger misses far more energy than the system ever held.

    Surfaces that open and land hard let the ledger miss a little: the trapezoidal rule does not see the work of an
    impact. A step that misses a hundred times all the energy there was is a solution of the step's equations which
    the motion cannot take.

    Parameters
    ----------
    records
        (k, columns) of a run from its start, J.
    first
        First step to look at; those before have been.
    times
        (k + 1,) s, at the step ends.

    Raises
    ------
    ConvergenceError
        With the time of the first such step.
    """
    stored = records[:, [KINETIC, STRAIN, CONTACT]].sum(axis=1)
    missed = records[:, INPUT] - stored - records[:, [FRICTION, MODULATION, NUMERICAL, VISCOUS]].sum(axis=1)
    held = np.maximum.accumulate(np.maximum(stored, np.abs(records[:, INPUT])))
    made = np.abs(np.diff(missed))
    absurd = (made > ABSURD * held[:-1]) & (made > LEAST * held[-1])
    bad = np.flatnonzero(absurd[max(first - 1, 0) :]) + max(first - 1, 0) + 1
    if not bad.size:
        return
    raise ConvergenceError(
        f"a step makes {made[bad[0] - 1]:.2g} J out of nothing, with never more than {held[bad[0] - 1]:.2g} J",
        time_s=float(times[bad[0]]),
        iterations=int(records[bad[0], ITERATIONS]),
        residual_history=[],
        advice="surfaces that open and land hard ask for a smaller contact.friction.elastic_slip, smaller steps "
        "(integrator.steps_per_cycle) or a higher preload",
    )
