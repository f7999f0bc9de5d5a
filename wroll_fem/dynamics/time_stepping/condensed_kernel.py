"""Compiled loop of the condensed time integration (equations in `condensed`)."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact.kernels import (
    SLIP,
    consistent_tangent,
    interface_work,
    record_opening,
    record_slip,
    trial_traction,
)
from wroll_fem.contact.point import AXIAL, HOOP, NORMAL, axial, component_of, hoop, normal, point_of
from wroll_fem.dynamics.reduction import interface_operator
from wroll_fem.dynamics.reduction.interface_operator import add_free_jump, add_response, fill_modal_force
from wroll_fem.dynamics.time_stepping import modal_kernel, records
from wroll_fem.dynamics.time_stepping.modal_kernel import commit_motion, correction, predict, strain_energy
from wroll_fem.dynamics.time_stepping.records import STRAIN, record_contact
from wroll_fem.dynamics.time_stepping.state import ContactMemory, Motion
from wroll_fem.numerics import compiled_krylov, lu
from wroll_fem.numerics import newton as rates
from wroll_fem.numerics.compiled_krylov import combine, extend, krylov_space, start
from wroll_fem.numerics.newton import CONDENSED_RENEWAL, SLIDING_RENEWAL
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray, IntArray

drop_stale_cache(
    __file__, modal_kernel.__file__, records.__file__, rates.__file__, lu.__file__, interface_operator.__file__,
    compiled_krylov.__file__,
)  # fmt: skip

STIFFNESS_CHANGE = 0.3
"""Change of the tangential stiffness of a point, relative to the reference contact stiffness, above which the point is
included in Newton's dense matrix."""
STUCK_RATE, STUCK_SHARE = 0.5, 0.3
"""If an iteration with a new matrix leaves more than `STUCK_RATE` of the residual, points whose own residual exceeds
`STUCK_SHARE` of it are included until the end of the step. These are points that change between sticking and slipping,
or points near their slip limit, whose friction depends on the normal jump."""
ALL_POINTS = 20
"""Number of iterations after which all points are included."""
NEGLIGIBLE = np.float32(1e-12)
"""Entries of Newton's matrix, whose diagonal is near 1, that are replaced by zero. Entries that symmetry makes zero are
1e-40 by rounding, and such subnormal numbers make LU factors three times slower on some processors."""
UNKNOWNS_PER_ITERATION, MOST_ITERATIONS = 50, 12
"""Number of active DOFs per iteration of GMRES that is tried before new factors; largest number of iterations."""
KRYLOV_TOLERANCE, HOPELESS = 0.1, 1.5
"""Relative residual at which GMRES ends; it is given up if it seems to need `HOPELESS` times its iterations."""
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


class _Factors(NamedTuple):
    """Newton's matrix of m active contact DOFs.

    Attributes
    ----------
    slides : whether the matrix starts from the compliance `InterfaceOperator.sliding`
    active : (m,) active contact DOFs
    change : (m, 3) rows of the stiffness change
    matrix, pivots : (m, m), (m,) LU factors, see `lu.factor`
    """

    slides: bool
    active: IntArray
    change: FloatArray
    matrix: np.ndarray
    pivots: np.ndarray


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


@numba.njit(cache=True)
def _active_dofs(tangent, springs, status, included):
    """Contact degrees of freedom in Newton's matrix: their tangent differs enough from the reference stiffness.

    The tangential degrees of freedom of the points ``included`` (n,) are always among them.
    """
    n = status.shape[0]
    active = np.empty(3 * n, np.int64)
    m = 0
    for k in range(n):
        h, z = hoop(k), axial(k)
        change = abs(tangent[k, HOOP, HOOP] - springs[h]) + abs(tangent[k, AXIAL, AXIAL] - springs[z])
        base = springs[h] + springs[z]
        if included[k] or status[k] == SLIP or change > STIFFNESS_CHANGE * base:
            active[m] = h
            active[m + 1] = z
            m += 2
    for k in range(n):
        if abs(tangent[k, NORMAL, NORMAL] - springs[normal(k, n)]) > 0.0:
            active[m] = normal(k, n)
            m += 1
    return active[:m]


@numba.njit(cache=True)
def _active_beside_sliding(tangent, springs):
    """Contact degrees of freedom whose tangent differs from the springs that `InterfaceOperator.sliding` contains.

    These are all tangential ones of closed points, and normal ones of points that have opened or closed.
    """
    n = tangent.shape[0]
    active = np.empty(3 * n, np.int64)
    m = 0
    for k in range(n):
        if tangent[k, HOOP, HOOP] != 0.0 or tangent[k, AXIAL, AXIAL] != 0.0:
            active[m] = hoop(k)
            active[m + 1] = axial(k)
            m += 2
    for k in range(n):
        if tangent[k, NORMAL, NORMAL] != springs[normal(k, n)]:
            active[m] = normal(k, n)
            m += 1
    return active[:m]


@numba.njit(cache=True)
def _include(rho, size, iterations, included):
    """Include points in Newton's matrix after a poor iteration with a new matrix; see `STUCK_SHARE`, `ALL_POINTS`."""
    n = included.shape[0]
    for k in range(n):
        own = max(abs(rho[hoop(k)]), abs(rho[axial(k)]), abs(rho[normal(k, n)]))
        if own > STUCK_SHARE * size or iterations > ALL_POINTS:
            included[k] = True


@numba.njit(cache=True)
def _factor(active, slides, tangent, springs, compliance):
    """Rows (m, 3) of the stiffness change Delta D, and LU factors of I + Delta D F (m, m), for m active contact DOFs.

    Delta D is the contact tangent minus the reference contact stiffness, F the interface ``compliance`` (3 n, 3 n) with
    this stiffness; if the compliance ``slides``, it has no tangential springs. The factors are in single precision,
    which halves their cost: they only correct residuals that are computed in double precision.
    """
    m, n = active.shape[0], tangent.shape[0]
    change = np.empty((m, 3))
    matrix = np.empty((m, m), np.float32)
    for i in range(m):
        dof = active[i]
        k, row = point_of(dof, n), component_of(dof, n)
        for c in range(3):
            change[i, c] = tangent[k, row, c]
        if row == NORMAL or not slides:
            change[i, row] -= springs[dof]
        c0, c1, c2 = np.float32(change[i, 0]), np.float32(change[i, 1]), np.float32(change[i, 2])
        f0, f1, f2 = compliance[hoop(k)], compliance[axial(k)], compliance[normal(k, n)]
        for j in range(m):
            a = active[j]
            value = c0 * f0[a] + c1 * f1[a] + c2 * f2[a]
            matrix[i, j] = value if abs(value) > NEGLIGIBLE else np.float32(0.0)
        matrix[i, i] += 1.0
    return _Factors(slides, active, change, matrix, lu.factor(matrix))


@numba.njit(cache=True)
def _factored(tangent, springs, status, included, interface):
    """`_Factors` for the contact ``tangent`` (n, 3, 3), from the compliance that leaves fewer active DOFs.

    An open point has three of them beside springs that stick, and one beside springs that slide.
    """
    active = _active_dofs(tangent, springs, status, included)
    if interface.sliding.dense.shape[0] > 0:
        others = _active_beside_sliding(tangent, springs)
        if others.shape[0] < active.shape[0]:
            return _factor(others, True, tangent, springs, interface.sliding.dense)
    return _factor(active, False, tangent, springs, interface.sticking.dense)


def no_factors():
    """Entries of `_Factors` without active DOFs: Newton's matrix is the identity."""
    return False, np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 0), np.float32), np.empty(0, np.int32)


@numba.njit(cache=True)
def _entries(factors):
    """Entries of `_Factors`, for Python: an interrupt while a class of Python is called for a result is a crash."""
    return factors.slides, factors.active, factors.change, factors.matrix, factors.pivots


@numba.njit(cache=True)
def _newton_step(factors, interface, area, springs, rho, amplitudes, delta):
    """Fill ``delta`` (3 n,), m, with the Newton step -(I + F (D - D_0))^{-1} rho for the residual ``rho`` (3 n,), m.

    F is the compliance with the springs D_0, D the contact tangent. If the factors `slides`, the compliance is F_1,
    without the tangential springs T of D_0, and the stiffness change is Delta = D - D_0 + T. The step is then
    -rho - F_1 (T rho + y) with (I + Delta F_1) y = -Delta (rho + F_1 T rho); see docs/theory.md.
    """
    active, change = factors.active, factors.change
    m, n = active.shape[0], area.shape[0]
    blocks = interface.sliding.blocks if factors.slides else interface.sticking.blocks
    traction = np.zeros(3 * n)
    delta[:] = rho
    if factors.slides:
        for i in range(2 * n):
            traction[i] = springs[i] * rho[i]
        add_response(traction, area, interface.profiles, blocks, amplitudes, delta)
    y = np.empty(m, np.float32)
    for i in range(m):
        k = point_of(active[i], n)
        y[i] = -(change[i, 0] * delta[hoop(k)] + change[i, 1] * delta[axial(k)] + change[i, 2] * delta[normal(k, n)])
    lu.solve(factors.matrix, factors.pivots, y)
    for i in range(m):
        traction[active[i]] += y[i]
    delta[:] = rho
    add_response(traction, area, interface.profiles, blocks, amplitudes, delta)
    for i in range(3 * n):
        delta[i] = -delta[i]


@numba.njit(cache=True)
def _apply_matrix(tangent, interface, area, springs, traction, amplitudes, x, out):
    """Fill ``out`` (3 n,) with (I + F (D - D_0)) x, for the contact ``tangent`` D; ``traction`` (3 n,): work array."""
    n = area.shape[0]
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        for row, dof in ((HOOP, h), (AXIAL, z), (NORMAL, r)):
            d = tangent[k, row]
            traction[dof] = d[HOOP] * x[h] + d[AXIAL] * x[z] + d[NORMAL] * x[r] - springs[dof] * x[dof]
    out[:] = x
    add_response(traction, area, interface.profiles, interface.sticking.blocks, amplitudes, out)


@numba.njit(cache=True)
def _krylov_step(factors, tangent, interface, area, springs, rho, most, traction, amplitudes, space, delta):
    """`_newton_step` for the contact ``tangent``, by GMRES that the ``factors`` of an earlier matrix precondition.

    Returns whether GMRES converges in ``most`` iterations; only then is ``delta`` filled.
    """
    start(space, rho)
    left, goal = 0.0, np.log(KRYLOV_TOLERANCE)
    for k in range(most):
        direction, product = space.directions[k], space.vectors[k + 1]
        _newton_step(factors, interface, area, springs, space.vectors[k], amplitudes, direction)  # -P b_k
        _apply_matrix(tangent, interface, area, springs, traction, amplitudes, direction, product)
        left += np.log(extend(space, k))
        if left <= goal:
            combine(space, k + 1, delta)
            delta *= -1.0
            return np.isfinite(delta).all()
        if not (k + 1) * goal >= HOPELESS * most * left:
            return False
    return False


@numba.njit(cache=True)
def _extrapolate(state, g):
    """Fill ``g`` (3 n,) with the first guess of the jump after a step."""
    for i in range(g.shape[0]):
        g[i] = 2.0 * state.contact.jump[i] - state.jump_before[i]


@numba.njit(cache=True)
def advance_steps(acceleration, step, modal, interface, reference, laws, state, newton, accumulated, records, kept):
    """Advance by up to len(acceleration) - 1 steps; returns their number, and the entries of the last `_Factors`.

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
    area, springs, dt = laws.area, reference.springs, step.dt
    motion, contact, history = state.motion, state.contact, newton.history
    n = area.shape[0]
    t, e, status = np.empty(3 * n), np.empty(2 * n), np.empty(n, np.int64)
    s, rho, delta, g, g_try = np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n)
    here, there = _Trial(g, t, e, status, s, rho), _Trial(g_try, t, e, status, s, rho)
    amplitudes = np.zeros(interface.sticking.blocks.shape[:2])
    g_hat, force = np.zeros(3 * n), np.zeros(motion.q.shape[0])
    tangent = np.zeros((n, 3, 3))
    space, traction = krylov_space(3 * n, MOST_ITERATIONS), np.zeros(3 * n)
    factors, have_factor, lags = _Factors(*kept), False, False
    included = np.zeros(n, np.bool_)

    for number in range(acceleration.shape[0] - 1):
        h, q_hat = predict(motion, acceleration[number + 1], step, modal)
        iterations = 0
        if n > 0:
            g_hat[:] = reference.jump
            add_free_jump(q_hat, interface, amplitudes, g_hat)
            _extrapolate(state, g)
            size = _residual(g_hat, interface, reference, contact, laws, dt, here, amplitudes)
            history[:] = 0.0
            history[0] = size
            fresh, krylov_iterations = False, KRYLOV_ITERATIONS
            included[:] = False
            while size > newton.limit:
                if iterations == newton.max_iterations and krylov_iterations > 0:
                    # once more, from a new matrix and without GMRES: cycles depend on where the iteration starts
                    iterations, krylov_iterations, have_factor = 0, 0, False
                    _extrapolate(state, g)
                    size = _residual(g_hat, interface, reference, contact, laws, dt, here, amplitudes)
                    history[1:] = 0.0
                    included[:] = False
                if iterations == newton.max_iterations:
                    return number, _entries(factors)
                lags = False
                if not have_factor:
                    consistent_tangent(g, contact.jump, contact.elastic_slip, laws, dt, tangent)
                    fresh = True
                    if iterations < krylov_iterations:
                        most = min(factors.active.shape[0] // UNKNOWNS_PER_ITERATION, MOST_ITERATIONS)
                        lags = _krylov_step(
                            factors, tangent, interface, area, springs, rho, most, traction, amplitudes, space, delta
                        )
                    if not lags:
                        factors = _factored(tangent, springs, status, included, interface)
                        have_factor = True
                if not lags:
                    _newton_step(factors, interface, area, springs, rho, amplitudes, delta)
                iterations += 1
                damping = 1.0
                while True:
                    for i in range(3 * n):
                        g_try[i] = g[i] + damping * delta[i]
                    new = _residual(g_hat, interface, reference, contact, laws, dt, there, amplitudes)
                    if new < size or not fresh or damping < SHORTEST:
                        break
                    damping *= 0.5
                rate = new / size
                if rate >= 1.0 and not fresh:
                    # a kept factor failed: go back and renew it there
                    size = _residual(g_hat, interface, reference, contact, laws, dt, here, amplitudes)
                    have_factor = False
                    continue
                g[:] = g_try
                size = new
                history[iterations] = size
                if rate > (SLIDING_RENEWAL if factors.slides else CONDENSED_RENEWAL):
                    have_factor = False
                    if fresh and (rate > STUCK_RATE or iterations > ALL_POINTS):
                        _include(rho, size, iterations, included)
                fresh = False
            fill_modal_force(s, area, interface, amplitudes, force)
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
    return acceleration.shape[0] - 1, _entries(factors)
