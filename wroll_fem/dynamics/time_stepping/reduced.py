r"""Time integration in reduced coordinates with residual checks, enrichment of the basis and an error estimate.

The basis starts from the modes that the base excites and the static responses; it is enriched during the run. After
every block of steps the residual r of the full model is evaluated at some of the steps. The projection error
is the part of the static response :math:`K_0^{-1} r` outside the basis (`ReducedModel.projection_error`): motion
outside the basis is quasi-static. If it exceeds a small fraction of the motion in the energy norm, its principal shapes
are added to the basis and the block is repeated from its start. Every accepted step is therefore computed in a
sufficient basis, and the remaining projection error gives the error estimate.

The estimate holds for contact that slides and stays closed. Where points open, layers strike each other, and impacts
excite modes outside the basis, which then do not respond quasi-statically; `reduction.error_estimate` accounts for
this. An interface that can open and carries no pressure does not hold its layers: the structure K_0 has unrestrained
parts, and the run is refused.

References
----------
Krysl, Lall, Marsden (2001), Int. J. Numer. Meth. Engng 51, 479, doi:10.1002/nme.167 (POD in structural dynamics).
"""

from __future__ import annotations

import time as clock
from typing import ClassVar

import numpy as np
import scipy.linalg as la

from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.error_estimate import estimate
from wroll_fem.dynamics.reduction.evaluated_points import EvaluatedPoints
from wroll_fem.dynamics.reduction.modal_step import modal_step
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel, modal_force
from wroll_fem.dynamics.reduction.stuck_modes import modes_to_reduce, most_excited
from wroll_fem.dynamics.statics.contact_state import ContactState, contact_energy_limit, open_fraction, unpressed
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import OPEN
from wroll_fem.dynamics.time_stepping.reduced_kernel import (
    KeptMatrix,
    ReducedInterface,
    ReducedState,
    ResidualChecks,
    advance_reduced,
    sum_up,
)
from wroll_fem.dynamics.time_stepping.state import Accumulated, ContactMemory, Modal, Motion, Newton
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.dynamics.time_stepping.uniqueness import check_step_uniqueness
from wroll_fem.errors import ReductionError
from wroll_fem.typing import FloatArray

BLOCK = 50
"""Number of time steps in a block. A block of steps is repeated when the basis is enriched."""

CHECK_EVERY = 17
"""Number of steps between two residual checks. It does not divide the usual numbers of steps per cycle, so that all
phases of a cycle are checked.
The last step of a block of time steps is checked as well: a growing motion is largest there. Where contact points are
open, turning points of the motion are checked too (`reduced_kernel.turns`)."""

SHAPE_SHARE = 0.3
"""Energy norm of a principal shape of the projection error, relative to the tolerance, above which the shape is added
to the basis."""

CONTACT_SHARE = 2.0
"""Largest energy norm of the motion that enters the error estimate at a residual check, divided by sqrt(2 E), where
E (J) is `contact_energy_limit`. A larger norm is replaced by this limit, because a loose contact slides and opens under
forces that are small compared with those of the motion."""

FLOATING = 1e-12
"""Lowest eigenvalue of the structure with its interfaces stuck, relative to the highest eigenvalue, below which a part
of the structure counts as unrestrained."""

START_MODES, LARGEST = 12, 400
"""Number of reduced coordinates at the start, and the largest one; a run that needs more stops with an error."""

MANY = 150
"""Number of reduced coordinates, or half the number of contact points if that is more, from which a run that may fall
back to `condensed` does so, since it is as fast."""


class ReducedStepper(Stepper):
    """Time stepping in reduced coordinates, whose basis is enriched during the run; used like `CondensedStepper`.

    Parameters
    ----------
    tolerance
        Largest projection error in a block of steps, relative to the largest motion so far, both in the energy norm.
    largest_error
        Error estimate above which a run stops with `ReductionError`; not checked by default.
    condensation
        Modes from `modes_to_reduce`; computed if it is None.

    Attributes
    ----------
    model
        The current reduced model.
    points
        Contact points at which the laws are evaluated.
    """

    name = "reduced"
    block: ClassVar[int] = BLOCK
    check_every: ClassVar[int] = CHECK_EVERY
    remedy: ClassVar[str] = "use solver.method: condensed, or raise solver.reduction_tolerance"
    state: ReducedState

    def __init__(
        self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float,
        tolerance: float = 2e-3, largest_error: float = np.inf, condensation: Condensation | None = None,
    ):  # fmt: skip
        super().__init__(system, preload, scheme, options)
        check_step_uniqueness(system, preload, scheme, dt)
        self._checked: list[FloatArray] = []
        self.condensation = condensation or modes_to_reduce(system, preload, scheme, dt)
        self.tolerance, self.largest_error = tolerance, largest_error
        self._open_at_rest = open_fraction(system, preload)
        energy = contact_energy_limit(system.laws, preload.pressure) if system.n_points else np.inf
        self._contact = CONTACT_SHARE * np.sqrt(2.0 * energy)
        self.vectors = np.zeros((len(self.condensation.eigenvalues), 0))
        self.evaluate(EvaluatedPoints.of(system.laws, preload, self.condensation.springs))
        self.adopt(self._first_model())

    def evaluate(self, points: EvaluatedPoints) -> None:
        """Start from rest with the laws evaluated at ``points``."""
        self.points, reference = points, points.reference
        memory = ContactMemory(reference.jump.copy(), reference.elastic_slip.copy(), reference.traction.copy())
        self.state, self.accumulated = self._empty_state(self.vectors.shape[1], memory), Accumulated.zeros(points.n)
        for c, dofs in enumerate(contact_dofs(points.n).T):
            self.state.kept.tangents[:, c, c] = reference.springs[dofs]

    def _empty_state(self, m: int, contact: ContactMemory) -> ReducedState:
        """State at rest in ``m`` reduced coordinates, with the contact state ``contact``."""
        return ReducedState(Motion.zeros(m), contact, np.zeros(m), empty_matrix(m, contact), *np.zeros((6, 1)))

    def _first_model(self) -> ReducedModel:
        """Reduced model at the start: all modes if they are at most 2 `START_MODES`.

        Else the `START_MODES` modes that the base excites most, and the static responses to base motion and tip force.
        """
        c = self.condensation
        if len(c.eigenvalues) <= 2 * START_MODES:
            return ReducedModel.complete(c)
        if c.eigenvalues.min() <= 0.0:  # no static response; rounding decides about the sign of a floating part
            self._check_held(0.0)
        static = c.base / c.eigenvalues, c.tip / c.eigenvalues
        return ReducedModel.of_vectors(c, np.column_stack([*static, most_excited(c, START_MODES)]))

    def _check_held(self, time: float) -> None:
        """Raise a ReductionError if a part of the structure is unrestrained."""
        values = self.condensation.eigenvalues
        if unpressed(self.system, self.preload):
            raise self._refused("an interface carries no pressure: its layers are not held in the reduced model", time)
        if values.min() < FLOATING * values.max():
            raise self._refused("neither friction nor a support holds a layer in the reduced model", time)

    def _refused(self, message: str, time: float, residuals: FloatArray | None = None) -> ReductionError:
        history = [] if residuals is None else residuals[:5].tolist()
        return ReductionError(message, time_s=time, iterations=0, residual_history=history, advice=self.remedy)

    def adopt(self, model: ReducedModel) -> None:
        """Use a model whose basis contains the current one; the state is converted to the new coordinates."""
        self.state = self._turned(model.vectors.T @ self.vectors)
        self._use(model)
        self.state.time_step[0] = 0.0  # the kept matrix belonged to the old coordinates

    def _turned(self, turn: FloatArray) -> ReducedState:
        """State in m new coordinates; ``turn`` (m, present coordinates) projects the present ones on the new basis."""
        state, m = self.state, len(turn)
        if turn.shape[1]:
            motion, before = Motion(*(turn @ part for part in state.motion)), turn @ state.q_before
        else:
            motion, before = Motion.zeros(m), np.zeros(m)
        kept = state.kept._replace(matrix=np.zeros((m, m)), inverse=np.zeros((m, m)))
        return state._replace(motion=motion, q_before=before, kept=kept)

    def _use(self, model: ReducedModel) -> None:
        self.model, self.vectors = model, model.vectors
        self._steps: dict[float, Modal] = {}  # by step size, for this model
        jump = np.asfortranarray(model.jump[self.points.dofs])  # products with it and its transpose are faster
        # largest displacement jump that a unit coordinate makes: a residual in coordinates is bounded in metres
        weight = np.abs(jump).max(axis=0, initial=0.0)
        if not self.points.n:
            weight = np.abs(model.tip) + 1e-12
        force = np.ascontiguousarray((jump * self.points.weights[:, None]).T)
        self._interface = ReducedInterface(jump, force, weight)
        c = self.condensation
        self._inertia = model.vectors / c.eigenvalues[:, None]
        self._dashpots = c.viscous_force(model.vectors) / c.eigenvalues[:, None] if c.damping else None

    def displacement(self) -> FloatArray:
        """(n_dofs,) displacement relative to the preload state, m."""
        return self.condensation.displacement(self.vectors @ self.state.motion.q)

    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector i (m,) and M i (m,) in reduced coordinates; they are equal because M is the identity."""
        return self.model.base, self.model.base

    def snapshot(self) -> dict[str, np.ndarray]:
        """Copy of the state needed to continue the run; the basis, which is never modified in place, is shared."""
        return super().snapshot() | {"vectors": self.vectors, "values": self.model.eigenvalues}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Return to the state and the basis of a `snapshot`."""
        if state["vectors"] is not self.vectors:
            model = ReducedModel.on(self.condensation, state["vectors"], np.array(state["values"]))
            self.state = self._empty_state(model.size, self.state.contact)
            self._use(model)
        super().restore(state)

    def _prepare(self, dt: float) -> Modal:
        """Matrices of the reduced structure for steps of ``dt`` (s); a new step or basis has a new Newton's matrix."""
        s, model, kept = self.scheme, self.model, self.state.kept
        if dt not in self._steps:
            self._steps[dt] = modal_step(model, () if model.damping is None else (model.damping,), s, dt)
        modal = self._steps[dt]
        if self.state.time_step[0] != dt:
            area, springs = self.points.laws.area, self.points.reference.springs
            sum_up(kept, springs, self._interface.jump, area, 1.0 + s.alpha, modal)
            kept.inverse[:] = la.inv(kept.matrix)
            self.state.time_step[0] = dt
        return modal

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance in the compiled loop; see `Stepper.try_steps`."""
        m, n, most = self.model.size, self.points.n, self.options.max_iterations
        modal = self._prepare(dt)
        newton = Newton(self.residual_limit, most, np.zeros(most + 1))
        rows = np.zeros((len(acceleration), 3 * m + 3 * n + 1))  # any step may be checked
        checks = ResidualChecks(self.check_every, rows, np.zeros(1, np.int64))
        done = self._run_loop(acceleration, dt, modal, newton, checks, records)
        if done < len(acceleration) - 1:
            self.last_history = [float(h) for h in newton.history if h > 0.0]
        self._checked.append(rows[: checks.filled[0]])
        return int(done)

    def _run_loop(
        self, acceleration: FloatArray, dt: float, modal: Modal, newton: Newton, checks: ResidualChecks,
        records: FloatArray,
    ) -> int:  # fmt: skip
        """Run the compiled loop of the scheme; returns the number of completed steps. For `try_steps`."""
        return advance_reduced(
            np.ascontiguousarray(acceleration), self.step(dt), modal, self._interface, self.points.reference,
            self.points.laws, self.state, newton, self.accumulated, checks, records,
        )  # fmt: skip

    def advance(self, acceleration: FloatArray, dt: float, time: float) -> FloatArray:
        """Advance k time steps, in blocks of `block` steps.

        If the basis is insufficient for a block, it is enriched and the block is repeated.

        Raises
        ------
        ReductionError
            If a part of the structure is unrestrained, the basis becomes too large, or the error estimate exceeds its
            limit.
        """
        if not self.complete:
            self._check_held(time)
        size = self.block
        blocks = range(0, len(acceleration) - 1, size)
        return np.vstack([self._advance_block(acceleration[i : i + size + 1], dt, time + i * dt) for i in blocks])

    def _advance_block(self, acceleration: FloatArray, dt: float, time: float) -> FloatArray:
        start, redone = self.snapshot(), 0.0
        while True:
            self._checked = []
            began = clock.process_time()
            records = super().advance(acceleration, dt, time)
            stepped = clock.process_time()
            error, motion = self._check_residuals()
            state = self.state
            largest = max(float(state.largest[0]), float(motion.max(initial=0.0)))
            share = np.sqrt(error.max(initial=0.0) / largest) if largest > 0 else 0.0
            if share <= self.tolerance or self.complete:
                state.projection_error[:] += error.sum()
                state.motion_norm[:] += np.minimum(motion, self._contact**2).sum()
                state.largest[0] = largest
                state.training[0] += redone + clock.process_time() - stepped
                self._accept(records, time)
                return records
            self.restore(start)
            self._enrich(self.tolerance * np.sqrt(largest), time)
            start = self.snapshot()
            redone += clock.process_time() - began

    def _accept(self, records: FloatArray, time: float) -> None:
        """Take note of the opening in a block of steps; raise a ReductionError if `stopping_error` is too large."""
        opened = np.abs(records[:, OPEN] - self._open_at_rest).max(initial=0.0)
        self.state.opened[0] = max(float(self.state.opened[0]), float(opened))
        if (error := self.stopping_error) > self.largest_error:
            raise self._refused(f"the error of the reduced model reaches {100 * error:.2g} %", time)

    def _check_residuals(self) -> tuple[FloatArray, FloatArray]:
        """Squared energy norms of the projection error (k,) and of the motion (k,) at the k residual checks, J.

        The static response to the residual is the sum of its part in the basis and the projection error. These two
        are orthogonal in the energy inner product. The elastic force of the motion has no part outside the basis.
        """
        q, response, inside = self._at_checks()
        total = self.model.energy_norm(response) ** 2
        return (
            np.maximum(total - np.sum(inside**2 / self.model.eigenvalues[:, None], axis=0), 0.0),
            np.sum(self.model.eigenvalues[:, None] * q**2, axis=0),
        )

    def _at_checks(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Displacement, static response to the residual force, and reduced residual force, at the k residual checks.

        The shapes are (m, k), (r, k) and (m, k) for m reduced coordinates and r modes.
        """
        m, n = self.model.size, self.points.n
        rows = np.vstack(self._checked) if self._checked else np.zeros((0, 3 * m + 3 * n + 1))
        q, a, v = rows[:, :m].T, rows[:, m : 2 * m].T, rows[:, 2 * m : 3 * m].T
        s, base = rows[:, 3 * m : -1].T, rows[:, -1]
        inside = self._interface.force @ s + a + np.outer(self.model.base, base)
        if self.model.damping is not None:
            inside += self.model.damping @ v
        return q, self._static_response(a, v, s, base), inside

    def _static_response(self, a: FloatArray, v: FloatArray, s: FloatArray, base: FloatArray) -> FloatArray:
        """(r, k) static response, in r modal coordinates, to the residual force at the k residual checks.

        The residual force is the sum of the forces of inertia, dashpots, interfaces and base motion.
        """
        c = self.condensation
        response = self._inertia @ a + np.outer(c.base / c.eigenvalues, base)
        if self.system.n_points:
            response += modal_force(c, self.system.weights[:, None] * s) / c.eigenvalues[:, None]
        if self._dashpots is not None:
            response += self._dashpots @ v
        return response

    def _enrich(self, level: float, time: float) -> None:
        """Add the principal shapes of the projection error whose energy norm exceeds `SHAPE_SHARE` times ``level``."""
        _, response, inside = self._at_checks()
        lacking = self.model.projection_error(response, inside)
        root = np.sqrt(self.condensation.eigenvalues)[:, None]
        left, size, _ = la.svd(root * lacking, full_matrices=False)
        keep = size > SHAPE_SHARE * level
        keep[0] = True
        model = self.model.enriched(left[:, keep] / root)
        if model.size > self.largest_basis or model.size == self.model.size:
            problem = f"the reduced model does not follow the motion with {self.model.size} coordinates"
            raise self._refused(problem, time, size)
        self.adopt(model)

    @property
    def largest_basis(self) -> int:
        """Largest number of reduced coordinates: `LARGEST`, or fewer where the run may fall back; see `MANY`."""
        stays = np.isinf(self.largest_error) or self.scheme.exact_modes
        return LARGEST if stays else min(LARGEST, max(MANY, self.system.n_points // 2))

    def report(self) -> dict[str, float]:
        """Number of reduced coordinates, error estimate, and CPU time of the training of the basis, s."""
        return {
            "reduced_coordinates": self.model.size,
            "reduction_error_estimate": self.error_estimate,
            "training_time_s": float(self.state.training[0]),
        }

    @property
    def error_estimate(self) -> float:
        """Root-mean-square projection error during the run, relative to the motion, both in the energy norm.

        The motion is limited by `CONTACT_SHARE`; see `reduction.error_estimate` for points that open.
        """
        state = self.state
        return estimate(*(float(part[0]) for part in (state.projection_error, state.motion_norm, state.opened)))

    @property
    def stopping_error(self) -> float:
        """Error that stops a run once it exceeds its limit."""
        return self.error_estimate

    @property
    def complete(self) -> bool:
        """Whether the basis contains all modes, so that the model is exact."""
        return self.model.size == len(self.condensation.eigenvalues)


def empty_matrix(m: int, contact: ContactMemory) -> KeptMatrix:
    """Newton's matrix of ``m`` reduced coordinates before it is assembled."""
    return KeptMatrix(
        np.zeros((len(contact.jump) // 3, 3, 3)), np.zeros((m, m)), np.zeros((m, m)), np.zeros(1, np.int64)
    )
