"""Backbone curve of a case: frequency and damping of the resonance versus amplitude."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.analyses.curve_reading import memory_remark, reduction_remark, span_remark
from wroll_fem.analyses.forecasts.computing_time import estimate_curve
from wroll_fem.analyses.harmonic import condensed_structure
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures, preflight, summary
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.analyses.shared.zeta_parts import backbone_parts
from wroll_fem.analyses.slip_modes import in_span, path_span, slips_inside
from wroll_fem.analyses.training_progress import Passes, training_file
from wroll_fem.blas import one_thread
from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.causes import with_cause
from wroll_fem.dynamics.periodic.datasets import (
    PeriodicMotion,
    at_one_motion,
    cycle_balance_error,
    least_work,
    per_motion,
    quadrature_error,
)
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.training.enrichment import checked_motions, trained_backbone
from wroll_fem.dynamics.training.training import Trained
from wroll_fem.errors import ConvergenceError
from wroll_fem.results.dataset import annotate
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import BackboneCase, RandomResponseCase
    from wroll_fem.progress import Progress


NO_DAMPING = 1e-9
"""Damping ratio up to which the damping of a backbone is regarded as round-off."""


def backbone_dataset(system: System, curve: BackboneCurve) -> xr.Dataset:
    """Dataset of frequency, damping and work versus `tip_amplitude`, with interface fields at the largest damping."""
    motions = [PeriodicMotion(curve.balance, q, w) for q, w in zip(curve.coefficients, curve.frequencies, strict=True)]
    dim, tip, base = "tip_amplitude", curve.tip, curve.base_acceleration
    data = {
        "resonance_frequency": (dim, curve.frequencies / (2.0 * np.pi)),
        "modal_damping": (dim, curve.damping),
        "resonant_base_acceleration": (dim, base),
        "newton_iterations": (dim, curve.iterations),
    } | per_motion(motions, system, dim)
    data["kinetic_energy_amplitude"] = (dim, np.array([motion.kinetic for motion in motions]))
    data["mass_displacement_amplitude"] = (dim, curve.fundamental(curve.balance.model.base))
    # the work done by the negative damping is the work that the base would have to do
    data["input_work_per_cycle"] = (dim, curve.dissipation)
    parts: dict[str, FloatArray] = {}
    if "material_modal_damping" in data:
        friction = backbone_parts(curve.damping, data["material_modal_damping"][1])
        parts = {"material": curve.damping - friction, "friction": friction}
        data |= {f"{name}_modal_damping": (dim, values) for name, values in parts.items()}
    most = int(np.argmax(curve.damping))
    dataset = xr.Dataset(data, coords={dim: tip})
    if len(system.probe_names) > 1:
        model = curve.balance.model
        reach = np.abs(
            [curve.fundamental(row) for row in np.vstack([model.tip, model.probes[: len(system.named_probes)]])]
        )
        dataset = dataset.assign_coords(probe=list(system.probe_names)).assign(probe_amplitude=(("probe", dim), reach))
    dataset = xr.merge([dataset, at_one_motion(system, curve.balance, motions[most])])
    sampling = curve.balance.contact.sampling
    dataset.attrs |= {
        "f_stuck_hz": float(curve.frequencies[0] / (2.0 * np.pi)),
        "f_largest_amplitude_hz": float(curve.frequencies[-1] / (2.0 * np.pi)),
        "zeta_max": float(curve.damping[most]),
        "tip_amplitude_at_zeta_max_m": float(tip[most]),
        "base_acceleration_at_zeta_max_m_s2": float(base[most]),
        "harmonics": sampling.harmonics,
        "samples_per_period": sampling.samples,
        "branch_points": len(tip),
        "newton_iterations_mean": float(np.mean(curve.iterations)),
        "reduced_coordinates": curve.balance.model.size,
        "dofs": system.n_dofs,
        "interface_points": system.n_points,
        "memory_change": float(max(m.memory for m in motions)),
        "least_work_per_cycle_j": least_work(motions),
        "method": "extended periodic motion, harmonic balance",
    } | {f"zeta_{name}": float(values[most]) for name, values in parts.items()}
    return annotate(dataset)


def range_remark(dataset: xr.Dataset) -> str:
    """Warning if the damping is largest at the end of the curve, so that it may rise further; empty otherwise."""
    damping = friction_damping(dataset)
    if not damping.max() > 0.0 or int(np.argmax(damping)) < len(damping) - 1:
        return ""
    return (
        f"the damping still rises at the largest amplitude, {dataset.attrs['tip_amplitude_at_zeta_max_m']:.2g} m: "
        "zeta_max is the value at the end of the range; raise backbone.tip_largest"
    )


def undamped_remark(dataset: xr.Dataset) -> str:
    """Warning if friction dissipates nothing at every amplitude; empty otherwise."""
    if float(friction_damping(dataset).max()) > NO_DAMPING:
        return ""
    rest = "material damping" if "material_modal_damping" in dataset else "round-off"
    return (
        f"friction dissipates no energy up to the largest amplitude, {float(dataset['tip_amplitude'].max()):.2g} m: "
        f"layers stick or have no friction, and zeta_max is {rest}; raise backbone.tip_largest, or mu if it is 0"
    )


def friction_damping(dataset: xr.Dataset) -> FloatArray:
    """(p,) modal damping ratio of a backbone without the part of material damping."""
    return np.asarray(dataset["friction_modal_damping" if "friction_modal_damping" in dataset else "modal_damping"])


def end_remark(curve: BackboneCurve, largest: float) -> str:
    """Warning if a backbone ends below the requested tip amplitude ``largest`` (m); empty otherwise."""
    if not curve.cut:
        return ""
    return (
        f"the backbone ends at a tip amplitude of {float(curve.tip[-1]):.2g} m, below the requested {largest:.2g} m: "
        f"{curve.cut}; lower backbone.tip_largest; a dwell computes motions beyond it"
    )


def followed_backbone(
    case: BackboneCase | RandomResponseCase, system: System, state: ContactState, progress: Progress,
    checkpoint: Path | None = None, *, resume: bool = False,
) -> Trained[BackboneCurve]:  # fmt: skip
    """Backbone of the main mode of a preloaded system, in an adaptive basis.

    Parameters
    ----------
    system, state
        Structure, and its state under the preload.
    checkpoint
        Checkpoint file; None writes none.
    resume
        Continue from the checkpoint.

    Raises
    ------
    ConvergenceError
        If a periodic motion is not found; ``partial`` contains the curve up to that point.
    """
    if not slips_inside(case):
        condensation = condensed_structure(case, system, state, progress)
        return _trained_curve(case, system, state, condensation, progress, checkpoint, resume=resume)
    span = path_span(case, system, state, progress)

    def solve() -> Trained[BackboneCurve]:
        return _trained_curve(case, system, state, span.modes, progress, checkpoint, resume=resume)

    return in_span(span, solve, checked_motions, progress)


def _trained_curve(
    case: BackboneCase | RandomResponseCase, system: System, state: ContactState, condensation: Condensation,
    progress: Progress, checkpoint: Path | None, *, resume: bool,
) -> Trained[BackboneCurve]:  # fmt: skip
    """Backbone in an adaptive basis of the modes ``condensation``, with progress."""
    settings = case.harmonic
    try:
        with (
            one_thread(), progress.stage("backbone", 1) as stage,
            training_file(case, checkpoint, resume=resume) as file,
        ):  # fmt: skip
            passes = Passes(progress, stage, settings.reduction_tolerance)

            def at_point(share: float, count: int) -> None:
                smallest, largest = case.backbone.tip_smallest, case.backbone.tip_largest
                tip = smallest * (largest / smallest) ** share
                passes.at_point(share, count, f"tip {1e6 * tip:.3g} um")

            trained = trained_backbone(
                condensation, state, system.laws,
                tip_amplitudes=(case.backbone.tip_smallest, case.backbone.tip_largest),
                harmonics=settings.harmonics, samples=settings.samples, max_periods=settings.max_periods,
                tolerance=settings.reduction_tolerance, on_round=passes.report, on_point=at_point,
                file=file, hyper_reduction=settings.hyper_reduction,
            )  # fmt: skip
            stage.update(1)
            return trained
    except ConvergenceError as stop:
        error = with_cause(stop, condensation, system.laws)
        if isinstance(error.partial, BackboneCurve):
            error.partial = backbone_dataset(system, error.partial)
        raise error from stop


def trained_dataset(system: System, trained: Trained[BackboneCurve]) -> xr.Dataset:
    """`backbone_dataset` of a trained curve, with its errors as attributes."""
    dataset = backbone_dataset(system, trained.curve)
    return dataset.assign_attrs(
        {
            "curves_computed": trained.rounds,
            "reduction_error_estimate": trained.energy_error,
            "reduction_tip_error_estimate": trained.tip_error,
            **({"span_error_estimate": trained.span_error} if trained.span_error else {}),
            **({} if trained.sample is None else trained.sample.as_attrs()),
            "energy_balance_error": cycle_balance_error(dataset),
            "work_quadrature_error": quadrature_error(dataset),
        }
    )


def run_backbone(
    case: BackboneCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False
) -> xr.Dataset:
    """Compute frequency and damping of the main mode versus its amplitude, from sticking to gross slip.

    The main mode contributes most to the tip displacement under a static base acceleration. Arguments and errors are
    those of `followed_backbone`.
    """
    system, state = prepare(case, progress)
    started = time.process_time()
    trained = followed_backbone(case, system, state, progress, checkpoint, resume=resume)
    dataset = trained_dataset(system, trained)
    end = end_remark(trained.curve, case.backbone.tip_largest)
    loose = reduction_remark(trained.energy_error, case.harmonic), span_remark(trained.span_error)
    for remark in (memory_remark(dataset), end or undamped_remark(dataset) or range_remark(dataset), *loose):
        if remark:
            progress.warning(remark)
    return dataset.assign_attrs({"solver_time_s": time.process_time() - started})


ANALYSIS = Analysis(
    name="backbone",
    sentence="Periodic motion at resonance: frequency and damping versus amplitude.",
    sections=("geometry", "mandrel", "coil", "contact", "preload"),
    run=run_backbone,
    summary=(summary.interfaces, summary.work_per_cycle, summary.slip),
    figures=(figures.figure("backbone", "backbone"), figures.slip_maps, figures.slip_in_space),
    fields=(figures.write_slip,),
    variables={
        "tip_amplitude": (
            "resonance_frequency", "modal_damping", "resonant_base_acceleration", "friction_work_per_cycle",
        ),
        "interface, point": ("cumulative_slip", "max_slip", "slipped", "pressure"),
    },
    plots=("backbone", "slip_map", "peak_slip_vectors", "pressure_map", "wrap_slip"),
    preflight=preflight.CHECKS["backbone"],
    estimate=estimate_curve,
    resumable=True,
)  # fmt: skip
