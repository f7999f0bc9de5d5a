"""Random: time history under a random motion of the base, its spectra, damping and statistics."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_history
from wroll_fem.analyses.history import FIELDS, FIGURES, PLOTS, SUMMARY, VARIABLES, time_history
from wroll_fem.analyses.random_levels import level_summary, run_levels
from wroll_fem.analyses.random_plan import planned
from wroll_fem.analyses.random_reading import read_spectra
from wroll_fem.analyses.random_statistics import accuracy, graded, spectra_variables, statistics
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import preflight
from wroll_fem.analyses.shared.figures import figure

if TYPE_CHECKING:
    from wroll_fem.case import RandomCase
    from wroll_fem.progress import Progress


def run_random(
    case: RandomCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Compute the time history with energy ledger and slip fields, spectra, damping from H1, and rms values.

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
    case = planned(case)
    if case.excitation.in_series:
        return run_levels(case, progress=progress, checkpoint=checkpoint, resume=resume)
    history = time_history(case, progress=progress, checkpoint=checkpoint, resume=resume)
    found = read_spectra(history, case.excitation, case.output.damping)
    attrs, reasons = graded(case, [history], found)
    for text in reasons:
        progress.warning(text)
    dataset = xr.merge([history, spectra_variables(found.spectra)], combine_attrs="drop_conflicts")
    steady = history.isel(time=history["time"].values >= found.start)
    attrs |= statistics(steady, found.spectra) | accuracy(found)
    return dataset.assign_attrs(history.attrs | attrs)


def estimate_random(case: RandomCase) -> dict[str, Any]:
    """Size and approximate time of the run."""
    case = planned(case)
    found = estimate_history(case)
    runs = len(case.excitation.all_levels_db) * (case.excitation.records or 1)
    return found | {name: runs * found[name] for name in ("steps", "duration_s", "estimated_seconds") if name in found}


def random_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Entries of a single history, or of the levels of a series."""
    if "level" in dataset.dims:
        return level_summary(dataset)
    return {name: value for part in SUMMARY for name, value in part(dataset).items()}


ANALYSIS = Analysis(
    name="random",
    sentence="Time history under a random motion of the base: spectra, transmissibility, damping, rms values, slip.",
    sections=("geometry", "mandrel", "coil", "contact", "preload", "excitation"),
    run=run_random,
    summary=(random_summary,),
    figures=(
        figure("spectra", "spectra", needs="coherence", without="level"),
        figure("levels", "random_levels", needs="frequency_at_level"),
        *FIGURES,
    ),
    fields=FIELDS,
    variables=VARIABLES
    | {
        "frequency": (
            "base_psd", "tip_psd", "transmissibility_real", "transmissibility_imag", "coherence", "h1_error",
            "hv_real", "hv_imag",
        ),
    },
    plots=("spectra", "random_levels", "transmissibility", "comparison", *PLOTS),
    preflight=preflight.CHECKS["random"],
    estimate=estimate_random,
    resumable=True,
)  # fmt: skip
