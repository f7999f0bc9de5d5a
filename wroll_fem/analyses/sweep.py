"""Sweep: time history under a chirp of the base, with transmissibility and damping."""

from __future__ import annotations

from math import nan
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_history
from wroll_fem.analyses.history import FIELDS, FIGURES, PLOTS, SUMMARY, VARIABLES, time_history
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import preflight
from wroll_fem.analyses.shared.figures import figure
from wroll_fem.analyses.shared.time_step import step_at, sweep_step_error
from wroll_fem.analyses.shared.zeta_parts import parts_of_sweep
from wroll_fem.signals.attainment import swept_peak
from wroll_fem.signals.damping import HalfPower, likely_damping
from wroll_fem.signals.estimators import estimate_damping
from wroll_fem.signals.motions import sweep_motion
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.signals.sweeps import Sweep
from wroll_fem.signals.tip import rigid_tip
from wroll_fem.signals.transmissibility import magnitude, transmissibility

if TYPE_CHECKING:
    from wroll_fem.case import SweepCase
    from wroll_fem.progress import Progress

NUMERICAL_SHARE = 0.1
"""Numerical dissipation, relative to the input work, above which the damping ratio of a sweep is doubtful."""


def run_sweep(
    case: SweepCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Compute the time history with energy ledger, slip fields and transmissibility; attributes describe the damping.

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
    motion = sweep_motion(case.excitation)
    curve = transmissibility(history, motion)
    dataset = xr.merge([history, curve], combine_attrs="drop_conflicts")
    T = curve["transmissibility_real"].values + 1j * curve["transmissibility_imag"].values
    read = estimate_damping(curve["frequency"].values, T, case.output.damping)
    participation = history.attrs.get("tip_participation")
    dt = step_at(history, read.shape.f_n) if case.integrator.follow_frequency else None
    error, coarse = sweep_step_error(case, (curve["frequency"].values, np.abs(T)), read.shape, participation, dt)
    spectrum = magnitude(curve, "transmissibility_spectrum").values
    remarks = coarse, numerical_remark(history)
    known = Circumstances(motion, participation, spectrum=spectrum, remarks=remarks, rigid=rigid_tip(history))
    quality = judge(read, curve["frequency"].values, np.abs(T), known)
    for text in quality.reasons:
        progress.warning(text)
    attrs = quality.as_attrs(read.as_attrs("demodulated envelope"))
    attrs |= parts_of_sweep(dataset, attrs["zeta"], (read.shape.f_low, read.shape.f_high))
    attrs |= {"time_step_error": error, "sweep_attainment": _attainment(motion, read.shape, participation)}
    return dataset.assign_attrs(history.attrs | attrs)


def _attainment(motion: Sweep, read: HalfPower, participation: float | None) -> float:
    """Part of the steady peak that a linear resonance reaches with the damping read; nan without a resonance."""
    if not read.resonant:
        return nan
    zeta = likely_damping(read, participation)[0]
    return swept_peak(read.f_n, zeta, motion.rate_at(read.f_n), downward=motion.downward).attainment


def numerical_remark(history: xr.Dataset) -> str:
    """Warning if much of the energy of a sweep is dissipated by the integration scheme; empty otherwise."""
    lost, put_in = (float(history[name].values[-1]) for name in ("numerical_dissipation", "input_work"))
    if not put_in > 0.0 or lost <= NUMERICAL_SHARE * put_in:
        return ""
    return (
        f"the integration scheme dissipates {100 * lost / put_in:.0f} % of the input work, so a part of zeta is "
        "numerical; raise integrator.steps_per_cycle, or use harmonic"
    )


ANALYSIS = Analysis(
    name="sweep",
    sentence="Time history under a sine sweep of the base: transmissibility, damping, slip and energies.",
    sections=("geometry", "mandrel", "coil", "contact", "preload", "excitation"),
    run=run_sweep,
    summary=SUMMARY,
    figures=(figure("transmissibility", "transmissibility", needs="transmissibility_real"), *FIGURES),
    fields=FIELDS,
    variables=VARIABLES | {"frequency": ("transmissibility_real", "transmissibility_imag")},
    plots=("transmissibility", "comparison", *PLOTS),
    preflight=preflight.CHECKS["sweep"],
    estimate=estimate_history,
    resumable=True,
)
