"""Sweep: time history under a chirp of the base, with transmissibility and damping."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_history
from wroll_fem.analyses.history import FIELDS, FIGURES, PLOTS, SUMMARY, VARIABLES, time_history
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import preflight
from wroll_fem.analyses.shared.figures import figure
from wroll_fem.analyses.shared.time_step import step_at, sweep_step_error
from wroll_fem.analyses.shared.zeta_parts import parts_of_sweep
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.attainment import swept_peak
from wroll_fem.signals.damping import HalfPower, likely_damping
from wroll_fem.signals.estimators import estimate_damping
from wroll_fem.signals.motions import base_motion, sweep_motion
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.signals.sweeps import Sweep
from wroll_fem.signals.there_and_back import ThereAndBack
from wroll_fem.signals.tip import rigid_tip
from wroll_fem.signals.transmissibility import magnitude, transmissibility

if TYPE_CHECKING:
    from wroll_fem.case import SweepCase
    from wroll_fem.progress import Progress

DOWN = "down_"
"""Prefix of the variables and entries of the downward branch of a sweep up and down."""

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
    motion = base_motion(case.excitation)
    if not isinstance(motion, ThereAndBack):
        sweep = sweep_motion(case.excitation)
        curve = transmissibility(history, sweep)
        dataset = xr.merge([history, curve], combine_attrs="drop_conflicts")
        return dataset.assign_attrs(history.attrs | _Branch(case, history, sweep, curve).attrs(progress))
    there, back = motion.branches(history)
    up = _Branch(case, there, motion.up, transmissibility(there, motion.up))
    grid = up.curve["frequency"].values
    down = _Branch(case, back, motion.down, transmissibility(back, motion.down, frequency=grid), "down")
    attrs = up.attrs(progress) | {f"{DOWN}{name}": value for name, value in down.attrs(progress).items()}
    named = down.curve.rename({str(name): f"{DOWN}{name}" for name in down.curve.data_vars})
    dataset = xr.merge([history, up.curve, annotate(named)], combine_attrs="drop_conflicts")
    return dataset.assign_attrs(history.attrs | attrs)


@dataclass(frozen=True)
class _Branch:
    """Sweep in one direction: its part of the history, and its transmissibility.

    Attributes
    ----------
    case
        Case of the run.
    history
        History of this branch; its time starts with the branch.
    motion
        Base motion of this branch.
    curve
        Transmissibility.
    name
        Name of the branch for warnings; empty for a sweep in one direction.
    """

    case: SweepCase
    history: xr.Dataset
    motion: Sweep
    curve: xr.Dataset
    name: str = ""

    def attrs(self, progress: Progress) -> dict[str, Any]:
        """Attributes of the resonance, its damping and their accuracy; the reasons for doubts are warnings."""
        case, history, curve = self.case, self.history, self.curve
        frequency = curve["frequency"].values
        T = curve["transmissibility_real"].values + 1j * curve["transmissibility_imag"].values
        read = estimate_damping(frequency, T, case.output.damping)
        participation = history.attrs.get("tip_participation")
        dt = step_at(history, read.shape.f_n) if case.integrator.follow_frequency else None
        stuck = history.attrs.get("stuck_resonance_hz")
        error, coarse = sweep_step_error(case, (frequency, np.abs(T)), read.shape, participation, dt, stuck)
        known = Circumstances(
            self.motion, participation, spectrum=magnitude(curve, "transmissibility_spectrum").values,
            remarks=(coarse, numerical_remark(history)), rigid=rigid_tip(history),
        )  # fmt: skip
        quality = judge(read, frequency, np.abs(T), known)
        if self.name:  # its first frequency is the last one of the case
            texts = (text.replace("excitation.f_start", "excitation.f_end") for text in quality.reasons)
            quality = replace(quality, reasons=tuple(texts))
        for text in quality.reasons:
            progress.warning(f"downward: {text}" if self.name else text)
        attrs = quality.as_attrs(read.as_attrs("demodulated envelope"))
        attrs |= parts_of_sweep(history, attrs["zeta"], (read.shape.f_low, read.shape.f_high))
        attained = _attainment(self.motion, read.shape, participation)
        return attrs | {"time_step_error": error, "sweep_attainment": attained}


def _attainment(motion: Sweep, read: HalfPower, participation: float | None) -> float:
    """Part of the steady peak that a linear resonance reaches with the damping read; nan without a resonance."""
    if not read.resonant:
        return nan
    zeta = likely_damping(read, participation)[0]
    return swept_peak(read.f_n, zeta, motion.rate_at(read.f_n), downward=motion.downward).attainment


def numerical_remark(history: xr.Dataset) -> str:
    """Warning if much of the energy of a sweep is dissipated by the integration scheme; empty otherwise."""
    lost, put_in = (
        float(np.diff(history[name].values[[0, -1]])[0]) for name in ("numerical_dissipation", "input_work")
    )
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
