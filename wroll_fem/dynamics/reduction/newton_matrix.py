"""Newton's matrix of the condensed contact equations: LU factors of the active contact DOFs, compiled.

The equations are rho(g) = g - g_hat + F s(g) = 0 for the jump g (3 n,) after a time step (see `condensed`); Newton's
matrix is I + F (D - D_0), with the interface compliance F, the contact tangent D and the reference stiffness D_0. Only
contact DOFs whose tangent differs from D_0 need an unknown of the factorised matrix; the others follow from them.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact.kernels import SLIP
from wroll_fem.contact.point import AXIAL, HOOP, NORMAL, axial, component_of, hoop, normal, point_of
from wroll_fem.dynamics.reduction import interface_operator
from wroll_fem.dynamics.reduction.interface_operator import add_response
from wroll_fem.numerics import compiled_krylov, lu
from wroll_fem.numerics.compiled_krylov import combine, extend, krylov_space, start
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray, IntArray

drop_stale_cache(__file__, lu.__file__, interface_operator.__file__, compiled_krylov.__file__)

STIFFNESS_CHANGE = 0.3
"""Change of the tangential stiffness of a point, relative to the reference contact stiffness, above which the point is
included in Newton's dense matrix."""
STUCK_SHARE = 0.3
"""Share of the largest residual above which `include_points` includes a point."""
NEGLIGIBLE = np.float32(1e-12)
"""Entries of Newton's matrix, whose diagonal is near 1, that are replaced by zero. Entries that symmetry makes zero are
1e-40 by rounding, and such subnormal numbers make LU factors three times slower on some processors."""
KRYLOV_TOLERANCE, HOPELESS = 0.1, 1.5
"""Relative residual at which GMRES ends; it is given up if it seems to need `HOPELESS` times its iterations."""


class Factors(NamedTuple):
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


class Workspace(NamedTuple):
    """Arrays that the steps of one loop share, for n points.

    Attributes
    ----------
    tangent : (n, 3, 3) contact tangent, Pa/m
    included : (n,) points whose tangential degrees of freedom are always in the factorised matrix
    amplitudes : amplitudes of `add_response`
    traction : (3 n,) traction, Pa
    step : (3 n,) Newton step of the jump, m
    space : `KrylovSpace` of `krylov_step`
    """

    tangent: FloatArray
    included: np.ndarray
    amplitudes: FloatArray
    traction: FloatArray
    step: FloatArray
    space: compiled_krylov.KrylovSpace


@numba.njit(cache=True)
def workspace(interface, n, most):
    """`Workspace` for the `InterfaceOperator` of ``n`` points, and at most ``most`` iterations of GMRES."""
    return Workspace(
        np.zeros((n, 3, 3)), np.zeros(n, np.bool_), np.zeros(interface.sticking.blocks.shape[:2]), np.zeros(3 * n),
        np.zeros(3 * n), krylov_space(3 * n, most),
    )  # fmt: skip


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
def include_points(rho, size, everything, included):
    """Include the points whose residual exceeds `STUCK_SHARE` of the largest, ``size``, or, on demand, ``everything``.

    These are points that change between sticking and slipping, or points near their slip limit, whose friction depends
    on the normal jump.
    """
    n = included.shape[0]
    for k in range(n):
        own = max(abs(rho[hoop(k)]), abs(rho[axial(k)]), abs(rho[normal(k, n)]))
        if own > STUCK_SHARE * size or everything:
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
    return Factors(slides, active, change, matrix, lu.factor(matrix))


@numba.njit(cache=True)
def factored(interface, springs, status, work):
    """`Factors` for the contact tangent in ``work``, from the compliance that leaves fewer active DOFs.

    An open point has three of them beside springs that stick, and one beside springs that slide.
    """
    tangent = work.tangent
    active = _active_dofs(tangent, springs, status, work.included)
    if interface.sliding.dense.shape[0] > 0:
        others = _active_beside_sliding(tangent, springs)
        if others.shape[0] < active.shape[0]:
            return _factor(others, True, tangent, springs, interface.sliding.dense)
    return _factor(active, False, tangent, springs, interface.sticking.dense)


def no_factors():
    """Entries of `Factors` without active DOFs: Newton's matrix is the identity."""
    return False, np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 0), np.float32), np.empty(0, np.int32)


@numba.njit(cache=True)
def entries(factors):
    """Entries of `Factors`, for Python: an interrupt while a class of Python is called for a result is a crash."""
    return factors.slides, factors.active, factors.change, factors.matrix, factors.pivots


@numba.njit(cache=True)
def newton_step(factors, interface, area, springs, rho, work, delta):
    """Fill ``delta`` (3 n,), m, with the Newton step -(I + F (D - D_0))^{-1} rho for the residual ``rho`` (3 n,), m.

    F is the compliance with the springs D_0, D the contact tangent. If the factors `slides`, the compliance is F_1,
    without the tangential springs T of D_0, and the stiffness change is Delta = D - D_0 + T. The step is then
    -rho - F_1 (T rho + y) with (I + Delta F_1) y = -Delta (rho + F_1 T rho); see docs/theory.md.
    """
    active, change = factors.active, factors.change
    m, n = active.shape[0], area.shape[0]
    blocks = interface.sliding.blocks if factors.slides else interface.sticking.blocks
    traction, amplitudes = work.traction, work.amplitudes
    traction[:] = 0.0
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
def _apply_matrix(interface, area, springs, x, work, out):
    """Fill ``out`` (3 n,) with (I + F (D - D_0)) x, for the contact tangent D in ``work``."""
    n, tangent, traction = area.shape[0], work.tangent, work.traction
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        for row, dof in ((HOOP, h), (AXIAL, z), (NORMAL, r)):
            d = tangent[k, row]
            traction[dof] = d[HOOP] * x[h] + d[AXIAL] * x[z] + d[NORMAL] * x[r] - springs[dof] * x[dof]
    out[:] = x
    add_response(traction, area, interface.profiles, interface.sticking.blocks, work.amplitudes, out)


@numba.njit(cache=True)
def krylov_step(factors, interface, area, springs, rho, most, work, delta):
    """`newton_step` for the contact tangent in ``work``, by GMRES that ``factors`` of an earlier matrix precondition.

    Returns whether GMRES converges in ``most`` iterations; only then is ``delta`` filled.
    """
    space = work.space
    start(space, rho)
    left, goal = 0.0, np.log(KRYLOV_TOLERANCE)
    for k in range(most):
        direction, product = space.directions[k], space.vectors[k + 1]
        newton_step(factors, interface, area, springs, space.vectors[k], work, direction)  # -P b_k
        _apply_matrix(interface, area, springs, direction, work, product)
        left += np.log(extend(space, k))
        if left <= goal:
            combine(space, k + 1, delta)
            delta *= -1.0
            return np.isfinite(delta).all()
        if not (k + 1) * goal >= HOPELESS * most * left:
            return False
    return False
