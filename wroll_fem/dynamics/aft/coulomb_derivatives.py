"""Derivatives of the tractions of sliding points with Coulomb friction (see `derivatives`, `coulomb`).

The elastic slip of a point changes as its motion does, except that sliding changes this dependence. Between two samples
at which the point slides, the difference, D, is constant: the derivatives of the Fourier coefficients of the traction
are those of a point that sticks, and one product per such span with its D. Derivatives by the mean displacement, whose
motion is constant too, are products alone: they are exactly zero where a point slides at every sample, so that
equations without a solution stay singular.
"""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.dynamics.aft import coulomb
from wroll_fem.dynamics.aft.coulomb import FIRST, LANES, SCALE, SLIP_H, SLIP_Z, advance_period, empty_lanes, take_point
from wroll_fem.numerics.numba_cache import drop_stale_cache

drop_stale_cache(__file__, coulomb.__file__)


@numba.njit(cache=True)
def _side_by_side(values):
    """Motions (N, groups 2 LANES) in hoop, then in axial direction, for unit coefficients of both directions.

    Each group has `LANES` of the 2 R coefficients, which are the hoop ones, the axial ones and zeros. ``values``
    (N, R): see `kernel.Series`.
    """
    count, size = values.shape
    out = np.zeros((count, (2 * size + LANES - 1) // LANES * 2 * LANES))
    for q in range(size):
        for j in range(count):
            out[j, _place(q)] = values[j, q]
            out[j, _place(size + q) + LANES] = values[j, q]
    return out


@numba.njit(cache=True, inline="always")
def _place(coefficient):
    """Place of the hoop motion of a coefficient in a row of `_side_by_side`; the axial one is `LANES` later."""
    return coefficient // LANES * 2 * LANES + coefficient % LANES


@numba.njit(cache=True, error_model="numpy", inline="always")
def _slide(change, shape, grown, slip_h, slip_z, limit, scale):
    """Update the ``change`` of the elastic slip, minus that of a sticking point, at a sample at which the point slides.

    With the direction m of the elastic slip, the derivative by the trial slip is ``scale`` (I - m m^T).

    Parameters
    ----------
    change, shape : rows of `_side_by_side`; the motion of a unit coefficient is ``grown`` times ``shape``
    slip_h, slip_z, limit : elastic slip (hoop, axial) and its limit, m
    scale : elastic slip relative to the trial slip, below 1
    """
    m_h, m_z = slip_h / limit, slip_z / limit
    a00, a01, a11 = scale * (1.0 - m_h * m_h), -scale * m_h * m_z, scale * (1.0 - m_z * m_z)
    for group in range(change.shape[0] // (2 * LANES)):
        first = group * 2 * LANES
        for b in range(LANES):
            x_h, x_z = grown * shape[first + b], grown * shape[first + LANES + b]
            u_h, u_z = change[first + b] + x_h, change[first + LANES + b] + x_z
            change[first + b] = a00 * u_h + a01 * u_z - x_h
            change[first + LANES + b] = a01 * u_h + a11 * u_z - x_z


@numba.njit(cache=True, error_model="numpy")
def add_history(points, places, path, periods, reference, laws, series, factors, blocks):
    """Add to ``blocks`` what sliding changes in the derivatives of the tangential tractions.

    The derivatives by the mean displacement are complete, the others lack those of a point that sticks.

    Parameters
    ----------
    points : (a,) indices of sliding points with Coulomb friction
    places : (a,) their places in ``blocks`` and ``factors``
    path, reference, series : see `derivatives`
    periods : (n,) number of whole periods of each point, see `kernel.Hysteresis`
    factors : (N, 4 n_blocks) four columns per block, see `derivatives.STICK`
    blocks : (n_blocks, 3, R, 3, R) updated, see `derivatives`
    """
    count, size = series.values.shape
    shapes = _side_by_side(series.values)
    table, state = empty_lanes(count)
    change, spans = np.zeros((LANES, shapes.shape[1])), np.zeros((count + 1, shapes.shape[1]))
    weights, project = np.zeros((count + 1, size)), np.ascontiguousarray(series.project.T)
    lanes, done, taken, busy = np.full(LANES, -1), np.zeros(LANES, np.int64), 0, 0
    while True:
        for b in range(LANES):
            if lanes[b] < 0 and taken < points.shape[0]:
                take_point(b, points[taken], path, reference, laws, table, state)
                change[b] = 0.0
                lanes[b], done[b] = taken, 0
                taken += 1
                busy += 1
        if busy == 0:
            break
        advance_period(table, path.ramp, state)
        for b in range(LANES):
            if lanes[b] < 0:
                continue
            index = lanes[b]
            k, limit, first = points[index], laws.gamma[points[index]], state[FIRST + b] > 0.0
            if done[b] < periods[k]:
                for i in range(1, count + 1):
                    j = i if i < count else 0
                    if table[j, SCALE + b] < 1.0:
                        grown = path.ramp[i] if first else 1.0
                        _slide(
                            change[b], shapes[j], grown, table[j, SLIP_H + b], table[j, SLIP_Z + b], limit,
                            table[j, SCALE + b],
                        )  # fmt: skip
                done[b] += 1
                continue
            last = 0
            spans[0] = change[b]
            weights[0] = 0.0
            for i in range(1, count + 1):
                j = i if i < count else 0
                if table[j, SCALE + b] < 1.0:
                    last += 1
                    spans[last] = spans[last - 1]
                    weights[last] = 0.0
                    _slide(
                        spans[last], shapes[j], 1.0, table[j, SLIP_H + b], table[j, SLIP_Z + b], limit,
                        table[j, SCALE + b],
                    )  # fmt: skip
                stiffness, weight, shares = factors[j, 4 * places[index]], weights[last], project[j]
                for r in range(size):
                    weight[r] += stiffness * shares[r]
            for span in range(last + 1):
                spans[span, _place(0)] += 1.0
                spans[span, _place(size) + LANES] += 1.0
            found = np.dot(weights[: last + 1].T, spans[: last + 1])
            block = blocks[places[index]]
            for r in range(size):
                for q in range(size):
                    along, across = _place(q), _place(size + q)
                    block[0, r, 0, q] += found[r, along]
                    block[0, r, 1, q] += found[r, across]
                    block[1, r, 0, q] += found[r, along + LANES]
                    block[1, r, 1, q] += found[r, across + LANES]
            lanes[b] = -1
            busy -= 1
        state[FIRST:] = 0.0
