r"""Coulomb friction with elastic slip before sliding (penalty method; a Jenkins element in two directions).

.. math:: e = \operatorname{clip}(e_c + \Delta g_t), \quad |e| \le \gamma^*, \qquad \tau = \frac{\mu p}{\gamma^*} e
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from wroll_fem.contact.law import FrictionLaw, Parameter
from wroll_fem.errors import InputError


@dataclass(frozen=True)
class PenaltyCoulomb(FrictionLaw):
    """Coulomb friction with elastic slip before sliding.

    The traction is ``tau = (mu p / elastic_slip) e``. The elastic slip ``e`` is projected onto the disc
    ``|e| <= elastic_slip``. The friction limit and the stick stiffness are proportional to the current pressure ``p``.

    Attributes
    ----------
    mu
        Coefficient of friction.
    elastic_slip
        Largest elastic relative displacement, gamma* in m.
    """

    name: ClassVar[str] = "penalty_coulomb"
    sentence: ClassVar[str] = "Coulomb friction with an elastic slip before sliding"
    mu: Annotated[float, Parameter("coefficient of friction, dimensionless", least=0.0)]
    elastic_slip: Annotated[
        float,
        Parameter(
            "allowable elastic slip gamma*, m: relative displacement at which sliding starts",
            above=0,
        ),
    ]

    def __post_init__(self) -> None:
        check_stick(self.mu, self.elastic_slip)


def check_stick(mu: float, elastic_slip: float) -> None:
    """Refuse a negative coefficient of friction and an elastic slip that is not positive.

    Raises
    ------
    InputError
        If one of the two is out of range; the error names the key of the case file.
    """
    if not mu >= 0:
        raise InputError(
            f"coefficient of friction {mu} is negative", key="contact.friction.mu", remedy="give 0 or more"
        )
    if not elastic_slip > 0:
        raise InputError(
            f"elastic slip {elastic_slip} m is not positive",
            key="contact.friction.elastic_slip",
            remedy="give a length in m, for example 1e-6",
        )


def slip_update(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, bool]:
    """Elastic slip (m), limited to the disc of radius gamma*, and whether the point slides."""
    return clip(trial_h, trial_z, laws.gamma[k])


def slip_derivatives(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Derivatives of the elastic slip: with respect to the trial slip, then with respect to the increment (zero).

    Each derivative is a 2 x 2 matrix, given by its entries 00, 01, 10, 11 (0: hoop, 1: axial).
    """
    a00, a01, a10, a11 = clip_derivatives(trial_h, trial_z, laws.gamma[k])
    return a00, a01, a10, a11, 0.0, 0.0, 0.0, 0.0


def clip(trial_h: float, trial_z: float, radius: float) -> tuple[float, float, bool]:
    """Trial elastic slip (m) projected onto the disc of ``radius`` (m), and whether it was outside."""
    length = math.sqrt(trial_h * trial_h + trial_z * trial_z)
    if length > radius:
        scale = radius / length
        return trial_h * scale, trial_z * scale, True
    return trial_h, trial_z, False


def clip_derivatives(trial_h: float, trial_z: float, radius: float) -> tuple[float, float, float, float]:
    """Derivative of the projected slip with respect to the trial slip.

    It is a 2 x 2 matrix, given by its entries 00, 01, 10, 11 (0: hoop, 1: axial).
    """
    length = math.sqrt(trial_h * trial_h + trial_z * trial_z)
    if length > radius:
        mh, mz = trial_h / length, trial_z / length
        c = radius / length
        return c * (1.0 - mh * mh), -c * mh * mz, -c * mh * mz, c * (1.0 - mz * mz)
    return 1.0, 0.0, 0.0, 1.0
