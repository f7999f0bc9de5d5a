"""Compiled loop of the reduced time integration (equations in `reduced_model`).

Newton's matrix A = S + (1 + alpha) (G Phi)^T W (D - D_0) G Phi is small. It is reused in later iterations and steps;
only the contributions of points whose tangent D has changed are updated.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact.kernels import consistent_tangent, interface_work, record_opening, record_slip, trial_traction
from wroll_fem.contact.point import NORMAL, axial, hoop, normal
from wroll_fem.dynamics.time_stepping import modal_kernel, records
from wroll_fem.dynamics.time_stepping.modal_kernel import (
    answer,
    by_block,
    commit_motion,
    correction,
    predict,
    strain_energy,
)
from wroll_fem.dynamics.time_stepping.records import OPEN, STRAIN, record_contact
from wroll_fem.dynamics.time_stepping.state import ContactMemory, Motion
from wroll_fem.numerics import newton as rates
from wroll_fem.numerics.newton import REDUCED_RENEWAL
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray, IntArray

drop_stale_cache(__file__, modal_kernel.__file__, records.__file__, rates.__file__)

TANGENT_CHANGE = 0.02
"""Change of the contact tangent at a point, divided by its reference hoop stiffness, above which the update of Newton's
matrix includes the point.

A point is also included after any change of its normal stiffness, and from the fourth iteration of a step after any
change at all."""
REBUILD = 2000
"""Number of updates after which Newton's matrix is assembled again, to limit the accumulated rounding error."""


class ReducedInterface(NamedTuple):
    """Matrices that relate jump and traction of the interfaces to the m reduced coordinates.

    Attributes
    ----------
    jump : (3 n, m) relative displacement per unit coordinate
    force : (m, 3 n) reduced force per unit traction, the transpose of ``jump`` times the areas
    weight : (m,) largest jump per unit coordinate; converts a residual in coordinates to an upper bound of the jump, m
    """

    jump: FloatArray
    force: FloatArray
    weight: FloatArray


class KeptMatrix(NamedTuple):
    """Newton's matrix, which is reused from step to step.

    Attributes
    ----------
    tangents : (n, 3, 3) contact tangents contained in the matrix, order (hoop, axial, normal), Pa/m
    matrix : (m, m) Newton's matrix
    inverse : (m, m) inverse of the matrix
    renewals : (1,) number of updates so far
    """

    tangents: FloatArray
    matrix: FloatArray
    inverse: FloatArray
    renewals: IntArray


class ReducedState(NamedTuple):
    """State of a reduced run.

    Attributes
    ----------
    motion, contact : motion in reduced coordinates, and contact state of all points
    q_before : (m,) displacement one step before
    kept : Newton's matrix
    time_step : (1,) time step of the kept matrix, s; 0 if there is no matrix
    projection_error, motion_norm : (1,) squared energy norms of the projection error, and of the motion (limited by
        `reduced.CONTACT_SHARE`), summed over the residual checks
    largest : (1,) largest squared energy norm of the motion so far
    training : (1,) CPU time of residual checks, enrichment and repeated steps, s
    opened : (1,) largest change of the share of open points since the preload state
    """

    motion: Motion
    contact: ContactMemory
    q_before: FloatArray
    kept: KeptMatrix
    time_step: FloatArray
    projection_error: FloatArray
    motion_norm: FloatArray
    largest: FloatArray
    training: FloatArray
    opened: FloatArray


class ResidualChecks(NamedTuple):
    """Data saved for the residual checks; from them the residual of the full model is evaluated later.

    Attributes
    ----------
    every : number of steps between two checked steps; the last step, and slow turning points of open contact (`turns`),
        are checked too
    rows : (k, 3 m + 3 n + 1) output: displacement q (m,), acceleration a (m,), velocity v (m,), traction correction s
        (3 n,) and base acceleration of each checked step
    filled : (1,) output: number of rows filled
    """

    every: int
    rows: FloatArray
    filled: IntArray


class Trial(NamedTuple):
    """Trial state of the interfaces: jump, traction, elastic slip, status and traction correction."""

    g: FloatArray
    t: FloatArray
    e: FloatArray
    status: IntArray
    s: FloatArray


class Work(NamedTuple):
    """Arrays in which a step is solved: trial contact, residuals, forces and displacement (m,), tangents, scales.

    After `solve_step` the trial contact and ``force``, the reduced force of the traction correction, are those of the
    solution.
    """

    trial: Trial
    rho: FloatArray
    rho_new: FloatArray
    force: FloatArray
    force_new: FloatArray
    x_new: FloatArray
    tangent: FloatArray
    scale: FloatArray


@numba.njit(cache=True)
def working_arrays(m, laws, reference):
    """`Work` for ``m`` reduced coordinates."""
    n = laws.area.shape[0]
    trial = Trial(np.zeros(3 * n), np.empty(3 * n), np.empty(2 * n), np.empty(n, np.int64), np.zeros(3 * n))
    scale = np.zeros(n)
    for k in range(n):
        scale[k] = max(reference.springs[hoop(k)], 1e-6 * laws.kn[k])
    vectors = np.zeros((5, m))
    return Work(trial, vectors[0], vectors[1], vectors[2], vectors[3], vectors[4], np.zeros((n, 3, 3)), scale)


@numba.njit(cache=True)
def place(x, interface, reference, g):
    """Fill ``g`` (3 n,), m, with the relative displacement at the reduced displacement ``x`` (m,)."""
    np.dot(interface.jump, x, g)
    g += reference.jump


@numba.njit(cache=True)
def _residual(x, q_hat, modal, interface, reference, contact, laws, step, trial, force, rho):
    """Fill ``rho`` (m,) with the residual of displacement ``x`` (m,); returns an upper bound of the jump due to rho, m.

    The residual is x - q_hat + (1 + alpha) A (G Phi)^T W s, with q_hat from `predict`, the displacement A per force
    (`answer`) and the traction correction s at x. The relative displacement in ``trial`` belongs to ``x`` (`place`).
    """
    g, t, e, status, s = trial
    n = status.shape[0]
    trial_traction(g, contact.jump, contact.elastic_slip, laws, step.dt, t, e, status)
    correction(g, t, reference, s)
    weighted = np.empty(3 * n)
    for k in range(n):
        weighted[hoop(k)] = laws.area[k] * s[hoop(k)]
        weighted[axial(k)] = laws.area[k] * s[axial(k)]
        weighted[normal(k, n)] = laws.area[k] * s[normal(k, n)]
    np.dot(interface.jump.T, weighted, force)  # one matrix for both products stays in the cache of the processor
    weight, change = interface.weight, answer(modal, force, 1.0 + step.alpha)
    size = 0.0
    for i in range(x.shape[0]):
        rho[i] = x[i] - q_hat[i] + change[i]
        size += abs(rho[i]) * weight[i]
    return size if np.isfinite(size) else np.inf


@numba.njit(cache=True)
def _renew(kept, tangent, stiffness_scale, tolerance, jump, area, factor):
    """Update Newton's matrix for the points whose ``tangent`` has changed; returns the number of these points."""
    held, matrix = kept.tangents, kept.matrix
    n, m = area.shape[0], matrix.shape[0]
    changed = np.empty(n, np.int64)
    count = 0
    for k in range(n):
        difference = 0.0
        for i in range(3):
            for j in range(3):
                d = abs(tangent[k, i, j] - held[k, i, j])
                difference = max(difference, d if j < NORMAL else d * 1e-3)
        normal_change = abs(tangent[k, NORMAL, NORMAL] - held[k, NORMAL, NORMAL])
        if normal_change > 0.0 or difference > tolerance * stiffness_scale[k]:
            changed[count] = k
            count += 1
    if count == 0:
        return 0
    rows = np.empty((3 * count, m))
    right = np.empty((3 * count, m))
    for c in range(count):
        k = changed[c]
        dofs = (hoop(k), axial(k), normal(k, n))
        for i in range(3):
            for col in range(m):
                rows[3 * c + i, col] = jump[dofs[i], col]
        for i in range(3):
            d0 = factor * area[k] * (tangent[k, i, 0] - held[k, i, 0])
            d1 = factor * area[k] * (tangent[k, i, 1] - held[k, i, 1])
            d2 = factor * area[k] * (tangent[k, i, 2] - held[k, i, 2])
            for col in range(m):
                right[3 * c + i, col] = d0 * rows[3 * c, col] + d1 * rows[3 * c + 1, col] + d2 * rows[3 * c + 2, col]
        held[k] = tangent[k]
    matrix += np.dot(rows.T, right)
    return count


@numba.njit(cache=True)
def advance_reduced(acceleration, step, modal, interface, reference, laws, state, newton, accumulated, checks, records):
    """Advance by up to len(acceleration) - 1 steps; returns the number of completed steps.

    A step that does not converge ends the loop; ``state`` is the state after the last completed step.

    Parameters
    ----------
    acceleration : (k + 1,) base acceleration at the ends of the steps, m/s^2
    step, modal, interface, reference, laws : `Step`, `Modal`, `ReducedInterface`, `Reference`, `PointLaws`
    state, accumulated : `ReducedState` and `Accumulated`, updated
    newton : `Newton`; its history receives the residuals of the last step
    checks : `ResidualChecks`, filled
    records : (k, record_size) output
    """
    motion, contact = state.motion, state.contact
    work = working_arrays(motion.q.shape[0], laws, reference)
    trial, force, x = work.trial, work.force, np.zeros_like(motion.q)
    checks.filled[0] = 0
    latest = -1

    for number in range(acceleration.shape[0] - 1):
        ag_new = acceleration[number + 1]
        h, q_hat = predict(motion, ag_new, step, modal)
        x[:] = 2.0 * motion.q - state.q_before
        iterations = solve_step(x, q_hat, step, modal, interface, reference, laws, contact, state.kept, newton, work)
        if iterations < 0:
            return number
        state.q_before[:] = motion.q
        ends = acceleration[number : number + 2]
        commit_motion(ends, step, modal, h, q_hat, force, motion, accumulated, records[number])
        commit_contact(trial, contact, reference, laws, step.dt, accumulated)
        records[number, STRAIN] = strain_energy(motion, modal, contact.jump, reference, laws.area)
        record_contact(records[number], accumulated, iterations, trial.status)
        # layers that have opened land on each other around the largest strain energy of a half cycle
        lands = turns(number, records)
        slow = lands and number - latest >= checks.every
        latest = number if lands else latest
        if slow or (number + 1) % checks.every == 0 or number == acceleration.shape[0] - 2:
            keep_row(motion, trial.s, ag_new, checks)
    return acceleration.shape[0] - 1


@numba.njit(cache=True)
def solve_step(x, q_hat, step, modal, interface, reference, laws, contact, kept, newton, work):
    """Solve the equations of a step (`_residual`), starting at ``x`` (m,); returns the number of iterations, or -1.

    ``x`` becomes the solution; for ``work`` see `Work`. The other arguments are those of `advance_reduced`.
    """
    place(x, interface, reference, work.trial.g)
    return iterate(x, q_hat, step, modal, interface, reference, laws, contact, kept, newton, REDUCED_RENEWAL, work)


@numba.njit(cache=True)
def iterate(x, q_hat, step, modal, interface, reference, laws, contact, kept, newton, renewal, work):
    """`solve_step` where the relative displacement in ``work.trial`` belongs to ``x`` already.

    ``renewal`` is the ratio of successive residuals above which Newton's matrix is renewed.
    """
    trial, rho, rho_new, force, force_new, x_new, tangent, scale = work
    history = newton.history
    factor = 1.0 + step.alpha
    size = _residual(x, q_hat, modal, interface, reference, contact, laws, step, trial, force, rho)
    history[:] = 0.0
    history[0] = size
    iterations = 0
    fresh = False
    while size > newton.limit:
        if iterations == newton.max_iterations:
            return -1
        if modal.dashpots.matrix.shape[0] > 0:
            delta = np.dot(kept.inverse, by_block(modal.dashpots.matrix, modal.dashpots.starts, rho))
        else:
            delta = np.dot(kept.inverse, rho / modal.inverse)
        iterations += 1
        damping, new = 1.0, np.inf
        while True:
            x_new[:] = x - damping * delta
            place(x_new, interface, reference, trial.g)
            new = _residual(x_new, q_hat, modal, interface, reference, contact, laws, step, trial, force_new, rho_new)
            if new < size or not fresh or damping < 0.02:
                break
            damping *= 0.5
        rate = new / size
        if rate < 1.0 or fresh:
            x[:], rho[:], force[:], size = x_new, rho_new, force_new, new
            history[iterations] = size
        else:  # the kept matrix failed: back to x, with the tangent there
            place(x, interface, reference, trial.g)
            size = _residual(x, q_hat, modal, interface, reference, contact, laws, step, trial, force, rho)
        fresh = False
        if rate > renewal and size > newton.limit:
            consistent_tangent(trial.g, contact.jump, contact.elastic_slip, laws, step.dt, tangent)
            tolerance = TANGENT_CHANGE if iterations < 4 else 0.0
            if _renew(kept, tangent, scale, tolerance, interface.jump, laws.area, factor) > 0:
                kept.renewals[0] += 1
                if kept.renewals[0] % REBUILD == 0:
                    sum_up(kept, reference.springs, interface.jump, laws.area, factor, modal)
                kept.inverse[:] = np.linalg.inv(kept.matrix)
            fresh = True
    return iterations if np.isfinite(size) else -1


@numba.njit(cache=True)
def commit_contact(trial, contact, reference, laws, dt, accumulated):
    """Commit the trial state of the contact after a step ``dt`` (s), and add its work, slip and opening."""
    g, t, e, status, _ = trial
    interface_work(contact.jump, contact.elastic_slip, contact.traction, g, e, t, laws, accumulated.work)
    path, peak, peak_vector = accumulated.slip
    record_slip(contact.jump, contact.elastic_slip, g, e, reference.jump, status, path, peak, peak_vector)
    record_opening(g, status, dt, accumulated.opening.gap, accumulated.opening.open_time)
    contact.jump[:] = g
    contact.elastic_slip[:] = e
    contact.traction[:] = t


@numba.njit(cache=True)
def turns(number, records):
    """Whether the strain energy of open contact passed a maximum before the step ``number``.

    ``records`` (k, record_size) are those of the steps so far.
    """
    if number < 2 or records[number, OPEN] == 0.0:
        return False
    before, turned, after = records[number - 2, STRAIN], records[number - 1, STRAIN], records[number, STRAIN]
    return before <= turned and turned > after


@numba.njit(cache=True)
def keep_row(motion, s, base_acceleration, checks):
    """Save a step for the residual checks; ``s`` (3 n,) is its traction correction, Pa."""
    m, n = motion.q.shape[0], s.shape[0]
    row = checks.rows[checks.filled[0]]
    row[:m] = motion.q
    row[m : 2 * m] = motion.a
    row[2 * m : 3 * m] = motion.v
    row[3 * m : 3 * m + n] = s
    row[3 * m + n] = base_acceleration
    checks.filled[0] += 1


@numba.njit(cache=True)
def sum_up(kept, springs, jump, area, factor, modal):
    """Assemble Newton's matrix from ``modal`` and the contact tangents ``kept.tangents`` of all points."""
    matrix = kept.matrix
    n, m = area.shape[0], matrix.shape[0]
    right = np.empty((3 * n, m))
    for k in range(n):
        dofs = (hoop(k), axial(k), normal(k, n))
        for i in range(3):
            for col in range(m):
                total = -springs[dofs[i]] * jump[dofs[i], col]
                for j in range(3):
                    total += kept.tangents[k, i, j] * jump[dofs[j], col]
                right[dofs[i], col] = factor * area[k] * total
    matrix[:] = np.dot(jump.T, right)
    if modal.dashpots.matrix.shape[0] > 0:
        matrix += modal.dashpots.matrix.reshape(m, m)
    else:
        for i in range(m):
            matrix[i, i] += 1.0 / modal.inverse[i]
