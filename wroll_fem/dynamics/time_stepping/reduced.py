r"""Time integration in reduced coordinates, with a residual check against the whole structure and enrichment.

The span starts from the modes that the base excites and the static responses; it grows by itself. After every
block of steps the equations of the *whole* structure are evaluated at some of them. What they ask for outside
the span, :math:`K_0^{-1} r` (`ReducedModel.missing`), moves quasi-statically; where it exceeds a small fraction of the
motion's energy norm, its principal shapes join the span and the block is done again from its start. So every step
that is kept was done in a span that was good enough for it, and the share still missing is the error estimate.

References
----------
Krysl, Lall, Marsden (2001), Int. J. Numer. Meth. Engng 51, 479, doi:10.1002/nme.167 (POD in structural dynamics).
"""

from __future__ import annotations

import time as clock

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel, modal_force
from wroll_fem.dynamics.statics.contact_springs import reference_stiffness
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.reduced_kernel import advance_reduced, sum_up
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.dynamics.time_stepping.uniqueness import check_unambiguous
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.typing import FloatArray

BLOCK = 50
"""Steps that are done again when the span is enriched."""

LOOK_EVERY = 17
"""Steps between two evaluations of the whole structure; no divisor of the usual steps per cycle, to see all phases.

The last step of a block is looked at as well, or growing motions would outrun the span."""

ENERGY_SHARE = 1e-3
"""Principal shapes of what is missing join the span down to this share of the largest one's amplitude."""

CONTACT_SHARE = 2.0
"""In the error estimate the motion counts up to this multiple of what the preloaded contact can hold (energy norms): a
loose contact slides and opens under forces that are small against those of the motion."""

LARGEST = 400
"""Coordinates beyond which a reduced model is none; the run stops and says so."""

START_MODES = 12


class ReducedStepper(Stepper):
    """Time stepping in a span that grows with the motion; interface as `CondensedStepper`.

    Attributes
    ----------
    model
        The current reduced model.
    missing, moved
        Sums over the looks of the squared energy norms of what the span missed, and of the motion.
    """

    state_names = (
        "values", "q", "v", "a", "residual", "residual_change", "q_before", "jump", "elastic_slip",
        "traction", "held", "matrix", "solver", "renewals", "missing", "moved", "largest", "time_step",
        "training",
    )  # fmt: skip

    def __init__(
        self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float,
        tolerance: float = 2e-3,
    ):  # fmt: skip
        super().__init__(system, preload, scheme, options)
        if system.damping is not None:
            raise InputError(
                "reduced time stepping has no viscous damping", key="solver.method", remedy="use full, or harmonic"
            )
        check_unambiguous(system, preload, scheme, dt)
        self._looks: list[FloatArray] = []
        self.condensation = condense(system, reference_stiffness(system, preload, dt), scheme, dt)
        self.tolerance = tolerance
        n = system.n_points
        self.jump, self.elastic_slip = preload.jump.copy(), preload.elastic_slip.copy()
        self.traction = preload.traction.copy()
        self.held = np.zeros((n, 3, 3))
        for c in range(3):
            self.held[:, c, c] = self._by_point(self.condensation.springs)[:, c]
        self.renewals = np.zeros(1, np.int64)
        self._contact = CONTACT_SHARE * np.sqrt(2.0 * held_energy(system, preload)) if n else np.inf
        self.missing, self.moved, self.largest, self.time_step = np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(1)
        self.training = np.zeros(1)  # CPU seconds spent on looks, enrichment and steps done again
        self.matrix, self.solver = np.zeros((0, 0)), np.zeros((0, 0))
        self.last_history = []
        self.q = self.v = self.a = self.residual = self.residual_change = self.q_before = np.zeros(0)
        self.vectors = np.zeros((len(self.condensation.eigenvalues), 0))
        self._adopt(self._first_model())

    def _by_point(self, slots: FloatArray) -> FloatArray:
        """(n, 3) hoop, axial, normal of an array (3 n,) in slot order."""
        n = self.system.n_points
        return np.column_stack([slots[: 2 * n].reshape(n, 2), slots[2 * n :]])

    def _first_model(self) -> ReducedModel:
        """Modes that the base excites most, static response to base acceleration and to a force at the tip."""
        c = self.condensation
        if len(c.eigenvalues) <= 2 * START_MODES:
            return ReducedModel.complete(c)
        participation = np.abs(c.base) / c.eigenvalues
        modes = np.argsort(-participation)[:START_MODES]
        unit = np.zeros((len(c.eigenvalues), START_MODES))
        unit[modes, np.arange(START_MODES)] = 1.0
        return ReducedModel.of_vectors(c, np.column_stack([c.base / c.eigenvalues, c.tip / c.eigenvalues, unit]))

    def _adopt(self, model: ReducedModel) -> None:
        """Take over a model whose span holds the present one's; the state is the same motion in new coordinates."""
        turn = model.vectors.T @ self.vectors
        for name in ("q", "v", "a", "residual", "residual_change", "q_before"):
            setattr(self, name, turn @ getattr(self, name) if self.vectors.shape[1] else np.zeros(model.size))
        self._use(model)
        self.matrix, self.solver = np.zeros((2, model.size, model.size))
        self.time_step[0] = 0.0  # the kept matrix belonged to the old coordinates

    def _use(self, model: ReducedModel) -> None:
        self.model, self.vectors, self.values = model, model.vectors, model.eigenvalues
        self._operator = np.ascontiguousarray(model.jump)
        self._force = np.ascontiguousarray((model.jump * self.system.weights[:, None]).T)
        self._inertia = model.vectors / self.condensation.eigenvalues[:, None]
        # largest displacement jump that a unit coordinate makes: a residual in coordinates is bounded in metres
        self._weight = np.abs(model.jump).max(axis=0, initial=0.0)
        if not self.system.n_points:
            self._weight = np.abs(model.tip) + 1e-12

    def displacement(self) -> FloatArray:
        """(n_dofs,) displacement relative to the preload state, m."""
        return self.condensation.displacement(self.vectors @ self.q)

    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector and inertia force (m,) of a unit base acceleration: the reduced mass is 1."""
        return self.model.base, self.model.base

    def snapshot(self) -> dict[str, np.ndarray]:
        """Copy of everything the future depends on; the span, large and never changed in place, goes by reference."""
        return super().snapshot() | {"vectors": self.vectors}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Return to a `snapshot`, in the span it was taken in."""
        if state["vectors"] is not self.vectors:
            for name in ("q", "v", "a", "residual", "residual_change", "q_before", "matrix", "solver"):
                setattr(self, name, np.array(state[name]))
            self._use(ReducedModel.on(self.condensation, state["vectors"], np.array(state["values"])))
        super().restore(state)

    def _prepare(self, dt: float) -> FloatArray:
        """Modal factor (m,) of a step; sums Newton's matrix up anew when the step or the span changed."""
        s = self.scheme
        inverse = 1.0 / (1.0 / (s.beta * dt**2) + (1.0 + s.alpha) * self.model.eigenvalues)
        if self.time_step[0] != dt:
            sum_up(
                self.held, self.condensation.springs, self._operator, self.system.laws.area, 1.0 + s.alpha, inverse,
                self.matrix,
            )  # fmt: skip
            self.solver[:] = la.inv(self.matrix)
            self.time_step[0] = dt
        return inverse

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance in the compiled loop; see `Stepper.try_steps`."""
        s, model, n = self.scheme, self.model, self.system.n_points
        inverse = self._prepare(dt)
        history = np.zeros(self.options.max_iterations + 1)
        looks = np.zeros((len(acceleration) // LOOK_EVERY + 2, 2 * model.size + 3 * n + 1))
        count = np.zeros(1, np.int64)
        done = advance_reduced(
            np.ascontiguousarray(acceleration), dt, s.alpha, s.beta, s.gamma,
            model.eigenvalues, self._operator, self._force, model.base, model.tip, model.springs, inverse, self._weight,
            self.preload.jump, self.preload.traction, self.system.laws,
            self.q, self.v, self.a, self.residual, self.residual_change, self.q_before,
            self.jump, self.elastic_slip, self.traction, self.held, self.matrix, self.solver, self.renewals,
            self.totals, self.flows, self.slip.path, self.slip.peak, self.slip.peak_vector,
            self.residual_limit, self.options.max_iterations, history, records,
            LOOK_EVERY, looks, count,
        )  # fmt: skip
        if done < len(acceleration) - 1:
            self.last_history = [float(h) for h in history if h > 0.0]
        self._looks.append(looks[: count[0]])
        return int(done)

    def advance(self, acceleration: FloatArray, dt: float, time: float) -> FloatArray:
        """Advance k steps, block by block; where the span proves too small for a block, enrich it and do it again."""
        blocks = range(0, len(acceleration) - 1, BLOCK)
        return np.vstack([self._advance_block(acceleration[i : i + BLOCK + 1], dt, time + i * dt) for i in blocks])

    def _advance_block(self, acceleration: FloatArray, dt: float, time: float) -> FloatArray:
        start, redone = self.snapshot(), 0.0
        while True:
            self._looks = []
            began = clock.process_time()
            records = super().advance(acceleration, dt, time)
            stepped = clock.process_time()
            missing, moved = self._look()
            largest = max(float(self.largest[0]), float(moved.max(initial=0.0)))
            share = np.sqrt(missing.max(initial=0.0) / largest) if largest > 0 else 0.0
            if share <= self.tolerance or self.model.size == len(self.condensation.eigenvalues):
                self.missing += missing.sum()
                self.moved += np.minimum(moved, self._contact**2).sum()
                self.largest[0] = largest
                self.training[0] += redone + clock.process_time() - stepped
                return records
            self.restore(start)
            self._enrich(self.tolerance * np.sqrt(largest), time)
            start = self.snapshot()
            redone += clock.process_time() - began

    def _look(self) -> tuple[FloatArray, FloatArray]:
        """Squared energy norms (k,) of what the span misses at the looks, and of the motion there.

        The static response to the residual r is the sum of its part in the span and of the missing part, which
        are orthogonal in energy; the elastic force of the motion itself asks for nothing outside.
        """
        q, response, inside = self._at_looks()
        total = self.model.energy_norm(response) ** 2
        return (
            np.maximum(total - np.sum(inside**2 / self.model.eigenvalues[:, None], axis=0), 0.0),
            np.sum(self.model.eigenvalues[:, None] * q**2, axis=0),
        )

    def _at_looks(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coordinates q (m, k) at the looks, static response (r, k) to the residual force there, the force (m, k)."""
        m, n = self.model.size, self.system.n_points
        rows = np.vstack(self._looks) if self._looks else np.zeros((0, 2 * m + 3 * n + 1))
        q, a, s, base = rows[:, :m].T, rows[:, m : 2 * m].T, rows[:, 2 * m : -1].T, rows[:, -1]
        inside = self._force @ s + a + np.outer(self.model.base, base)
        return q, self._static_response(a, s, base), inside

    def _static_response(self, a: FloatArray, s: FloatArray, base: FloatArray) -> FloatArray:
        """(r, k) response K_0^{-1} r to inertia, interfaces and base motion."""
        c = self.condensation
        values = c.eigenvalues[:, None]
        response = self._inertia @ a + np.outer(c.base / c.eigenvalues, base)
        if self.system.n_points:
            response += modal_force(c, self.system.weights[:, None] * s) / values
        return response

    def _enrich(self, level: float, time: float) -> None:
        """Add the principal shapes (energy inner product) of what is missing that exceed a part of ``level``."""
        _, response, inside = self._at_looks()
        lacking = self.model.missing(response, inside)
        root = np.sqrt(self.condensation.eigenvalues)[:, None]
        left, size, _ = la.svd(root * lacking, full_matrices=False)
        keep = size > 0.3 * level
        keep[0] = True
        model = self.model.enriched(left[:, keep] / root)
        if model.size > LARGEST or model.size == self.model.size:
            raise ConvergenceError(
                f"the reduced model does not follow the motion ({self.model.size} coordinates)",
                time_s=time,
                iterations=0,
                residual_history=[float(s) for s in size[:5]],
                advice="use solver.method: condensed, or raise solver.reduction_tolerance",
            )
        self._adopt(model)

    def report(self) -> dict[str, float]:
        """Size of the span, and what it missed."""
        return {
            "reduced_coordinates": self.model.size,
            "reduction_error_estimate": self.error_estimate,
            "training_time_s": float(self.training[0]),
        }

    @property
    def error_estimate(self) -> float:
        """Energy norm that the span missed over that of the motion, root mean square over the run, dimensionless.

        The motion counts up to `CONTACT_SHARE` of what the contact can hold.
        """
        return float(np.sqrt(self.missing[0] / self.moved[0])) if self.moved[0] > 0 else 0.0


def held_energy(system: System, preload: ContactState) -> float:
    """Energy in J that the contact holds when every point is about to slip at its preload pressure."""
    law, pressure = system.laws, preload.pressure
    return float(law.area @ (0.5 * pressure**2 / law.kn + 0.5 * law.mu * pressure * law.gamma))
