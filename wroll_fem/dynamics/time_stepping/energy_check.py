"""The energy ledger as a watchdog: a time history that makes energy out of nothing is not one."""

from __future__ import annotations

import numpy as np

from wroll_fem.dynamics.time_stepping.stepper import (
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
"""Energy from nothing in one step, over the largest the system has held, that stops a run."""

LEAST = 1e-6
"""Part of the largest energy held in the same steps below which nothing is judged (the start, all rounding)."""


def check_energy(records: FloatArray, times: FloatArray, held: float) -> float:
    """Refuse steps whose ledger misses far more energy than the system ever held; return the largest it did hold, J.

    A point that turns round in the step after it opened is given a little (docs/theory.md). A step that makes a hundred
    times all the energy there was is a solution of the step's equations which the motion cannot take, and impacts that
    in all gave more than the system ever held are an unstable integration.

    Parameters
    ----------
    records
        (k + 1, columns) in J: the last step judged before (not judged again), and k new ones.
    times
        (k + 1,) s, at which these steps end.
    held
        Largest energy before, J.

    Raises
    ------
    ConvergenceError
        With the time at which the first such step starts.
    """
    stored = records[:, [KINETIC, STRAIN, CONTACT]].sum(axis=1)
    missed = records[:, INPUT] - stored - records[:, [FRICTION, MODULATION, NUMERICAL, VISCOUS, IMPACT]].sum(axis=1)
    most = np.maximum.accumulate(np.maximum(np.maximum(stored, np.abs(records[:, INPUT])), held))
    made = np.abs(np.diff(missed)) + np.maximum(-np.diff(records[:, IMPACT]), 0.0)
    bad = np.flatnonzero((made > ABSURD * most[:-1]) & (made > LEAST * most[-1]) | (-records[1:, IMPACT] > most[1:]))
    if bad.size:
        raise ConvergenceError(
            f"a step makes {made[bad[0]]:.2g} J out of nothing, with never more than {most[bad[0]]:.2g} J before",
            time_s=float(times[bad[0]]),
            iterations=int(records[bad[0] + 1, ITERATIONS]),
            residual_history=[],
            advice="surfaces that open and land hard ask for a smaller contact.friction.elastic_slip, smaller steps "
            "(integrator.steps_per_cycle), a higher preload, or integrator.scheme: moderate_dissipation",
        )
    return float(most[-1])
