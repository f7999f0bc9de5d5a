r"""Coulomb friction smoothed over the slip rate by the logistic function; no elastic slip, no memory.

.. math:: \tau = \mu p\, S\!\left(\frac{V}{V_0}\right) \frac{\Delta g_t}{|\Delta g_t|}, \qquad
          S(x) = \frac{2}{1 + e^{-x}} - 1 = \tanh\frac{x}{2}, \qquad V = \frac{|\Delta g_t|}{\Delta t}

Below the reference speed V_0 the point is a viscous damper (slope 1/2 of S at zero); at rest it holds nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from wroll_fem.errors import InputError

KIND = 2

REFERENCE_TIME = 1e-3
"""Seconds that turn the reference speed into the length Newton's tolerance is measured by; no result depends on it."""


@dataclass(frozen=True)
class SmoothedCoulomb:
    """Coulomb friction whose sign is the logistic function of slip rate over a reference speed.

    Attributes
    ----------
    mu
        Coefficient of friction, reached at slip rates well above the reference speed.
    reference_speed
        V_0 in m/s: S = 0.46 at V_0, 0.987 at 5 V_0.
    """

    mu: float
    reference_speed: float

    def __post_init__(self) -> None:
        if not self.mu >= 0:
            raise InputError(
                f"coefficient of friction {self.mu} is negative", key="contact.friction.mu", remedy="give 0 or more"
            )
        if not self.reference_speed > 0:
            raise InputError(
                f"reference speed {self.reference_speed} m/s is not positive",
                key="contact.friction.reference_speed",
                remedy="give a slip rate in m/s, well below those of the motion",
            )

    @property
    def elastic_slip(self) -> float:
        """Length in m that normalises the traction, tau = (mu p / elastic_slip) e; nothing is elastic here."""
        return self.reference_speed * REFERENCE_TIME


@numba.njit(cache=True, inline="always")
def logistic_sign(x: float) -> float:
    """S(x) = 2 / (1 + exp(-x)) - 1, the smoothed sign, written so that it neither overflows nor cancels."""
    return np.tanh(0.5 * x)


@numba.njit(cache=True, inline="always")
def slip_update(dg_h: float, dg_z: float, gamma: float, speed: float, dt: float) -> tuple[float, float, bool]:
    """Normalised traction (m) against the increment, and whether the point moves faster than the reference speed."""
    size = np.sqrt(dg_h * dg_h + dg_z * dg_z)
    reach = speed * dt
    if size == 0.0:
        return 0.0, 0.0, False
    c = gamma * logistic_sign(size / reach) / size
    return c * dg_h, c * dg_z, size > reach


@numba.njit(cache=True, inline="always")
def slip_derivatives(
    dg_h: float, dg_z: float, gamma: float, speed: float, dt: float
) -> tuple[float, float, float, float]:
    """Derivatives (00, 01, 10, 11) with respect to the increment."""
    size = np.sqrt(dg_h * dg_h + dg_z * dg_z)
    reach = speed * dt
    if size == 0.0:
        c = 0.5 * gamma / reach
        return c, 0.0, 0.0, c
    s = logistic_sign(size / reach)
    along = 0.5 * gamma * (1.0 - s * s) / reach
    across = gamma * s / size
    nh, nz = dg_h / size, dg_z / size
    d = along - across
    return across + d * nh * nh, d * nh * nz, d * nh * nz, across + d * nz * nz
