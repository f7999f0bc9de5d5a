r"""Compiled contact: traction, tangent and work at every interface point.

Component order ("slots") of all interface vectors of ``n`` points: hoop and axial of point ``k`` in
slots ``2 k`` and ``2 k + 1``, its normal in slot ``2 n + k``. Tangential slots come first because
they alone change their law while the contact stays closed.

With the relative displacement :math:`g` (outer minus inner body), pressure :math:`p` and the law E of the point
(see `laws`)

.. math::
    t_n = k_n g_n, \quad p = \max(0, -t_n), \qquad
    e = E(e_c + \Delta g_t, \Delta g_t; \Delta t), \qquad
    \tau = \frac{\mu p}{\gamma^*} e, \qquad \Delta s = \Delta g_t - \Delta e

where the index c marks the committed state. A trial evaluation never changes committed arrays.
The force on the structure is :math:`-G^T W t`.

A point that opens within a time step (:math:`g_{n,c} < 0 < g_n`) holds on once more,
:math:`t_n = k_n g_{n,c} g_n / (g_{n,c} - g_n)`, so that the trapezoidal work of the step returns exactly the energy
stored in the penalty. With :math:`t_n = 0` there it would return more, and rattling layers would feed on it
(docs/theory.md).
"""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.contact.laws import SMOOTHED, PointLaws, slip_derivatives, slip_update
from wroll_fem.numerics.numba_cache import drop_stale_cache

__all__ = [
    "OPEN", "SLIP", "STICK", "PointLaws", "consistent_tangent", "interface_work", "record_slip", "slip_derivatives",
    "slip_update", "trial_traction",
]  # fmt: skip

drop_stale_cache(__file__)

STICK, SLIP, OPEN = 0, 1, 2


@numba.njit(cache=True, inline="always")
def _release(kn, gn, gn_c):
    """Normal traction (Pa, tension) of a point that opens from ``gn_c`` < 0 to ``gn`` > 0 within a time step."""
    return kn * gn_c * gn / (gn_c - gn)


@numba.njit(cache=True, inline="always")
def _squared(tn, k, laws):
    """Square of a normal traction that a penalty stores: not that of a release."""
    return 0.0 if laws.separation[k] and tn > 0.0 else tn * tn


@numba.njit(cache=True)
def trial_traction(g, g_c, e_c, laws, dt, t, e, status):
    """Trial traction from the relative displacement; fills ``t`` (Pa), ``e`` (m) and ``status``.

    Parameters
    ----------
    g, g_c : (3 n,) trial and committed relative displacement, m
    e_c : (2 n,) committed elastic slip, m
    laws : `PointLaws`
    dt : step from the committed state, s; infinite in statics
    t, e, status : outputs (3 n,), (2 n,), (n,); e is what the interface stores: nothing for the smoothed law
    """
    n = laws.kn.shape[0]
    for k in range(n):
        gn = g[2 * n + k]
        closed = gn <= 0.0 or not laws.separation[k]
        tn = laws.kn[k] * gn if closed else 0.0
        if not closed and g_c[2 * n + k] < 0.0 and dt < np.inf:
            tn = _release(laws.kn[k], gn, g_c[2 * n + k])
        p = -tn if tn < 0.0 else 0.0
        dh, dz = g[2 * k] - g_c[2 * k], g[2 * k + 1] - g_c[2 * k + 1]
        eh, ez, sliding = slip_update(k, e_c[2 * k] + dh, e_c[2 * k + 1] + dz, dh, dz, laws, dt)
        status[k] = (SLIP if sliding else STICK) if closed else OPEN
        kt = laws.mu[k] * p / laws.gamma[k]
        t[2 * k] = kt * eh
        t[2 * k + 1] = kt * ez
        t[2 * n + k] = tn
        if laws.kind[k] == SMOOTHED:
            eh, ez = 0.0, 0.0
        e[2 * k] = eh
        e[2 * k + 1] = ez


@numba.njit(cache=True)
def consistent_tangent(g, g_c, e_c, laws, dt, d):
    """Derivative of the trial traction; fills ``d`` (n, 3, 3), order (hoop, axial, normal), Pa/m."""
    n = laws.kn.shape[0]
    for k in range(n):
        gn = g[2 * n + k]
        closed = gn <= 0.0 or not laws.separation[k]
        for i in range(3):
            for j in range(3):
                d[k, i, j] = 0.0
        kn = laws.kn[k]
        if not closed:
            if g_c[2 * n + k] < 0.0 and dt < np.inf:
                d[k, 2, 2] = kn * (g_c[2 * n + k] / (g_c[2 * n + k] - gn)) ** 2
            continue
        d[k, 2, 2] = kn
        p = -kn * gn
        if p < 0.0:
            continue
        dh, dz = g[2 * k] - g_c[2 * k], g[2 * k + 1] - g_c[2 * k + 1]
        trial_h, trial_z = e_c[2 * k] + dh, e_c[2 * k + 1] + dz
        eh, ez, _ = slip_update(k, trial_h, trial_z, dh, dz, laws, dt)
        a00, a01, a10, a11, b00, b01, b10, b11 = slip_derivatives(k, trial_h, trial_z, dh, dz, laws, dt)
        kt = laws.mu[k] * p / laws.gamma[k]
        d[k, 0, 0] = kt * (a00 + b00)
        d[k, 0, 1] = kt * (a01 + b01)
        d[k, 1, 0] = kt * (a10 + b10)
        d[k, 1, 1] = kt * (a11 + b11)
        limit_slope = -laws.mu[k] * kn / laws.gamma[k]
        d[k, 0, 2] = limit_slope * eh
        d[k, 1, 2] = limit_slope * ez


@numba.njit(cache=True)
def interface_work(g_c, e_c, t_c, g, e, t, laws, work):
    """Add the work of one committed step to ``work`` (5,), J.

    ``work[0]`` friction: mean traction times plastic slip; ``work[1]`` change of the stored contact energy
    (normal penalty and elastic slip); ``work[2]`` exchange with the pressure-dependent stick stiffness
    (zero while the pressure is constant); ``work[3]`` total interface work (trapezoidal rule); ``work[4]`` what
    normal contact takes where a point closes or has just opened (it gives some back only where a point turns round
    in the very step after it opened).
    """
    area, kn, mu, gamma = laws.area, laws.kn, laws.mu, laws.gamma
    n = kn.shape[0]
    for k in range(n):
        w = area[k]
        pc = -t_c[2 * n + k] if t_c[2 * n + k] < 0.0 else 0.0
        p = -t[2 * n + k] if t[2 * n + k] < 0.0 else 0.0
        stored_normal = 0.0
        if kn[k] > 0.0:
            stored_normal = 0.5 * (_squared(t[2 * n + k], k, laws) - _squared(t_c[2 * n + k], k, laws)) / kn[k]
        old = 0.5 * mu[k] * pc / gamma[k] * (e_c[2 * k] ** 2 + e_c[2 * k + 1] ** 2)
        new = 0.5 * mu[k] * p / gamma[k] * (e[2 * k] ** 2 + e[2 * k + 1] ** 2)
        elastic = 0.0
        plastic = 0.0
        for c in range(2):
            i = 2 * k + c
            mean = 0.5 * (t[i] + t_c[i])
            de = e[i] - e_c[i]
            elastic += mean * de
            plastic += mean * (g[i] - g_c[i] - de)
        work[0] += w * plastic
        work[1] += w * (stored_normal + new - old)
        work[2] += w * (elastic - (new - old))
        normal = 0.5 * (t[2 * n + k] + t_c[2 * n + k]) * (g[2 * n + k] - g_c[2 * n + k])
        work[3] += w * (plastic + elastic + normal)
        work[4] += w * (normal - stored_normal)


@numba.njit(cache=True)
def record_slip(g_c, e_c, g, e, g_0, status, path, peak, peak_vector):
    """Accumulate slip path (n,), m, and the largest tangential displacement vector (n, 2) since ``g_0``."""
    for k in range(path.shape[0]):
        if status[k] == SLIP:  # a point that sticks has no plastic slip but that of rounding
            dh = g[2 * k] - g_c[2 * k] - (e[2 * k] - e_c[2 * k])
            dz = g[2 * k + 1] - g_c[2 * k + 1] - (e[2 * k + 1] - e_c[2 * k + 1])
            path[k] += np.sqrt(dh * dh + dz * dz)
        rh = g[2 * k] - g_0[2 * k]
        rz = g[2 * k + 1] - g_0[2 * k + 1]
        size = np.sqrt(rh * rh + rz * rz)
        if size > peak[k]:
            peak[k] = size
            peak_vector[2 * k] = rh
            peak_vector[2 * k + 1] = rz
