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
import numpy as np

from wroll_fem.contact import kernels
from wroll_fem.contact.point import axial, hoop, normal, pressure
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__, kernels.__file__)


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
def slide_to_turning_points(x, contact, slid, jump, reference, beyond):
    """Move points that slide and turn back in this step to their turning points.

    Parameters
    ----------
    x : (m,) displacement expected at the end of the step
    contact : `ContactMemory`; the committed jump of these points becomes the one at the turning point
    slid : (2 n,) tangential displacement in the last step of points that slid at its end, m; 0 at the others
    jump : (3 n, m) relative displacement per unit coordinate
    reference : `Reference`
    beyond : (2 n,) output: slip to the turning points, m, 0 at the other points
    """
    for k in range(slid.shape[0] // 2):
        h, z = hoop(k), axial(k)
        beyond[h], beyond[z] = 0.0, 0.0
        if slid[h] == 0.0 and slid[z] == 0.0:
            continue
        t_h, t_z = contact.traction[h], contact.traction[z]
        size = math.sqrt(t_h * t_h + t_z * t_z)
        if size == 0.0:
            continue
        n_h, n_z = t_h / size, t_z / size
        ahead_h = reference.jump[h] - contact.jump[h] + np.dot(jump[h], x)
        ahead_z = reference.jump[z] - contact.jump[z] + np.dot(jump[z], x)
        before, after = slid[h] * n_h + slid[z] * n_z, ahead_h * n_h + ahead_z * n_z
        if before > 0.0 and after < 0.0:
            distance = overshoot(before, after)
            beyond[h], beyond[z] = distance * n_h, distance * n_z
            contact.jump[h] += beyond[h]
            contact.jump[z] += beyond[z]


@numba.njit(cache=True)
def add_work_of_path(contact, trial, beyond, slid, laws, work, path):
    """Replace the friction work of a step, mean traction times slip, by the work of sliding at the friction limit.

    A point that slides with pressure p at the end of the step has slid along the traction there. If it slid at the
    start, the mean of both limits acts; else it has slid in the last part of the step, estimated by the share of slip
    in its displacement, and the limit there follows the pressure.

    Parameters
    ----------
    contact, trial : `ContactMemory` before, and `Trial` after the step
    beyond : (2 n,) slip to turning points, m, included in the step
    slid : (2 n,) tangential displacement in the step before; updated
    laws : `PointLaws`
    work, path : work (5,), J, and slip path (n,), m, of `interface_work` and `record_slip`; updated

    Returns
    -------
    Change of the friction work, J
    """
    g, t, e, status, _ = trial
    total = 0.0
    n = laws.area.shape[0]
    for k in range(n):
        h, z = hoop(k), axial(k)
        slides = status[k] == kernels.SLIP
        turned = beyond[h] != 0.0 or beyond[z] != 0.0
        if not laws.sticks[k] or not (slides or turned):
            slid[h], slid[z] = 0.0, 0.0
            continue
        dg_h, dg_z = g[h] - contact.jump[h], g[z] - contact.jump[z]
        plain_h = dg_h - (e[h] - contact.elastic_slip[h])
        plain_z = dg_z - (e[z] - contact.elastic_slip[z])
        polygon = 0.5 * ((t[h] + contact.traction[h]) * plain_h + (t[z] + contact.traction[z]) * plain_z)
        limit = math.sqrt(contact.traction[h] ** 2 + contact.traction[z] ** 2)
        before = math.sqrt(beyond[h] ** 2 + beyond[z] ** 2)
        s_h, s_z = plain_h - beyond[h], plain_z - beyond[z]
        slip = math.sqrt(s_h * s_h + s_z * s_z)
        exact = limit * before
        if slides:
            end = math.sqrt(t[h] * t[h] + t[z] * t[z])
            if not turned and (slid[h] != 0.0 or slid[z] != 0.0):
                exact += 0.5 * (limit + end) * slip
            else:
                p_c, p = pressure(contact.traction[normal(k, n)]), pressure(t[normal(k, n)])
                moved = math.sqrt((dg_h - beyond[h]) ** 2 + (dg_z - beyond[z]) ** 2)
                share = min(1.0, slip / moved) if moved > 0.0 else 1.0
                grown = 0.5 * share * (p_c / p - 1.0) if p > 0.0 else 0.0
                exact += end * (1.0 + grown) * slip
        total += laws.area[k] * (exact - polygon)
        if turned:
            path[k] += before + ((slip - math.sqrt(plain_h * plain_h + plain_z * plain_z)) if slides else 0.0)
        slid[h], slid[z] = (dg_h, dg_z) if slides else (0.0, 0.0)
    work[kernels.FRICTION] += total
    work[kernels.TOTAL] += total
    return total
