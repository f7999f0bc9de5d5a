"""Compiled loop of the trigonometric integration (equations in `stepper`)."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.dynamics.time_stepping import modal_kernel, records, reduced_kernel
from wroll_fem.dynamics.time_stepping.modal_kernel import answer, damped, strain_energy, viscous_force
from wroll_fem.dynamics.time_stepping.records import (
    FIRST_PROBE,
    INPUT_FLOW,
    KINETIC,
    NUMERICAL_FLOW,
    OF_PROBE,
    STRAIN,
    TIP_ACCELERATION,
    TIP_DISPLACEMENT,
    TIP_VELOCITY,
    VISCOUS_FLOW,
    record_contact,
    record_flows,
)
from wroll_fem.dynamics.time_stepping.reduced_kernel import (
    KeptMatrix,
    commit_contact,
    iterate,
    keep_row,
    place,
    working_arrays,
)
from wroll_fem.dynamics.time_stepping.state import ContactMemory, Motion
from wroll_fem.dynamics.trigonometric import propagation, slip_path
from wroll_fem.dynamics.trigonometric.propagation import IMPLICIT, NODES, OUTPUTS, WEIGHTS
from wroll_fem.dynamics.trigonometric.slip_path import add_work_of_path, slide_to_turning_points
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray

drop_stale_cache(
    __file__, modal_kernel.__file__, records.__file__, reduced_kernel.__file__, propagation.__file__,
    slip_path.__file__,
)  # fmt: skip

LAST = len(NODES) - 1

RENEWAL = 0.25
"""Ratio of successive residuals above which a step renews Newton's matrix (small and dense): a resolved mode depends on
friction's correction by a twelfth of the square of its angle in a step only."""


class TrigonometricState(NamedTuple):
    """State of a trigonometric run.

    Attributes
    ----------
    motion, contact : motion in reduced coordinates, and contact state of all points
    free, free_rate : (m,) displacement d without the answer p of unresolved modes to friction's correction, and without
        the shift of the others; its rate d'
    force, force_before, force_earlier : (m,) reduced force of friction's correction now, and one and two steps before
    known : (m,) this force as p knows it, which differs after a change of the basis
    mismatch : (m,) displacement of the contact minus the one of the structure, which the iteration leaves
    moved : (2 n,) tangential displacement in the last step of points near the friction limit, m; 0 at the others
    sliding : (n,) 1 at points that slid at the end of the last step, else 0
    clock : (1,) time, s
    kept, time_step, projection_error, motion_norm, largest, training, opened : see `ReducedState`
    """

    motion: Motion
    contact: ContactMemory
    free: FloatArray
    free_rate: FloatArray
    force: FloatArray
    force_before: FloatArray
    force_earlier: FloatArray
    known: FloatArray
    mismatch: FloatArray
    moved: FloatArray
    sliding: FloatArray
    clock: FloatArray
    kept: KeptMatrix
    time_step: FloatArray
    projection_error: FloatArray
    motion_norm: FloatArray
    largest: FloatArray
    training: FloatArray
    opened: FloatArray


@numba.njit(cache=True)
def _propagate(steps, free, v, force, nodes, out):
    """Fill ``out`` (OUTPUTS, m) with the results of a step, without the force at its end; see `Propagation`."""
    at = 0
    for block in range(steps.starts.shape[0] - 1):
        first = steps.starts[block]
        n = steps.starts[block + 1] - first
        if n == 1:
            d, rate, load = free[first], v[first], force[first]
            for kind in range(OUTPUTS):
                total = steps.state[at] * d + steps.state[at + 1] * rate + steps.state[at + 2] * load
                for j in range(LAST + 1):
                    total += steps.base[kind, first, j] * nodes[j]
                out[kind, first] = total
                at += 4
            continue
        for kind in range(OUTPUTS):
            for i in range(n):
                total = 0.0
                for j in range(n):
                    total += steps.state[at + j] * free[first + j]
                for j in range(n):
                    total += steps.state[at + n + j] * v[first + j]
                for j in range(n):
                    total += steps.state[at + 2 * n + j] * force[first + j]
                for j in range(nodes.shape[0]):
                    total += steps.base[kind, first + i, j] * nodes[j]
                out[kind, first + i] = total
                at += 4 * n


@numba.njit(cache=True)
def _add_end(steps, force, out):
    """Add to ``out`` (OUTPUTS, m) what the ``force`` (m,) at the end of the step adds."""
    at = 0
    for block in range(steps.starts.shape[0] - 1):
        first = steps.starts[block]
        n = steps.starts[block + 1] - first
        if n == 1:
            for kind in range(OUTPUTS):
                out[kind, first] += steps.state[at + 3] * force[first]
                at += 4
            continue
        for kind in range(OUTPUTS):
            for i in range(n):
                total = 0.0
                for j in range(n):
                    total += steps.state[at + 3 * n + j] * force[first + j]
                out[kind, first + i] += total
                at += 4 * n


@numba.njit(cache=True)
def _work_of_nodes(nodes, steps, modal, v, out, flows):
    """Add the work of the base and of the dashpots during a step to ``flows``, by quadrature."""
    has_dashpots = damped(modal.dashpots)
    for j in range(LAST + 1):
        velocity = v if j == 0 else (out[1] if j == LAST else out[2 + j])
        weight = steps.dt * WEIGHTS[j]
        flows[INPUT_FLOW] -= weight * nodes[j] * np.dot(modal.base, velocity)
        if has_dashpots:
            flows[VISCOUS_FLOW] += weight * np.dot(velocity, viscous_force(modal.dashpots, velocity))


@numba.njit(cache=True)
def _answer_start(steps, state, q_hat):
    """Add to ``q_hat`` (m,) the displacement p of unresolved modes after the step, without the force at its end."""
    for i in range(q_hat.shape[0]):
        if not steps.resolved[i]:
            p, rate = state.motion.q[i] - state.free[i], state.motion.v[i] - state.free_rate[i]
            load = (1.0 - IMPLICIT) * state.known[i] - steps.eigenvalues[i] * p
            q_hat[i] += p + steps.mobility[i] * (rate * steps.dt + IMPLICIT * steps.dt * steps.dt * load)


@numba.njit(cache=True)
def _commit_resolved(steps, modal, force, mean_base, out, state, flows):
    """Advance the resolved modes, and add their work to ``flows``; the acceleration holds that of d without force."""
    q, v, a = state.motion.q, state.motion.v, state.motion.a
    free, before, base, eigenvalues = state.free, state.force, modal.base, modal.eigenvalues
    resolved, shift, gains = steps.resolved, steps.shift, steps.gain  # outside the loop: numba counts references
    given, numerical = 0.0, 0.0
    for i in range(force.shape[0]):
        if not resolved[i]:
            continue
        d, d_new, old, new, gain = free[i], out[0, i], q[i], out[0, i] + shift[i] * force[i], gains[i]
        change, mean = force[i] - before[i], 0.5 * (force[i] + before[i])
        given -= mean_base * base[i] * (new - old - d_new + d)
        numerical += mean * (new - old - gain * (d_new - d)) - gain * change * (0.5 * (d + d_new) - out[2, i])
        numerical -= 0.5 * eigenvalues[i] * (new * new - old * old - d_new * d_new + d * d)
        q[i], v[i] = new, out[1, i]
        a[i] += gain * force[i]
    flows[INPUT_FLOW] += given
    flows[NUMERICAL_FLOW] += numerical + given


@numba.njit(cache=True)
def _commit_others(steps, modal, force, mean_base, out, state, flows):
    """Advance the other modes, d + p, and add the work of p to ``flows``; see `_commit_resolved`.

    p follows the implicit midpoint rule with the weight `IMPLICIT` of the end of the step (docs/trigonometric.md).
    """
    q, v, a = state.motion.q, state.motion.v, state.motion.a
    free, free_rate, before, known, base = state.free, state.free_rate, state.force, state.known, modal.base
    resolved, eigenvalues, rates, mobility = steps.resolved, steps.eigenvalues, steps.rates, steps.mobility
    dt, given, total, viscous = steps.dt, 0.0, 0.0, 0.0
    for i in range(force.shape[0]):
        if resolved[i]:
            continue
        value, rate, f, f_new = eigenvalues[i], rates[i], before[i], force[i]
        d, d_rate, d_new, d_rate_new = free[i], free_rate[i], out[0, i], out[1, i]
        p, p_rate = q[i] - d, v[i] - d_rate
        load = (1.0 - IMPLICIT) * known[i] + IMPLICIT * f_new
        mean = mobility[i] * (p_rate + IMPLICIT * dt * (load - value * p))
        change = dt * (load - rate * mean - value * (p + IMPLICIT * dt * mean))
        p_new, p_rate_new = p + dt * mean, p_rate + change
        moved, free_moved = p_new - p, d_new - d
        numerical = (0.5 * (f + f_new) - load) * moved + (IMPLICIT - 0.5) * (change * change + value * moved * moved)
        numerical += (0.5 * (f + f_new) - 2.0 * rate * mean) * free_moved  # p and d together
        numerical -= d_rate_new * p_rate_new - d_rate * p_rate + value * (d_new * p_new - d * p)
        given -= mean_base * base[i] * moved
        total += numerical
        viscous += rate * mean * (dt * mean + 2.0 * free_moved)
        q[i], v[i] = d_new + p_new, d_rate_new + p_rate_new
        a[i] += change / dt
    flows[INPUT_FLOW] += given
    flows[NUMERICAL_FLOW] += total + given
    flows[VISCOUS_FLOW] += viscous


@numba.njit(cache=True)
def _commit_motion(nodes, steps, modal, force, out, state, flows):
    """Update the motion; add the work of base, dashpots and scheme (derived in docs/trigonometric.md).

    Parameters
    ----------
    nodes : base acceleration at `NODES`, m/s^2
    force : (m,) force of friction's correction at the end of the step
    out : (OUTPUTS, m) results of the step
    """
    motion = state.motion
    _work_of_nodes(nodes, steps, modal, state.free_rate, out, flows)
    mean_base = 0.5 * (nodes[0] + nodes[LAST])
    motion.a[:] = -modal.base * nodes[LAST] - modal.eigenvalues * out[0]
    if damped(modal.dashpots):
        motion.a[:] -= viscous_force(modal.dashpots, out[1])
    _commit_resolved(steps, modal, force, mean_base, out, state, flows)
    _commit_others(steps, modal, force, mean_base, out, state, flows)
    state.free[:] = out[0]
    state.free_rate[:] = out[1]
    state.force_earlier[:] = state.force_before
    state.force_before[:] = state.force
    state.force[:] = force
    state.known[:] = force
    state.clock[0] += steps.dt


@numba.njit(cache=True)
def _record_motion(motion, modal, record):
    """Write displacement, velocity and acceleration of tip and probes, and the kinetic energy, to a record."""
    record[TIP_DISPLACEMENT] = np.dot(modal.tip, motion.q)
    record[TIP_VELOCITY] = np.dot(modal.tip, motion.v)
    record[TIP_ACCELERATION] = np.dot(modal.tip, motion.a)
    record[KINETIC] = 0.5 * np.dot(motion.v, motion.v)
    for k in range(modal.probes.shape[0]):
        first = FIRST_PROBE + OF_PROBE * k
        record[first] = np.dot(modal.probes[k], motion.q)
        record[first + 1] = np.dot(modal.probes[k], motion.v)
        record[first + 2] = np.dot(modal.probes[k], motion.a)


@numba.njit(cache=True)
def _continued(state):
    """(m,) force at the end of a step that continues the last ones: a parabola, or linear where points have slid."""
    if np.any(state.sliding):
        return 2.0 * state.force - state.force_before
    return 3.0 * (state.force - state.force_before) + state.force_earlier


@numba.njit(cache=True)
def advance_trigonometric(
    nodes, step, steps, modal, interface, reference, laws, state, newton, accumulated, checks, records
):
    """Advance by up to len(nodes) steps; returns the number of completed steps.

    A step that does not converge ends the loop; ``state`` is the state after the last completed step.

    Parameters
    ----------
    nodes : (k, len(NODES)) base acceleration in each step, m/s^2
    step, steps : `Step` with alpha = 0, and `Propagation`
    modal, interface, reference, laws : `Modal`, `ReducedInterface`, `Reference`, `PointLaws`
    state, accumulated : `TrigonometricState` and `Accumulated`, updated
    newton : `Newton`; its history receives the residuals of the last step
    checks : `ResidualChecks`, filled
    records : (k, record_size) output
    """
    motion, contact = state.motion, state.contact
    m = motion.q.shape[0]
    work = working_arrays(m, laws, reference)
    trial, x, q_hat, force = work.trial, np.zeros(m), np.zeros(m), np.zeros(m)
    out, beyond, limits = np.zeros((OUTPUTS, m)), np.zeros_like(state.moved), np.zeros_like(state.sliding)
    committed = np.zeros_like(contact.jump)
    checks.filled[0] = 0
    for number in range(nodes.shape[0]):
        _propagate(steps, state.free, state.free_rate, state.force, nodes[number], out)
        q_hat[:] = out[0]
        _answer_start(steps, state, q_hat)
        x[:] = q_hat + answer(modal, _continued(state), 1.0)
        committed[:] = contact.jump
        place(x, interface, reference, trial.g)
        slide_to_turning_points(trial.g, contact, state.moved, laws, step.dt, beyond, limits)
        iterations = iterate(
            x, q_hat, step, modal, interface, reference, laws, contact, state.kept, newton, RENEWAL, work
        )
        contact.jump[:] = committed
        if iterations < 0:
            return number
        force[:] = -work.force
        _add_end(steps, force, out)
        flows = accumulated.flows
        mean = 0.5 * (state.force + force)
        _commit_motion(nodes[number], steps, modal, force, out, state, flows)
        for i in range(m):
            left = x[i] - motion.q[i]
            flows[NUMERICAL_FLOW] += mean[i] * (left - state.mismatch[i])
            state.mismatch[i] = left
        flows[NUMERICAL_FLOW] -= add_work_of_path(
            contact, trial, beyond, limits, state.moved, state.sliding, laws, accumulated.work, accumulated.slip.path
        )
        commit_contact(trial, contact, reference, laws, step.dt, accumulated)
        record = records[number]
        _record_motion(motion, modal, record)
        record_flows(record, accumulated)
        record[STRAIN] = strain_energy(motion, modal, contact.jump, reference, laws.area)
        record_contact(record, accumulated, iterations, trial.status)
        if (number + 1) % checks.every == 0 or number == nodes.shape[0] - 1:
            keep_row(motion, trial.s, nodes[number, LAST], checks)
    return nodes.shape[0]
