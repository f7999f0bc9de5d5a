r"""Compiled contact kernels: traction, tangent and work at every interface point.

The formulas for one point and the order of the contact degrees of freedom are defined in `point`.

With the relative displacement :math:`g` (outer minus inner body), the pressure :math:`p` and the friction law E of the
point (see `laws`),

.. math::
    t_n = k_n g_n, \quad p = \max(0, -t_n), \qquad
    e = E(e_c + \Delta g_t, \Delta g_t; \Delta t), \qquad
    \tau = \frac{\mu p}{\gamma^*} e, \qquad \Delta s = \Delta g_t - \Delta e

where the index c marks the committed state. A trial evaluation never changes committed arrays.
The force on the structure is :math:`-G^T W t`.

A point that opens within a time step (:math:`g_{n,c} < 0 < g_n`) has a tensile release traction at the end of this
step, :math:`t_n = k_n g_{n,c} g_n / (g_{n,c} - g_n)`. The trapezoidal work of the step then returns exactly the energy
stored in the penalty. With :math:`t_n = 0` the work would return more, and rattling layers would gain energy
(docs/theory.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact.laws import PointLaws, slip_derivatives, slip_update
from wroll_fem.contact.point import (
    AXIAL,
    HOOP,
    NORMAL,
    axial,
    hoop,
    is_closed,
    normal,
    pressure,
    squared_penalty,
    step_stiffness,
    step_traction,
    stick_change,
    stick_stiffness,
    tangential_work,
)
from wroll_fem.contact.smoothed_coulomb import regularised_sign
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray

__all__ = [
    "FRICTION", "IMPACT", "MODULATION", "OPEN", "SLIP", "STICK", "STORED", "TOTAL", "PointLaws", "Reference",
    "consistent_tangent", "interface_work", "record_slip", "regularised_signs", "slip_derivatives",
    "slip_update", "trial_traction",
]  # fmt: skip

drop_stale_cache(__file__)

STICK, SLIP, OPEN = 0, 1, 2
"""Status of a contact point."""

FRICTION, STORED, MODULATION, TOTAL, IMPACT = range(5)
"""Indices of the entries of the array ``work`` in `interface_work`."""


class Reference(NamedTuple):
    """Contact state at the preload, from which motions start, and the reference contact stiffness in this state.

    Attributes
    ----------
    jump : (3 n,) g_0, m
    elastic_slip : (2 n,) e_0, m
    traction : (3 n,) t_0, Pa
    springs : (3 n,) reference contact stiffness D_0, Pa/m
    """

    jump: FloatArray
    elastic_slip: FloatArray
    traction: FloatArray
    springs: FloatArray


@numba.njit(cache=True)
def trial_traction(g, g_c, e_c, laws, dt, t, e, status):
    """Trial traction from the relative displacement; fills ``t`` (Pa), ``e`` (m) and ``status``.

    Parameters
    ----------
    g, g_c : (3 n,) trial and committed relative displacement, m
    e_c : (2 n,) committed elastic slip, m
    laws : `PointLaws`
    dt : step from the committed state, s; infinite in statics
    t, e, status : outputs (3 n,), (2 n,), (n,); e is the stored elastic slip, which is 0 for a law without memory and
        the displacement from the reference state for an elastic law
    """
    n = laws.kn.shape[0]
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        gn = g[r]
        separates = laws.separation[k]
        tn = step_traction(gn, g_c[r], laws.kn[k], separates, dt)
        dh, dz = g[h] - g_c[h], g[z] - g_c[z]
        p = pressure(tn)
        eh, ez, sliding = slip_update(k, e_c[h] + dh, e_c[z] + dz, dh, dz, p, laws, dt)
        status[k] = (SLIP if sliding else STICK) if is_closed(gn, separates) else OPEN
        kt = stick_stiffness(k, p, laws)
        t[h] = kt * eh
        t[z] = kt * ez
        t[r] = tn
        if laws.elastic[k]:
            eh, ez = e_c[h] + dh, e_c[z] + dz
        elif not laws.stores_slip[k]:
            eh, ez = 0.0, 0.0
        e[h] = eh
        e[z] = ez


@numba.njit(cache=True)
def consistent_tangent(g, g_c, e_c, laws, dt, d):
    """Consistent tangent of the trial traction; fills ``d`` (n, 3, 3), order (hoop, axial, normal), Pa/m."""
    n = laws.kn.shape[0]
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        gn = g[r]
        for i in range(3):
            for j in range(3):
                d[k, i, j] = 0.0
        kn, separates = laws.kn[k], laws.separation[k]
        d[k, NORMAL, NORMAL] = step_stiffness(gn, g_c[r], kn, separates, dt)
        p = -kn * gn
        if not is_closed(gn, separates) or p < 0.0:
            continue
        dh, dz = g[h] - g_c[h], g[z] - g_c[z]
        trial_h, trial_z = e_c[h] + dh, e_c[z] + dz
        eh, ez, slides = slip_update(k, trial_h, trial_z, dh, dz, p, laws, dt)
        a00, a01, a10, a11, b00, b01, b10, b11 = slip_derivatives(k, trial_h, trial_z, dh, dz, p, laws, dt)
        kt = stick_stiffness(k, p, laws)
        d[k, HOOP, HOOP] = kt * (a00 + b00)
        d[k, HOOP, AXIAL] = kt * (a01 + b01)
        d[k, AXIAL, HOOP] = kt * (a10 + b10)
        d[k, AXIAL, AXIAL] = kt * (a11 + b11)
        limit_slope = stick_change(k, -kn, laws)
        if slides and laws.stick[k] > 0.0 and p > 0.0:
            limit_slope = -kn * kt / p
        d[k, HOOP, NORMAL] = limit_slope * eh
        d[k, AXIAL, NORMAL] = limit_slope * ez


@numba.njit(cache=True)
def regularised_signs(x):
    """(n,) regularised sign of each entry of ``x`` (n,), see `smoothed_coulomb.regularised_sign`."""
    out = np.empty(x.shape[0])
    for i in range(x.shape[0]):
        out[i] = regularised_sign(x[i])
    return out


@numba.njit(cache=True)
def interface_work(g_c, e_c, t_c, g, e, t, laws, work):
    """Add the work of one committed step to ``work`` (5,), J.

    ``work[FRICTION]``: mean traction times plastic slip. ``work[STORED]``: change of the stored contact energy
    (normal penalty and elastic slip). ``work[MODULATION]``: work exchanged between the elastic slip and the varying
    stick stiffness (zero while the pressure is constant). ``work[TOTAL]``: total interface work (trapezoidal rule).
    ``work[IMPACT]``: energy that normal contact dissipates at points that close or have just opened (negative only at
    a point whose gap decreases in the step after it opened).
    """
    area, kn = laws.area, laws.kn
    n = kn.shape[0]
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        w, separates = area[k], laws.separation[k]
        stored_normal = 0.0
        if kn[k] > 0.0:
            stored_normal = 0.5 * (squared_penalty(t[r], separates) - squared_penalty(t_c[r], separates)) / kn[k]
        plastic, elastic, stored = tangential_work(
            k, pressure(t_c[r]), pressure(t[r]), (t_c[h], t_c[z]), (t[h], t[z]), (g[h] - g_c[h], g[z] - g_c[z]),
            (e_c[h], e_c[z]), (e[h], e[z]), laws,
        )  # fmt: skip
        normal_work = 0.5 * (t[r] + t_c[r]) * (g[r] - g_c[r])
        work[FRICTION] += w * plastic
        work[STORED] += w * (stored_normal + stored)
        work[MODULATION] += w * (elastic - stored)
        work[TOTAL] += w * (plastic + elastic + normal_work)
        work[IMPACT] += w * (normal_work - stored_normal)


@numba.njit(cache=True)
def record_slip(g_c, e_c, g, e, g_0, status, path, peak, peak_vector):
    """Accumulate the slip ``path`` (n,), m, and update the largest tangential relative displacement from ``g_0``.

    ``peak`` (n,) is the magnitude of the latter and ``peak_vector`` (2 n,) its hoop and axial components, m.
    """
    for k in range(path.shape[0]):
        h, z = hoop(k), axial(k)
        if status[k] == SLIP:  # at a point that sticks, plastic slip would be rounding error
            dh = g[h] - g_c[h] - (e[h] - e_c[h])
            dz = g[z] - g_c[z] - (e[z] - e_c[z])
            path[k] += np.sqrt(dh * dh + dz * dz)
        rh = g[h] - g_0[h]
        rz = g[z] - g_0[z]
        size = np.sqrt(rh * rh + rz * rz)
        if size > peak[k]:
            peak[k] = size
            peak_vector[h] = rh
            peak_vector[z] = rz


@numba.njit(cache=True)
def record_opening(g, status, dt, gap, open_time):
    """Update the largest normal displacement ``gap`` (n,), m, and the time spent open, ``open_time`` (n,), s."""
    n = gap.shape[0]
    for k in range(n):
        gap[k] = max(gap[k], g[normal(k, n)])
        if status[k] == OPEN:
            open_time[k] += dt
