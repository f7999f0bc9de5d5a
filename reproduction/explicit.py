"""Explicit Runge-Kutta runs from rest over six time constants, as in the thesis.

They show the effect of loose tolerances on the curves of the model (appendix C). For other purposes use
`wroll_fem.two_dof.time` and `wroll_fem.two_dof.periodic`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.two_dof import time as in_time
from wroll_fem.two_dof.model import PreloadedTwoMasses
from wroll_fem.two_dof.time import parameters, rates_into
from wroll_fem.typing import FloatArray

drop_stale_cache(__file__, in_time.__file__)

ZETA = 0.002
"""Damping ratio in the estimate of the time constant in the thesis (equation 5.5)."""

# Dormand and Prince (1980), J. Comput. Appl. Math. 6, 19-26
_C = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
_A = np.zeros((7, 6))
_A[1, :1] = 1 / 5
_A[2, :2] = 3 / 40, 9 / 40
_A[3, :3] = 44 / 45, -56 / 15, 32 / 9
_A[4, :4] = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
_A[5, :5] = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
_A[6] = 35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
_E = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])


@dataclass(frozen=True)
class ExplicitRun:
    """Result of a run from rest.

    Attributes
    ----------
    transmissibility : largest abs(x_1) over Y_0 in the last periods
    steps : number of accepted steps
    """

    transmissibility: float
    steps: int


@numba.njit(cache=True)
def _run(
    omega: float,
    p: FloatArray,
    end: float,
    start: float,
    rtol: float,
    atol: float,
    c: FloatArray,
    a: FloatArray,
    e: FloatArray,
) -> tuple[float, int]:
    """Largest abs(x1) between ``start`` and ``end`` (s) of a run from rest, and the number of steps."""
    threshold = atol / rtol
    y, k, new, stage = np.zeros(4), np.zeros((7, 4)), np.zeros(4), np.zeros(4)
    t, peak, steps = 0.0, 0.0, 0
    rates_into(y, t, omega, p, k[0])
    h = min(0.1 * end, 0.8 * rtol**0.2 / max(1e-300, np.max(np.abs(k[0])) / threshold))
    while t < end:
        h = min(h, end - t)
        failed = False
        while True:
            for i in range(1, 7):
                stage[:] = y
                for j in range(i):
                    stage += h * a[i, j] * k[j]
                rates_into(stage, t + c[i] * h, omega, p, k[i])
            new[:] = stage
            err = 0.0
            for q in range(4):
                d = 0.0
                for i in range(7):
                    d += e[i] * k[i, q]
                err = max(err, abs(h * d) / max(max(abs(y[q]), abs(new[q])), threshold))
            if err <= rtol:
                break
            h *= 0.5 if failed else max(0.1, 0.8 * (rtol / err) ** 0.2)
            failed = True
        if t + h >= start:
            for i in range(1, 5):
                u = 0.25 * i
                x = (1 + 2 * u) * (1 - u) ** 2 * y[0] + u * u * (3 - 2 * u) * new[0]
                x += h * (u * (1 - u) ** 2 * y[2] - u * u * (1 - u) * new[2])
                peak = max(peak, abs(x))
        t += h
        steps += 1
        y[:] = new
        k[0] = k[6]
        if not failed:
            ratio = 1.25 * (err / rtol) ** 0.2
            h = h / ratio if ratio > 0.2 else 5.0 * h
    return peak, steps


def run_from_rest(
    preloaded: PreloadedTwoMasses, omega: float, *, rtol: float, atol: float, periods: int = 20
) -> ExplicitRun:
    """Run for 6/(0.002 omega) s from rest under y = Y_0 sin(omega t), evaluated over the last ``periods``.

    Parameters
    ----------
    rtol, atol
        Relative and absolute (m or m/s) error allowed per step, for the largest component relative to
        max(abs(y), atol/rtol).

    Notes
    -----
    Dormand-Prince pair with the usual step control (factor 0.8 (rtol/err)^(1/5) between 0.1 and 5) and four output
    points per step, like ode45 of MATLAB. Where friction sticks, the stability limit due to the creep rate F_c s/2
    determines the step.
    """
    end = 6.0 / (ZETA * omega)
    start = end - periods * 2.0 * np.pi / omega
    peak, steps = _run(omega, parameters(preloaded), end, start, rtol, atol, _C, _A, _E)
    return ExplicitRun(peak / preloaded.base_amplitude, steps)
