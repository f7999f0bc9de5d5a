"""Compiled solution of a trigonometric step: friction laws at all points, and Newton's method with a kept matrix.

The iteration is that of `reduced_kernel.solve_step` with two differences, which make it faster. Forces take the matrix
of the jumps, so that one matrix stays in the cache of the processor. Newton's matrix is renewed later (`RENEWAL`):
a resolved mode depends on friction's correction by a twelfth of the square of its angle in a step only.
"""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.contact.kernels import consistent_tangent, trial_traction
from wroll_fem.contact.point import axial, hoop, normal
from wroll_fem.dynamics.time_stepping import modal_kernel, reduced_kernel
from wroll_fem.dynamics.time_stepping.modal_kernel import answer, by_block, correction
from wroll_fem.dynamics.time_stepping.reduced_kernel import REBUILD, TANGENT_CHANGE, renew, sum_up
from wroll_fem.dynamics.trigonometric import slip_path
from wroll_fem.dynamics.trigonometric.slip_path import slide_to_turning_points
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__, modal_kernel.__file__, reduced_kernel.__file__, slip_path.__file__)

RENEWAL = 0.25
"""Ratio of successive residuals above which a step renews Newton's matrix (small and dense)."""


@numba.njit(cache=True)
def _residual(x, q_hat, modal, interface, reference, contact, laws, step, trial, force, rho):
    """Fill ``rho`` (m,) with the residual of displacement ``x`` (m,); returns an upper bound of the jump due to rho, m.

    The residual is x - q_hat + A (G Phi)^T W s, with the displacement A per force (`answer`) and the traction
    correction s at x. ``force`` (m,) becomes (G Phi)^T W s.
    """
    trial.g[:] = np.dot(interface.jump, x)
    trial.g[:] += reference.jump
    return _residual_of_laws(x, q_hat, modal, interface, reference, contact, laws, step, trial, force, rho)


@numba.njit(cache=True)
def _residual_of_laws(x, q_hat, modal, interface, reference, contact, laws, step, trial, force, rho):
    """`_residual` for the relative displacement in ``trial``, which belongs to ``x``."""
    g, t, e, status, s = trial
    n = status.shape[0]
    trial_traction(g, contact.jump, contact.elastic_slip, laws, step.dt, t, e, status)
    correction(g, t, reference, s)
    weighted = np.empty(3 * n)
    for k in range(n):
        area = laws.area[k]
        weighted[hoop(k)], weighted[axial(k)] = area * s[hoop(k)], area * s[axial(k)]
        weighted[normal(k, n)] = area * s[normal(k, n)]
    force[:] = np.dot(interface.jump.T, weighted)
    weight, change = interface.weight, answer(modal, force, 1.0)
    size = 0.0
    for i in range(x.shape[0]):
        rho[i] = x[i] - q_hat[i] + change[i]
        size += abs(rho[i]) * weight[i]
    return size if np.isfinite(size) else np.inf


@numba.njit(cache=True)
def solve(x, q_hat, step, modal, interface, reference, laws, state, turning, newton, work):
    """Solve the equations of a step (`_residual`), starting at ``x`` (m,); returns the number of iterations, or -1.

    ``x`` becomes the solution. ``turning`` has the arrays ``beyond`` and ``limits`` of `slide_to_turning_points`;
    ``work`` is `Work`, the other arguments are those of `advance_trigonometric`.
    """
    contact, kept = state.contact, state.kept
    trial, rho, rho_new, force, force_new, x_new, tangent, scale = work
    history = newton.history
    trial.g[:] = np.dot(interface.jump, x)
    trial.g[:] += reference.jump
    slide_to_turning_points(trial.g, contact, state.moved, laws, step.dt, turning[0], turning[1])
    size = _residual_of_laws(x, q_hat, modal, interface, reference, contact, laws, step, trial, force, rho)
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
            new = _residual(x_new, q_hat, modal, interface, reference, contact, laws, step, trial, force_new, rho_new)
            if new < size or not fresh or damping < 0.02:
                break
            damping *= 0.5
        rate = new / size
        if rate < 1.0 or fresh:
            x[:], rho[:], force[:], size = x_new, rho_new, force_new, new
            history[iterations] = size
        else:  # the kept matrix failed: back to x, with the tangent there
            size = _residual(x, q_hat, modal, interface, reference, contact, laws, step, trial, force, rho)
        fresh = False
        if rate > RENEWAL and size > newton.limit:
            consistent_tangent(trial.g, contact.jump, contact.elastic_slip, laws, step.dt, tangent)
            tolerance = TANGENT_CHANGE if iterations < 4 else 0.0
            if renew(kept, tangent, scale, tolerance, interface.jump, laws.area, 1.0) > 0:
                kept.renewals[0] += 1
                if kept.renewals[0] % REBUILD == 0:
                    sum_up(kept, reference.springs, interface.jump, laws.area, 1.0, modal)
                kept.inverse[:] = np.linalg.inv(kept.matrix)
            fresh = True
    return iterations if np.isfinite(size) else -1
