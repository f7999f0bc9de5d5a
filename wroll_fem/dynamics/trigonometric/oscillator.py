"""One oscillator with friction elements in trigonometric steps, for the estimate of their error."""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.dynamics.trigonometric.propagation import OUTPUTS, propagation
from wroll_fem.typing import FloatArray


def trigonometric_response(
    turn: float, zeta: float, share: float, limits: FloatArray, dt: float, base: FloatArray, finer: int = 1
) -> FloatArray:
    """(n + 1,) relative displacement, m, from rest in n steps of ``dt`` (s).

    Parameters
    ----------
    turn, zeta
        Natural frequency with all friction elements stuck, rad/s, and viscous damping ratio.
    share, limits
        Share of the stiffness that the friction elements provide, and the displacements at which they slide, m.
    base
        (n finer + 1,) base acceleration, m/s^2, linear between ``finer`` + 1 samples per step.
    """
    whole, part = (
        propagation(np.array([turn**2]), [np.array([2.0 * zeta * turn])], np.zeros(1), h).state.reshape(OUTPUTS, 4)[:2]
        for h in (dt, dt / finer)
    )
    out = np.zeros((len(base) - 1) // finer + 1)
    _integrate(base, finer, whole, part, share * turn**2 / max(len(limits), 1), limits, out)
    return out


@numba.njit(cache=True)
def _integrate(base, finer, whole, part, stiffness, limits, out):
    """Fill ``out`` (n + 1,); rows of ``whole`` and ``part`` give u and v from u, v and the forces at both ends."""
    count = limits.shape[0]
    elastic, trial = np.zeros(count), np.zeros(count)
    u, v, force = 0.0, 0.0, 0.0
    for n in range(1, out.shape[0]):
        free, rate = u, v
        for k in range((n - 1) * finer, n * finer):  # exact for the base motion, with the sticking elements
            old = free
            free = part[0, 0] * old + part[0, 1] * rate - part[0, 2] * base[k] - part[0, 3] * base[k + 1]
            rate = part[1, 0] * old + part[1, 1] * rate - part[1, 2] * base[k] - part[1, 3] * base[k + 1]
        free += whole[0, 2] * force
        rate += whole[1, 2] * force
        x, new = free + whole[0, 3] * force, force
        for _ in range(30):
            new, slope = 0.0, 0.0  # correction of the sliding elements, and its derivative
            for j in range(count):
                moved = elastic[j] + x - u
                trial[j] = min(max(moved, -limits[j]), limits[j])
                new += stiffness * (x - trial[j])
                slope += stiffness if trial[j] == moved else 0.0
            gap = x - free - whole[0, 3] * new
            change = gap / (1.0 - whole[0, 3] * (stiffness * count - slope))
            if abs(change) <= 1e-13 * abs(x):
                break
            x -= change
        elastic[:] = trial
        v, u, force = rate + whole[1, 3] * new, x, new
        out[n] = u
