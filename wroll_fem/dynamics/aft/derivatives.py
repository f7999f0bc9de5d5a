"""Compiled derivatives of the contact tractions of a period with respect to the motion (see `harmonic_contact`).

They are exact, and include the dependence on the slip history. A point that never slid has none: each of its
derivatives is a product of two periodic functions, known from the Fourier coefficients of one of them.
"""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.contact.laws import slip_derivatives, slip_update
from wroll_fem.contact.point import (
    axial,
    contact_dof,
    hoop,
    is_closed,
    normal,
    penalty_traction,
    pressure,
    stick_change,
)
from wroll_fem.dynamics.aft import coulomb, coulomb_derivatives
from wroll_fem.dynamics.aft.coulomb import COULOMB
from wroll_fem.dynamics.aft.coulomb_derivatives import add_history
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__, coulomb.__file__, coulomb_derivatives.__file__)

STICK, HOOP_LIMIT, AXIAL_LIMIT, PENALTY = range(4)
"""Columns of the factors: derivatives of the tangential traction with respect to the elastic slip, of the hoop and the
axial traction with respect to the gap at constant elastic slip, and of the normal traction with respect to the gap."""


@numba.njit(cache=True)
def derivatives(points, path, hysteresis, reference, laws, series, products, blocks, by_frequency):
    """Derivatives of Fourier coefficients, ds/dg. s: traction minus the traction of the stuck interface; g: motion.

    They are exact and include the dependence of s on the slip history (s: see `kernel.correction`).

    Parameters
    ----------
    points : (a,) indices of the points
    path, reference : `kernel.SampledMotion`, `contact.kernels.Reference`
    hysteresis : `kernel.Hysteresis` of the same motion; the elastic slip of a point that never slid changes as its
        motion does
    series, products : `kernel.Series`, `kernel.Products`
    blocks : output (a, 3, R, 3, R) d s_i,r / d g_j,q, order (hoop, axial, normal), Pa/m; zero before
    by_frequency : output (a, 2, R) derivative of the tangential s with respect to the logarithm of the frequency at
        fixed coefficients, Pa; it is nonzero for laws that depend on the slip rate
    """
    count, size = series.values.shape
    n, a = laws.mu.shape[0], points.shape[0]
    factors, change, rows = np.zeros((count, 4 * a)), np.zeros((size, 6)), np.zeros((count, 4 * size + 2))
    gap_rows = np.zeros((count, 2 * size))
    coulomb_points, places, coulomb_count = np.empty(a, np.int64), np.empty(a, np.int64), 0
    missing = np.zeros(a, np.int64)  # first coefficient by which the derivatives of a point that sticks are missing
    for index in range(a):
        k = points[index]
        mine, block = factors[:, 4 * index : 4 * index + 4], blocks[index]
        if not hysteresis.moved[k] or laws.kind[k] == COULOMB:
            _factors_of_slip(k, path, hysteresis.slip, reference, laws, mine)
            if hysteresis.moved[k]:
                coulomb_points[coulomb_count], places[coulomb_count], missing[index] = k, index, 1
                coulomb_count += 1
            continue
        missing[index] = size
        _follow_history(k, path, hysteresis.periods[k], reference, laws, series, change, mine, rows, gap_rows)
        found = np.dot(series.project, rows)
        for r in range(size):
            for q in range(size):
                for c in range(2):
                    block[c, r, 0, q], block[c, r, 1, q] = found[r, 4 * q + 2 * c], found[r, 4 * q + 2 * c + 1]
            by_frequency[index, 0, r] = found[r, 4 * size]
            by_frequency[index, 1, r] = found[r, 4 * size + 1]
        if laws.stick[k] > 0.0:
            found = np.dot(series.project, gap_rows)
            for r in range(size):
                for q in range(size):
                    block[0, r, 2, q], block[1, r, 2, q] = found[r, 2 * q], found[r, 2 * q + 1]
    add_history(
        coulomb_points[:coulomb_count], places, path, hysteresis.periods, reference, laws, series, factors, blocks
    )
    sums = np.dot(products.project, factors)
    product_rows = _product_rows(products.orders, sums.shape[0] // 2)
    for index in range(a):
        block = blocks[index]
        _add_products(block, sums[:, 4 * index : 4 * index + 4], product_rows, missing[index])
        for r in range(size):
            for c in range(3):
                block[c, r, c, r] -= reference.springs[contact_dof(points[index], c, n)]


@numba.njit(cache=True, inline="always")
def _factors_at(gn, kn, separates, stick, held):
    """Factors at one sample (see `STICK`), those of the limits per elastic slip; ``gn``: gap, m.

    ``stick`` and ``held`` are the stick stiffness per pressure and the constant one.
    """
    stiffness = kn if is_closed(gn, separates) else 0.0
    pressed = 1.0 if pressure(penalty_traction(gn, kn, separates)) > 0.0 else 0.0
    slope = -pressed * stick * stiffness  # of the stick stiffness with the gap
    return slope * gn + pressed * held, slope, stiffness


@numba.njit(cache=True)
def _factors_of_slip(k, path, slip, reference, laws, factors):
    """Factors (N, 4) of a point with the elastic ``slip`` (2 n, N), m."""
    n = laws.mu.shape[0]
    h, z, r = hoop(k), axial(k), normal(k, n)
    motion, g_0 = path.motion, reference.jump[r]
    stick, held, kn, separates = stick_change(k, 1.0, laws), laws.stick[k], laws.kn[k], laws.separation[k]
    for j in range(factors.shape[0]):
        kt, slope, stiffness = _factors_at(g_0 + motion[r, j], kn, separates, stick, held)
        factors[j, STICK], factors[j, PENALTY] = kt, stiffness
        factors[j, HOOP_LIMIT], factors[j, AXIAL_LIMIT] = slope * slip[h, j], slope * slip[z, j]


@numba.njit(cache=True)
def _product_rows(orders, half):
    """Rows of the sums (see `kernel.Products`) that a product of two coefficients needs, and their factors.

    The coefficient r of a periodic function times the coefficient q of a motion is
    ``share[r] sums[first[r, q]] + sign[r, q] sums[second[r, q]]``. ``half`` is the number of cosines among the sums.
    """
    size = orders.shape[0]
    first, second = np.empty((size, size), np.int64), np.empty((size, size), np.int64)
    share, sign = np.full(size, 0.5), np.empty((size, size))
    share[0] = 0.25
    for r in range(size):
        sine = r > 0 and r % 2 == 0
        for q in range(size):
            far, near = orders[r] + orders[q], abs(orders[r] - orders[q])
            if sine == (q > 0 and q % 2 == 0):  # cos cos, sin sin
                first[r, q], second[r, q], sign[r, q] = near, far, -share[r] if sine else share[r]
            else:  # sin cos, cos sin
                first[r, q], second[r, q] = half + far, half + near
                sign[r, q] = share[r] if sine == (orders[r] >= orders[q]) else -share[r]
    return first, second, share, sign


@numba.njit(cache=True)
def _add_products(block, sums, rows, missing):
    """Add the derivatives that are products of a factor and the motion; ``rows`` are those of `_product_rows`.

    From the coefficient ``missing`` on, the elastic slip changes as the motion does, apart from what was added before.
    """
    first, second, share, sign = rows
    size = share.shape[0]
    for r in range(size):
        for q in range(size):
            i, j, a, b = first[r, q], second[r, q], share[r], sign[r, q]
            if q >= missing:
                both = a * sums[i, STICK] + b * sums[j, STICK]
                block[0, r, 0, q] += both
                block[1, r, 1, q] += both
            block[0, r, 2, q] += a * sums[i, HOOP_LIMIT] + b * sums[j, HOOP_LIMIT]
            block[1, r, 2, q] += a * sums[i, AXIAL_LIMIT] + b * sums[j, AXIAL_LIMIT]
            block[2, r, 2, q] += a * sums[i, PENALTY] + b * sums[j, PENALTY]


@numba.njit(cache=True)
def _follow_history(k, path, periods, reference, laws, series, change, factors, rows, gap_rows):
    """Derivatives of the traction of a point that slid, at the samples of the last of ``periods`` periods.

    Parameters
    ----------
    change : work array (R, 6): derivatives of the elastic slip minus those in stick. Columns: of the hoop slip with
        respect to the hoop and the axial motion, of the axial slip likewise, of both with respect to the gap.
    factors : output (N, 4), see `STICK`
    rows : output (N, 4 R + 2): derivatives of the tangential traction with respect to the tangential motion, in the
        order of ``change``, and with respect to the logarithm of the frequency
    gap_rows : output (N, 2 R) part of the derivatives with respect to the gap that is due to the history
    """
    motion, rate, ramp, ramp_rate, dt = path
    values, velocities = series.values, series.velocities
    count, size = values.shape
    n = laws.mu.shape[0]
    h, z, r_n = hoop(k), axial(k), normal(k, n)
    e_0h, e_0z, g_0 = reference.elastic_slip[h], reference.elastic_slip[z], reference.jump[r_n]
    stick, held, kn, separates = stick_change(k, 1.0, laws), laws.stick[k], laws.kn[k], laws.separation[k]
    exact, elastic = laws.exact_increment[k], laws.elastic[k]
    change[:] = 0.0
    eh, ez, before_h, before_z, wh, wz, last, p, last_j = e_0h, e_0z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0
    end = (periods + 1) * count
    for step in range(1, end + 1):
        j = step % count
        now_h, now_z, grown, growth = motion[h, j], motion[z, j], 1.0, 0.0
        if step <= count:
            grown, growth = ramp[step], ramp_rate[step]
            now_h, now_z = grown * now_h, grown * now_z
        th, tz = eh + now_h - before_h, ez + now_z - before_z
        vh = grown * rate[h, j] + growth * motion[h, j]
        vz = grown * rate[z, j] + growth * motion[z, j]
        if exact:
            vh, vz = now_h - before_h, now_z - before_z
        if held > 0.0:
            p = pressure(penalty_traction(g_0 + grown * motion[r_n, j], kn, separates))
        eh, ez, slides = slip_update(k, th, tz, vh, vz, p, laws, dt)
        if slides or not laws.sticks[k]:
            a00, a01, a10, a11, b00, b01, b10, b11 = slip_derivatives(k, th, tz, vh, vz, p, laws, dt)
            if held > 0.0:  # the limit follows the pressure
                sink = -kn * grown / p if p > 0.0 else 0.0
                for r in range(size):
                    by_h, by_z = change[r, 4], change[r, 5]
                    change[r, 4] = a00 * by_h + a01 * by_z + sink * eh * values[j, r]
                    change[r, 5] = a10 * by_h + a11 * by_z + sink * ez * values[j, r]
            if elastic:
                change[:, :4] = 0.0
            for r in range(size):
                x = grown * values[j, r]
                hh, hz, zh, zz = change[r, 0] + x, change[r, 1], change[r, 2], change[r, 3] + x
                change[r, 0], change[r, 1] = a00 * hh + a01 * zh - x, a00 * hz + a01 * zz
                change[r, 2], change[r, 3] = a10 * hh + a11 * zh, a10 * hz + a11 * zz - x
            if b00 != 0.0 or b01 != 0.0 or b10 != 0.0 or b11 != 0.0:
                for r in range(size):
                    fast = grown * velocities[j, r] + growth * values[j, r]
                    if exact:
                        fast = grown * values[j, r] - last * values[last_j, r]
                    change[r, 0] += b00 * fast
                    change[r, 1] += b01 * fast
                    change[r, 2] += b10 * fast
                    change[r, 3] += b11 * fast
            # at fixed coefficients the velocity is (change per sample)/dt, so d/d ln(w) = B (change per sample)
            if not exact and not elastic:
                wh, wz = a00 * wh + a01 * wz + b00 * vh + b01 * vz, a10 * wh + a11 * wz + b10 * vh + b11 * vz
        last, last_j = grown, j
        before_h, before_z = now_h, now_z
        if step > end - count:
            kt, slope, stiffness = _factors_at(g_0 + motion[r_n, j], kn, separates, stick, held)
            factors[j, STICK], factors[j, PENALTY] = kt, stiffness
            factors[j, HOOP_LIMIT], factors[j, AXIAL_LIMIT] = slope * eh, slope * ez
            for r in range(size):
                here = values[j, r]
                rows[j, 4 * r], rows[j, 4 * r + 1] = kt * (change[r, 0] + here), kt * change[r, 1]
                rows[j, 4 * r + 2], rows[j, 4 * r + 3] = kt * change[r, 2], kt * (change[r, 3] + here)
            rows[j, 4 * size], rows[j, 4 * size + 1] = kt * wh, kt * wz
            if held > 0.0:
                for r in range(size):
                    gap_rows[j, 2 * r], gap_rows[j, 2 * r + 1] = held * change[r, 4], held * change[r, 5]
        if elastic:
            eh, ez = e_0h + now_h, e_0z + now_z
