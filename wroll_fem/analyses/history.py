"""Time history of a case under base motion: preload, condensation, time integration."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.analyses.curve_reading import span_remark
from wroll_fem.analyses.excited_band import band_remark, basis_remark, excited_to, period_error
from wroll_fem.analyses.margins import stress
from wroll_fem.analyses.margins.stress import stress_of_displacement, with_yield
from wroll_fem.analyses.sampled_history import stepper_on_subset, subset_remark
from wroll_fem.analyses.shared import figures, summary
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.analyses.shared.time_step import detuned_harmonic, steps_per_cycle, time_grid, time_step
from wroll_fem.analyses.shock_plan import unresolved_modes
from wroll_fem.analyses.slip_modes import path_span, slips_inside
from wroll_fem.case.structural import OnStructure
from wroll_fem.dynamics.path_span.span import PathSpan
from wroll_fem.dynamics.path_span.stepper import PathStepper, path_stepper
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.reduction.stuck_modes import modes_to_reduce
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.dynamics.time_stepping.simulate import Checkpointing, make_stepper, saved_method, simulate
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.errors import ConvergenceError, ReductionError
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.motions import base_motion
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import HistoryCase
    from wroll_fem.progress import Progress


LARGE_REDUCTION_ERROR = 0.01
"""Estimated relative error of the reduced model above which the run falls back to `condensed`, or only warns if
`condensed` would take too long. The limit is five times `solver.reduction_tolerance` if this product is larger. The
estimated error of the lab roll at 10 to 300 kPa is below 0.004."""

FALLBACK_SIZE = 2000
"""Largest number of contact degrees of freedom for which a run falls back from `reduced` to `condensed`. With more, a
step of `condensed` takes seconds when many points change their contact state."""

SUMMARY = (summary.interfaces, summary.ledger, summary.slip, summary.base_loads, stress.summary)
FIGURES = (
    figures.figure("response", "response", needs="time"),
    figures.figure("energy_ledger", "energy_ledger", needs="time"),
    figures.slip_maps,
    figures.slip_in_space,
)
FIELDS = (figures.write_slip,)
VARIABLES: dict[str, tuple[str, ...]] = {
    "time": (
        "tip_displacement", "tip_acceleration", "base_acceleration", "input_work", "kinetic_energy", "strain_energy",
        "friction_energy",
    ),
    "interface, point": ("cumulative_slip", "max_slip", "slipped", "pressure"),
}  # fmt: skip
PLOTS = (
    "response", "energy_ledger", "slip_map", "peak_slip_vectors", "pressure_map", "slip_scene", "slip_on_cylinder",
    "wrap_slip",
)  # fmt: skip


class SharedStructure:
    """System, preload state, modes, span and basis that several time histories with the same time step share.

    Attributes
    ----------
    case
        Case of the largest motion.
    system, state
        Prepared system and its preload state.
    modes
        Modes of the structure, once a history has needed them.
    span
        Modes in the span of the path of a coil whose wraps slide.
    basis
        Vectors (r, m) and eigenvalues (m,) of the reduced model at the end of the last history by `reduced`: the next
        one starts with them.
    """

    def __init__(self, case: HistoryCase, progress: Progress):
        self.case = case
        self.system, self.state = prepare(case, progress)
        self.modes: Condensation | None = None
        self.span: PathSpan | None = None
        self.basis: tuple[FloatArray, FloatArray] | None = None


def time_history(
    case: HistoryCase, *, progress: Progress, checkpoint: Path | None = None, resume: bool = False,
    shared: SharedStructure | None = None,
) -> xr.Dataset:  # fmt: skip
    """Compute the time history with energy ledger and slip fields.

    Parameters
    ----------
    checkpoint
        Checkpoint file; None writes none.
    resume
        Continue from the checkpoint.
    shared
        Structure of the histories computed before; prepared here by default.

    Raises
    ------
    ConvergenceError
        If a step does not converge; ``partial`` has the history up to that step.
    """
    solver = case.solver
    shared = SharedStructure(case, progress) if shared is None else shared
    saving = None if checkpoint is None else Checkpointing(checkpoint, solver.checkpoint_seconds, resume)
    run = _Integration(case, shared, progress)
    method, reason = solver.method, "the reduced model was too inaccurate in an earlier part of this run"
    fell_back = method == "reduced" and saved_method(saving) == "condensed"
    if not fell_back:
        try:
            history = run.history(method, saving)
        except ReductionError as error:
            if run.scheme.exact_modes:
                raise
            fell_back, reason = True, error.problem
            saving = None if saving is None else replace(saving, resume=False)
    if fell_back:
        progress.warning(f"{reason}: the run falls back to solver.method: condensed, which needs no reduced model")
        history = run.history("condensed", saving)
    estimate = history.attrs.get("reduction_error_estimate", 0.0)
    if estimate > run.largest_error:
        progress.warning(
            f"the estimated error of the reduced model is {100 * estimate:.1f} %: layers open and slide over "
            "large areas; compare with solver.method: condensed on a coarser mesh, or lower solver.reduction_tolerance"
        )
    for remark in (span_remark(history.attrs.get("span_error_estimate", 0.0)), subset_remark(history.attrs)):
        if remark:
            progress.warning(remark)
    return history


@dataclass(frozen=True)
class _Integration:
    """Time integration of a prepared case by any `solver.method`."""

    case: HistoryCase
    shared: SharedStructure
    progress: Progress

    @property
    def system(self) -> System:
        """Prepared system."""
        return self.shared.system

    @property
    def state(self) -> ContactState:
        """Preload state."""
        return self.shared.state

    @property
    def span(self) -> PathSpan | None:
        """Modes in the span of the path of a coil whose wraps slide; None for any other case."""
        if self.shared.span is None and slips_inside(self.case):
            self.shared.span = path_span(self.shared.case, self.system, self.state, self.progress)
        return self.shared.span

    @property
    def modes(self) -> Condensation | None:
        """Modes for `reduced` and for the run by `condensed` that may replace it; None for another `solver.method`."""
        if self.case.solver.method != "reduced":
            return None
        if self.shared.modes is None:
            self.shared.modes = modes_to_reduce(self.system, self.state, self.scheme, time_step(self.case))
        return self.shared.modes

    @property
    def scheme(self) -> Scheme:
        """Time integration scheme."""
        return Scheme.named(self.case.integrator.scheme, self.case.integrator.alpha)

    @property
    def largest_error(self) -> float:
        """Largest acceptable error estimate of the reduced model."""
        return max(LARGE_REDUCTION_ERROR, 5.0 * self.case.solver.reduction_tolerance)

    def history(self, method: str, saving: Checkpointing | None) -> xr.Dataset:
        """Compute the time history by ``method``."""
        case, solver, dt = self.case, self.case.solver, time_step(self.case)
        scheme = self.scheme
        options = NewtonOptions(solver.tolerance, solver.max_iterations, solver.max_cuts)
        stepper = self._stepper(method, scheme, options, dt)
        _remarks(case, stepper, self.progress)
        try:
            found = simulate(
                self.system, self.state, base_motion(case.excitation), dt=dt, scheme=scheme, options=options,
                grid=time_grid(case, _main_mode(stepper).get("stuck_resonance_hz")),
                progress=self.progress, checkpoint=saving, every=case.output.every, stepper=stepper,
                recover=partial(stress_of_displacement, self.system, self.state, self.progress),
            )  # fmt: skip
        except ConvergenceError as error:
            if error.partial is not None:
                error.partial = _described(error.partial, case, method)
            raise
        if isinstance(stepper, ReducedStepper):
            self.shared.basis = stepper.vectors, stepper.model.eigenvalues
        if missing := basis_remark(case, stepper):
            self.progress.warning(missing)
        found = annotate(with_yield(found, case))
        return _described(found, case, method).assign_attrs(_main_mode(stepper))

    def _stepper(self, method: str, scheme: Scheme, options: NewtonOptions, dt: float) -> Stepper:
        system, state, tolerance, span = self.system, self.state, self.case.solver.reduction_tolerance, self.span
        most = self.largest_error if 3 * system.n_points <= FALLBACK_SIZE else np.inf
        if self.case.solver.hyper_reduction and method == "reduced" and self.modes is not None:
            found = stepper_on_subset(self.case, system, state, self.modes, scheme, options, dt, most, self.progress)
            if found is not None:
                return found
        with self.progress.stage("set-up" if method == "full" else "condensation", 1) as stage:
            stepper: Stepper
            if span is not None:
                stepper = path_stepper(system, state, scheme, options, dt=dt, tolerance=tolerance, span=span)
            else:
                stepper = make_stepper(
                    system, state, method=method, scheme=scheme, options=options, dt=dt, reduction_tolerance=tolerance,
                    largest_error=most, condensation=self.modes,
                )  # fmt: skip
            if isinstance(stepper, ReducedStepper) and self.shared.basis is not None and not stepper.complete:
                stepper.adopt(ReducedModel.on(stepper.condensation, *self.shared.basis))
            stage.update(1)
        return stepper


def _main_mode(stepper: Stepper) -> dict[str, float]:
    if not isinstance(stepper, CondensedStepper | ReducedStepper):
        return {}
    frequency, participation = stepper.condensation.main_mode
    return {"stuck_resonance_hz": frequency, "tip_participation": participation}


def _remarks(case: HistoryCase, stepper: Stepper, progress: Progress) -> None:
    if text := band_remark(case):
        progress.warning(text)
    if not isinstance(stepper, CondensedStepper | ReducedStepper):
        return
    condensation = stepper.condensation
    if stepper.system.laws.stores_slip.all():  # a law without memory sticks nowhere
        frequency, modes = condensation.main_mode[0], len(condensation.eigenvalues)
        progress.info(f"resonance of the sticking roll: {frequency:.2f} Hz; {modes} modes")
    detuned = detuned_harmonic(case, condensation) if stepper.system.interfaces else ""
    for text in (detuned, unresolved_modes(case, condensation, time_step(case))):
        if text:
            progress.warning(text)
    if not condensation.exact and not isinstance(stepper, PathStepper):
        progress.warning(
            "cyclic symmetry cannot be used (the mesh has no rotational symmetry, or a matrix file contains damping or "
            "no subspaces): the structure is approximated by its lowest modes and its responses to loads, with an "
            "error of about 1e-4 of the largest displacement; use solver.method: full for the exact solution"
        )


def _described(dataset: xr.Dataset, case: HistoryCase, method: str) -> xr.Dataset:
    excitation = case.excitation
    direction = "of the file" if isinstance(case, OnStructure) else excitation.direction
    attrs = {"excitation_kind": excitation.kind, "excitation_direction": direction, **excitation.attributes}
    highest = excited_to(case)
    attrs |= {"excited_to_hz": highest, "period_error_at_highest": period_error(case, highest)}
    return dataset.assign_attrs(attrs | {"method": method, "steps_per_cycle": steps_per_cycle(case)})
