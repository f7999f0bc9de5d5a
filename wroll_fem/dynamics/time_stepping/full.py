"""The reference: the whole structure in every step, sparse Newton, no condensation."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact import kernels
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.stepper import (
    CONTACT,
    FRICTION,
    IMPACT,
    INPUT,
    INTERFACE,
    ITERATIONS,
    KINETIC,
    MODULATION,
    NUMERICAL,
    OPEN,
    SLIPPING,
    STRAIN,
    VISCOUS,
    NewtonOptions,
    Stepper,
)
from wroll_fem.dynamics.time_stepping.uniqueness import check_unambiguous
from wroll_fem.numerics.linear import Factorisation, factorise
from wroll_fem.typing import FloatArray

FULL_NEWTON_RATE = 0.1
"""A kept factorisation is renewed when an iteration reduces the residual by less than this."""


class FullStepper(Stepper):
    """Sparse Newton on all DOFs; shares only the contact law with the condensed path."""

    state_names = ("w", "v", "a", "residual", "residual_change", "jump", "elastic_slip", "traction")

    def __init__(self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions):
        super().__init__(system, preload, scheme, options)
        n = system.n_dofs
        self.w, self.v, self.a = np.zeros(n), np.zeros(n), np.zeros(n)
        self.residual, self.residual_change = np.zeros(n), np.zeros(n)
        self.jump, self.elastic_slip = preload.jump.copy(), preload.elastic_slip.copy()
        self.traction = preload.traction.copy()
        self.inertia = system.mass @ system.influence
        self.trial = TrialContact(system)
        self._factor: tuple[float, Factorisation] | None = None
        self._longest_step = 0.0  # checked so far
        self.last_history = []

    def displacement(self) -> FloatArray:
        """(n_dofs,) displacement relative to the preload state, m."""
        return self.w.copy()

    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector and inertia force (n_dofs,) of a unit base acceleration."""
        return self.system.influence, self.inertia

    def start_from(self, displacement: FloatArray) -> None:
        """Release from rest at ``displacement`` (n_dofs,) in m, on top of the preload state."""
        system = self.system
        self.w[:] = displacement
        jump = self.preload.jump + system.jump @ displacement
        traction = self.trial(jump, self.preload)
        self.jump[:], self.elastic_slip[:], self.traction[:] = jump, self.trial.elastic_slip, traction
        change = system.weights * (traction - self.preload.traction)
        self.residual[:] = system.stiffness @ self.w + system.jump.T @ change
        self.a[:] = -factorise(system.mass).solve(self.residual)

    def _committed(self) -> ContactState:
        return ContactState(self.w, self.jump, self.elastic_slip, self.traction, self.trial.status)

    def _solve(self, history_term: FloatArray, ag: float, dt: float) -> tuple[FloatArray, FloatArray, int] | None:
        """Newton for the new displacement (n,) and residual r (n,); None when it does not converge."""
        system, s, t_0 = self.system, self.scheme, self.preload.traction
        inertia_factor, velocity_factor = 1.0 / (s.beta * dt**2), s.gamma / (s.beta * dt)
        damping = system.damping
        coasting = self._coasting(dt)  # velocity at the end of a step that does not move
        state = self._committed()
        w = self.w.copy()
        self.last_history = []

        def imbalance(w: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            jump = self.preload.jump + system.jump @ w
            traction = self.trial(jump, state, dt)
            r = system.stiffness @ w + system.jump.T @ (system.weights * (traction - t_0)) + self.inertia * ag
            if damping is not None:
                r += damping @ (coasting + velocity_factor * w)
            out = system.mass @ (inertia_factor * w) - history_term + (1.0 + s.alpha) * r
            return out, r, jump

        force, r, jump = imbalance(w)
        size = np.inf
        for iteration in range(1, self.options.max_iterations + 1):
            kept = self._factor
            if kept is None or kept[0] != dt:
                tangent = self.trial.stiffness(jump, state, dt=dt)
                matrix = system.mass * inertia_factor + (1.0 + s.alpha) * (
                    system.stiffness + system.jump.T @ sp.diags(system.weights) @ tangent @ system.jump
                )
                if damping is not None:
                    matrix += (1.0 + s.alpha) * velocity_factor * damping
                self._factor = factor = dt, factorise(matrix)
            else:
                factor = kept
            step = factor[1].solve(force)
            jump_step = system.jump @ step if system.n_points else step
            new = float(np.abs(jump_step).max(initial=0.0))
            self.last_history.append(new)
            stretch, before = 1.0, float(np.linalg.norm(force))
            force, r, jump = imbalance(w - step)
            if new <= self.residual_limit:
                return w - step, r, iteration
            # stick, slip and opening make the residual piecewise smooth: full steps of a new tangent may alternate
            while factor is not kept and stretch > 0.1 and not np.linalg.norm(force) < before:
                stretch *= 0.5
                force, r, jump = imbalance(w - stretch * step)
            w -= stretch * step
            if new > FULL_NEWTON_RATE * size:
                self._factor = None
            size = new
        self._factor = None
        return None

    def _coasting(self, dt: float) -> FloatArray:
        """(n,) the part of Newmark's new velocity that does not depend on the new displacement, m/s."""
        s = self.scheme
        h = (self.w + dt * self.v + dt**2 * (0.5 - s.beta) * self.a) / (s.beta * dt**2)
        return self.v + dt * ((1.0 - s.gamma) * self.a - s.gamma * h)

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance by sparse Newton on all DOFs; see `Stepper.try_steps`."""
        system, s = self.system, self.scheme
        self._factor = None  # so that a restored run repeats the same numbers
        if dt > self._longest_step:
            check_unambiguous(system, self.preload, s, dt)
            self._longest_step = dt
        for step in range(len(acceleration) - 1):
            ag, ag_new = float(acceleration[step]), float(acceleration[step + 1])
            h = (self.w + dt * self.v + dt**2 * (0.5 - s.beta) * self.a) / (s.beta * dt**2)
            solved = self._solve(system.mass @ h + s.alpha * self.residual, ag_new, dt)
            if solved is None:
                return step
            w, r, iterations = solved
            a = w / (s.beta * dt**2) - h
            v = self.v + dt * ((1.0 - s.gamma) * self.a + s.gamma * a)
            du, da, dr = w - self.w, a - self.a, r - self.residual
            m_da = system.mass @ da
            mean_a = 0.5 * (a + self.a)
            self.flows[0] -= 0.5 * (ag + ag_new) * (self.inertia @ du)
            self.flows[1] += 0.5 * s.alpha * du @ (dr + self.residual_change) - (s.gamma - 0.5) * du @ m_da
            self.flows[1] += dt**2 * (s.beta - 0.5 * s.gamma) * (mean_a @ m_da + (s.gamma - 0.5) * da @ m_da)
            if system.damping is not None:
                self.flows[2] += 0.5 * du @ (system.damping @ (v + self.v))
            jump = self.preload.jump + system.jump @ w
            kernels.interface_work(
                self.jump, self.elastic_slip, self.traction, jump, self.trial.elastic_slip, self.trial.traction,
                system.laws, self.totals,
            )  # fmt: skip
            kernels.record_slip(
                self.jump, self.elastic_slip, jump, self.trial.elastic_slip, self.preload.jump, self.trial.status,
                self.slip.path, self.slip.peak, self.slip.peak_vector,
            )  # fmt: skip
            self.w[:], self.v[:], self.a[:], self.residual[:], self.residual_change[:] = w, v, a, r, dr
            self.jump[:], self.elastic_slip[:], self.traction[:] = jump, self.trial.elastic_slip, self.trial.traction
            self._record(records[step], iterations)
        return len(acceleration) - 1

    def _record(self, row: FloatArray, iterations: int) -> None:
        system = self.system
        tip = system.probes["tip"]
        row[0], row[1], row[2] = tip @ self.w, tip @ self.v, tip @ self.a
        row[KINETIC] = 0.5 * self.v @ (system.mass @ self.v)
        change = self.jump - self.preload.jump
        row[STRAIN] = 0.5 * self.w @ (system.stiffness @ self.w) - (system.weights * self.preload.traction) @ change
        row[INPUT], row[NUMERICAL], row[VISCOUS] = self.flows
        row[FRICTION], row[CONTACT], row[MODULATION], row[INTERFACE], row[IMPACT] = self.totals
        row[ITERATIONS] = iterations
        if system.n_points:
            row[OPEN] = np.mean(self.trial.status == kernels.OPEN)
            row[SLIPPING] = np.mean(self.trial.status == kernels.SLIP)
