"""Periodic motions of the two masses by shooting: Newton's method with time-integrated variational equations.

Shooting is an independent check of the harmonic balance in `periodic`: the two methods share only the equations of
motion. The base displacement is y = Y_0 sin(omega t). The second half of a period is the first one with the opposite
sign (see `model`), so Newton's method solves x(T/2) + x(0) = 0. One orbit takes some milliseconds.
"""

from __future__ import annotations

from dataclasses import replace

import numba
import numpy as np
from scipy.integrate import solve_ivp

from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.two_dof import time as in_time
from wroll_fem.two_dof.model import PreloadedTwoMasses
from wroll_fem.two_dof.time import _slopes, parameters, rates_into
from wroll_fem.typing import FloatArray

drop_stale_cache(__file__, in_time.__file__)

LEAST_SMOOTHING = 1e-6
"""Smallest scale of the regularised sign function in the search for a starting orbit, s/m; at smaller scales the search
stops with an error."""


@numba.njit(cache=True)
def _with_derivative(t: float, y: FloatArray, omega: float, p: FloatArray) -> FloatArray:
    """(20,) time derivative of ``y``, which contains the state (4,) and its sensitivity (4, 4) to the initial state."""
    out = np.empty(20)
    rates_into(y, t, omega, p, out)
    out[4:] = (_slopes(t, y[:4], omega, p) @ np.ascontiguousarray(y[4:]).reshape(4, 4)).ravel()
    return out


def periodic_orbit(
    preloaded: PreloadedTwoMasses, omega: float, guess: FloatArray | None = None, *, tolerance: float = 1e-11
) -> FloatArray:
    """Initial state of the periodic orbit.

    Parameters
    ----------
    preloaded
        Parameters of the model.
    omega
        Frequency of the base motion, rad/s.
    guess
        (4,) state from which Newton's method starts; rest if None. If Newton's method fails, it starts from the orbit
        for a smoother friction law.
    tolerance
        Relative tolerance of LSODA; the residual of the periodicity condition is below 1e3 times this value.

    Returns
    -------
    (4,) absolute x1, x2 (m), v1, v2 (m/s) at t = 0

    Raises
    ------
    ConvergenceError
        If no orbit is found.
    """
    found = _newton(preloaded, omega, np.zeros(4) if guess is None else guess, tolerance)
    if found is not None:
        return found
    if preloaded.smoothing < LEAST_SMOOTHING:
        raise ConvergenceError(
            f"no periodic orbit found at omega = {omega:.6g} rad/s, capacity {preloaded.capacity:g} N", time_s=None,
            iterations=40, residual_history=[], advice="reduce two_dof.smoothing",
        )  # fmt: skip
    smoother = replace(preloaded, smoothing=0.5 * preloaded.smoothing)
    return periodic_orbit(preloaded, omega, periodic_orbit(smoother, omega, tolerance=tolerance), tolerance=tolerance)


def _newton(preloaded: PreloadedTwoMasses, omega: float, x: FloatArray, tolerance: float) -> FloatArray | None:
    """Initial state of the periodic orbit, from damped Newton iterations; None if they do not converge."""
    half, size, step, p = (0.0, np.pi / omega), np.inf, np.zeros(4), parameters(preloaded)
    for _ in range(40):
        start = np.concatenate([x, np.eye(4).ravel()])
        end = solve_ivp(
            _with_derivative, half, start, method="LSODA", args=(omega, p), rtol=tolerance,
            atol=tolerance * preloaded.base_amplitude,
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
    preloaded: PreloadedTwoMasses, omega: float, state: FloatArray, *, points: int = 1001, tolerance: float = 1e-11
) -> float:
    """Transmissibility of a periodic orbit: largest abs(x1) divided by Y_0.

    Parameters
    ----------
    preloaded
        Parameters of the model.
    omega
        Frequency of the base motion, rad/s.
    state
        (4,) state at t = 0, as returned by `periodic_orbit`.
    points
        Number of samples per half period; the maximum is refined by the parabola that x, v and a define.
    tolerance
        Relative tolerance of LSODA.
    """
    times = np.linspace(0.0, np.pi / omega, points)
    path = in_time.integrate(preloaded, omega, state, times, tolerance)
    return in_time.peak_of_path(preloaded, omega, times, path)


def orbit_curve(preloaded: PreloadedTwoMasses, omegas: FloatArray) -> FloatArray:
    """(n,) transmissibility at increasing frequencies (n,), rad/s; each orbit is the initial guess of the next."""
    state, found = None, []
    for omega in omegas:
        state = periodic_orbit(preloaded, float(omega), state)
        found.append(orbit_transmissibility(preloaded, float(omega), state))
    return np.array(found)


def off_neighbours(omegas: FloatArray, values: FloatArray) -> FloatArray:
    """(n - 2,) relative distance of each inner point of a curve from the straight line between its neighbours."""
    share = (omegas[1:-1] - omegas[:-2]) / (omegas[2:] - omegas[:-2])
    line = values[:-2] + share * (values[2:] - values[:-2])
    return np.asarray(np.abs(values[1:-1] - line) / np.abs(values[1:-1]))


def adapted_curve(
    preloaded: PreloadedTwoMasses, omegas: FloatArray, *, bound: float = 0.005, finest: float = 2e-6
) -> tuple[FloatArray, FloatArray]:
    """Transmissibility curve on a frequency grid that is bisected where the curve bends.

    Parameters
    ----------
    preloaded
        Parameters of the model.
    omegas
        (n,) initial frequencies, rad/s.
    bound
        Largest relative distance of a point from the straight line between its neighbours.
    finest
        Intervals shorter than this are not bisected, rad/s.

    Returns
    -------
    omega : (m,) frequencies, rad/s, ascending.
    transmissibility : (m,)

    Raises
    ------
    ConvergenceError
        If an orbit is not found.
    """
    states: dict[float, FloatArray] = {}
    values: dict[float, float] = {}
    todo = [float(omega) for omega in omegas]
    while todo:
        for omega in todo:
            near = min(states, key=lambda known: abs(known - omega), default=None)
            states[omega] = periodic_orbit(preloaded, omega, None if near is None else states[near])
            values[omega] = orbit_transmissibility(preloaded, omega, states[omega])
        grid = np.array(sorted(values))
        bad = np.flatnonzero(off_neighbours(grid, np.array([values[w] for w in grid])) > bound) + 1
        ends = {(i, i + 1) for b in bad for i in (b - 1, b)}
        todo = sorted(float(0.5 * (grid[i] + grid[j])) for i, j in ends if grid[j] - grid[i] > finest)
    return grid, np.array([values[w] for w in grid])
