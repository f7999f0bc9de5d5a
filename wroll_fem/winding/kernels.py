"""Compiled loops of the wound-roll stress: the source's scheme, and accretion on a grid of its own.

A radial modulus is a broken line over the pressure: (pressures, moduli) of its knots and the slope beyond the last.
Symbols as in the source: s increment of the pressure, r radius, h thickness of the web, T tension stress, E modulus
along the web, K_m mandrel stiffness; y = r s per accreted thickness, kappa = E/E_r.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

_NEAR, _FAR = 0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0)  # Gauss points of a cell


@njit(cache=True)
def radial_modulus(pressure, knots, moduli, slope):
    """E_r at one pressure, Pa: linear between the knots, constant below, ``slope`` per Pa beyond the last."""
    last = len(knots) - 1
    if pressure <= knots[0]:
        return moduli[0]
    if pressure >= knots[last]:
        return moduli[last] + slope * (pressure - knots[last])
    i = np.searchsorted(knots, pressure) - 1
    share = (pressure - knots[i]) / (knots[i + 1] - knots[i])
    return moduli[i] + share * (moduli[i + 1] - moduli[i])


@njit(cache=True)
def coefficients(r, h, ratio):
    """(A, B, C) of equation 2.10 at radius ``r`` for E_theta/E_r = ``ratio``."""
    return 1.0 + 1.5 * h / r, (h / r) ** 2 * (1.0 - ratio) - 2.0, 1.0 - 1.5 * h / r


@njit(cache=True)
def wrap_by_wrap(r, T, h, E, core, knots, moduli, slope):
    """Pressure at every interface after each wrap was laid in turn: equations 2.10 to 2.14 as printed.

    Parameters
    ----------
    r, T
        (n + 1,) radius under wrap 1, 2, ... and of the free surface, m; tension stress of each wrap, Pa.
    core
        E/K_m - 1 + nu_theta of the forward-difference core row 2.12.

    Returns
    -------
    (n + 1,) array
        Pressure, Pa, positive in compression; 0 at the free surface.
    """
    n = len(r) - 1
    P, s, ratio = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    if n > 0:
        ratio[0] = 1.0 / (1.0 + core * h / r[0])  # row 2.12: s_0 = ratio s_1
    for last in range(n):  # the wrap laid at r[last] on a roll of `last` wraps
        for i in range(1, last):
            A, B, C = coefficients(r[i], h, E / radial_modulus(P[i], knots, moduli, slope))
            ratio[i] = -A / (B + C * ratio[i - 1])
        s[last] = T[last] * h / r[last]
        for i in range(last - 1, -1, -1):
            s[i] = ratio[i] * s[i + 1]
        for i in range(last + 1):
            P[i] += s[i]
    return P


@njit(cache=True)
def accrete(r, T, E, core, knots, moduli, slope):
    """Pressure in a roll that grows continuously, on a grid with constant ratio of radii.

    Parameters
    ----------
    r, T
        (n + 1,) radii, m, r[i + 1]/r[i] constant; tension stress at which the web is laid there, Pa.
    core
        E/K_m + nu_theta of the core condition dy/dx = core y, x = ln r.

    Returns
    -------
    (n + 1,) array
        Pressure, Pa; 0 at the free surface.

    Notes
    -----
    Second order in the step d of x, core row included (docs/winding.md, equations 6 to 9). A step of growth is the
    trapezoidal rule; the radial modulus at its end comes from Euler's predictor. The modulus enters by its mean over
    each cell (two Gauss points): near the free surface, where the pressure vanishes, its nodal values would leave
    first order.
    """
    n = len(r) - 1
    d = math.log(r[n] / r[0]) / n
    Q, y, ratio = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)  # Q = r P
    y[0] = T[0]
    for last in range(1, n + 1):
        before, after = 0.5 * d * r[last - 1], 0.5 * d * r[last]
        P, from_inside = (Q[0] + 2.0 * before * y[0]) / r[0], 0.0
        for i in range(last):
            P_next = (Q[i + 1] + 2.0 * before * y[i + 1]) / r[i + 1] if i + 1 < last else 0.0
            near = E / radial_modulus(P + _NEAR * (P_next - P), knots, moduli, slope)
            far = E / radial_modulus(P + _FAR * (P_next - P), knots, moduli, slope)
            kappa = from_inside + 0.5 * (_FAR * near + _NEAR * far)
            if i == 0:
                ratio[0] = 1.0 / (1.0 + d * core + d * d * kappa)
            else:
                ratio[i] = 1.0 / (2.0 + d * d * kappa - ratio[i - 1])
            from_inside = 0.5 * (_NEAR * near + _FAR * far)
            P = P_next
        for i in range(last):
            Q[i] += before * y[i]
        y[last] = T[last]
        for i in range(last - 1, -1, -1):
            y[i] = ratio[i] * y[i + 1]
            Q[i] += after * y[i]
    return Q / r
