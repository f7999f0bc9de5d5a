"""The reference stepper: the full model is solved in every step by sparse Newton iterations."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact import kernels
from wroll_fem.dynamics.reduction.condensation import Condensation, condense
from wroll_fem.dynamics.statics.contact_springs import reference_stiffness
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import (
    FIRST_PROBE,
    INPUT_FLOW,
    KINETIC,
    NUMERICAL_FLOW,
    STRAIN,
    TIP_ACCELERATION,
    TIP_DISPLACEMENT,
    TIP_VELOCITY,
    VISCOUS_FLOW,
    record_contact,
    record_flows,
)
from wroll_fem.dynamics.time_stepping.state import ContactMemory, Motion
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.dynamics.time_stepping.uniqueness import check_step_uniqueness
from wroll_fem.numerics.linear import Factorisation, factorise
from wroll_fem.numerics.newton import FULL_RENEWAL
from wroll_fem.typing import FloatArray

MOST_REFINEMENTS, REFINED = 30, 1e-9
"""Largest number of corrections of a linear step for the dashpots of the modes, and relative change that ends them."""


class FullState(NamedTuple):
    """State of a run with the full method: motion of all DOFs, and contact."""

    motion: Motion
    contact: ContactMemory


def modal_force(modes: Condensation, mass: sp.csr_matrix, velocity: FloatArray) -> FloatArray:
    """(n_dofs,) forces of the dashpots of the modes, N, at the velocities (n_dofs,), m/s."""
    rates = np.concatenate(modes.damping)
    return np.asarray(mass @ modes.displacement(rates * modes.coordinates(mass @ velocity)))


class StepMatrix:
    """Factorised Newton matrix A of a time step, and dashpots of the modes, C, whose full matrix is never formed.

    While contact sticks, A is diagonal in the modes, and (A + C)^-1 is known. Where it slips, this is the start of an
    iteration that converges by a factor of the damping ratio or better.
    """

    def __init__(
        self,
        matrix: sp.csr_matrix,
        mass: sp.csr_matrix,
        modes: Condensation | None,
        weights: tuple[float, float, float],
    ):
        self.mass, self.modes = mass, modes
        self.factor: Factorisation = factorise(matrix)
        inertia, stiffness, self.viscous = weights  # of mass, stiffness and damping in A + C
        if modes is not None:
            known = inertia + stiffness * modes.eigenvalues
            rates = self.viscous * np.concatenate(modes.damping)
            self._less = rates / (known * (known + rates))

    def solve(self, force: FloatArray) -> FloatArray:
        """(n_dofs,) displacement (A + C)^-1 of a force (n_dofs,)."""
        if self.modes is None:
            return self.factor.solve(force)
        step = self.factor.solve(force) - self.modes.displacement(self._less * self.modes.coordinates(force))
        for _ in range(MOST_REFINEMENTS):
            last, step = step, self.factor.solve(force - self.viscous * modal_force(self.modes, self.mass, step))
            if np.abs(step - last).max() <= REFINED * np.abs(step).max():
                break
        return step


class FullStepper(Stepper):
    """Time stepping by sparse Newton iterations on all DOFs; only the contact law is shared with `CondensedStepper`."""

    name = "full"
    state: FullState

    def __init__(self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions):
        super().__init__(system, preload, scheme, options)
        self.state = FullState(Motion.zeros(system.n_dofs), ContactMemory.of(preload))
        self.inertia = system.mass @ system.influence
        self.trial = TrialContact(system)
        self._factor: tuple[float, StepMatrix] | None = None
        self._longest_step = 0.0  # checked so far
        self._modes: Condensation | None = None  # for modal damping

    def displacement(self) -> FloatArray:
        """(n_dofs,) displacement relative to the preload state, m."""
        return self.state.motion.q.copy()

    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector i (n_dofs,), and M i (n_dofs,), the inertia force per unit base acceleration."""
        return self.system.influence, self.inertia

    def start_from(self, displacement: FloatArray) -> None:
        """Start from rest at ``displacement`` (n_dofs,), m, relative to the preload state."""
        system, (motion, contact) = self.system, self.state
        motion.q[:] = displacement
        jump = self.preload.jump + system.jump @ displacement
        traction = self.trial(jump, self.preload)
        contact.jump[:], contact.elastic_slip[:], contact.traction[:] = jump, self.trial.elastic_slip, traction
        force = system.contact_force(traction - self.preload.traction)
        motion.residual[:] = system.stiffness @ motion.q + force
        motion.a[:] = -factorise(system.mass).solve(motion.residual)

    def _committed(self) -> ContactState:
        return ContactState(self.state.motion.q, *self.state.contact, self.trial.status)

    def _solve(self, history_term: FloatArray, ag: float, dt: float) -> tuple[FloatArray, FloatArray, int] | None:
        """New displacement (n_dofs,), m, residual r (n_dofs,), N, number of iterations; None without convergence."""
        system, s, t_0 = self.system, self.scheme, self.preload.traction
        inertia_factor, velocity_factor = 1.0 / (s.beta * dt**2), s.gamma / (s.beta * dt)
        damping, damped = system.damping, self._damped
        coasting = self._coasting(dt)  # velocity at the end of a step that does not move
        state = self._committed()
        w = self.state.motion.q.copy()
        self.last_history = []

        def imbalance(w: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            jump = self.preload.jump + system.jump @ w
            traction = self.trial(jump, state, dt)
            r = system.stiffness @ w + system.contact_force(traction - t_0) + self.inertia * ag
            if damped:
                r += self._viscous_force(coasting + velocity_factor * w)
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
                weights = inertia_factor, 1.0 + s.alpha, (1.0 + s.alpha) * velocity_factor
                self._factor = factor = dt, StepMatrix(matrix, system.mass, self._modes, weights)
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
            if new > FULL_RENEWAL * size:
                self._factor = None
            size = new
        self._factor = None
        return None

    @property
    def _damped(self) -> bool:
        return self.system.damping is not None or self.system.modal_damping is not None

    def _viscous_force(self, velocity: FloatArray) -> FloatArray:
        """(n_dofs,) forces of all dashpots, N, at the velocities (n_dofs,), m/s."""
        damping = self.system.damping
        force = np.zeros(len(velocity)) if damping is None else damping @ velocity
        return force if self._modes is None else force + modal_force(self._modes, self.system.mass, velocity)

    def _coasting(self, dt: float) -> FloatArray:
        """(n_dofs,) part of Newmark's velocity at the end of a step that the new displacement does not affect, m/s."""
        s, m = self.scheme, self.state.motion
        h = (m.q + dt * m.v + dt**2 * (0.5 - s.beta) * m.a) / (s.beta * dt**2)
        return m.v + dt * ((1.0 - s.gamma) * m.a - s.gamma * h)

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance by sparse Newton iterations on all DOFs; see `Stepper.try_steps`."""
        system, s = self.system, self.scheme
        self._factor = None  # so that a restored run repeats the same numbers
        if system.modal_damping is not None and self._modes is None:
            only = replace(system, damping=None)
            self._modes = condense(only, reference_stiffness(system, self.preload, dt), s, dt)
        if dt > self._longest_step:
            check_step_uniqueness(system, self.preload, s, dt)
            self._longest_step = dt
        motion, contact, flows = self.state.motion, self.state.contact, self.accumulated.flows
        for step in range(len(acceleration) - 1):
            ag, ag_new = float(acceleration[step]), float(acceleration[step + 1])
            h = (motion.q + dt * motion.v + dt**2 * (0.5 - s.beta) * motion.a) / (s.beta * dt**2)
            solved = self._solve(system.mass @ h + s.alpha * motion.residual, ag_new, dt)
            if solved is None:
                return step
            w, r, iterations = solved
            a = w / (s.beta * dt**2) - h
            v = motion.v + dt * ((1.0 - s.gamma) * motion.a + s.gamma * a)
            du, da, dr = w - motion.q, a - motion.a, r - motion.residual
            m_da = system.mass @ da
            mean_a = 0.5 * (a + motion.a)
            flows[INPUT_FLOW] -= 0.5 * (ag + ag_new) * (self.inertia @ du)
            flows[NUMERICAL_FLOW] += 0.5 * s.alpha * du @ (dr + motion.residual_change) - (s.gamma - 0.5) * du @ m_da
            flows[NUMERICAL_FLOW] += dt**2 * (s.beta - 0.5 * s.gamma) * (mean_a @ m_da + (s.gamma - 0.5) * da @ m_da)
            if self._damped:
                flows[VISCOUS_FLOW] += 0.5 * du @ self._viscous_force(v + motion.v)
            jump, e, t = self.preload.jump + system.jump @ w, self.trial.elastic_slip, self.trial.traction
            kernels.interface_work(*contact, jump, e, t, system.laws, self.accumulated.work)
            kernels.record_slip(
                contact.jump, contact.elastic_slip, jump, e, self.preload.jump, self.trial.status, *self.slip
            )
            kernels.record_opening(jump, self.trial.status, dt, *self.accumulated.opening)
            for old, new in zip(motion, (w, v, a, r, dr), strict=True):
                old[:] = new
            contact.jump[:], contact.elastic_slip[:], contact.traction[:] = jump, e, t
            self._record(records[step], iterations)
        return len(acceleration) - 1

    def _record(self, row: FloatArray, iterations: int) -> None:
        system, motion = self.system, self.state.motion
        tip = system.probes["tip"]
        row[TIP_DISPLACEMENT], row[TIP_VELOCITY], row[TIP_ACCELERATION] = tip @ motion.q, tip @ motion.v, tip @ motion.a
        if len(system.output_rows):
            row[FIRST_PROBE:] = (system.output_rows @ np.column_stack([motion.q, motion.v, motion.a])).ravel()
        row[KINETIC] = 0.5 * motion.v @ (system.mass @ motion.v)
        change = self.jump - self.preload.jump
        row[STRAIN] = 0.5 * motion.q @ (system.stiffness @ motion.q) - (system.weights * self.preload.traction) @ change
        record_flows(row, self.accumulated)
        record_contact(row, self.accumulated, iterations, self.trial.status)
