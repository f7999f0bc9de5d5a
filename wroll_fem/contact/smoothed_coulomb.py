r"""Regularised Coulomb friction: a logistic function replaces the sign of the slip rate; no elastic slip, no memory.

.. math:: \tau = \mu p\, S\!\left(\frac{V}{V_0}\right) \frac{\Delta g_t}{|\Delta g_t|}, \qquad
          S(x) = \frac{2}{1 + e^{-x}} - 1 = \tanh\frac{x}{2}, \qquad V = \frac{|\Delta g_t|}{\Delta t}

Below the reference speed V_0 friction acts as a viscous damper (the slope of S at zero is 1/2). At rest it transmits no
tangential traction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Self

from wroll_fem.contact.law import FrictionLaw, Parameter
from wroll_fem.errors import InputError

REFERENCE_TIME = 1e-3
"""Time, s, that converts the reference speed to a length for Newton's tolerance; results do not depend on it."""

REFERENCE_SPEED = 0
"""Column of `PointLaws.own` that contains the reference speed."""


@dataclass(frozen=True)
class SmoothedCoulomb(FrictionLaw):
    """Regularised Coulomb friction: mu p times a logistic function of the slip rate divided by a reference speed.

    Attributes
    ----------
    mu
        Coefficient of friction, reached at slip rates well above the reference speed.
    reference_speed
        V_0 in m/s: S = 0.46 at V_0, 0.987 at 5 V_0.
    """

    name: ClassVar[str] = "smoothed_coulomb"
    sentence: ClassVar[str] = "mu p S(slip rate / reference_speed), S(x) = 2/(1 + exp(-x)) - 1; no elastic slip"
    stores_slip: ClassVar[bool] = False
    sticks: ClassVar[bool] = False
    mu: Annotated[float, Parameter("coefficient of friction well above reference_speed, dimensionless", least=0.0)]
    reference_speed: Annotated[
        float,
        Parameter("slip rate, m/s, below which friction acts as a viscous damper; S is 0.46 there", above=0.0),
    ]

    def __post_init__(self) -> None:
        if not self.mu >= 0:
            raise InputError(
                f"coefficient of friction {self.mu} is negative", key="contact.friction.mu", remedy="give 0 or more"
            )
        if not self.reference_speed > 0:
            raise InputError(
                f"reference speed {self.reference_speed} m/s is not positive",
                key="contact.friction.reference_speed",
                remedy="give a slip rate in m/s, well below the slip rates of the motion",
            )

    @property
    def elastic_slip(self) -> float:  # type: ignore[override]
        """Reference length, m, of the normalised traction e in tau = (mu p / elastic_slip) e.

        The law has no elastic slip: the length scales e and has no other effect.
        """
        return self.reference_speed * REFERENCE_TIME

    def rest_length(self, dt: float) -> float:
        """Length L = 2 V_0 dt, m: in a step ``dt`` (s) the dashpot mu p / (2 V_0) has the stiffness mu p / L."""
        return 2.0 * self.reference_speed * dt

    def in_series(self, count: float) -> Self:
        """See `FrictionLaw`."""
        return replace(self, reference_speed=count * self.reference_speed)


def regularised_sign(x: float) -> float:
    """Regularised sign S(x) = 2 / (1 + exp(-x)) - 1, computed without overflow or cancellation."""
    return math.tanh(0.5 * x)


def regularised_sign_slope(s: float) -> float:
    """Derivative dS/dx at the point x with S(x) = ``s``."""
    return 0.5 * (1.0 - s * s)


def slip_update(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, bool]:
    """Traction divided by mu p / elastic_slip, e (m), and whether the slip rate exceeds the reference speed."""
    size = math.sqrt(dg_h * dg_h + dg_z * dg_z)
    reach = laws.own[k, REFERENCE_SPEED] * dt
    if size == 0.0:
        return 0.0, 0.0, False
    c = laws.gamma[k] * regularised_sign(size / reach) / size
    return c * dg_h, c * dg_z, size > reach


def slip_derivatives(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Derivatives of e (see `slip_update`): with respect to the trial slip (zero), then to the increment.

    Each derivative is a 2 x 2 matrix, given by its entries 00, 01, 10, 11 (0: hoop, 1: axial).
    """
    gamma = laws.gamma[k]
    size = math.sqrt(dg_h * dg_h + dg_z * dg_z)
    reach = laws.own[k, REFERENCE_SPEED] * dt
    if size == 0.0:
        c = regularised_sign_slope(0.0) * gamma / reach
        return 0.0, 0.0, 0.0, 0.0, c, 0.0, 0.0, c
    s = regularised_sign(size / reach)
    along = gamma * regularised_sign_slope(s) / reach
    across = gamma * s / size
    nh, nz = dg_h / size, dg_z / size
    d = along - across
    return 0.0, 0.0, 0.0, 0.0, across + d * nh * nh, d * nh * nz, d * nh * nz, across + d * nz * nz
