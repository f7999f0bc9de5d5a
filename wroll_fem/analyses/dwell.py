"""Dwell: time history under sinusoidal base motion at one frequency, and the steady response."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_history
from wroll_fem.analyses.history import FIELDS, FIGURES, PLOTS, SUMMARY, VARIABLES, time_history
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import preflight
from wroll_fem.analyses.shared.time_step import dwell_step_error
from wroll_fem.signals.motions import base_motion
from wroll_fem.signals.tip import absolute_tip
from wroll_fem.signals.transmissibility import dwell_response, unsteadiness

if TYPE_CHECKING:
    from wroll_fem.case import DwellCase
    from wroll_fem.progress import Progress

STEADY_CYCLES = 5
"""Largest number of cycles, at the end of a dwell, from which the steady response is computed."""


def run_dwell(
    case: DwellCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Compute the time history with energy ledger and slip fields, and the steady response (attributes ``steady_*``).

    Parameters
    ----------
    checkpoint
        Checkpoint file; None writes none.
    resume
        Continue from the checkpoint.

    Raises
    ------
    ConvergenceError
        If a step does not converge; ``partial`` has the history up to that step.
    """
    history = time_history(case, progress=progress, checkpoint=checkpoint, resume=resume)
    motion = base_motion(case.excitation)
    steady = int(case.excitation.cycles - case.excitation.ramp_cycles)
    if steady >= 2:
        cycles = min(STEADY_CYCLES, steady)
        response = dwell_response(history["time"].values, absolute_tip(history), motion, cycles=cycles)  # type: ignore[arg-type]
        doubt = unsteadiness(response)
        history.attrs |= {f"steady_{key}": value for key, value in response.items()} | {"steady_doubt": doubt}
        if doubt:
            progress.warning(
                f"the dwell is not steady, and steady_magnitude is doubtful: during the last {cycles} cycles {doubt}; "
                "raise excitation.cycles (a steady_residual that remains with more cycles is due to harmonics)"
            )
    error, text = dwell_step_error(case, history)
    if text:
        progress.warning(text)
    return history.assign_attrs(time_step_error=error)


ANALYSIS = Analysis(
    name="dwell",
    sentence="Time history under sinusoidal base motion at one frequency.",
    sections=("geometry", "mandrel", "coil", "contact", "preload", "excitation"),
    run=run_dwell,
    summary=SUMMARY,
    figures=FIGURES,
    fields=FIELDS,
    variables=VARIABLES,
    plots=PLOTS,
    preflight=preflight.CHECKS["dwell"],
    estimate=estimate_history,
    resumable=True,
)
