"""Compiled part of the harmonic balance: contact laws during one period (see `harmonic_contact`).

The motion of a point relative to the preload state is known at N phases of the period (`SampledMotion`). The elastic
slip starts from the preload state. In a first period the motion grows from zero (the ramp); whole periods follow until
the elastic slip repeats. Tractions are those of the last period. The normal law is the penalty alone: a point that
opens between two samples has no release traction (see `harmonic_contact`).
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact import point
from wroll_fem.contact.laws import slip_update
from wroll_fem.contact.point import (
    axial,
    hoop,
    is_closed,
    modulation_work,
    normal,
    penalty_traction,
    pressure,
    stick_change,
    tangential_work,
)
from wroll_fem.dynamics.aft import coulomb
from wroll_fem.dynamics.aft.coulomb import slide_to_periodic, sort_points
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import BoolArray, FloatArray, IntArray

drop_stale_cache(__file__, coulomb.__file__)


class SampledMotion(NamedTuple):
    """Motion of the contact points at the samples of a period.

    Attributes
    ----------
    motion, rate : (3 n, N) relative displacement from the preload state at phases 2 pi j / N, and its change
        per sample (velocity times ``dt``), m; no rates, (0, 0), if all points have Coulomb friction
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

    def of_mean(self) -> Series:
        """The same matrices for the mean alone, the first of the coefficients."""
        first = (self.values[:, :1], self.velocities[:, :1], self.project[:1])
        return Series(*(np.ascontiguousarray(part) for part in first))


class Products(NamedTuple):
    """What gives the matrix that multiplies a motion by a periodic function.

    Attributes
    ----------
    project : (2 (2 H + 1), N) matrix that gives the Fourier coefficients of the function from its samples: those of
        cos 0, ..., cos 2 H, then of sin 0, ..., sin 2 H. The first one is twice the mean.
    orders : (R,) harmonic number of each coefficient of the motion
    """

    project: FloatArray
    orders: IntArray


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
    together, rest = sort_points(path, reference, laws, out)
    if together.shape[0] > 0:
        slide_to_periodic(together, path, reference, laws, max_periods, tolerance, out)
    for k in rest:
        h, z, r = hoop(k), axial(k), normal(k, n)
        eh, ez = reference.elastic_slip[h], reference.elastic_slip[z]
        before_h = before_z = p = 0.0
        g_0, kn, separates, pressed = reference.jump[r], laws.kn[k], laws.separation[k], laws.stick[k] > 0.0
        moved[k] = not laws.sticks[k]
        by_rate, elastic = not laws.exact_increment[k] and laws.kind[k] != coulomb.COULOMB, laws.elastic[k]
        for i in range(1, count + 1):
            j = i % count
            now_h, now_z = ramp[i] * motion[h, j], ramp[i] * motion[z, j]
            th, tz = eh + now_h - before_h, ez + now_z - before_z
            vh, vz = now_h - before_h, now_z - before_z
            if by_rate:
                vh = ramp[i] * rate[h, j] + ramp_rate[i] * motion[h, j]
                vz = ramp[i] * rate[z, j] + ramp_rate[i] * motion[z, j]
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
                th, tz = eh + motion[h, j] - before_h, ez + motion[z, j] - before_z
                vh, vz = motion[h, j] - before_h, motion[z, j] - before_z
                if by_rate:
                    vh, vz = rate[h, j], rate[z, j]
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
    n, count = is_open.shape
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        stick, held = stick_change(k, 1.0, laws), laws.stick[k]  # per pressure, and constant; for all samples
        kn, separates, g_0 = laws.kn[k], laws.separation[k], reference.jump[r]
        t_h, t_z, t_n = reference.traction[h], reference.traction[z], reference.traction[r]
        d_h, d_z, d_n = reference.springs[h], reference.springs[z], reference.springs[r]
        motion_h, motion_z, motion_n = path.motion[h], path.motion[z], path.motion[r]
        slip_h, slip_z, s_h, s_z, s_n, opens = slip[h], slip[z], s[h], s[z], s[r], is_open[k]
        for j in range(count):
            gn = g_0 + motion_n[j]
            tn = penalty_traction(gn, kn, separates)
            kt = held + stick * pressure(tn)
            opens[j] = not is_closed(gn, separates)
            s_h[j] = point.correction(kt * slip_h[j], t_h, d_h, motion_h[j])
            s_z[j] = point.correction(kt * slip_z[j], t_z, d_z, motion_z[j])
            s_n[j] = point.correction(tn, t_n, d_n, motion_n[j])
        low = high = motion_n[0]  # in a loop of their own: the one above is vectorised
        for j in range(count):
            low, high = min(low, motion_n[j]), max(high, motion_n[j])
        most = max(  # the pressure falls as the gap grows
            abs(pressure(penalty_traction(g_0 + low, kn, separates)) + t_n),
            abs(pressure(penalty_traction(g_0 + high, kn, separates)) + t_n),
        )
        pressure_change[k] = most / -t_n if t_n < 0.0 else np.inf


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
