"""Dwell: time history under a sine of the base at one frequency, and its steady end."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from wroll_fem.analyses.history import FIELDS, FIGURES, PLOTS, SUMMARY, VARIABLES, time_history
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import preflight
from wroll_fem.analyses.shared.estimates import estimate_history
from wroll_fem.signals.base_motion import base_motion
from wroll_fem.signals.transmissibility import dwell_response

if TYPE_CHECKING:
    from wroll_fem.case import DwellCase
    from wroll_fem.progress import Progress

STEADY_CYCLES = 5
"""Whole cycles at the end from which the steady response is taken, if there are as many after the ramp."""


def run_dwell(
    case: DwellCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Time history with energy ledger and slip fields; the steady response in the attributes ``steady_*``.

    Raises
    ------
    ConvergenceError
        With the history until then in ``partial``.
    """
    history = time_history(case, progress=progress, checkpoint=checkpoint, resume=resume)
    motion = base_motion(case.excitation)
    steady = int(case.excitation.cycles - case.excitation.ramp_cycles)
    if steady >= 2:
        tip = history["tip_acceleration"] + history["base_acceleration"]
        cycles = min(STEADY_CYCLES, steady)
        response = dwell_response(history["time"].values, tip.values, motion, cycles=cycles)  # type: ignore[arg-type]
        history.attrs |= {f"steady_{key}": value for key, value in response.items()}
    return history


ANALYSIS = Analysis(
    name="dwell",
    sentence="Time history under a sine of the base at one frequency.",
    sections=("geometry", "mandrel", "coil", "contact", "preload", "excitation"),
    run=run_dwell,
    summary=SUMMARY,
    figures=FIGURES,
    fields=FIELDS,
    variables=VARIABLES,
    plots=PLOTS,
    preflight=(preflight.contact_warnings, preflight.structure_warnings, preflight.scheme_warnings),
    estimate=estimate_history,
    resumable=True,
)
