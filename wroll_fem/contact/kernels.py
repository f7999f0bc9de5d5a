r"""Compiled contact laws: traction, tangent and work at every interface point.

Component order ("slots") of all interface vectors of ``n`` points: hoop and axial of point ``k`` in
slots ``2 k`` and ``2 k + 1``, its normal in slot ``2 n + k``. Tangential slots come first because
they alone change their law while the contact stays closed.

With the relative displacement :math:`g` (outer minus inner body), pressure :math:`p` and elastic slip :math:`e`

.. math::
    t_n = k_n g_n, \quad p = \max(0, -t_n), \qquad
    e = \operatorname{clip}(e_c + g_t - g_{t,c}), \quad |e| \le \gamma^*, \qquad
    \tau = \frac{\mu p}{\gamma^*} e, \qquad \Delta s = \Delta g_t - \Delta e

where the index c marks the committed state. A trial evaluation never changes committed arrays.
The force on the structure is :math:`-G^T W t`.
"""

from __future__ import annotations

import numba
import numpy as np

STICK, SLIP, OPEN = 0, 1, 2


@numba.njit(cache=True)
def trial_traction(g, g_c, e_c, kn, separation, mu, gamma, t, e, status):
    """Trial traction from the relative displacement; fills ``t`` (Pa), ``e`` (m) and ``status``.

    Parameters
    ----------
    g, g_c : (3 n,) trial and committed relative displacement, m
    e_c : (2 n,) committed elastic slip, m
    kn, separation, mu, gamma : (n,) normal penalty Pa/m, flag, coefficient, elastic slip m
    t, e, status : outputs (3 n,), (2 n,), (n,)
    """
    n = kn.shape[0]
    for k in range(n):
        gn = g[2 * n + k]
        closed = gn <= 0.0 or not separation[k]
        tn = kn[k] * gn if closed else 0.0
        p = -tn if tn < 0.0 else 0.0
        eh = e_c[2 * k] + (g[2 * k] - g_c[2 * k])
        ez = e_c[2 * k + 1] + (g[2 * k + 1] - g_c[2 * k + 1])
        length = np.sqrt(eh * eh + ez * ez)
        status[k] = STICK if closed else OPEN
        if length > gamma[k]:
            scale = gamma[k] / length
            eh *= scale
            ez *= scale
            if closed:
                status[k] = SLIP
        kt = mu[k] * p / gamma[k]
        t[2 * k] = kt * eh
        t[2 * k + 1] = kt * ez
        t[2 * n + k] = tn
        e[2 * k] = eh
        e[2 * k + 1] = ez


@numba.njit(cache=True)
def consistent_tangent(g, g_c, e_c, kn, separation, mu, gamma, d):
    """Derivative of the trial traction; fills ``d`` (n, 3, 3), order (hoop, axial, normal), Pa/m."""
    n = kn.shape[0]
    for k in range(n):
        gn = g[2 * n + k]
        closed = gn <= 0.0 or not separation[k]
        for i in range(3):
            for j in range(3):
                d[k, i, j] = 0.0
        if not closed:
            continue
        d[k, 2, 2] = kn[k]
        p = -kn[k] * gn
        if p < 0.0:
            continue
        eh = e_c[2 * k] + (g[2 * k] - g_c[2 * k])
        ez = e_c[2 * k + 1] + (g[2 * k + 1] - g_c[2 * k + 1])
        length = np.sqrt(eh * eh + ez * ez)
        kt = mu[k] * p / gamma[k]
        if length > gamma[k]:
            mh, mz = eh / length, ez / length
            c = kt * gamma[k] / length
            d[k, 0, 0] = c * (1.0 - mh * mh)
            d[k, 0, 1] = -c * mh * mz
            d[k, 1, 0] = -c * mh * mz
            d[k, 1, 1] = c * (1.0 - mz * mz)
            eh, ez = gamma[k] * mh, gamma[k] * mz
        else:
            d[k, 0, 0] = kt
            d[k, 1, 1] = kt
        limit_slope = -mu[k] * kn[k] / gamma[k]
        d[k, 0, 2] = limit_slope * eh
        d[k, 1, 2] = limit_slope * ez


@numba.njit(cache=True)
def interface_work(g_c, e_c, t_c, g, e, t, area, kn, mu, gamma, work):
    """Add the work of one committed step to ``work`` (4,), J.

    ``work[0]`` friction: mean traction times plastic slip; ``work[1]`` change of the stored contact energy
    (normal penalty and elastic slip); ``work[2]`` exchange with the pressure-dependent stick stiffness
    (zero while the pressure is constant); ``work[3]`` total interface work (trapezoidal rule).
    """
    n = kn.shape[0]
    for k in range(n):
        w = area[k]
        pc = -t_c[2 * n + k] if t_c[2 * n + k] < 0.0 else 0.0
        p = -t[2 * n + k] if t[2 * n + k] < 0.0 else 0.0
        stored_normal = 0.0
        if kn[k] > 0.0:
            stored_normal = 0.5 * (t[2 * n + k] ** 2 - t_c[2 * n + k] ** 2) / kn[k]
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
