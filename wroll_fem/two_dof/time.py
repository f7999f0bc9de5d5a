"""Time integration of the two masses from rest until they repeat, with scipy's LSODA (stiff where friction sticks)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from scipy.integrate import solve_ivp

from wroll_fem.contact.laws import regularised_sign, regularised_sign_slope
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.two_dof.model import Pressed
from wroll_fem.typing import FloatArray

drop_stale_cache(__file__)

BLOCK = 8
"""Periods between two looks at what has changed."""
MOST_PERIODS = 200_000


@dataclass(frozen=True)
class SettledMotion:
    """Motion from rest that has settled.

    Attributes
    ----------
    transmissibility : largest abs(x_1) over Y_0 in the last period
    periods : periods integrated
    remaining : estimated distance from the periodic motion over its size
    """

    transmissibility: float
    periods: int
    remaining: float


@numba.njit(cache=True)
def rates_into(state: FloatArray, t: float, omega: float, p: FloatArray, out: FloatArray) -> None:
    """Rates of (x1, x2, v1, v2) in absolute displacements, as equations 5.2 and 5.3 are written, into ``out`` (4,)."""
    m1, k1, c1, m2, k2, c2, capacity, smoothing, amplitude, a, b = p
    x1, x2, v1, v2 = state[0], state[1], state[2], state[3]
    y, y_dot = amplitude * np.sin(omega * t), amplitude * omega * np.cos(omega * t)
    friction = capacity * regularised_sign(smoothing * (v1 - v2))
    pull_1 = k1 * (x1 - y) + c1 * (v1 - y_dot)
    pull_2 = k2 * (x2 - a * x1 - b * y) + c2 * (v2 - a * v1 - b * y_dot)
    out[0], out[1] = v1, v2
    out[2] = (-pull_1 + a * pull_2 - friction) / m1
    out[3] = (-pull_2 + friction) / m2


@numba.njit(cache=True)
def _rates(t: float, state: FloatArray, omega: float, p: FloatArray) -> FloatArray:
    """(4,) rates."""
    out = np.empty(4)
    rates_into(state, t, omega, p, out)
    return out


@numba.njit(cache=True)
def _slopes(t: float, state: FloatArray, omega: float, p: FloatArray) -> FloatArray:
    """(4, 4) derivatives of the rates."""
    m1, k1, c1, m2, k2, c2, capacity, smoothing, _, a, _ = p
    s = regularised_sign(smoothing * (state[2] - state[3]))
    f = capacity * smoothing * regularised_sign_slope(s)
    out = np.zeros((4, 4))
    out[0, 2] = out[1, 3] = 1.0
    out[2, 0], out[2, 1] = -(k1 + a * a * k2) / m1, a * k2 / m1
    out[2, 2], out[2, 3] = -(c1 + a * a * c2 + f) / m1, (a * c2 + f) / m1
    out[3, 0], out[3, 1] = a * k2 / m2, -k2 / m2
    out[3, 2], out[3, 3] = (a * c2 + f) / m2, -(c2 + f) / m2
    return out


def parameters(p: Pressed) -> FloatArray:
    """(11,) numbers of the compiled equations."""
    return np.array([p.m1, p.k1, p.c1, p.m2, p.k2, p.c2, p.capacity, p.smoothing, p.base_amplitude, *p.hold])


def integrate(
    pressed: Pressed, omega: float, state: Sequence[float] | FloatArray, times: FloatArray, tolerance: float
) -> FloatArray:
    """States (n, 4) of x1, x2, v1, v2 at ``times`` (n,), from ``state`` at the first of them.

    Raises
    ------
    ConvergenceError
        When LSODA gives up.
    """
    found = solve_ivp(
        _rates, (times[0], times[-1]), state, method="LSODA", t_eval=times, args=(omega, parameters(pressed)),
        jac=_slopes, rtol=tolerance, atol=tolerance * pressed.base_amplitude,
    )  # fmt: skip
    if not found.success:
        raise ConvergenceError(
            f"time integration at omega = {omega:.6g} rad/s: {found.message}", time_s=float(times[-1]), iterations=0,
            residual_history=[], advice="use a smaller two_dof.smoothing",
        )  # fmt: skip
    return np.asarray(found.y.T)


def settle(pressed: Pressed, omega: float, *, settled: float = 1e-6, tolerance: float = 1e-10) -> SettledMotion:
    """Motion from rest under y = Y_0 sin(omega t) until it repeats.

    The change of the state over a block of periods falls by a ratio q from block to block in the end; what is
    left to come is then q / (1 - q) times the last change.

    Parameters
    ----------
    settled
        What may be left, over the size of the motion (energy norm).
    tolerance
        Relative tolerance of the integration.

    Raises
    ------
    ConvergenceError
        When it does not settle in a very long time.
    """
    period = 2.0 * np.pi / omega
    block = period * np.arange(BLOCK + 1)
    weight = np.sqrt([pressed.k1, pressed.k2, pressed.m1, pressed.m2])
    state, changes = np.zeros(4), [np.inf]
    periods = 0
    while periods < MOST_PERIODS:
        path = integrate(pressed, omega, state, block, tolerance)
        periods += BLOCK
        changes.append(float(np.linalg.norm(weight * (path[-1] - state))))
        state = path[-1]
        # two blocks at once: beats between the transient and the looks every BLOCK periods cancel in the product
        q = np.sqrt(changes[-1] / changes[-3]) if len(changes) > 3 and changes[-3] > 0.0 else 1.0
        size = float(np.linalg.norm(weight * state))
        remaining = changes[-1] * q / (1.0 - q) / size if q < 1.0 else np.inf
        if remaining < settled or changes[-1] < 10.0 * tolerance * size:
            return SettledMotion(_largest(pressed, omega, state, tolerance), periods, min(remaining, 1.0))
    raise ConvergenceError(
        f"the motion at omega = {omega:.6g} rad/s has not settled", time_s=periods * period, iterations=periods,
        residual_history=changes[-5:], advice="use more damping, or two_dof.method: periodic",
    )  # fmt: skip


def dwell(pressed: Pressed, omega: float, duration: float, *, tolerance: float = 1e-8) -> float:
    """Largest abs(x_1) over Y_0 in the last period of a run of ``duration`` (s) from rest, as the source reads it."""
    period = 2.0 * np.pi / omega
    start = integrate(pressed, omega, np.zeros(4), np.array([0.0, duration - period]), tolerance)[-1]
    return _largest(pressed, omega, start, tolerance, begin=duration - period)


def _largest(pressed: Pressed, omega: float, state: FloatArray, tolerance: float, *, begin: float = 0.0) -> float:
    """Largest abs(x_1) over Y_0 in the period from ``begin``; between two points by the parabola of x, v and a."""
    times = begin + 2.0 * np.pi / omega * np.linspace(0.0, 1.0, 1001)
    path = integrate(pressed, omega, state, times, tolerance)
    k = int(np.argmax(np.abs(path[:, 0])))
    x, v = path[k, 0], path[k, 2]
    a = _rates(times[k], path[k], omega, parameters(pressed))[2]
    return float(abs(x - 0.5 * v * v / a) / pressed.base_amplitude)
