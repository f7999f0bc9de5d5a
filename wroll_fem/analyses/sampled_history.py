"""Time histories on a subset of the contact points: training for a sweep or dwell, and what its errors mean."""

from __future__ import annotations

import time as clock
from typing import TYPE_CHECKING, Any

from wroll_fem.analyses.training_progress import Passes
from wroll_fem.blas import one_thread
from wroll_fem.case.excitation import ChirpExcitation, DwellExcitation
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.sampled_histories.stepper import SampledStepper, sampled_stepper
from wroll_fem.dynamics.statics.contact_state import ContactState, unpressed
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.reduced import FLOATING
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.dynamics.training.history_points import history_points
from wroll_fem.errors import ConvergenceError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wroll_fem.case import HistoryCase
    from wroll_fem.progress import Progress

AROUND = 0.1
"""Band of the training motions of a dwell, on both sides of its frequency, relative to it."""

TRAINED = 0.5
"""Tolerance of the training motions, relative to `solver.reduction_tolerance`: a history is not periodic."""

FEWER = 0.5
"""Share of the contact points above which a subset is not worth its error."""

LARGE_ERROR = 0.01
"""Error of the friction work, or of the motion, of the subset above which a run warns."""


def stepper_on_subset(
    case: HistoryCase, system: System, state: ContactState, modes: Condensation, scheme: Scheme,
    options: NewtonOptions, dt: float, largest_error: float, progress: Progress,
) -> SampledStepper | None:  # fmt: skip
    """Stepper on a subset of the contact points, trained for the motion of the base; None, with a remark, without one.

    Parameters
    ----------
    modes
        Modes of the structure with stuck interfaces.
    options, dt
        Controls of a step, and its size, s.
    largest_error
        Error estimate above which the run stops with a `ReductionError`.
    """
    values = modes.eigenvalues
    if not system.n_points:
        return None
    if unpressed(system, state) or values.min() < FLOATING * values.max():
        progress.info("no subset of the contact points is used: the contact does not hold the layers")
        return None
    (amplitude, low, high), began = _motion(case), clock.process_time()
    tolerance = TRAINED * case.solver.reduction_tolerance
    try:
        with one_thread(), progress.stage("training on a response curve", 1) as stage:
            passes = Passes(progress, stage, tolerance)

            def at_point(hertz: float, count: int) -> None:
                passes.at_point((hertz - low) / (high - low), count, f"{hertz:.2f} Hz")

            trained = history_points(
                modes, state, system.laws, amplitude=amplitude, frequencies=(low, high), tolerance=tolerance,
                on_round=passes.report, on_point=at_point,
            )  # fmt: skip
            stage.update(1)
    except ConvergenceError as stop:
        cause = stop.problem.replace("harmonic.reduction_tolerance", "its tolerance")
        progress.warning(f"no subset of the contact points is used: its training stops ({cause})")
        return None
    count = 0 if trained is None else len(trained.sample.points)
    if trained is None or count > FEWER * system.n_points:
        needed = f"it would need {count} of {system.n_points}" if count else "nothing slips"
        progress.info(f"no subset of the contact points is used: {needed}")
        return None
    progress.info(f"friction at {count} of {system.n_points} contact points, {trained.model.size} basis vectors")
    found = sampled_stepper(
        system, state, scheme, options, dt=dt, trained=trained, largest_error=largest_error
    )  # fmt: skip
    found.training_seconds = clock.process_time() - began
    return found


def _motion(case: HistoryCase) -> tuple[float, float, float]:
    """Largest amplitude of the base (m/s^2) and band of frequencies (Hz) of a sweep or dwell."""
    excitation = case.excitation
    if isinstance(excitation, DwellExcitation):
        f = excitation.frequency
        return excitation.amplitude, (1.0 - AROUND) * f, (1.0 + AROUND) * f
    assert isinstance(excitation, ChirpExcitation)
    ends = excitation.f_start, excitation.f_end
    largest = max(excitation.profile.factor) if excitation.profile is not None else 1.0
    return largest * excitation.amplitude, min(ends), max(ends)


def subset_remark(attrs: Mapping[Any, Any]) -> str:
    """Warning about large errors of the subset on which a history was computed; empty if there are none."""
    work, motion = attrs.get("sampling_work_error", 0.0), attrs.get("sampling_motion_error", 0.0)
    if max(work, motion) <= LARGE_ERROR:
        return ""
    return (
        f"the subset of the contact points has an error of {100 * work:.2g} % in the friction work and "
        f"{100 * motion:.2g} % in the motion: set solver.hyper_reduction: false"
    )
