"""Periodic elastic slip of points with Coulomb friction, many points at a time (see `kernel`).

The equations are those of `kernel.iterate_to_periodic` for the law `penalty_coulomb`, in the same order. One point
after the other would wait for a square root and a division at every sample; points side by side fill that time, and
the vector instructions of the processor. A point whose motion stays within the friction limit needs no iteration.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.point import axial, hoop
from wroll_fem.contact.registry import LAWS
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__)

COULOMB = LAWS.index(PenaltyCoulomb)
"""Number of the law in `PointLaws.kind`."""

LANES = 16
"""Number of points side by side. The loops over them have a constant length and constant offsets in one array; with
fewer points or with one array per quantity, the compiler does not vectorise them."""
MOTION_H, MOTION_Z, SLIP_H, SLIP_Z, SCALE = (k * LANES for k in range(5))
"""First place of each quantity in a row of the ``table`` of `advance_period`."""

E_H, E_Z, BEFORE_H, BEFORE_Z, LIMIT, FIRST = (k * LANES for k in range(6))
"""First place of each quantity in its ``state``."""

FEWEST = 6
"""Number of sliding points from which they are computed side by side."""

WITHIN = 1.0 - 1e-12
"""Elastic slip, relative to its limit, up to which a point holds whatever the rounding."""


@numba.njit(cache=True, error_model="numpy")
def sort_points(path, reference, laws, out):
    """Compute the points with Coulomb friction that hold, and store them in the `Hysteresis` ``out``.

    Such a point holds during the ramp too: its elastic slip moves from one slip within the limit to another.

    Parameters
    ----------
    path, reference, laws : `SampledMotion`, `contact.kernels.Reference`, `PointLaws`

    Returns
    -------
    sliding : indices of the points with Coulomb friction that slide; empty if they are fewer than `FEWEST`
    rest : indices of the remaining points
    """
    n, count = out.sliding.shape
    sliding, rest, slides, others = np.empty(n, np.int64), np.empty(n, np.int64), 0, 0
    for k in range(n):
        if laws.kind[k] != COULOMB:
            rest[others] = k
            others += 1
            continue
        start_h, start_z, limit = reference.elastic_slip[hoop(k)], reference.elastic_slip[axial(k)], laws.gamma[k]
        square = limit * limit * WITHIN
        motion_h, motion_z = path.motion[hoop(k)], path.motion[axial(k)]
        slip_h, slip_z = out.slip[hoop(k)], out.slip[axial(k)]
        for j in range(count):
            slip_h[j], slip_z[j] = start_h + motion_h[j], start_z + motion_z[j]
        outside = start_h * start_h + start_z * start_z > square
        for j in range(count):
            outside |= slip_h[j] * slip_h[j] + slip_z[j] * slip_z[j] > square
        if outside:
            sliding[slides] = k
            slides += 1
            continue
        out.sliding[k, :] = False
        out.moved[k], out.periods[k], out.change[k] = False, 1, 0.0
    if slides < FEWEST:
        for i in range(slides):
            rest[others + i] = sliding[i]
        return sliding[:0], rest[: others + slides]
    return sliding[:slides], rest[:others]


@numba.njit(cache=True)
def empty_lanes(count):
    """Arguments ``table`` and ``state`` of `advance_period` for ``count`` samples, without points."""
    state = np.zeros(FIRST + LANES)
    state[LIMIT:FIRST] = 1.0
    return np.zeros((count, SCALE + LANES)), state


@numba.njit(cache=True)
def take_point(b, k, path, reference, laws, table, state):
    """Put point ``k`` into lane ``b``, at the beginning of its first period."""
    h, z = hoop(k), axial(k)
    for j in range(table.shape[0]):
        table[j, MOTION_H + b], table[j, MOTION_Z + b] = path.motion[h, j], path.motion[z, j]
    state[E_H + b], state[E_Z + b] = reference.elastic_slip[h], reference.elastic_slip[z]
    state[BEFORE_H + b], state[BEFORE_Z + b], state[LIMIT + b], state[FIRST + b] = 0.0, 0.0, laws.gamma[k], 1.0


@numba.njit(cache=True, error_model="numpy")
def advance_period(table, ramp, state):
    """Advance the points of all lanes by one period.

    Parameters
    ----------
    table : (N, 5 LANES) rows of samples: motion (hoop, axial), m; outputs elastic slip (hoop, axial), m, and this slip
        relative to the trial slip, which is below 1 where the point slides
    ramp : (N + 1,) factor on the motion of the points in their first period
    state : (6 LANES,) elastic slip and motion (hoop, axial each) at the end of the period before, updated, m; limit, m;
        1 for points in their first period
    """
    count = table.shape[0]
    for i in range(1, count + 1):
        row = table[i if i < count else 0]
        for b in range(LANES):
            grown = ramp[i] if state[FIRST + b] > 0.0 else 1.0
            now_h, now_z, limit = grown * row[MOTION_H + b], grown * row[MOTION_Z + b], state[LIMIT + b]
            th, tz = state[E_H + b] + now_h - state[BEFORE_H + b], state[E_Z + b] + now_z - state[BEFORE_Z + b]
            length = math.sqrt(th * th + tz * tz)
            scale = limit / (length if length > limit else limit)
            state[E_H + b], state[E_Z + b] = th * scale, tz * scale
            state[BEFORE_H + b], state[BEFORE_Z + b] = now_h, now_z
            row[SLIP_H + b], row[SLIP_Z + b] = th * scale, tz * scale
            row[SCALE + b] = scale


@numba.njit(cache=True, error_model="numpy")
def slide_to_periodic(points, path, reference, laws, max_periods, tolerance, out):
    """Compute the periodic elastic slip of sliding ``points`` with Coulomb friction; see `kernel.iterate_to_periodic`.

    ``points`` (a,) are indices. A lane takes the next point as soon as its own has become periodic.
    """
    slip, sliding, moved, periods, change = out
    count = sliding.shape[1]
    (table, state), start = empty_lanes(count), np.zeros(BEFORE_H)
    lanes, taken, busy = np.full(LANES, -1), 0, 0
    while True:
        for b in range(LANES):
            if lanes[b] >= 0 or taken == points.shape[0]:
                continue
            k = points[taken]
            take_point(b, k, path, reference, laws, table, state)
            lanes[b], periods[k], moved[k] = k, -1, False
            taken += 1
            busy += 1
        if busy == 0:
            break
        start[:] = state[:BEFORE_H]
        advance_period(table, path.ramp, state)
        state[FIRST:] = 0.0
        for b in range(LANES):
            k = lanes[b]
            if k < 0:
                continue
            periods[k] += 1
            for j in range(count):
                if moved[k]:
                    break
                moved[k] = table[j, SCALE + b] < 1.0
            moves = max(abs(state[E_H + b] - start[E_H + b]), abs(state[E_Z + b] - start[E_Z + b])) / laws.gamma[k]
            if periods[k] == max_periods or (periods[k] > 0 and moves <= tolerance):
                change[k] = moves
                for j in range(count):
                    slip[hoop(k), j], slip[axial(k), j] = table[j, SLIP_H + b], table[j, SLIP_Z + b]
                    sliding[k, j] = table[j, SCALE + b] < 1.0
                lanes[b] = -1
                busy -= 1
