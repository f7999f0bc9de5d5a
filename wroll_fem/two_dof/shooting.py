"""Periodic orbits of the two masses by shooting: time integration with the variational equations, Newton on the gap.

It shares nothing with the harmonic balance of `periodic` but the equations (those of `time`, in absolute
displacements), and so checks it. The base moves as y = Y_0 sin(omega t); the second half of a period mirrors the first
(see `model`), so that Newton's method runs on x(T/2) + x(0) = 0. Some milliseconds per orbit.
"""

from __future__ import annotations

from dataclasses import replace

import numba
import numpy as np
from scipy.integrate import solve_ivp

from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.two_dof import time as in_time
from wroll_fem.two_dof.model import Pressed
from wroll_fem.two_dof.time import _rates, _slopes, parameters, rates_into
from wroll_fem.typing import FloatArray

drop_stale_cache(__file__, in_time.__file__)

LEAST_SMOOTHING = 1e-6
"""Scale of the smoothed sign below which a smoother law is no help any more, s/m."""


@numba.njit(cache=True)
def _with_derivative(t: float, y: FloatArray, omega: float, p: FloatArray) -> FloatArray:
    """Rates of the state (4,) and of its derivative (4, 4) by the start, stacked in ``y`` (20,)."""
    out = np.empty(20)
    rates_into(y, t, omega, p, out)
    out[4:] = (_slopes(t, y[:4], omega, p) @ np.ascontiguousarray(y[4:]).reshape(4, 4)).ravel()
    return out


def periodic_orbit(
    pressed: Pressed, omega: float, guess: FloatArray | None = None, *, tolerance: float = 1e-11
) -> FloatArray:
    """State (4,) of x1, x2, v1, v2 at t = 0 of the periodic orbit; absolute, SI.

    Parameters
    ----------
    omega
        rad/s.
    guess
        A state to start from; without one, rest. Where Newton's method fails it starts from the orbit of a smoother
        law.
    tolerance
        Relative tolerance of LSODA; the gap that is left is below 1e3 times as much.

    Raises
    ------
    ConvergenceError
        When no orbit is found.
    """
    found = _newton(pressed, omega, np.zeros(4) if guess is None else guess, tolerance)
    if found is not None:
        return found
    if pressed.smoothing < LEAST_SMOOTHING:
        raise ConvergenceError(
            f"no periodic orbit found at omega = {omega:.6g} rad/s, capacity {pressed.capacity:g} N", time_s=None,
            iterations=40, residual_history=[], advice="use a smaller two_dof.smoothing",
        )  # fmt: skip
    smoother = replace(pressed, smoothing=0.5 * pressed.smoothing)
    return periodic_orbit(pressed, omega, periodic_orbit(smoother, omega, tolerance=tolerance), tolerance=tolerance)


def _newton(pressed: Pressed, omega: float, x: FloatArray, tolerance: float) -> FloatArray | None:
    """State at t = 0 of the periodic orbit, or None; steps that do not reduce the gap are halved."""
    half, size, step, p = (0.0, np.pi / omega), np.inf, np.zeros(4), parameters(pressed)
    for _ in range(40):
        start = np.concatenate([x, np.eye(4).ravel()])
        end = solve_ivp(
            _with_derivative, half, start, method="LSODA", args=(omega, p), rtol=tolerance,
            atol=tolerance * pressed.base_amplitude,
        ).y[:, -1]  # fmt: skip
        gap = x + end[:4]
        new = float(np.abs(gap).max())
        if new < 1e3 * tolerance * (1.0 + np.abs(x).max()):
            return x
        if not new < size:
            step *= 0.5
            x = x - step
            continue
        size = new
        step = -np.linalg.solve(np.eye(4) + end[4:].reshape(4, 4), gap)
        x = x + step
    return None


def orbit_transmissibility(
    pressed: Pressed, omega: float, state: FloatArray, *, points: int = 1001, tolerance: float = 1e-11
) -> float:
    """Largest abs(x1) over Y_0 on the orbit through ``state`` (4,); between two points by the parabola of x, v, a."""
    times = np.linspace(0.0, np.pi / omega, points)
    path = in_time.integrate(pressed, omega, state, times, tolerance)
    k = int(np.argmax(np.abs(path[:, 0])))
    x, v = path[k, 0], path[k, 2]
    a = _rates(times[k], path[k], omega, parameters(pressed))[2]
    return float(abs(x - 0.5 * v * v / a) / pressed.base_amplitude)


def orbit_curve(pressed: Pressed, omegas: FloatArray) -> FloatArray:
    """(n,) transmissibility over rising ``omegas`` (n,), each orbit started from its neighbour's."""
    state, found = None, []
    for omega in omegas:
        state = periodic_orbit(pressed, float(omega), state)
        found.append(orbit_transmissibility(pressed, float(omega), state))
    return np.array(found)


def off_neighbours(omegas: FloatArray, values: FloatArray) -> FloatArray:
    """(n - 2,) relative distance of each inner point from the straight line between its neighbours."""
    share = (omegas[1:-1] - omegas[:-2]) / (omegas[2:] - omegas[:-2])
    line = values[:-2] + share * (values[2:] - values[:-2])
    return np.asarray(np.abs(values[1:-1] - line) / np.abs(values[1:-1]))


def adapted_curve(
    pressed: Pressed, omegas: FloatArray, *, bound: float = 0.005, finest: float = 2e-6
) -> tuple[FloatArray, FloatArray]:
    """Frequencies and transmissibilities, bisected until every point is within ``bound`` of its neighbours' line.

    Parameters
    ----------
    omegas
        (n,) frequencies to start from, rad/s.
    finest
        Intervals below this are not divided, rad/s.
    """
    states: dict[float, FloatArray] = {}
    values: dict[float, float] = {}
    todo = [float(omega) for omega in omegas]
    while todo:
        for omega in todo:
            near = min(states, key=lambda known: abs(known - omega), default=None)
            states[omega] = periodic_orbit(pressed, omega, None if near is None else states[near])
            values[omega] = orbit_transmissibility(pressed, omega, states[omega])
        grid = np.array(sorted(values))
        bad = np.flatnonzero(off_neighbours(grid, np.array([values[w] for w in grid])) > bound) + 1
        ends = {(i, i + 1) for b in bad for i in (b - 1, b)}
        todo = sorted(float(0.5 * (grid[i] + grid[j])) for i, j in ends if grid[j] - grid[i] > finest)
    return grid, np.array([values[w] for w in grid])
