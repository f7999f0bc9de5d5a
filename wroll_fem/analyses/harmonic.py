"""Steady response of a case by harmonic balance: preload, modes, adaptive basis, response curve."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from wroll_fem.analyses.forecasts.computing_time import estimate_curve
from wroll_fem.analyses.margins import stress
from wroll_fem.analyses.margins.stress import stress_of_curve, with_yield
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures, preflight, summary
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.analyses.shared.zeta_parts import parts_of_curve
from wroll_fem.analyses.training_progress import Passes, training_file
from wroll_fem.case.structural import OnRoll, OnStructure
from wroll_fem.dynamics.periodic.causes import with_cause
from wroll_fem.dynamics.periodic.datasets import curve_dataset, cycle_balance_error, quadrature_error
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.condensation import MOMENTS, Condensation, condense, held
from wroll_fem.dynamics.reduction.kept_structure import kept_modes
from wroll_fem.dynamics.reduction.snapshots import WholeSlip, snapshots_of_chirp
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.training.enrichment import trained_response
from wroll_fem.dynamics.training.training import Trained
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.damping import HalfPower
from wroll_fem.signals.estimators import CurveDamping, estimate_damping, without_half_power_points
from wroll_fem.signals.estimators.estimate import DampingEstimate
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import HarmonicCase, StructuralCase
    from wroll_fem.case.harmonic import Harmonic
    from wroll_fem.progress import Progress

HIGHEST_ORDER, NEAR_MULTIPLE, LEAST_SHARE = 7, 0.04, 0.02
"""Criteria of the warning about a mode near a neglected harmonic: highest odd order of the harmonic; largest relative
difference between the natural frequency of the mode and the frequency of the harmonic; least tip participation of the
mode, relative to the main mode."""

SAME_MODE = 0.01
"""Relative difference of two natural frequencies up to which they count as one mode."""

DRIFT = 10.0
"""Mean relative displacement of the interfaces, divided by its oscillating part, above which the run warns."""

MEMORY_WARNING = 0.02
"""Change of the elastic slip per period, relative to its largest value gamma*, above which the run warns."""


def condensed_structure(case: StructuralCase, system: System, state: ContactState, progress: Progress) -> Condensation:
    """Reduce the structure with stuck interfaces to the modes excited by interface forces, base motion or tip force."""
    with progress.stage("modes", 1) as stage:
        springs = stick_springs(system, state)
        moments = MOMENTS if held(system, springs) else 0
        condensation = kept_modes(
            system, springs, moments,
            lambda springs: condense(system, springs, Scheme.hht(0.0), case.time_step, moments=moments),
        )  # fmt: skip
        stage.update(1, f"{len(condensation.eigenvalues)} modes")
    if not condensation.exact:
        progress.warning(
            "cyclic symmetry cannot be used (the mesh has no rotational symmetry, or a matrix file contains damping or "
            "no subspaces): the structure is approximated by its lowest modes and its responses to loads, with an "
            "error of about 1e-4 of the largest displacement"
        )
    return condensation


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
    condensation = condensed_structure(case, system, state, progress)
    started = time.process_time()
    trained = _trained_curve(case, system, state, condensation, progress, checkpoint, resume=resume)
    seconds = time.process_time() - started
    dataset = curve_dataset(system, trained.curve)
    stressed = with_yield(stress_of_curve(system, state, progress, trained.curve), case)
    dataset = _described(xr.merge([dataset, stressed], combine_attrs="override"), case)
    read = unbounded_reading(trained.curve) or read_response(dataset, case.output.damping, error=trained.tip_error)
    remarks = _remarks(case, dataset, trained, condensation, read)
    stuck, participation = condensation.main_mode
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
            threadpool_limits(1, "blas"), progress.stage("harmonic balance", 1) as stage,
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
        other_mode_remark(condensation) if _rubs(case) else "",
        reduction_remark(trained.energy_error, settings),
    )


def _rubs(case: HarmonicCase) -> bool:
    return isinstance(case, OnRoll) and case.coil.rubs


def missed_harmonic(condensation: Condensation, frequency: float, harmonics: int) -> str:
    """Warning if a mode lies near a neglected harmonic of the resonance frequency; empty otherwise.

    Parameters
    ----------
    condensation
        Modes of the structure.
    frequency
        Resonance frequency, rad/s.
    harmonics
        Highest harmonic in the analysis.

    Notes
    -----
    The friction force is odd in the motion, so its odd harmonics dominate; they decrease with the order.
    """
    c = condensation
    share = np.abs(c.base * c.tip)
    share = share / max(float(share.max(initial=0.0)), 1e-300)
    natural = np.sqrt(np.maximum(c.eigenvalues, 0.0))
    for order in range(harmonics + 1 + harmonics % 2, HIGHEST_ORDER + 1, 2):
        near = (np.abs(natural / (order * frequency) - 1.0) < NEAR_MULTIPLE) & (share > LEAST_SHARE)
        if near.any():
            return (
                f"a mode at {natural[near][0] / (2.0 * np.pi):.0f} Hz lies near {order} times the resonance frequency, "
                f"and this harmonic is neglected; set harmonic.harmonics to {order}"
            )
    return ""


def other_mode_remark(condensation: Condensation) -> str:
    """Warning if the base excites another mode more than the one with the largest tip motion; empty otherwise.

    This is so for a coil that is soft in shear: most of its mass moves in a mode of its own.
    """
    mass = condensation.base**2
    if not mass.any():
        return ""
    most, (followed, _) = int(np.argmax(mass)), condensation.main_mode
    hertz = float(np.sqrt(max(condensation.eigenvalues[most], 0.0)) / (2.0 * np.pi))
    if abs(hertz - followed) <= SAME_MODE * followed:
        return ""
    return (
        f"the base excites a mode at {hertz:.4g} Hz most ({100.0 * mass[most] / mass.sum():.0f} % of the mass that it "
        f"moves), but the tip moves most in the mode at {followed:.4g} Hz (interfaces stuck), which f_n and zeta "
        "follow: the coil is soft in shear; give the band of the mode that is wanted"
    )


def read_response(dataset: xr.Dataset, method: str = "half_power", *, error: float | None = None) -> CurveDamping:
    """Estimate damping from the response curve, or from the upper envelope of a folded curve.

    ``method`` is a key of `ESTIMATORS`. ``error`` is the relative error of the curve, for the error bars. Between the
    folds of a curve that leans over, several motions have the same frequency. The largest of them is used at every
    frequency. The resulting envelope has no phase. Where a broad peak has no half-power points, a curve without folds
    is read by `rational_fraction`.
    """
    T = dataset["transmissibility_real"].values + 1j * dataset["transmissibility_imag"].values
    frequency = dataset["frequency"].values
    size = np.abs(T)
    noise = None if error is None else error * float(size.max())
    if np.all(np.diff(frequency) > 0.0):
        read = estimate_damping(frequency, T, method, noise=noise)
        return read if method != "half_power" else without_half_power_points(read, frequency, T)
    grid = np.unique(np.concatenate([np.linspace(frequency[0], frequency[-1], 20 * len(frequency)), frequency]))
    best = np.zeros_like(grid)
    for i in range(len(frequency) - 1):
        low, high = sorted((frequency[i], frequency[i + 1]))
        inside = (grid >= low) & (grid <= high)
        if high > low:
            share = (grid[inside] - frequency[i]) / (frequency[i + 1] - frequency[i])
            best[inside] = np.maximum(best[inside], size[i] + share * (size[i + 1] - size[i]))
    return estimate_damping(grid, best, method, noise=noise)


def unbounded_reading(curve: HarmonicCurve) -> CurveDamping | None:
    """Estimate with f_n, but without peak and damping, if the resonance is practically undamped; None otherwise."""
    if curve.gap is None:
        return None
    low, high = (w / (2.0 * np.pi) for w in curve.gap)
    middle = 0.5 * (low + high)
    edges = np.abs(curve.transmissibility[np.isin(curve.frequencies, curve.gap)])
    height = min(float(edges.min(initial=np.inf)), curve.balance.largest_growth)
    remedy = "" if curve.balance.model.damping is not None else "; give the material damping in section damping"
    reason = (
        f"the resonance near {middle:.5g} Hz grows beyond {height:.0f} times the base motion: its damping "
        f"ratio due to friction is below {50.0 / height:.2g} %, or friction does not limit it; the curve is "
        f"omitted between {low:.6g} and {high:.6g} Hz{remedy}"
    )
    shape = HalfPower(middle, np.nan, np.nan, np.nan, np.nan, np.nan, complete=False, reason=reason)
    return CurveDamping(shape, DampingEstimate(middle, np.nan, np.nan, np.nan, "half power", reason))


def several_motions(curve: HarmonicCurve) -> tuple[float, float] | None:
    """Lowest and highest frequency (Hz) of the widest fold of a curve; None without folds."""
    turns = np.flatnonzero(np.diff(np.sign(np.diff(curve.frequencies)))) + 1
    ends = np.concatenate([[0], turns, [len(curve.frequencies) - 1]])
    hertz = curve.frequencies[ends] / (2.0 * np.pi)
    folds = [(high, low) for high, low in zip(hertz[1:], hertz[:-1], strict=True) if high < low]
    return max(folds, key=lambda fold: fold[1] - fold[0], default=None)


def skipped_remark(curve: HarmonicCurve) -> str:
    """Warning about internal resonances that were stepped over along the curve; empty otherwise."""
    if not curve.skipped:
        return ""
    places = ", ".join(f"{w / (2.0 * np.pi):.5g}" for w in curve.skipped)
    return (
        f"undamped internal resonances just below {places} Hz are stepped over: a harmonic of the motion coincides "
        "with a mode there; compare with a sweep, or raise harmonic.harmonics"
    )


def drift_remark(curve: HarmonicCurve) -> str:
    """Warning about a mean relative displacement that the friction law does not limit; empty otherwise.

    A friction law without memory transmits no traction at zero slip rate. A layer that is not held otherwise drifts.
    """
    contact = curve.balance.contact
    if contact.laws.sticks.all():
        return ""
    jump = contact.jump[: 2 * contact.n]
    mean = float(np.abs(jump @ curve.coefficients[:, 0].T).max(initial=0.0))
    motion = float(np.abs(jump @ curve.coefficients[:, 1:].reshape(-1, jump.shape[1]).T).max(initial=0.0))
    if mean <= DRIFT * motion:
        return ""
    return (
        f"the mean relative displacement of the layers is {mean:.2g} m, {mean / max(motion, 1e-300):.2g} times its "
        "amplitude: the friction law transmits no traction at rest and does not hold them; displacements and slip of "
        "the interfaces are meaningless; use penalty_coulomb"
    )


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


def reduction_remark(error: float, settings: Harmonic) -> str:
    """Warning if the error estimate of the reduced model exceeds its tolerance; empty otherwise."""
    if error <= settings.reduction_tolerance:
        return ""
    return (
        f"the estimated error of the reduced model is {100 * error:.2g} % of the motion, above "
        "harmonic.reduction_tolerance, and its basis is not enlarged further"
    )


def memory_remark(dataset: xr.Dataset) -> str:
    """Warning if the friction hysteresis is not yet periodic; empty otherwise."""
    change = float(dataset.attrs["memory_change"])
    if change <= MEMORY_WARNING:
        return ""
    return (
        f"the friction hysteresis is not periodic: the elastic slip at some point still changes by "
        f"{100 * change:.2g} % of elastic_slip per period; "
        "raise harmonic.max_periods"
    )


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
    plots=("harmonic_response", "hysteresis", "comparison", "slip_map", "peak_slip_vectors", "pressure_map"),
    preflight=preflight.CHECKS["harmonic"],
    estimate=estimate_curve,
    resumable=True,
)
