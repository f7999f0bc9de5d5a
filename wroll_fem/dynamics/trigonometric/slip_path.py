r"""Slip of a point within a step: its work along the path, and the way that it slides before it turns back.

The ends of a step show neither the moment at which a point begins to slide nor the farthest place of one that slides
and turns back. Both matter in second order of the step. For a motion of amplitude X that slides in a loop with the
elastic slip :math:`\gamma`, steps of the angle :math:`\omega h` leave on average

- :math:`(\omega h)^2 / 6` of the friction work, if it is the mean traction of a step times its slip. A point slides
  at the friction limit; limit times slip has no such error.
- :math:`(\omega h)^2 / 24 \cdot X / (X - \gamma)` of the slip, between the last end of a step and the turning point. A
  parabola through three ends of steps gives this distance with an error of third order.

Derivation: docs/trigonometric.md.
"""

from __future__ import annotations

import math

import numba

from wroll_fem.contact import kernels
from wroll_fem.contact.laws import slip_update
from wroll_fem.contact.point import axial, hoop, normal, pressure, stick_stiffness
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__, kernels.__file__)

NEAR = 0.9
"""Traction of a sticking point, relative to mu p, from which a turning point within a step may make it slide. With 10
steps per cycle the turning point is at most 5 % of the amplitude away from the ends of the step."""


@numba.njit(cache=True)
def overshoot(before, after):
    """Distance of a turning point beyond the middle one of three places at equal intervals.

    Parameters
    ----------
    before, after : last increment along the direction of slip, positive, and next one, negative; m
    """
    slope = 0.5 * (before + after)
    return 0.5 * slope * slope / (before - after)


@numba.njit(cache=True)
def slide_to_turning_points(g, contact, moved, laws, dt, beyond, limits):
    """Let points that turn back in this step slide as far as their turning points require.

    Parameters
    ----------
    g : (3 n,) relative displacement expected at the end of the step, m
    contact : `ContactMemory`; the committed jump of these points receives the slip
    moved : (2 n,) tangential displacement in the last step of points near the friction limit, m; 0 at the others
    laws : `PointLaws`
    dt : size of the step, s
    beyond : (2 n,) output: slip up to the turning points, m, 0 at the other points
    limits : (n,) output: traction of these points during this slip, Pa
    """
    n = limits.shape[0]
    traction, jump = contact.traction, contact.jump
    for k in range(n):
        h, z = hoop(k), axial(k)
        beyond[h], beyond[z] = 0.0, 0.0
        if moved[h] == 0.0 and moved[z] == 0.0:
            continue
        t_h, t_z = traction[h], traction[z]
        size = math.sqrt(t_h * t_h + t_z * t_z)
        if size == 0.0:
            continue
        n_h, n_z = t_h / size, t_z / size
        before = moved[h] * n_h + moved[z] * n_z
        if before <= 0.0:
            continue
        after = (g[h] - jump[h]) * n_h + (g[z] - jump[z]) * n_z
        if after < 0.0:
            distance = overshoot(before, after)
            d_h, d_z = distance * n_h, distance * n_z
            e_h, e_z = contact.elastic_slip[h], contact.elastic_slip[z]
            p = pressure(traction[normal(k, n)])
            new_h, new_z, slides = slip_update(k, e_h + d_h, e_z + d_z, d_h, d_z, p, laws, dt)
            if slides:
                beyond[h], beyond[z] = e_h + d_h - new_h, e_z + d_z - new_z
                jump[h] += beyond[h]
                jump[z] += beyond[z]
                limits[k] = stick_stiffness(k, p, laws) * math.sqrt(new_h * new_h + new_z * new_z)


@numba.njit(cache=True)
def add_work_of_path(contact, trial, beyond, limits, moved, sliding, laws, work, path):
    """Replace the friction work of a step, mean traction times slip, by the work of sliding at the friction limit.

    A point that slides with pressure p at the end of the step has slid along the traction there. If it slid at the
    start, the mean of both limits acts; else it has slid in the last part of the step, estimated by the share of slip
    in its displacement, and the limit there follows the pressure.

    Parameters
    ----------
    contact, trial : `ContactMemory` before, and `Trial` after the step
    beyond, limits : slip to turning points (2 n,), m, included in the step, and traction during it (n,), Pa
    moved : (2 n,) tangential displacement in the last step of points near the friction limit, m; updated
    sliding : (n,) 1 at points that slid at the end of the last step, else 0; updated
    laws : `PointLaws`
    work, path : work (5,), J, and slip path (n,), m, of `interface_work` and `record_slip`; updated

    Returns
    -------
    Change of the friction work, J
    """
    g, t, e, status, _ = trial
    g_c, e_c, t_c = contact.jump, contact.elastic_slip, contact.traction  # outside the loop: numba counts references
    area, mu, sticks, total = laws.area, laws.mu, laws.sticks, 0.0
    n = area.shape[0]
    for k in range(n):
        h, z = hoop(k), axial(k)
        slides = status[k] == kernels.SLIP
        turned = beyond[h] != 0.0 or beyond[z] != 0.0
        p_c, p = pressure(t_c[normal(k, n)]), pressure(t[normal(k, n)])
        near = NEAR * mu[k] * p
        followed = sticks[k] and p > 0.0 and (slides or t[h] * t[h] + t[z] * t[z] > near * near)
        dg_h, dg_z = g[h] - g_c[h], g[z] - g_c[z]
        slid = sliding[k] > 0.0
        moved[h], moved[z] = (dg_h, dg_z) if followed else (0.0, 0.0)
        sliding[k] = 1.0 if slides and followed else 0.0
        if not sticks[k] or not (slides or turned):
            continue
        plain_h = dg_h - (e[h] - e_c[h])
        plain_z = dg_z - (e[z] - e_c[z])
        polygon = 0.5 * ((t[h] + t_c[h]) * plain_h + (t[z] + t_c[z]) * plain_z)
        before = math.sqrt(beyond[h] ** 2 + beyond[z] ** 2)
        slip = math.sqrt((plain_h - beyond[h]) ** 2 + (plain_z - beyond[z]) ** 2)
        exact = limits[k] * before if turned else 0.0
        if slides:
            end = math.sqrt(t[h] * t[h] + t[z] * t[z])
            if slid and not turned:
                exact += 0.5 * (math.sqrt(t_c[h] ** 2 + t_c[z] ** 2) + end) * slip
            else:
                size = math.sqrt((dg_h - beyond[h]) ** 2 + (dg_z - beyond[z]) ** 2)
                share = min(1.0, slip / size) if size > 0.0 else 1.0
                grown = 0.5 * share * (p_c / p - 1.0) if p > 0.0 else 0.0
                exact += end * (1.0 + grown) * slip
        total += area[k] * (exact - polygon)
        if turned:
            path[k] += before + ((slip - math.sqrt(plain_h * plain_h + plain_z * plain_z)) if slides else 0.0)
    work[kernels.FRICTION] += total
    work[kernels.TOTAL] += total
    return total
