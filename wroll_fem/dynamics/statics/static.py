"""Nonlinear static equilibrium with friction: the preload step and load paths."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact import kernels
from wroll_fem.contact.laws import SMOOTHED, PointLaws
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.linear import Factorisation, factorise
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.dynamics.statics.condensed import CondensedStatic

KEEP_RATE = 0.1
"""A factorisation is kept while each iteration reduces the residual by this."""

LEAST_TANGENT = 1e-6
"""Share of the normal penalty that Newton's matrix (never the residual) gives to a point that holds nothing yet."""


@dataclass(frozen=True)
class ContactState:
    """Committed state of a system at rest or between two steps.

    Attributes
    ----------
    displacement
        (n_dofs,) m.
    jump
        (3 n_points,) relative displacement in slot order, m.
    elastic_slip
        (2 n_points,) m.
    traction
        (3 n_points,) Pa; tangential slots first, the normal is negative in compression.
    status
        (n_points,) `contact.kernels.STICK`, ``SLIP`` or ``OPEN``.
    """

    displacement: FloatArray
    jump: FloatArray
    elastic_slip: FloatArray
    traction: FloatArray
    status: np.ndarray

    @property
    def pressure(self) -> FloatArray:
        """(n_points,) contact pressure, Pa, positive in compression."""
        n = len(self.status)
        return np.maximum(0.0, -self.traction[2 * n :])

    @classmethod
    def unloaded(cls, system: System) -> ContactState:
        """State of a system that nothing has touched yet: no gap, no pressure."""
        n = system.n_points
        return cls(np.zeros(system.n_dofs), np.zeros(3 * n), np.zeros(2 * n), np.zeros(3 * n), np.zeros(n, np.int64))


def slot_blocks(d: FloatArray) -> sp.csr_matrix:
    """(n, 3, 3) point tangents (hoop, axial, normal) as a (3 n, 3 n) sparse matrix in slot order."""
    n = len(d)
    k = np.arange(n)
    slots = np.column_stack([2 * k, 2 * k + 1, 2 * n + k])
    rows = np.repeat(slots, 3, axis=1).ravel()
    cols = np.tile(slots, (1, 3)).ravel()
    return sp.csr_matrix((d.ravel(), (rows, cols)), shape=(3 * n, 3 * n))


class WithLaws(Protocol):
    """A system, or a part of its points."""

    @property
    def laws(self) -> PointLaws:
        """Law parameters of the points."""
        ...


class TrialContact:
    """Trial evaluation of all interfaces from a committed state (which it never changes)."""

    def __init__(self, system: WithLaws):
        self.laws = system.laws
        n = self.laws.n
        self.traction, self.elastic_slip = np.zeros(3 * n), np.zeros(2 * n)
        self.status, self.tangent = np.zeros(n, np.int64), np.zeros((n, 3, 3))

    def __call__(self, jump: FloatArray, state: ContactState, dt: float = np.inf) -> FloatArray:
        """Trial traction (3 n_points,), Pa, ``dt`` s after ``state``; also fills ``elastic_slip`` and ``status``."""
        kernels.trial_traction(
            jump, state.jump, state.elastic_slip, self.laws, dt, self.traction, self.elastic_slip, self.status
        )
        return self.traction

    def stiffness(self, jump: FloatArray, state: ContactState, floor: float = 0.0, dt: float = np.inf) -> sp.csr_matrix:
        """Consistent tangent (3 n, 3 n) in slot order; ``floor`` is the least stiffness per slot, Pa/m."""
        kernels.consistent_tangent(jump, state.jump, state.elastic_slip, self.laws, dt, self.tangent)
        if floor > 0.0:
            # weak friction that sticks is what holds a layer: a floor in its place would stall Newton's method
            sticks = (self.status == kernels.STICK) & (self.tangent[:, 0, 0] > 0.0)
            for c in range(3):
                least = np.where(sticks, self.tangent[:, c, c], floor)
                self.tangent[:, c, c] = np.maximum(self.tangent[:, c, c], least)
        return slot_blocks(self.tangent)

    def committed(self, displacement: FloatArray, jump: FloatArray) -> ContactState:
        """The state that results when the last trial is accepted."""
        return ContactState(
            displacement, jump.copy(), self.elastic_slip.copy(), self.traction.copy(), self.status.copy()
        )


def solve_static(
    system: System,
    force: FloatArray,
    state: ContactState,
    *,
    tolerance: float = 1e-9,
    max_iterations: int = 40,
    load_factor: float = 1.0,
) -> ContactState:
    """Equilibrium K u + G^T W t(u) = force, friction starting from ``state``.

    Newton's method with the consistent tangent and a backtracking line search. Where nothing yet
    holds a body (no pressure, hence no stick stiffness) the tangent alone, never the residual,
    gets a small stiffness.

    Raises
    ------
    ConvergenceError
        With ``load_factor`` in place of the time.
    """
    trial, jump_operator, weights = TrialContact(system), system.jump, system.weights
    u = state.displacement.copy()
    history: list[float] = []
    floor = LEAST_TANGENT * float(system.laws.kn.max(initial=0.0))

    def residual(u: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        jump = jump_operator @ u
        internal = system.stiffness @ u
        contact = jump_operator.T @ (weights * trial(jump, state))
        scale = np.linalg.norm(force) + np.linalg.norm(contact) + np.linalg.norm(internal)
        r = internal + contact - force
        return r, jump, float(np.linalg.norm(r) / scale) if scale > 0 else 0.0

    r, jump, size = residual(u)
    factor: Factorisation | None = None
    for _ in range(max_iterations):
        history.append(size)
        if size <= tolerance:
            return trial.committed(u, jump)
        fresh = factor is None
        if factor is None:
            tangent = trial.stiffness(jump, state, floor)
            factor = factorise(system.stiffness + jump_operator.T @ sp.diags(weights) @ tangent @ jump_operator)
        step = factor.solve(r)
        damping, best = 1.0, (np.inf, 0.0)
        for _ in range(8):
            size_new = residual(u - damping * step)[2]
            if size_new < best[0]:
                best = (size_new, damping)
            if size_new < (1.0 - 0.1 * damping) * size or not fresh:
                break
            damping *= 0.5
        if best[0] > KEEP_RATE * size:
            factor = None
            if not fresh and best[0] >= size:
                r, jump, size = residual(u)
                continue
        u = u - best[1] * step
        r, jump, size = residual(u)
    raise unconverged(load_factor, max_iterations, history)


def stick_springs(system: System, state: ContactState) -> FloatArray:
    """(3 n_points,) stiffness per slot of the contact that sticks at ``state``, Pa/m.

    Open points have none, nor has the smoothed law along the surface: it holds nothing at rest.
    """
    law, pressure = system.laws, state.pressure
    closed = (pressure > 0) | ~law.separation
    stick = np.where(law.kind == SMOOTHED, 0.0, law.mu * pressure / law.gamma)
    return np.concatenate([np.repeat(stick, 2), np.where(closed, law.kn, 0.0)])


def unconverged(load_factor: float, iterations: int, history: list[float]) -> ConvergenceError:
    """Error of a static step, at ``load_factor`` in place of the time."""
    return ConvergenceError(
        f"static step did not converge (load factor {load_factor:.4g})",
        time_s=load_factor,
        iterations=iterations,
        residual_history=history,
        advice="raise preload.steps, or check that friction or a support holds every body",
    )


def solve_load_path(
    system: System,
    forces: Sequence[FloatArray],
    state: ContactState | None = None,
    *,
    max_cuts: int = 6,
    progress: Callable[[int], None] | None = None,
    condensed: CondensedStatic | None = None,
) -> list[ContactState]:
    """Quasi-static path through a sequence of force vectors, committing friction at each.

    A step that does not converge is cut in halves up to ``max_cuts`` times. ``condensed`` solves on the interfaces
    alone; without it the whole structure is solved.

    Returns
    -------
    list of ContactState
        One per force vector.
    """
    current = ContactState.unloaded(system) if state is None else state
    previous = np.zeros(system.n_dofs) if state is None else equilibrium_force(system, current)
    path = []
    for i, target in enumerate(forces):
        done, step = 0.0, 1.0
        while done < 1.0:
            step = min(step, 1.0 - done)
            try:
                force = previous + (done + step) * (target - previous)
                if condensed is None:
                    current = solve_static(system, force, current, load_factor=i + done + step)
                else:
                    current = condensed(force, current, load_factor=i + done + step)
            except ConvergenceError:
                step *= 0.5
                if step < 0.5**max_cuts:
                    raise
                continue
            done += step
        previous = target
        path.append(current)
        if progress is not None:
            progress(i + 1)
    return path


def equilibrium_force(system: System, state: ContactState) -> FloatArray:
    """External force (n_dofs,) in N that holds ``state`` in equilibrium."""
    return system.stiffness @ state.displacement + system.jump.T @ (system.weights * state.traction)


def solve_preload(
    system: System, *, steps: int = 10, progress: Callable[[int], None] | None = None, condensed: bool = True
) -> ContactState:
    """Ramp the load "preload" in equal steps with friction; the state it leaves starts the dynamics.

    Parameters
    ----------
    condensed
        Solve on the interfaces alone where the roll's symmetry allows it; False solves the whole structure.
    """
    from wroll_fem.dynamics.statics.condensed import CondensedStatic  # which builds on this file

    force = system.loads.get("preload", np.zeros(system.n_dofs))
    if not np.any(force):
        return ContactState.unloaded(system)
    scale = float(np.abs(force).sum() / max(system.laws.area.sum(), 1e-300)) / np.sqrt(3.0)
    solver = CondensedStatic.of(system, scale) if condensed else None
    path = [force * (i + 1) / steps for i in range(steps)]
    return solve_load_path(system, path, progress=progress, condensed=solver)[-1]
