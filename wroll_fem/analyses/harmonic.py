"""Steady response of a case by harmonic balance: preload, modes, adaptive basis, response curve."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.analyses.curve_reading import (
    drift_remark,
    memory_remark,
    missed_harmonic,
    other_mode_remark,
    read_response,
    reduction_remark,
    several_motions,
    skipped_remark,
    span_remark,
    unbounded_reading,
)
from wroll_fem.analyses.forecasts.computing_time import estimate_curve
from wroll_fem.analyses.margins import stress
from wroll_fem.analyses.margins.stress import stress_of_curve, with_yield
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures, preflight, summary
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.analyses.shared.zeta_parts import parts_of_curve
from wroll_fem.analyses.slip_modes import in_span, path_span, slips_inside
from wroll_fem.analyses.training_progress import Passes, training_file
from wroll_fem.blas import one_thread
from wroll_fem.case.structural import OnRoll, OnStructure
from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.periodic.causes import with_cause
from wroll_fem.dynamics.periodic.datasets import curve_dataset, cycle_balance_error, quadrature_error
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.condensation import Condensation, condense, enough_moments
from wroll_fem.dynamics.reduction.kept_structure import kept_modes
from wroll_fem.dynamics.reduction.snapshots import WholeSlip, snapshots_of_chirp
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState, unpressed
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.reduced import FLOATING
from wroll_fem.dynamics.training.basis import SMALL
from wroll_fem.dynamics.training.enrichment import checked_points, trained_response
from wroll_fem.dynamics.training.training import Trained
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.estimators import CurveDamping
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import HarmonicCase, StructuralCase
    from wroll_fem.progress import Progress

SLIP_LOWERS = 1.5
"""Natural frequency of a sticking structure, relative to the upper end of a band, up to which slip may lower the
resonance into the band."""


def condensed_structure(case: StructuralCase, system: System, state: ContactState, progress: Progress) -> Condensation:
    """Reduce the structure with stuck interfaces to the modes excited by interface forces, base motion or tip force.

    Raises
    ------
    InputError
        If a layer floats that an interface should hold: a motion without stiffness has no steady response.
    """
    with progress.stage("modes", 1) as stage:
        springs = stick_springs(system, state)
        moments = enough_moments(system, springs)
        condensation = kept_modes(
            system, springs, moments,
            lambda springs: condense(system, springs, Scheme.hht(0.0), case.time_step, moments=moments),
        )  # fmt: skip
        stage.update(1, f"{len(condensation.eigenvalues)} modes")
    values = condensation.eigenvalues
    if values.min() < FLOATING * values.max():
        _check_floating(system, state, springs, small=len(values) <= SMALL)
    if not condensation.exact:
        progress.warning(
            "cyclic symmetry cannot be used (the mesh has no rotational symmetry, or a matrix file contains damping or "
            "no subspaces): the structure is approximated by its lowest modes and its responses to loads, with an "
            "error of about 1e-4 of the largest displacement"
        )
    return condensation


def _check_floating(system: System, state: ContactState, springs: FloatArray, *, small: bool) -> None:
    """Refuse interfaces that leave a floating layer without stiffness; ``small`` structures need no basis of motions.

    Raises
    ------
    InputError
        If an interface carries no pressure, or friction without memory acts in a structure that is not small.
    """
    if unpressed(system, state):
        raise InputError(
            "an interface carries no pressure, and nothing else holds its layers: they have no steady response",
            key="preload", remedy="give a preload that presses every interface, or use analysis: dwell or sweep",
        )  # fmt: skip
    loose = springs[contact_dofs(system.n_points)[:, 0]] == 0.0
    if not small and bool((loose & (system.laws.mu > 0.0) & (state.pressure > 0.0)).any()):
        raise InputError(
            "friction without memory transmits no traction at rest, and nothing else holds the layers: their mean "
            "displacement is undetermined", key="friction.law",
            remedy="use penalty_coulomb, or analysis: dwell or sweep",
        )  # fmt: skip


def _check_orders(system: System, harmonics: int) -> None:
    highest = max((force.order for force in system.harmonic_forces), default=0)
    if highest > harmonics:
        raise InputError(
            f"is {harmonics}, but a force acts at harmonic {highest}", key="harmonic.harmonics",
            remedy=f"set it to {highest} or more",
        )  # fmt: skip


def run_harmonic(
    case: HarmonicCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Compute the response curve with work per cycle and slip, and estimate its damping.

    Parameters
    ----------
    checkpoint
        Checkpoint file; None writes none.
    resume
        Continue from the checkpoint.

    Raises
    ------
    ConvergenceError
        If a point of the curve does not converge; ``partial`` contains the curve up to that point.
    """
    system, state = prepare(case, progress)
    _check_orders(system, case.harmonic.harmonics)
    if slips_inside(case):
        return _slipping_curve(case, system, state, progress, checkpoint, resume=resume)
    condensation = condensed_structure(case, system, state, progress)
    started = time.process_time()
    trained = _trained_curve(case, system, state, condensation, progress, checkpoint, resume=resume)
    return _results(case, system, state, condensation, trained, time.process_time() - started, progress)


def _slipping_curve(
    case: HarmonicCase, system: System, state: ContactState, progress: Progress, checkpoint: Path | None, *,
    resume: bool,
) -> xr.Dataset:  # fmt: skip
    """Response curve of a coil whose wraps slide, in the span of its quasi-static path."""
    started = time.process_time()
    span = path_span(case, system, state, progress)

    def solve() -> Trained[HarmonicCurve]:
        return _trained_curve(case, system, state, span.modes, progress, checkpoint, resume=resume)

    trained = in_span(span, solve, checked_points, progress)
    return _results(case, system, state, span.modes, trained, time.process_time() - started, progress)


def _results(
    case: HarmonicCase, system: System, state: ContactState, condensation: Condensation,
    trained: Trained[HarmonicCurve], seconds: float, progress: Progress,
) -> xr.Dataset:  # fmt: skip
    """Dataset of a response curve with its readings and their quality, after the warnings about them."""
    dataset = curve_dataset(system, trained.curve)
    stressed = with_yield(stress_of_curve(system, state, progress, trained.curve), case)
    dataset = _described(xr.merge([dataset, stressed], combine_attrs="override"), case)
    read = unbounded_reading(trained.curve) or read_response(dataset, case.output.damping, error=trained.tip_error)
    remarks = _remarks(case, dataset, trained, condensation, read)
    stuck, participation = condensation.main_mode_between(*_band(case))
    known = Circumstances(
        participation=participation, several=several_motions(trained.curve), remarks=remarks, rigid=system.rigid_tip
    )
    quality = judge(read, dataset["frequency"].values, np.abs(trained.curve.transmissibility), known)
    for text in dict.fromkeys((*quality.reasons, *remarks)):
        if text:
            progress.warning(text)
    attrs = quality.as_attrs(read.as_attrs("harmonic balance"))
    return dataset.assign_attrs(
        attrs
        | parts_of_curve(dataset, attrs["zeta"])
        | {
            "stuck_resonance_hz": stuck,
            "tip_participation": participation,
            "solver_time_s": seconds,
            "curves_computed": trained.rounds,
            "reduction_error_estimate": trained.energy_error,
            "reduction_tip_error_estimate": trained.tip_error,
            **({"span_error_estimate": trained.span_error} if trained.span_error else {}),
            **({} if trained.sample is None else trained.sample.as_attrs()),
            "energy_balance_error": cycle_balance_error(dataset),
            "work_quadrature_error": quadrature_error(dataset),
        }
    )


def _trained_curve(
    case: HarmonicCase, system: System, state: ContactState, condensation: Condensation, progress: Progress,
    checkpoint: Path | None, *, resume: bool,
) -> Trained[HarmonicCurve]:  # fmt: skip
    """Response curve in an adaptive basis, with progress; arguments and errors as for `run_harmonic`."""
    excitation, settings = case.excitation, case.harmonic
    try:
        with (
            one_thread(), progress.stage("harmonic balance", 1) as stage,
            training_file(case, checkpoint, resume=resume) as file,
        ):  # fmt: skip
            passes = Passes(progress, stage, settings.reduction_tolerance)

            def at_point(hertz: float, count: int) -> None:
                share = (hertz - excitation.f_start) / (excitation.f_end - excitation.f_start)
                passes.at_point(share, count, f"{hertz:.2f} Hz")

            def watch() -> FloatArray | None:
                progress.info("interfaces open widely: a chirp in time gives shapes for the basis")
                try:
                    return snapshots_of_chirp(
                        system, state, condensation, amplitude=excitation.amplitude,
                        frequencies=(excitation.f_start, excitation.f_end), on_part=passes.in_time,
                    )  # fmt: skip
                except WholeSlip:
                    raise
                except ConvergenceError:
                    progress.info("the chirp does not converge; the basis goes without its shapes")
                    return None

            trained = trained_response(
                condensation, state, system.laws, amplitude=excitation.amplitude,
                frequencies=(excitation.f_start, excitation.f_end),
                harmonics=settings.harmonics, samples=settings.samples, max_periods=settings.max_periods,
                tolerance=settings.reduction_tolerance, on_round=passes.report, on_point=at_point, file=file,
                hyper_reduction=settings.hyper_reduction,
                snapshots=watch if _rubs(case) else None,
            )  # fmt: skip
            stage.update(1)
            return trained
    except ConvergenceError as stop:
        error = with_cause(stop, condensation, system.laws)
        if isinstance(error.partial, HarmonicCurve):
            error.partial = _described(curve_dataset(system, error.partial), case)
        raise error from stop


def _remarks(
    case: HarmonicCase, dataset: xr.Dataset, trained: Trained[HarmonicCurve], condensation: Condensation,
    read: CurveDamping,
) -> tuple[str, ...]:  # fmt: skip
    """Warnings about a curve; each is empty if there is nothing to say."""
    settings, curve, resonance = case.harmonic, trained.curve, 2.0 * np.pi * read.shape.f_n
    return (
        memory_remark(dataset),
        missed_harmonic(condensation, resonance, settings.harmonics) if read.shape.resonant else "",
        skipped_remark(curve),
        drift_remark(curve),
        other_mode_remark(condensation, _band(case)) if _rubs(case) else "",
        reduction_remark(trained.energy_error, settings),
        span_remark(trained.span_error),
    )


def _band(case: HarmonicCase) -> tuple[float, float]:
    """Lowest and highest natural frequency (Hz) of a sticking structure whose resonance the curve may have."""
    return case.excitation.f_start, SLIP_LOWERS * case.excitation.f_end


def _rubs(case: HarmonicCase) -> bool:
    return isinstance(case, OnRoll) and case.coil.rubs


def _described(dataset: xr.Dataset, case: HarmonicCase) -> xr.Dataset:
    excitation = case.excitation
    direction = "of the file" if isinstance(case, OnStructure) else excitation.direction
    attrs = {
        "excitation_direction": direction,
        "f_start_hz": excitation.f_start,
        "f_end_hz": excitation.f_end,
        "amplitude_m_s2": excitation.amplitude,
        "method": "harmonic balance",
    }
    return annotate(dataset).assign_attrs(dataset.attrs | attrs)


ANALYSIS = Analysis(
    name="harmonic",
    sentence="Periodic response to sinusoidal base motion versus frequency, by harmonic balance.",
    sections=("geometry", "mandrel", "coil", "contact", "preload", "excitation"),
    run=run_harmonic,
    summary=(summary.interfaces, summary.work_per_cycle, summary.slip, summary.base_loads, stress.summary),
    figures=(
        figures.figure("transmissibility", "harmonic_response"),
        figures.figure("hysteresis", "hysteresis", needs="loop_force"),
        figures.slip_maps,
        figures.slip_in_space,
    ),
    fields=(figures.write_slip,),
    variables={
        "frequency": ("transmissibility_real", "transmissibility_imag", "tip_amplitude", "friction_work_per_cycle"),
        "frequency, interface, point": ("slip_amplitude",),
        "interface, point": ("cumulative_slip", "max_slip", "slipped", "pressure"),
    },
    plots=(
        "harmonic_response",
        "hysteresis",
        "comparison",
        "slip_map",
        "peak_slip_vectors",
        "pressure_map",
        "wrap_slip",
    ),
    preflight=preflight.CHECKS["harmonic"],
    estimate=estimate_curve,
    resumable=True,
)
