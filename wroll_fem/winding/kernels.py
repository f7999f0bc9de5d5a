"""Compiled kernels for wound-roll stress: scheme of the thesis, finite wraps on refined grids, continuous growth.

The radial modulus is a piecewise linear function of the pressure, given by its knots (pressures, moduli) and by its
slope beyond the last knot. Symbols as in the thesis: s pressure increment, r radius, h web thickness, T tension stress,
E modulus along the web, K_m mandrel stiffness; in addition y = r s per wound thickness and kappa = E/E_r.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

_NEAR, _FAR = 0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0)  # Gauss points of a cell


@njit(cache=True)
def radial_modulus(pressure, knots, moduli, slope):
    """Radial modulus E_r, Pa, at a given pressure.

    Parameters
    ----------
    pressure
        Pressure, Pa.
    knots, moduli
        (n,) pressures and moduli at the knots, Pa; the modulus is constant below the first knot.
    slope
        Slope beyond the last knot, Pa/Pa.
    """
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
    """Coefficients (A, B, C) of the difference equation 2.10 of the thesis.

    Parameters
    ----------
    r, h
        Radius and thickness of the web, m.
    ratio
        E_theta/E_r at this radius.
    """
    return 1.0 + 1.5 * h / r, (h / r) ** 2 * (1.0 - ratio) - 2.0, 1.0 - 1.5 * h / r


@njit(cache=True)
def wrap_by_wrap(r, T, h, E, core, knots, moduli, slope):
    """Pressure between the wraps of a roll by the scheme of the thesis, one node per wrap (equations 2.10 to 2.14).

    Parameters
    ----------
    r, T
        (n + 1,) inner radius of each wrap and radius of the free surface, m; tension stress at these radii, Pa.
    h, E
        Thickness of the web, m; modulus E_theta along the web, Pa.
    core
        E/K_m - 1 + nu_theta, in the forward difference at the core (equation 2.12).
    knots, moduli, slope
        Radial modulus, as for `radial_modulus`.

    Returns
    -------
    (n + 1,) array
        Pressure, Pa, positive in compression; 0 at the free surface.
    """
    n = len(r) - 1
    P, s, ratio = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    if n > 0:
        ratio[0] = 1.0 / (1.0 + core * h / r[0])  # row 2.12: s_0 = ratio s_1
    A, B_rigid, C = coefficients(r, h, 0.0)
    soft = E * (h / r) ** 2
    for last in range(n):  # the wrap laid at r[last] on a roll of `last` wraps
        for i in range(1, last):
            B = B_rigid[i] - soft[i] / radial_modulus(P[i], knots, moduli, slope)
            ratio[i] = -A[i] / (B + C[i] * ratio[i - 1])
        s[last] = T[last] * h / r[last]
        for i in range(last - 1, -1, -1):
            s[i] = ratio[i] * s[i + 1]
        for i in range(last + 1):
            P[i] += s[i]
    return P


@njit(cache=True)
def _cell_means(P, P_next, E, knots, moduli, slope):
    """Two means of kappa = E/E_r over a cell, weighted with the shape function of its inner and of its outer node."""
    near = E / radial_modulus(P + _NEAR * (P_next - P), knots, moduli, slope)
    far = E / radial_modulus(P + _FAR * (P_next - P), knots, moduli, slope)
    return 0.5 * (_FAR * near + _NEAR * far), 0.5 * (_NEAR * near + _FAR * far)


@njit(cache=True)
def _eliminate(Q, r, x, first, last, E, core, knots, moduli, slope, ratio, carry):
    """Forward elimination of a tridiagonal system: fill ratio[i] = y[i]/y[i + 1] for the rows i = first to last - 1.

    y is the unknown (see the module docstring); carry[i + 1] is the term of cell i in row i + 1.
    """
    P = Q[first] / r[first]
    for i in range(first, last):
        P_next, d = Q[i + 1] / r[i + 1], x[i + 1] - x[i]
        inner, outer = _cell_means(P, P_next, E, knots, moduli, slope)
        if i == 0:
            ratio[0] = 1.0 / (1.0 + d * (core + d * inner))
        else:
            before = d / (x[i] - x[i - 1])
            ratio[i] = 1.0 / (1.0 + before * (1.0 - ratio[i - 1]) + d * (carry[i] + d * inner))
        carry[i + 1] = d * outer
        P = P_next


@njit(cache=True)
def lay_wraps(r, T, h, cells, E, core, knots, moduli, slope, blocks, zones):
    """Pressure in a roll of wraps of finite thickness, on a grid with several cells in each wrap.

    Parameters
    ----------
    r, T
        (cells n + 1,) radii of the nodes for n wraps, m; (n,) tension stress of each wrap, Pa.
    h, cells
        Thickness of the web, m; number of cells in each wrap.
    E
        Modulus E_theta along the web, Pa.
    core
        E/K_m + nu_theta, in the core condition dy/dx = core y with x = ln r.
    knots, moduli, slope
        Radial modulus, as for `radial_modulus`.
    blocks, zones
        (levels,) numbers of wraps, ascending. Nodes more than ``zones[k]`` wraps below the surface are updated only
        every ``blocks[k]`` wraps (each a multiple of the previous one), with the modulus at the middle of the block.
        The relative change of the pressure there during one block is about blocks[k]/zones[k]. With a zone as deep as
        the roll, all nodes are updated with every wrap.

    Returns
    -------
    (cells n + 1,) array
        Pressure, Pa, 0 at the free surface; inside the last wrap r P is linear.

    Notes
    -----
    Second order in the cell size, core row included (docs/winding.md, equations 7 to 10). The load of a wrap is applied
    in ``cells`` equal steps. Each step uses the modulus at its middle, predicted from the previous step.
    """
    n, nodes, levels = len(T), len(r), len(blocks)
    x = np.log(r)
    Q, y, middle = np.zeros(nodes), np.zeros(nodes), np.zeros(nodes)  # Q = r P, y = r s
    ratio, carry = np.zeros(nodes), np.zeros(nodes)
    before, change = np.zeros((levels, nodes)), np.zeros((levels, nodes))
    edge = np.zeros(levels + 1, np.int64)  # nodes below edge[k] are updated at the end of a block of level k
    passed = np.zeros(levels)  # load that has arrived at that edge since the start of the block
    for start in range(0, n, blocks[0]):
        end = min(start + blocks[0], n)
        for k in range(levels - 1, -1, -1):
            if start % blocks[k] == 0:
                edge[k], passed[k] = max(0, start - zones[k]) * cells, 0.0
                for i in range(edge[k + 1], edge[k] + 1):
                    middle[i] = Q[i] + 0.5 * change[k, i]
                _eliminate(middle, r, x, edge[k + 1], edge[k], E, core, knots, moduli, slope, ratio, carry)
                for i in range(edge[k + 1], start * cells + 1):
                    before[k, i] = Q[i]
        first = edge[0]
        for wrap in range(start, end):
            top, part = wrap * cells, T[wrap] * h / cells
            for i in range(max(0, top - cells + 1), top + 1):
                y[i] = part  # new nodes have no previous increment
            for _ in range(cells):
                for i in range(first, top + 1):
                    middle[i] = Q[i] + 0.5 * y[i]
                _eliminate(middle, r, x, first, top, E, core, knots, moduli, slope, ratio, carry)
                y[top] = part
                Q[top] += part
                for i in range(top - 1, first - 1, -1):
                    y[i] = ratio[i] * y[i + 1]
                    Q[i] += y[i]
                passed[0] += y[first]
            for j in range(1, cells):
                Q[top + j] = T[wrap] * h * (1.0 - j / cells)
        for k in range(levels):
            if end % blocks[k] == 0 or end == n:
                hand_down = passed[k]
                for i in range(edge[k] - 1, edge[k + 1] - 1, -1):
                    hand_down *= ratio[i]
                    Q[i] += hand_down
                if k + 1 < levels:
                    passed[k + 1] += hand_down
                for i in range(edge[k + 1], nodes):  # new nodes have no previous change
                    change[k, i] = Q[i] - before[k, i] if before[k, i] > 0.0 else 0.0
    return Q / r


@njit(cache=True)
def accrete(r, T, E, core, knots, moduli, slope):
    """Pressure in a roll of infinitely thin wraps that grows continuously, on a grid of radii in geometric progression.

    Parameters
    ----------
    r, T
        (n + 1,) radii, m, with a constant ratio r[i + 1]/r[i]; tension stress at which the web is wound there, Pa.
    E
        Modulus E_theta along the web, Pa.
    core
        E/K_m + nu_theta, in the core condition dy/dx = core y with x = ln r.
    knots, moduli, slope
        Radial modulus, as for `radial_modulus`.

    Returns
    -------
    (n + 1,) array
        Pressure, Pa; 0 at the free surface.

    Notes
    -----
    Second order in the step d of x, core row included (docs/winding.md, equations 6 to 9). A step of growth uses the
    trapezoidal rule, with the radial modulus at its end from an Euler predictor. The modulus is averaged over each cell
    (two Gauss points): with its nodal values the scheme would be of first order near the free surface, where the
    pressure vanishes.
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
            inner, outer = _cell_means(P, P_next, E, knots, moduli, slope)
            kappa = from_inside + inner
            if i == 0:
                ratio[0] = 1.0 / (1.0 + d * core + d * d * kappa)
            else:
                ratio[i] = 1.0 / (2.0 + d * d * kappa - ratio[i - 1])
            from_inside = outer
            P = P_next
        for i in range(last):
            Q[i] += before * y[i]
        y[last] = T[last]
        for i in range(last - 1, -1, -1):
            y[i] = ratio[i] * y[i + 1]
            Q[i] += after * y[i]
    return Q / r
