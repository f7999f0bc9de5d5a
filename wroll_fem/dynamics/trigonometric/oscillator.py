"""One oscillator with friction elements in trigonometric steps, for the estimate of their error."""

from __future__ import annotations

import numba
import numpy as np

from wroll_fem.dynamics.trigonometric import slip_path
from wroll_fem.dynamics.trigonometric.propagation import OUTPUTS, propagation
from wroll_fem.dynamics.trigonometric.slip_path import NEAR, overshoot
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray

drop_stale_cache(__file__, slip_path.__file__)


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
        propagation(np.array([turn**2]), [np.array([2.0 * zeta * turn])], np.zeros(1), h) for h in (dt, dt / finer)
    )
    steps, finest = (found.state.reshape(OUTPUTS, 4)[:2].copy() for found in (whole, part))
    if part.resolved[0]:
        finest[:, 2:] /= part.gain[0]  # the base motion is not filtered
    out = np.zeros((len(base) - 1) // finer + 1)
    stiffness = share * turn**2 / max(len(limits), 1)
    _integrate(base, finer, steps, finest, float(whole.shift[0]), stiffness, limits, out)
    return out


@numba.njit(cache=True)
def _integrate(base, finer, whole, part, shift, stiffness, limits, out):
    """Fill ``out`` (n + 1,); rows of ``whole`` and ``part`` give d and v from d, v and the forces at both ends.

    The displacement is d + ``shift`` times the force (docs/trigonometric.md).
    """
    count = limits.shape[0]
    elastic, start, trial = np.zeros(count), np.zeros(count), np.zeros(count)
    d, v, u, before, force = 0.0, 0.0, 0.0, 0.0, 0.0
    answer = whole[0, 3] + shift
    for n in range(1, out.shape[0]):
        free, rate = d, v
        for k in range((n - 1) * finer, n * finer):  # exact for the base motion, with the sticking elements
            old = free
            free = part[0, 0] * old + part[0, 1] * rate - part[0, 2] * base[k] - part[0, 3] * base[k + 1]
            rate = part[1, 0] * old + part[1, 1] * rate - part[1, 2] * base[k] - part[1, 3] * base[k + 1]
        free += whole[0, 2] * force
        rate += whole[1, 2] * force
        x, new = free + answer * force, force
        for j in range(count):  # elements that turn back
            sign = 1.0 if elastic[j] > 0.0 else -1.0
            past, ahead = (u - before) * sign, (x - u) * sign
            start[j] = elastic[j]
            if past > 0.0 and ahead < 0.0 and sign * elastic[j] > NEAR * limits[j]:
                start[j] -= sign * max(sign * elastic[j] + overshoot(past, ahead) - limits[j], 0.0)
        for _ in range(30):
            new, slope = 0.0, 0.0  # correction of the sliding elements, and its derivative
            for j in range(count):
                moved = start[j] + x - u
                trial[j] = min(max(moved, -limits[j]), limits[j])
                new += stiffness * (x - trial[j])
                slope += stiffness if trial[j] == moved else 0.0
            gap = x - free - answer * new
            change = gap / (1.0 - answer * (stiffness * count - slope))
            if abs(change) <= 1e-13 * abs(x):
                break
            x -= change
        elastic[:] = trial
        before, u, force = u, x, new
        d, v = free + whole[0, 3] * new, rate + whole[1, 3] * new
        out[n] = u
