"""The compiled loop of the reduced time integration (equations in `reduction`).

Newton's matrix A = S + (1 + alpha) (G Phi)^T W (D - D_0) G Phi is small and is kept from iteration to iteration and
from step to step: only points whose tangent D changed are renewed in it.
``held`` (n, 3, 3) is the tangent that the kept matrix holds, order (hoop, axial, normal).
"""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.contact.kernels import consistent_tangent, interface_work, record_slip, trial_traction
from wroll_fem.dynamics.time_stepping import condensed_kernel
from wroll_fem.dynamics.time_stepping.condensed_kernel import commit_modal, correction, record_contact, strain_energy
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__, condensed_kernel.__file__)

KEEP_RATE = 0.12
"""A kept matrix is renewed when an iteration reduces the residual by less than this."""
TANGENT_CHANGE = 0.02
"""A point is renewed in the matrix when its tangent changed by this fraction of its stiffness."""
REBUILD = 2000
"""Renewals after which the kept matrix is summed up anew, against the drift of rounding."""


@numba.njit(cache=True)
def _residual(q, q_hat, jump_operator, force_operator, scale, g_0, t_0, springs, jump, elastic_slip, laws, dt,
              g, t, e, status, s, force, rho, weight):  # fmt: skip
    """rho = q - q_hat + scale * (G Phi)^T W s. Returns a bound of its jump, m."""
    g[:] = g_0
    g += np.dot(jump_operator, q)
    trial_traction(g, jump, elastic_slip, laws, dt, t, e, status)
    correction(g, t, g_0, t_0, springs, s)
    force[:] = np.dot(force_operator, s)
    size = 0.0
    for i in range(q.shape[0]):
        rho[i] = q[i] - q_hat[i] + scale[i] * force[i]
        if not np.isfinite(rho[i]):
            return np.inf
        size += abs(rho[i]) * weight[i]
    return size


@numba.njit(cache=True)
def _renew(held, tangent, stiffness_scale, tolerance, jump_operator, area, factor, matrix):
    """Bring ``matrix`` from the tangent ``held`` to ``tangent`` where they differ; returns the points renewed."""
    n, m = area.shape[0], matrix.shape[0]
    changed = np.empty(n, np.int64)
    count = 0
    for k in range(n):
        difference = 0.0
        for i in range(3):
            for j in range(3):
                d = abs(tangent[k, i, j] - held[k, i, j])
                difference = max(difference, d if j < 2 else d * 1e-3)
        if abs(tangent[k, 2, 2] - held[k, 2, 2]) > 0.0 or difference > tolerance * stiffness_scale[k]:
            changed[count] = k
            count += 1
    if count == 0:
        return 0
    rows = np.empty((3 * count, m))
    right = np.empty((3 * count, m))
    for c in range(count):
        k = changed[c]
        slots = (2 * k, 2 * k + 1, 2 * n + k)
        for i in range(3):
            for col in range(m):
                rows[3 * c + i, col] = jump_operator[slots[i], col]
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
def advance_reduced(
    acceleration, dt, alpha, beta, gamma_n,
    eigenvalues, jump_operator, force_operator, base, tip, springs, inverse, weight,
    g_0, t_0, laws,
    q, v, a, residual, residual_change, q_before,
    jump, elastic_slip, traction, held, matrix, solver, renewals,
    totals, flows, slip_path, slip_peak, slip_vector,
    limit, max_iterations, history, records,
    look_every, looks, look_count,
):  # fmt: skip
    """Advance len(acceleration) - 1 steps; returns the number done (state is that of the last good step).

    ``looks`` (k, 2 m + 3 n + 1) receives q, a, s and the base acceleration every ``look_every`` steps and at the last.
    """
    n, m = laws.area.shape[0], q.shape[0]
    t, e, status = np.empty(3 * n), np.empty(2 * n), np.empty(n, np.int64)
    s, g = np.zeros(3 * n), np.zeros(3 * n)
    rho, rho_new, force, force_new = np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m)
    x, x_new = np.zeros(m), np.zeros(m)
    tangent = np.zeros((n, 3, 3))
    stiffness_scale = np.zeros(n)
    scale = (1.0 + alpha) * inverse
    for k in range(n):
        stiffness_scale[k] = max(springs[2 * k], 1e-6 * laws.kn[k])
    look_count[0] = 0

    for step in range(acceleration.shape[0] - 1):
        ag, ag_new = acceleration[step], acceleration[step + 1]
        h = (q + dt * v + dt * dt * (0.5 - beta) * a) / (beta * dt * dt)
        q_hat = (h - (1.0 + alpha) * base * ag_new + alpha * residual) * inverse
        x[:] = 2.0 * q - q_before
        size = _residual(x, q_hat, jump_operator, force_operator, scale, g_0, t_0, springs, jump, elastic_slip, laws,
                         dt, g, t, e, status, s, force, rho, weight)  # fmt: skip
        history[:] = 0.0
        history[0] = size
        iterations = 0
        fresh = False
        while size > limit:
            if iterations == max_iterations:
                return step
            delta = np.dot(solver, rho / inverse)
            iterations += 1
            damping, new = 1.0, np.inf
            while True:
                x_new[:] = x - damping * delta
                new = _residual(x_new, q_hat, jump_operator, force_operator, scale, g_0, t_0, springs, jump,
                                elastic_slip, laws, dt, g, t, e, status, s, force_new, rho_new, weight)  # fmt: skip
                if new < size or not fresh or damping < 0.02:
                    break
                damping *= 0.5
            rate = new / size
            accepted = rate < 1.0 or fresh
            if accepted:
                x[:], rho[:], force[:], size = x_new, rho_new, force_new, new
                history[iterations] = size
            else:  # the kept matrix failed: back to where we were, with the tangent of there
                size = _residual(x, q_hat, jump_operator, force_operator, scale, g_0, t_0, springs, jump, elastic_slip,
                                 laws, dt, g, t, e, status, s, force, rho, weight)  # fmt: skip
            fresh = False
            if rate > KEEP_RATE and size > limit:
                consistent_tangent(g, jump, elastic_slip, laws, dt, tangent)
                tolerance = TANGENT_CHANGE if iterations < 4 else 0.0
                if _renew(held, tangent, stiffness_scale, tolerance, jump_operator, laws.area, 1.0 + alpha, matrix) > 0:
                    renewals[0] += 1
                    if renewals[0] % REBUILD == 0:
                        sum_up(held, springs, jump_operator, laws.area, 1.0 + alpha, inverse, matrix)
                    solver[:] = np.linalg.inv(matrix)
                fresh = True
        if not np.isfinite(size):
            return step
        q_before[:] = q
        commit_modal(
            step, ag, ag_new, dt, alpha, beta, gamma_n, eigenvalues, base, tip, inverse, q_hat, h, force,
            q, v, a, residual, residual_change, flows, records,
        )  # fmt: skip
        interface_work(jump, elastic_slip, traction, g, e, t, laws, totals)
        record_slip(jump, elastic_slip, g, e, g_0, status, slip_path, slip_peak, slip_vector)
        jump[:] = g
        elastic_slip[:] = e
        traction[:] = t
        records[step, 5] = strain_energy(q, eigenvalues, jump, g_0, t_0, springs, laws.area, n)
        record_contact(records[step], totals, iterations, status)
        if (step + 1) % look_every == 0 or step == acceleration.shape[0] - 2:
            row = look_count[0]
            looks[row, :m] = q
            looks[row, m : 2 * m] = a
            looks[row, 2 * m : 2 * m + 3 * n] = s
            looks[row, 2 * m + 3 * n] = ag_new
            look_count[0] += 1
    return acceleration.shape[0] - 1


@numba.njit(cache=True)
def sum_up(held, springs, jump_operator, area, factor, inverse, matrix):
    """Sum the matrix up from the tangents it holds."""
    n, m = area.shape[0], matrix.shape[0]
    right = np.empty((3 * n, m))
    for k in range(n):
        slots = (2 * k, 2 * k + 1, 2 * n + k)
        for i in range(3):
            for col in range(m):
                total = -springs[slots[i]] * jump_operator[slots[i], col]
                for j in range(3):
                    total += held[k, i, j] * jump_operator[slots[j], col]
                right[slots[i], col] = factor * area[k] * total
    matrix[:] = np.dot(jump_operator.T, right)
    for i in range(m):
        matrix[i, i] += 1.0 / inverse[i]
