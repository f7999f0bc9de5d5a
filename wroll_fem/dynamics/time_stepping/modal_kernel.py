"""Compiled functions for steps of a structure in modal coordinates, shared by the condensed and the reduced loop."""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.contact import point
from wroll_fem.contact.point import point_of
from wroll_fem.dynamics.time_stepping import records
from wroll_fem.dynamics.time_stepping.records import (
    FIRST_PROBE,
    INPUT_FLOW,
    KINETIC,
    NUMERICAL_FLOW,
    OF_PROBE,
    TIP_ACCELERATION,
    TIP_DISPLACEMENT,
    TIP_VELOCITY,
    VISCOUS_FLOW,
    record_flows,
)
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__, records.__file__)


@numba.njit(cache=True)
def correction(g, t, reference, s):
    """Fill ``s`` with the traction correction t - t_0 - D_0 (g - g_0), Pa; index 0 denotes the preload state."""
    g_0, t_0, springs = reference.jump, reference.traction, reference.springs
    for i in range(g.shape[0]):
        s[i] = point.correction(t[i], t_0[i], springs[i], g[i] - g_0[i])


@numba.njit(cache=True)
def damped(dashpots):
    """Whether the structure has viscous damping."""
    return dashpots.rates.shape[0] + dashpots.coupling.shape[0] > 0


@numba.njit(cache=True)
def by_block(flat, starts, x):
    """(m,) product of a matrix of blocks, a flat array as in `Dashpots`, with ``x`` (m,)."""
    out = np.empty(x.shape[0])
    at = 0
    for b in range(starts.shape[0] - 1):
        first, last = starts[b], starts[b + 1]
        size = last - first
        out[first:last] = np.dot(flat[at : at + size * size].reshape(size, size), x[first:last])
        at += size * size
    return out


@numba.njit(cache=True)
def viscous_force(dashpots, velocity):
    """(m,) forces of the dashpots at ``velocity`` (m,); the structure is damped."""
    if dashpots.coupling.shape[0] > 0:
        return by_block(dashpots.coupling, dashpots.starts, velocity)
    return dashpots.rates * velocity


@numba.njit(cache=True)
def answer(modal, force, factor):
    """(m,) displacement after a step due to ``factor`` times ``force`` (m,)."""
    if modal.dashpots.coupling.shape[0] > 0:
        return factor * by_block(modal.dashpots.solution, modal.dashpots.starts, force)
    return factor * modal.inverse * force


@numba.njit(cache=True)
def predict(motion, ag_new, step, modal):
    """Newmark's history term h (m,), and displacement q_hat (m,) after the step if the traction correction is zero."""
    dt, alpha, beta, gamma = step
    h = (motion.q + dt * motion.v + dt * dt * (0.5 - beta) * motion.a) / (beta * dt * dt)
    force = h - (1.0 + alpha) * modal.base * ag_new + alpha * motion.residual
    if damped(modal.dashpots):
        coasting = motion.v + dt * ((1.0 - gamma) * motion.a - gamma * h)  # velocity after a step without displacement
        force -= (1.0 + alpha) * viscous_force(modal.dashpots, coasting)
    return h, answer(modal, force, 1.0)


@numba.njit(cache=True)
def strain_energy(motion, modal, jump, reference, area):
    """Change of the strain energy of the bodies since the preload state, minus the work of the preload forces, J."""
    n = area.shape[0]
    energy = 0.5 * np.dot(motion.q * modal.eigenvalues, motion.q)
    for i in range(3 * n):
        d = jump[i] - reference.jump[i]
        energy -= area[point_of(i, n)] * (0.5 * reference.springs[i] * d * d + reference.traction[i] * d)
    return energy


@numba.njit(cache=True)
def commit_motion(acceleration, step, modal, h, q_hat, force, motion, accumulated, record):
    """Update the motion by Newmark's formulas; add the work of base, dashpots and scheme (derived in docs/theory.md).

    Parameters
    ----------
    acceleration : (2,) base acceleration at both ends of the step, m/s^2
    step, modal : `Step`, `Modal`
    h, q_hat : from `predict`
    force : (m,) modal force of the traction correction
    motion, accumulated : `Motion` and `Accumulated`, updated
    record : (record_size(p),) output
    """
    dt, alpha, beta, gamma = step
    eigenvalues, base, tip, probes = modal.eigenvalues, modal.base, modal.tip, modal.probes
    q, v, a, residual, residual_change = motion
    ag, ag_new = acceleration[0], acceleration[1]
    du_dr, du_da, aa, aa_new, da_da, base_du = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    u_tip, v_tip, a_tip, kinetic = 0.0, 0.0, 0.0, 0.0
    change = answer(modal, force, 1.0 + alpha)
    viscous, has_dashpots = force, damped(modal.dashpots)
    if has_dashpots:
        v_end = np.empty(q.shape[0])
        for i in range(q.shape[0]):
            a_new = (q_hat[i] - change[i]) / (beta * dt * dt) - h[i]
            v_end[i] = v[i] + dt * ((1.0 - gamma) * a[i] + gamma * a_new)
        viscous = viscous_force(modal.dashpots, v_end)
        lost = viscous_force(modal.dashpots, v + v_end)
        for i in range(q.shape[0]):
            accumulated.flows[VISCOUS_FLOW] += 0.5 * (q_hat[i] - change[i] - q[i]) * lost[i]
    for i in range(q.shape[0]):
        q_new = q_hat[i] - change[i]
        a_new = q_new / (beta * dt * dt) - h[i]
        v_new = v[i] + dt * ((1.0 - gamma) * a[i] + gamma * a_new)
        r_new = eigenvalues[i] * q_new + force[i] + base[i] * ag_new
        if has_dashpots:
            r_new += viscous[i]
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
    flows = accumulated.flows
    flows[INPUT_FLOW] -= 0.5 * (ag + ag_new) * base_du
    flows[NUMERICAL_FLOW] += 0.5 * alpha * du_dr - (gamma - 0.5) * du_da
    flows[NUMERICAL_FLOW] += dt * dt * (beta - 0.5 * gamma) * (0.5 * (aa_new - aa) + (gamma - 0.5) * da_da)
    record[TIP_DISPLACEMENT] = u_tip
    record[TIP_VELOCITY] = v_tip
    record[TIP_ACCELERATION] = a_tip
    record[KINETIC] = kinetic
    for k in range(probes.shape[0]):
        u_probe, v_probe, a_probe = 0.0, 0.0, 0.0
        for i in range(q.shape[0]):
            u_probe += probes[k, i] * q[i]
            v_probe += probes[k, i] * v[i]
            a_probe += probes[k, i] * a[i]
        first = FIRST_PROBE + OF_PROBE * k
        record[first], record[first + 1], record[first + 2] = u_probe, v_probe, a_probe
    record_flows(record, accumulated)
