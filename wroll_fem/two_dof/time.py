"""Time integration of the two masses to the steady state with LSODA (the equations are stiff where friction sticks)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from scipy.integrate import solve_ivp

from wroll_fem.contact.laws import regularised_sign, regularised_sign_slope
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.two_dof.model import PreloadedTwoMasses
from wroll_fem.typing import FloatArray

drop_stale_cache(__file__)

BLOCK = 8
"""Number of periods between two checks of the periodicity."""
MOST_PERIODS = 200_000
"""Largest number of periods; after these the integration stops with an error."""


@dataclass(frozen=True)
class SteadyState:
    """Steady state reached by time integration from rest.

    Attributes
    ----------
    transmissibility : largest abs(x_1) in the last period, divided by Y_0
    periods : number of periods integrated
    periodicity_error : estimated relative distance from the periodic motion (energy norm)
    """

    transmissibility: float
    periods: int
    periodicity_error: float


@numba.njit(cache=True)
def rates_into(state: FloatArray, t: float, omega: float, p: FloatArray, out: FloatArray) -> None:
    """Compute the time derivative of the state (equations 5.2 and 5.3 in absolute displacements).

    Parameters
    ----------
    state
        (4,) x1, x2 (m), v1, v2 (m/s).
    t, omega
        Time (s) and frequency of the base motion (rad/s).
    p
        (11,) parameters, as returned by `parameters`.
    out
        (4,) array for the result.
    """
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
    """(4,) time derivative of the state."""
    out = np.empty(4)
    rates_into(state, t, omega, p, out)
    return out


@numba.njit(cache=True)
def _slopes(t: float, state: FloatArray, omega: float, p: FloatArray) -> FloatArray:
    """(4, 4) Jacobian of the time derivative."""
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


def parameters(p: PreloadedTwoMasses) -> FloatArray:
    """(11,) parameters of the compiled equations."""
    return np.array(
        [p.m1, p.k1, p.c1, p.m2, p.k2, p.c2, p.capacity, p.smoothing, p.base_amplitude, *p.support_coupling]
    )


def integrate(
    preloaded: PreloadedTwoMasses,
    omega: float,
    state: Sequence[float] | FloatArray,
    times: FloatArray,
    tolerance: float,
) -> FloatArray:
    """Integrate the equations of motion.

    Parameters
    ----------
    preloaded
        Parameters of the model.
    omega
        Frequency of the base motion, rad/s.
    state
        (4,) initial x1, x2 (m), v1, v2 (m/s) at the first time.
    times
        (n,) times, s, ascending.
    tolerance
        Relative tolerance of LSODA.

    Returns
    -------
    (n, 4) states at the times

    Raises
    ------
    ConvergenceError
        If LSODA fails.
    """
    found = solve_ivp(
        _rates, (times[0], times[-1]), state, method="LSODA", t_eval=times, args=(omega, parameters(preloaded)),
        jac=_slopes, rtol=tolerance, atol=tolerance * preloaded.base_amplitude,
    )  # fmt: skip
    if not found.success:
        raise ConvergenceError(
            f"time integration failed at omega = {omega:.6g} rad/s ({found.message})", time_s=float(times[-1]),
            iterations=0, residual_history=[], advice="reduce two_dof.smoothing",
        )  # fmt: skip
    return np.asarray(found.y.T)


def integrate_to_steady_state(
    preloaded: PreloadedTwoMasses, omega: float, *, accuracy: float = 1e-6, tolerance: float = 1e-10
) -> SteadyState:
    """Integrate from rest under y = Y_0 sin(omega t) until the motion is periodic.

    The change of the state over a block of periods eventually decreases by a constant ratio q from block to block, so
    the remaining change is q / (1 - q) times the last change.

    Parameters
    ----------
    preloaded
        Parameters of the model.
    omega
        Frequency of the base motion, rad/s.
    accuracy
        Largest relative distance from the periodic motion (energy norm).
    tolerance
        Relative tolerance of the integration.

    Raises
    ------
    ConvergenceError
        If the motion is not periodic after `MOST_PERIODS` periods, or if the integration fails.
    """
    period = 2.0 * np.pi / omega
    block = period * np.arange(BLOCK + 1)
    weight = np.sqrt([preloaded.k1, preloaded.k2, preloaded.m1, preloaded.m2])
    state, changes = np.zeros(4), [np.inf]
    periods = 0
    while periods < MOST_PERIODS:
        path = integrate(preloaded, omega, state, block, tolerance)
        periods += BLOCK
        changes.append(float(np.linalg.norm(weight * (path[-1] - state))))
        state = path[-1]
        # the ratio over two blocks is free of beats between the transient and the checks every BLOCK periods
        q = np.sqrt(changes[-1] / changes[-3]) if len(changes) > 3 and changes[-3] > 0.0 else 1.0
        size = float(np.linalg.norm(weight * state))
        remaining = changes[-1] * q / (1.0 - q) / size if q < 1.0 else np.inf
        if remaining < accuracy or changes[-1] < 10.0 * tolerance * size:
            return SteadyState(_largest(preloaded, omega, state, tolerance), periods, min(remaining, 1.0))
    raise ConvergenceError(
        f"the motion at omega = {omega:.6g} rad/s is not periodic yet", time_s=periods * period, iterations=periods,
        residual_history=changes[-5:], advice="increase the damping, or use two_dof.method: periodic",
    )  # fmt: skip


def dwell(preloaded: PreloadedTwoMasses, omega: float, duration: float, *, tolerance: float = 1e-8) -> float:
    """Transmissibility in the last period of a run from rest, as evaluated in the thesis.

    Parameters
    ----------
    preloaded
        Parameters of the model.
    omega
        Frequency of the base motion, rad/s.
    duration
        Duration of the run, s.
    tolerance
        Relative tolerance of the integration.

    Returns
    -------
    Largest abs(x_1) divided by Y_0

    Raises
    ------
    ConvergenceError
        If the integration fails.
    """
    period = 2.0 * np.pi / omega
    start = integrate(preloaded, omega, np.zeros(4), np.array([0.0, duration - period]), tolerance)[-1]
    return _largest(preloaded, omega, start, tolerance, begin=duration - period)


def _largest(
    preloaded: PreloadedTwoMasses, omega: float, state: FloatArray, tolerance: float, *, begin: float = 0.0
) -> float:
    """Largest abs(x_1) divided by Y_0 in the period that starts at ``begin`` (s)."""
    times = begin + 2.0 * np.pi / omega * np.linspace(0.0, 1.0, 1001)
    return peak_of_path(preloaded, omega, times, integrate(preloaded, omega, state, times, tolerance))


def peak_of_path(preloaded: PreloadedTwoMasses, omega: float, times: FloatArray, path: FloatArray) -> float:
    """Largest abs(x_1) divided by Y_0, interpolated by a parabola at the largest sample.

    The parabola has the displacement, velocity and acceleration of this sample.

    Parameters
    ----------
    preloaded
        Parameters of the model.
    omega
        Frequency of the base motion, rad/s.
    times
        (n,) times, s.
    path
        (n, 4) states at these times.
    """
    k = int(np.argmax(np.abs(path[:, 0])))
    x, v = path[k, 0], path[k, 2]
    a = _rates(times[k], path[k], omega, parameters(preloaded))[2]
    return float(abs(x - 0.5 * v * v / a) / preloaded.base_amplitude)
