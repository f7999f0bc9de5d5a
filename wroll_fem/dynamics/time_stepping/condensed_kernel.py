"""The compiled loop of the condensed time integration (equations in `condensed`).

State of a run, all relative to the preload state unless said:
``q, v, a`` (r,) modal displacement, velocity, acceleration; ``residual`` (r,) the modal r_n = K u + G^T W t - f;
``residual_change`` its change over the last step; ``jump`` and ``jump_before`` (3 n,) total relative
displacement now and one step ago; ``elastic_slip`` (2 n,) and ``traction`` (3 n,) committed contact state.
"""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.contact.kernels import OPEN, SLIP, consistent_tangent, interface_work, record_slip, trial_traction
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__)

STIFFNESS_CHANGE = 0.1
"""A point joins Newton's dense matrix when its stick stiffness left the preload state's by this fraction."""
STALE_RATE = 0.3
"""A kept factor is renewed when an iteration reduces the residual by less than this."""


@numba.njit(cache=True)
def correction(g, t, g_0, t_0, springs, s):
    """s = t - t_0 - D_0 (g - g_0), Pa."""
    for i in range(g.shape[0]):
        s[i] = t[i] - t_0[i] - springs[i] * (g[i] - g_0[i])


@numba.njit(cache=True)
def _gather(s, area, profiles, n, amplitudes):
    """Amplitudes (n_blocks, 3 n_rows) of the point forces area * s, component by component."""
    n_blocks, n_theta = profiles.shape[1], profiles.shape[2]
    rows = n // n_theta
    force = np.empty((rows, n_theta))
    for c in range(3):
        for row in range(rows):
            for i in range(n_theta):
                k = row * n_theta + i
                slot = 2 * k + c if c < 2 else 2 * n + k
                force[row, i] = area[k] * s[slot]
        projected = np.dot(force, profiles[c].T)
        for b in range(n_blocks):
            for row in range(rows):
                amplitudes[b, c * rows + row] = projected[row, b]


@numba.njit(cache=True)
def _scatter(amplitudes, profiles, n, out):
    """Add the point values (3 n,) of amplitudes (n_blocks, 3 n_rows) to ``out``."""
    n_blocks, n_theta = profiles.shape[1], profiles.shape[2]
    rows = n // n_theta
    part = np.empty((rows, n_blocks))
    for c in range(3):
        for b in range(n_blocks):
            for row in range(rows):
                part[row, b] = amplitudes[b, c * rows + row]
        values = np.dot(part, profiles[c])
        for row in range(rows):
            for i in range(n_theta):
                k = row * n_theta + i
                slot = 2 * k + c if c < 2 else 2 * n + k
                out[slot] += values[row, i]


@numba.njit(cache=True)
def _interface_residual(g, g_hat, blocks, profiles, area, s, n, amplitudes, rho):
    """rho = g - g_hat + F s. Returns max |rho|, m."""
    for i in range(3 * n):
        rho[i] = g[i] - g_hat[i]
    _gather(s, area, profiles, n, amplitudes)
    for b in range(blocks.shape[0]):
        amplitudes[b] = np.dot(blocks[b], amplitudes[b])
    _scatter(amplitudes, profiles, n, rho)
    largest = 0.0
    for i in range(3 * n):
        if not np.isfinite(rho[i]):
            return np.inf
        largest = max(largest, abs(rho[i]))
    return largest


@numba.njit(cache=True)
def _free_jump(q, starts, modal_jump, profiles, n, amplitudes, out):
    """Add the jump of modal coordinates q to ``out`` (3 n,)."""
    size = amplitudes.shape[1]
    for b in range(amplitudes.shape[0]):
        first, last = starts[b], starts[b + 1]
        block = modal_jump[size * first : size * last].reshape(size, last - first)
        amplitudes[b] = np.dot(block, q[first:last])
    _scatter(amplitudes, profiles, n, out)


@numba.njit(cache=True)
def _modal_force(s, area, starts, modal_jump, profiles, n, amplitudes, force):
    """Modal force (r,) of the interface correction s: G^T W s in modal coordinates."""
    _gather(s, area, profiles, n, amplitudes)
    size = amplitudes.shape[1]
    for b in range(amplitudes.shape[0]):
        first, last = starts[b], starts[b + 1]
        block = modal_jump[size * first : size * last].reshape(size, last - first)
        force[first:last] = np.dot(amplitudes[b], block)


@numba.njit(cache=True)
def _active_slots(tangent, springs, status, everything, n):
    """Slots whose tangent differs enough from the built-in springs to be solved for."""
    active = np.empty(3 * n, np.int64)
    m = 0
    for k in range(n):
        change = abs(tangent[k, 0, 0] - springs[2 * k]) + abs(tangent[k, 1, 1] - springs[2 * k + 1])
        base = springs[2 * k] + springs[2 * k + 1]
        if everything or status[k] == SLIP or change > STIFFNESS_CHANGE * base:
            active[m] = 2 * k
            active[m + 1] = 2 * k + 1
            m += 2
    for k in range(n):
        if abs(tangent[k, 2, 2] - springs[2 * n + k]) > 0.0:
            active[m] = 2 * n + k
            m += 1
    return active[:m]


@numba.njit(cache=True)
def _factor(active, tangent, springs, compliance, n):
    """Delta D on the active rows (m, 3) and the inverse of (I + Delta D F) on the active slots (m, m)."""
    m = active.shape[0]
    change = np.empty((m, 3))
    matrix = np.empty((m, m))
    slots = np.empty(3, np.int64)
    for i in range(m):
        slot = active[i]
        k = slot // 2 if slot < 2 * n else slot - 2 * n
        row = slot - 2 * k if slot < 2 * n else 2
        slots[0], slots[1], slots[2] = 2 * k, 2 * k + 1, 2 * n + k
        for c in range(3):
            change[i, c] = tangent[k, row, c]
        change[i, row] -= springs[slot]
        c0, c1, c2 = change[i, 0], change[i, 1], change[i, 2]
        f0, f1, f2 = compliance[slots[0]], compliance[slots[1]], compliance[slots[2]]
        for j in range(m):
            a = active[j]
            matrix[i, j] = c0 * f0[a] + c1 * f1[a] + c2 * f2[a]
        matrix[i, i] += 1.0
    return change, np.ascontiguousarray(np.linalg.inv(matrix))


@numba.njit(cache=True)
def _newton_step(active, change, inverse, blocks, profiles, area, rho, n, amplitudes, delta):
    """delta = -(I + F Delta D)^{-1} rho with Delta D restricted to the active rows."""
    m = active.shape[0]
    rhs = np.empty(m)
    for i in range(m):
        slot = active[i]
        k = slot // 2 if slot < 2 * n else slot - 2 * n
        rhs[i] = -(change[i, 0] * rho[2 * k] + change[i, 1] * rho[2 * k + 1] + change[i, 2] * rho[2 * n + k])
    y = np.dot(inverse, rhs)
    full = np.zeros(3 * n)
    for i in range(m):
        full[active[i]] = y[i]
    delta[:] = -rho
    _gather(full, area, profiles, n, amplitudes)
    for b in range(blocks.shape[0]):
        amplitudes[b] = -np.dot(blocks[b], amplitudes[b])
    _scatter(amplitudes, profiles, n, delta)


@numba.njit(cache=True)
def advance_steps(
    acceleration, dt, alpha, beta, gamma_n,
    eigenvalues, starts, modal_jump, profiles, base, tip, springs, inverse, blocks, compliance,
    g_0, t_0,
    laws,
    q, v, a, residual, residual_change,
    jump, jump_before, elastic_slip, traction,
    totals, flows, slip_path, slip_peak, slip_vector,
    limit, max_iterations, history, records,
):  # fmt: skip
    """Advance len(acceleration) - 1 steps; returns the number done (state is that of the last good step).

    ``starts`` (n_blocks + 1,), flat ``modal_jump``, ``profiles`` (3, n_blocks, n_theta) and ``blocks``
    (n_blocks, 3 n_rows, 3 n_rows) hold the harmonics; ``compliance`` (3 n, 3 n) is F itself, for Newton's matrix.
    """
    area = laws.area
    n = area.shape[0]
    t, e, status = np.empty(3 * n), np.empty(2 * n), np.empty(n, np.int64)
    s, rho, delta, g, g_try = np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n)
    amplitudes = np.zeros((blocks.shape[0], blocks.shape[1]))
    g_hat, force = np.zeros(3 * n), np.zeros(q.shape[0])
    tangent = np.zeros((n, 3, 3))
    active = np.empty(0, np.int64)
    change, factor = np.empty((0, 3)), np.empty((0, 0))
    have_factor = False

    for step in range(acceleration.shape[0] - 1):
        ag, ag_new = acceleration[step], acceleration[step + 1]
        h = (q + dt * v + dt * dt * (0.5 - beta) * a) / (beta * dt * dt)
        q_hat = (h - (1.0 + alpha) * base * ag_new + alpha * residual) * inverse
        iterations = 0
        converged = True
        if n > 0:
            g_hat[:] = g_0
            _free_jump(q_hat, starts, modal_jump, profiles, n, amplitudes, g_hat)
            for i in range(3 * n):
                g[i] = 2.0 * jump[i] - jump_before[i]
            trial_traction(g, jump, elastic_slip, laws, dt, t, e, status)
            correction(g, t, g_0, t_0, springs, s)
            size = _interface_residual(g, g_hat, blocks, profiles, area, s, n, amplitudes, rho)
            history[:] = 0.0
            history[0] = size
            fresh = False
            everything = False
            while size > limit:
                if iterations == max_iterations:
                    converged = False
                    break
                if not have_factor:
                    consistent_tangent(g, jump, elastic_slip, laws, dt, tangent)
                    active = _active_slots(tangent, springs, status, everything, n)
                    change, factor = _factor(active, tangent, springs, compliance, n)
                    have_factor = True
                    fresh = True
                _newton_step(active, change, factor, blocks, profiles, area, rho, n, amplitudes, delta)
                iterations += 1
                damping = 1.0
                while True:
                    for i in range(3 * n):
                        g_try[i] = g[i] + damping * delta[i]
                    trial_traction(g_try, jump, elastic_slip, laws, dt, t, e, status)
                    correction(g_try, t, g_0, t_0, springs, s)
                    new = _interface_residual(g_try, g_hat, blocks, profiles, area, s, n, amplitudes, rho)
                    if new < size or not fresh or damping < 0.1:
                        break
                    damping *= 0.5
                rate = new / size
                if rate >= 1.0 and not fresh:
                    # a kept factor failed: go back and renew it where we were
                    trial_traction(g, jump, elastic_slip, laws, dt, t, e, status)
                    correction(g, t, g_0, t_0, springs, s)
                    size = _interface_residual(g, g_hat, blocks, profiles, area, s, n, amplitudes, rho)
                    have_factor = False
                    continue
                g[:] = g_try
                size = new
                history[iterations] = size
                if rate > STALE_RATE:
                    have_factor = False
                    everything = everything or (fresh and iterations > 8)
                fresh = False
            if not converged:
                return step
            _modal_force(s, area, starts, modal_jump, profiles, n, amplitudes, force)
        commit_modal(
            step, ag, ag_new, dt, alpha, beta, gamma_n, eigenvalues, base, tip, inverse, q_hat, h, force,
            q, v, a, residual, residual_change, flows, records,
        )  # fmt: skip
        if n > 0:
            interface_work(jump, elastic_slip, traction, g, e, t, laws, totals)
            record_slip(jump, elastic_slip, g, e, g_0, status, slip_path, slip_peak, slip_vector)
            jump_before[:] = jump
            jump[:] = g
            elastic_slip[:] = e
            traction[:] = t
        records[step, 5] = strain_energy(q, eigenvalues, jump, g_0, t_0, springs, area, n)
        record_contact(records[step], totals, iterations, status)
    return acceleration.shape[0] - 1


@numba.njit(cache=True)
def record_contact(record, totals, iterations, status):
    """Ledger of the interfaces (J), iterations, and the fractions of the points that are open and slip."""
    record[6] = totals[1]
    record[7] = totals[0]
    record[8] = totals[2]
    record[10] = totals[3]
    record[15] = totals[4]
    record[11] = iterations
    slipping, opened = 0, 0
    for k in range(status.shape[0]):
        slipping += status[k] == SLIP
        opened += status[k] == OPEN
    record[12] = opened / max(status.shape[0], 1)
    record[13] = slipping / max(status.shape[0], 1)


@numba.njit(cache=True)
def strain_energy(q, eigenvalues, jump, g_0, t_0, springs, area, n):
    """Strain energy of the bodies and work of the preload forces since the preload state, J."""
    energy = 0.5 * np.dot(q * eigenvalues, q)
    for i in range(3 * n):
        d = jump[i] - g_0[i]
        w = area[i // 2 if i < 2 * n else i - 2 * n]
        energy -= w * (0.5 * springs[i] * d * d + t_0[i] * d)
    return energy


@numba.njit(cache=True)
def commit_modal(
    step, ag, ag_new, dt, alpha, beta, gamma_n, eigenvalues, base, tip, inverse, q_hat, h, force,
    q, v, a, residual, residual_change, flows, records,
):  # fmt: skip
    """Newmark update, input work and the scheme's own dissipation (derived in docs/theory.md)."""
    du_dr, du_da, aa, aa_new, da_da, base_du = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    u_tip, v_tip, a_tip, kinetic = 0.0, 0.0, 0.0, 0.0
    for i in range(q.shape[0]):
        q_new = q_hat[i] - (1.0 + alpha) * inverse[i] * force[i]
        a_new = q_new / (beta * dt * dt) - h[i]
        v_new = v[i] + dt * ((1.0 - gamma_n) * a[i] + gamma_n * a_new)
        r_new = eigenvalues[i] * q_new + force[i] + base[i] * ag_new
        du, da, dr = q_new - q[i], a_new - a[i], r_new - residual[i]
        du_dr += du * (dr + residual_change[i])
        du_da += du * da
        aa += a[i] * a[i]
        aa_new += a_new * a_new
        da_da += da * da
        base_du += base[i] * du
        kinetic += 0.5 * v_new * v_new
        u_tip += tip[i] * q_new
        v_tip += tip[i] * v_new
        a_tip += tip[i] * a_new
        q[i], v[i], a[i] = q_new, v_new, a_new
        residual[i], residual_change[i] = r_new, dr
    flows[0] -= 0.5 * (ag + ag_new) * base_du
    flows[1] += 0.5 * alpha * du_dr - (gamma_n - 0.5) * du_da
    flows[1] += dt * dt * (beta - 0.5 * gamma_n) * (0.5 * (aa_new - aa) + (gamma_n - 0.5) * da_da)
    records[step, 0] = u_tip
    records[step, 1] = v_tip
    records[step, 2] = a_tip
    records[step, 3] = flows[0]
    records[step, 4] = kinetic
    records[step, 9] = flows[1]
