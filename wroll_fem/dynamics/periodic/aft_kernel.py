"""Compiled part of the harmonic balance: contact laws during one period, and their exact derivatives (see `aft`).

The motion of a point relative to the preload state is known at N phases of the period (`SampledMotion`). The elastic
slip starts from the preload state. In a first period the motion grows from zero (the ramp); whole periods follow until
the elastic slip repeats. Tractions are those of the last period. The normal law is the penalty alone: a point that
opens between two samples has no release traction (see `aft`).
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact import point
from wroll_fem.contact.laws import slip_derivatives, slip_update
from wroll_fem.contact.point import (
    axial,
    contact_dof,
    hoop,
    is_closed,
    modulation_work,
    normal,
    penalty_traction,
    pressure,
    stick_change,
    tangential_work,
)
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import BoolArray, FloatArray, IntArray

drop_stale_cache(__file__)


class SampledMotion(NamedTuple):
    """Motion of the contact points at the samples of a period.

    Attributes
    ----------
    motion, rate : (3 n, N) relative displacement from the preload state at phases 2 pi j / N, and its change
        per sample (velocity times ``dt``), m
    ramp, ramp_rate : (N + 1,) factor on the motion in the first period and its change per sample
    dt : time per sample, s
    """

    motion: FloatArray
    rate: FloatArray
    ramp: FloatArray
    ramp_rate: FloatArray
    dt: float


class Hysteresis(NamedTuple):
    """Slip of the contact points during the last period computed.

    Attributes
    ----------
    slip : (2 n, N) elastic slip, m: the traction divided by the stick stiffness
    sliding : (n, N) whether the point slides
    moved : (n,) whether the point slid in any period, the ramp included
    periods : (n,) number of whole periods computed
    change : (n,) change of the elastic slip during the last of these periods, relative to gamma*
    """

    slip: FloatArray
    sliding: BoolArray
    moved: BoolArray
    periods: IntArray
    change: FloatArray


class Series(NamedTuple):
    """Matrices that convert Fourier coefficients to samples, and samples to Fourier coefficients.

    Attributes
    ----------
    values, velocities : (N, R) motion and its change per sample for unit coefficients
    project : (R, N) matrix that gives the coefficients from the samples
    """

    values: FloatArray
    velocities: FloatArray
    project: FloatArray


@numba.njit(cache=True)
def iterate_to_periodic(path, reference, laws, max_periods, tolerance, out):
    """Compute the periodic elastic slip of every point, and store it in the `Hysteresis` ``out``.

    Parameters
    ----------
    path : `SampledMotion`
    reference : `contact.kernels.Reference`
    max_periods : largest number of whole periods
    tolerance : change of the elastic slip during a period, relative to gamma*, up to which it counts as periodic
    """
    motion, rate, ramp, ramp_rate, dt = path
    slip, sliding, moved, periods, change = out
    n, count = sliding.shape
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        eh, ez = reference.elastic_slip[h], reference.elastic_slip[z]
        before_h = before_z = p = 0.0
        g_0, kn, separates, pressed = reference.jump[r], laws.kn[k], laws.separation[k], laws.stick[k] > 0.0
        moved[k] = not laws.sticks[k]
        exact, elastic = laws.exact_increment[k], laws.elastic[k]
        for i in range(1, count + 1):
            j = i % count
            now_h, now_z = ramp[i] * motion[h, j], ramp[i] * motion[z, j]
            th, tz = eh + now_h - before_h, ez + now_z - before_z
            vh = ramp[i] * rate[h, j] + ramp_rate[i] * motion[h, j]
            vz = ramp[i] * rate[z, j] + ramp_rate[i] * motion[z, j]
            if exact:
                vh, vz = now_h - before_h, now_z - before_z
            if pressed:
                p = pressure(penalty_traction(g_0 + ramp[i] * motion[r, j], kn, separates))
            eh, ez, slides = slip_update(k, th, tz, vh, vz, p, laws, dt)
            if elastic:
                eh, ez = th, tz
            before_h, before_z = now_h, now_z
            if slides:
                moved[k] = True
        periods[k] = 0
        for _ in range(max_periods):
            start_h, start_z = eh, ez
            for i in range(1, count + 1):
                j = i % count
                th, tz, vh, vz = eh + motion[h, j] - before_h, ez + motion[z, j] - before_z, rate[h, j], rate[z, j]
                if exact:
                    vh, vz = motion[h, j] - before_h, motion[z, j] - before_z
                if pressed:
                    p = pressure(penalty_traction(g_0 + motion[r, j], kn, separates))
                eh, ez, slides = slip_update(k, th, tz, vh, vz, p, laws, dt)
                before_h, before_z = motion[h, j], motion[z, j]
                slip[h, j], slip[z, j] = eh, ez
                if elastic:
                    eh, ez = th, tz
                sliding[k, j] = slides
                if slides:
                    moved[k] = True
            periods[k] += 1
            change[k] = max(abs(eh - start_h), abs(ez - start_z)) / laws.gamma[k]
            if change[k] <= tolerance:
                break


@numba.njit(cache=True)
def correction(path, slip, reference, laws, s, is_open, pressure_change):
    """Compute the traction minus the traction of the stuck interface, at the samples of a period.

    The difference is s = t - t_0 - D_0 (g - g_0). t: traction; g: relative displacement; index 0: preload state;
    D_0: reference contact stiffness.

    Parameters
    ----------
    path, reference : `SampledMotion`, `contact.kernels.Reference`
    slip : (2 n, N) elastic slip, m
    s : output (3 n, N), Pa
    is_open : output (n, N) whether the surfaces are apart
    pressure_change : output (n,) largest change of the pressure relative to the preload pressure
    """
    motion = path.motion
    g_0, t_0, springs = reference.jump, reference.traction, reference.springs
    n, count = is_open.shape
    for k in range(n):
        r = normal(k, n)
        stick, held = stick_change(k, 1.0, laws), laws.stick[k]  # per pressure, and constant; for all samples
        kn, separates = laws.kn[k], laws.separation[k]
        p_0 = -t_0[r]
        largest = 0.0
        for j in range(count):
            gn = g_0[r] + motion[r, j]
            tn = penalty_traction(gn, kn, separates)
            p = pressure(tn)
            is_open[k, j] = not is_closed(gn, separates)
            for c in range(2):
                i = contact_dof(k, c, n)
                s[i, j] = point.correction((held + stick * p) * slip[i, j], t_0[i], springs[i], motion[i, j])
            s[r, j] = point.correction(tn, t_0[r], springs[r], motion[r, j])
            largest = max(largest, abs(p - p_0))
        pressure_change[k] = largest / p_0 if p_0 > 0.0 else np.inf


@numba.njit(cache=True)
def derivatives(points, path, hysteresis, reference, laws, series, blocks, by_frequency):
    """Derivatives of Fourier coefficients, ds/dg. s: traction minus the traction of the stuck interface; g: motion.

    They are exact and include the dependence of s on the slip history (s: see `correction`).

    Parameters
    ----------
    points : (a,) indices of the points
    hysteresis : `Hysteresis` of the same motion; the elastic slip of a point that never slid changes as its motion does
    series : `Series`
    blocks : output (a, 3, R, 3, R) d s_i,r / d g_j,q, order (hoop, axial, normal), Pa/m
    by_frequency : output (a, 2, R) derivative of the tangential s with respect to the logarithm of the frequency at
        fixed coefficients, Pa; it is nonzero for laws that depend on the slip rate
    """
    motion, rate, ramp, ramp_rate, dt = path
    moved, periods = hysteresis.moved, hysteresis.periods
    e_0, g_0, springs = reference.elastic_slip, reference.jump, reference.springs
    values, velocities, project = series
    count, size = values.shape
    n = laws.mu.shape[0]
    # derivative of the elastic slip with respect to the hoop, then the axial motion, minus the derivative in stick
    dh, dz = np.zeros(2 * size), np.zeros(2 * size)
    dn = np.zeros(2 * size)  # of the elastic slip (hoop, axial) with respect to the normal motion
    rows = np.zeros((count, 7 * size + 2))
    for index in range(points.shape[0]):
        k = points[index]
        h, z, normal_dof = hoop(k), axial(k), normal(k, n)
        stick, held = stick_change(k, 1.0, laws), laws.stick[k]  # per pressure, and constant; for all samples
        kn, separates = laws.kn[k], laws.separation[k]
        eh, ez = e_0[h], e_0[z]
        before_h = before_z = 0.0
        dh[:] = 0.0
        dz[:] = 0.0
        dn[:] = 0.0
        wh = wz = last = p = 0.0
        exact, elastic, last_j = laws.exact_increment[k], laws.elastic[k], 0
        end = (periods[k] + 1) * count
        for step in range(1 if moved[k] else end - count + 1, end + 1):
            j = step % count
            now_h, now_z = motion[h, j], motion[z, j]
            if moved[k]:
                grown, growth = 1.0, 0.0
                if step <= count:
                    grown, growth = ramp[step], ramp_rate[step]
                    now_h, now_z = grown * now_h, grown * now_z
                th, tz = eh + now_h - before_h, ez + now_z - before_z
                vh = grown * rate[h, j] + growth * motion[h, j]
                vz = grown * rate[z, j] + growth * motion[z, j]
                if exact:
                    vh, vz = now_h - before_h, now_z - before_z
                if held > 0.0:
                    p = pressure(penalty_traction(g_0[normal_dof] + grown * motion[normal_dof, j], kn, separates))
                eh, ez, slides = slip_update(k, th, tz, vh, vz, p, laws, dt)
                if slides or not laws.sticks[k]:
                    a00, a01, a10, a11, b00, b01, b10, b11 = slip_derivatives(k, th, tz, vh, vz, p, laws, dt)
                    if held > 0.0:  # the limit follows the pressure
                        sink = -kn * grown / p if p > 0.0 else 0.0
                        for r in range(size):
                            nh, nz, here = dn[r], dn[size + r], values[j, r]
                            dn[r] = a00 * nh + a01 * nz + sink * eh * here
                            dn[size + r] = a10 * nh + a11 * nz + sink * ez * here
                    for r in range(size):
                        here = grown * values[j, r]
                        fast = grown * velocities[j, r] + growth * values[j, r]
                        if exact:
                            fast = here - last * values[last_j, r]
                        if elastic:
                            dh[r] = dh[size + r] = dz[r] = dz[size + r] = 0.0
                        hh, hz, zh, zz = dh[r] + here, dh[size + r], dz[r], dz[size + r] + here
                        dh[r] = a00 * hh + a01 * zh + b00 * fast - here
                        dh[size + r] = a00 * hz + a01 * zz + b01 * fast
                        dz[r] = a10 * hh + a11 * zh + b10 * fast
                        dz[size + r] = a10 * hz + a11 * zz + b11 * fast - here
                    # at fixed coefficients the velocity is (change per sample)/dt, so d/d ln(w) = B (change per sample)
                    if not exact and not elastic:
                        wh, wz = a00 * wh + a01 * wz + b00 * vh + b01 * vz, a10 * wh + a11 * wz + b10 * vh + b11 * vz
                last, last_j = grown, j
            else:
                eh, ez = e_0[h] + now_h, e_0[z] + now_z
            before_h, before_z = now_h, now_z
            if step > end - count:
                gn = g_0[normal_dof] + motion[normal_dof, j]
                stiffness = kn if is_closed(gn, separates) else 0.0
                pressed = pressure(penalty_traction(gn, kn, separates)) > 0.0
                slope = stick * -stiffness if pressed else 0.0  # of the stick stiffness with the gap
                kt = slope * gn + (held if pressed else 0.0)
                row = rows[j]
                for r in range(size):
                    here = values[j, r]
                    row[r] = kt * (dh[r] + here)
                    row[size + r] = kt * dh[size + r]
                    row[2 * size + r] = kt * dz[r]
                    row[3 * size + r] = kt * (dz[size + r] + here)
                    row[4 * size + r] = slope * eh * here + held * dn[r]
                    row[5 * size + r] = slope * ez * here + held * dn[size + r]
                    row[6 * size + r] = stiffness * here
                row[7 * size] = kt * wh
                row[7 * size + 1] = kt * wz
            if elastic:
                eh, ez = e_0[h] + now_h, e_0[z] + now_z
        found = np.dot(project, rows)
        for r in range(size):
            for q in range(size):
                for c in range(2):
                    blocks[index, c, r, 0, q] = found[r, 2 * c * size + q]
                    blocks[index, c, r, 1, q] = found[r, (2 * c + 1) * size + q]
                    blocks[index, c, r, 2, q] = found[r, (4 + c) * size + q]
                    blocks[index, 2, r, c, q] = 0.0
                blocks[index, 2, r, 2, q] = found[r, 6 * size + q]
            for c in range(3):
                blocks[index, c, r, c, r] -= springs[contact_dof(k, c, n)]
            by_frequency[index, 0, r] = found[r, 7 * size]
            by_frequency[index, 1, r] = found[r, 7 * size + 1]


@numba.njit(cache=True)
def cycle_work(motion, slip, g_0, laws, friction, modulation, path, peak):
    """Friction work per area and period, slip path and largest tangential displacement of every point.

    Parameters
    ----------
    motion, slip : (3 n, N) motion and (2 n, N) elastic slip during a period of the periodic state, m
    g_0 : (3 n,) relative displacement of the preload state, m
    friction : output (n,) mean traction times slip from sample to sample, summed over the period, J/m^2
    modulation : output (n,) energy exchanged between the elastic slip and the varying pressure, J/m^2
    path : output (n,) length of the slip path per period, m
    peak : output (n, 3) largest tangential displacement from the preload state, then its components, m
    """
    n, count = friction.shape[0], motion.shape[1]
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        stick, held = stick_change(k, 1.0, laws), laws.stick[k]  # per pressure, and constant; for all samples
        kn, separates = laws.kn[k], laws.separation[k]
        keeps = 1.0 if laws.stores_slip[k] else 0.0  # without memory all slip is lost
        friction[k] = modulation[k] = path[k] = 0.0
        peak[k, :] = 0.0
        for j in range(count):
            b = (j - 1) % count
            p = pressure(penalty_traction(g_0[r] + motion[r, j], kn, separates))
            p_b = pressure(penalty_traction(g_0[r] + motion[r, b], kn, separates))
            dh, dz = motion[h, j] - motion[h, b], motion[z, j] - motion[z, b]
            eh, ez, eh_b, ez_b = keeps * slip[h, j], keeps * slip[z, j], keeps * slip[h, b], keeps * slip[z, b]
            if laws.elastic[k]:
                eh, ez, eh_b, ez_b = motion[h, j], motion[z, j], motion[h, b], motion[z, b]
            plastic, _, _ = tangential_work(
                k, p_b, p, ((held + stick * p_b) * slip[h, b], (held + stick * p_b) * slip[z, b]),
                ((held + stick * p) * slip[h, j], (held + stick * p) * slip[z, j]), (dh, dz), (eh_b, ez_b), (eh, ez),
                laws,
            )  # fmt: skip
            friction[k] += plastic
            if not laws.elastic[k]:
                modulation[k] += modulation_work(k, p_b, p, (eh_b, ez_b), (eh, ez), laws)
            ph, pz = dh - (eh - eh_b), dz - (ez - ez_b)
            path[k] += np.sqrt(ph * ph + pz * pz)
            size = np.sqrt(motion[h, j] ** 2 + motion[z, j] ** 2)
            if size > peak[k, 0]:
                peak[k, 0], peak[k, 1], peak[k, 2] = size, motion[h, j], motion[z, j]
