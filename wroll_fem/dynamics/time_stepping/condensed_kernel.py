"""Compiled loop of the condensed time integration (equations in `condensed`)."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact.kernels import (
    consistent_tangent,
    interface_work,
    record_opening,
    record_slip,
    trial_traction,
)
from wroll_fem.dynamics.reduction import interface_operator, newton_matrix
from wroll_fem.dynamics.reduction.interface_operator import add_free_jump, add_response, fill_modal_force
from wroll_fem.dynamics.reduction.newton_matrix import (
    Factors,
    entries,
    factored,
    include_points,
    krylov_step,
    newton_step,
    workspace,
)
from wroll_fem.dynamics.time_stepping import modal_kernel, records
from wroll_fem.dynamics.time_stepping.modal_kernel import commit_motion, correction, predict, strain_energy
from wroll_fem.dynamics.time_stepping.records import STRAIN, record_contact
from wroll_fem.dynamics.time_stepping.state import ContactMemory, Motion
from wroll_fem.numerics import compiled_krylov, lu
from wroll_fem.numerics import newton as rates
from wroll_fem.numerics.newton import CONDENSED_RENEWAL, SLIDING_RENEWAL
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray, IntArray

drop_stale_cache(
    __file__, modal_kernel.__file__, records.__file__, rates.__file__, interface_operator.__file__,
    newton_matrix.__file__, lu.__file__, compiled_krylov.__file__,
)  # fmt: skip

STUCK_RATE = 0.5
"""Share of the residual above which an iteration with a new matrix calls `include_points`."""
ALL_POINTS = 20
"""Number of iterations after which all points are included in the matrix."""
UNKNOWNS_PER_ITERATION, MOST_ITERATIONS = 50, 12
"""Number of active DOFs per iteration of GMRES that is tried before new factors; largest number of iterations."""
KRYLOV_ITERATIONS = 10
"""Number of iterations in a time step after which each new matrix is factorised."""
SHORTEST = 0.3
"""Damping factor below which a step with a new matrix is taken even if it does not reduce the residual; a shorter one
only delays the change of the points' states."""


class CondensedState(NamedTuple):
    """State of a condensed run: motion in modal coordinates, contact, and the jump (3 n,) one step before, m."""

    motion: Motion
    contact: ContactMemory
    jump_before: FloatArray


class _Trial(NamedTuple):
    """Trial state of the interfaces: jump, traction, elastic slip, status, traction correction and residual."""

    g: FloatArray
    t: FloatArray
    e: FloatArray
    status: IntArray
    s: FloatArray
    rho: FloatArray


@numba.njit(cache=True)
def _residual(g_hat, interface, reference, contact, laws, dt, trial, amplitudes):
    """Evaluate the tractions at the trial jump g, and the residual rho = g - g_hat + F s; returns max |rho|, m.

    g_hat is the jump without traction correction s, F the interface compliance.
    """
    g, t, e, status, s, rho = trial
    trial_traction(g, contact.jump, contact.elastic_slip, laws, dt, t, e, status)
    correction(g, t, reference, s)
    for i in range(g.shape[0]):
        rho[i] = g[i] - g_hat[i]
    add_response(s, laws.area, interface.profiles, interface.sticking.blocks, amplitudes, rho)
    largest = 0.0
    for i in range(g.shape[0]):
        if not np.isfinite(rho[i]):
            return np.inf
        largest = max(largest, abs(rho[i]))
    return largest


class _Iteration(NamedTuple):
    """Result of the iteration of one step: whether it converged, iterations, and the factors, which may still serve."""

    converged: bool
    iterations: int
    factors: Factors
    serves: bool


@numba.njit(cache=True)
def _iterate(g_hat, krylov_iterations, interface, reference, laws, state, dt, newton, work, trials, factors, serves):
    """Newton iteration for the jump after a step; returns `_Iteration`, and leaves the trial state in ``trials``.

    Parameters
    ----------
    g_hat : (3 n,) jump without traction correction, m
    krylov_iterations : number of iterations in which GMRES is tried before new factors
    interface, reference, laws, state, newton, work : as in `advance_steps`; ``work`` is its `Workspace`
    dt : time step, s
    trials : `_Trial` of the iterate, and of the iterate that is tried; they share all but the jump
    factors, serves : last `Factors`, and whether they may be used as they are
    """
    here, there = trials
    g, g_try, rho, delta = here.g, there.g, here.rho, work.step
    contact, history, area, springs = state.contact, newton.history, laws.area, reference.springs
    for i in range(g.shape[0]):
        g[i] = 2.0 * contact.jump[i] - state.jump_before[i]
    size = _residual(g_hat, interface, reference, contact, laws, dt, here, work.amplitudes)
    history[:] = 0.0
    history[0] = size
    work.included[:] = False
    iterations, fresh = 0, False
    while size > newton.limit:
        if iterations == newton.max_iterations:
            return _Iteration(False, iterations, factors, serves)
        solved = False
        if not serves:
            consistent_tangent(g, contact.jump, contact.elastic_slip, laws, dt, work.tangent)
            fresh = True
            if iterations < krylov_iterations:
                most = min(factors.active.shape[0] // UNKNOWNS_PER_ITERATION, MOST_ITERATIONS)
                solved = krylov_step(factors, interface, area, springs, rho, most, work, delta)
            if not solved:
                factors, serves = factored(interface, springs, here.status, work), True
        if not solved:
            newton_step(factors, interface, area, springs, rho, work, delta)
        iterations += 1
        damping = 1.0
        while True:
            for i in range(g.shape[0]):
                g_try[i] = g[i] + damping * delta[i]
            new = _residual(g_hat, interface, reference, contact, laws, dt, there, work.amplitudes)
            if new < size or not fresh or damping < SHORTEST:
                break
            damping *= 0.5
        rate = new / size
        if rate >= 1.0 and not fresh:
            # a kept factor failed: go back and renew it there
            size = _residual(g_hat, interface, reference, contact, laws, dt, here, work.amplitudes)
            serves = False
            continue
        g[:] = g_try
        size = new
        history[iterations] = size
        if rate > (SLIDING_RENEWAL if factors.slides else CONDENSED_RENEWAL):
            serves = False
            if fresh and (rate > STUCK_RATE or iterations > ALL_POINTS):
                include_points(rho, size, iterations > ALL_POINTS, work.included)
        fresh = False
    return _Iteration(True, iterations, factors, serves)


@numba.njit(cache=True)
def advance_steps(acceleration, step, modal, interface, reference, laws, state, newton, accumulated, records, kept):
    """Advance by up to len(acceleration) - 1 steps; returns their number, and the entries of the last `Factors`.

    A step that does not converge ends the loop; ``state`` is the state after the last completed step.

    Parameters
    ----------
    acceleration : (k + 1,) base acceleration at the ends of the steps, m/s^2
    step, modal, interface, reference, laws : `Step`, `Modal`, `InterfaceOperator`, `Reference`, `PointLaws`
    state, accumulated : `CondensedState` and `Accumulated`, updated
    newton : `Newton`; its history receives the residuals of the last step
    records : (k, record_size) output
    kept : such entries of an earlier call with the same step, or `no_factors`
    """
    area, dt = laws.area, step.dt
    motion, contact = state.motion, state.contact
    n = area.shape[0]
    t, e, status = np.empty(3 * n), np.empty(2 * n), np.empty(n, np.int64)
    s, rho, g, g_try = np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n)
    trials = _Trial(g, t, e, status, s, rho), _Trial(g_try, t, e, status, s, rho)
    g_hat, force = np.zeros(3 * n), np.zeros(motion.q.shape[0])
    work = workspace(interface, n, MOST_ITERATIONS)
    factors, serves = Factors(*kept), False

    for number in range(acceleration.shape[0] - 1):
        h, q_hat = predict(motion, acceleration[number + 1], step, modal)
        iterations = 0
        if n > 0:
            g_hat[:] = reference.jump
            add_free_jump(q_hat, interface, work.amplitudes, g_hat)
            for krylov_iterations in (KRYLOV_ITERATIONS, 0):
                # a step that fails is repeated from a new matrix: cycles depend on where the iteration starts
                converged, iterations, factors, serves = _iterate(
                    g_hat, krylov_iterations, interface, reference, laws, state, dt, newton, work, trials,
                    factors, serves and krylov_iterations > 0,
                )  # fmt: skip
                if converged:
                    break
            if not converged:
                return number, entries(factors)
            fill_modal_force(s, area, interface, work.amplitudes, force)
        ends = acceleration[number : number + 2]
        commit_motion(ends, step, modal, h, q_hat, force, motion, accumulated, records[number])
        if n > 0:
            interface_work(contact.jump, contact.elastic_slip, contact.traction, g, e, t, laws, accumulated.work)
            path, peak, peak_vector = accumulated.slip
            record_slip(contact.jump, contact.elastic_slip, g, e, reference.jump, status, path, peak, peak_vector)
            record_opening(g, status, step.dt, accumulated.opening.gap, accumulated.opening.open_time)
            state.jump_before[:] = contact.jump
            contact.jump[:] = g
            contact.elastic_slip[:] = e
            contact.traction[:] = t
        records[number, STRAIN] = strain_energy(motion, modal, contact.jump, reference, area)
        record_contact(records[number], accumulated, iterations, status)
    return acceleration.shape[0] - 1, entries(factors)
