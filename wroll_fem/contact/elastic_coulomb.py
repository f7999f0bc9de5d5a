r"""Coulomb friction in series with a spring of constant stiffness, under any pressure.

.. math:: e = \operatorname{clip}(e_c + \Delta g_t), \quad |e| \le \mu p / k_t, \qquad \tau = k_t e

Where the pressure falls, the spring relaxes to the friction limit; where the surfaces part, it is without force. At
constant pressure this is the law of `penalty_coulomb`, whose stiffness is proportional to the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Self

from wroll_fem.contact.law import FrictionLaw, Parameter
from wroll_fem.contact.penalty_coulomb import check_stick, clip, clip_derivatives
from wroll_fem.errors import InputError


@dataclass(frozen=True)
class ElasticCoulomb(FrictionLaw):
    """Coulomb friction in series with a spring whose stiffness does not depend on the pressure.

    Attributes
    ----------
    mu
        Coefficient of friction.
    elastic_slip
        Typical elastic slip, m, to which tolerances refer: mu p / stick_stiffness at a typical pressure p.
    stick_stiffness
        Tangential stiffness k_t of the closed contact while it sticks, Pa/m.
    """

    name: ClassVar[str] = "elastic_coulomb"
    sentence: ClassVar[str] = "Coulomb friction in series with a spring of constant stiffness"
    in_rolls: ClassVar[bool] = False
    mu: Annotated[float, Parameter("coefficient of friction, dimensionless", least=0.0)]
    elastic_slip: Annotated[float, Parameter("typical elastic slip, m, to which tolerances refer", above=0)]
    stick_stiffness: Annotated[float, Parameter("tangential stiffness while the contact sticks, Pa/m", above=0)]

    def __post_init__(self) -> None:
        check_stick(self.mu, self.elastic_slip)
        if not self.stick_stiffness > 0:
            raise InputError(
                f"stick stiffness {self.stick_stiffness} Pa/m is not positive", key="stick_stiffness",
                remedy="give a positive stiffness",
            )  # fmt: skip

    @property
    def constant_stick(self) -> float:
        """See `FrictionLaw`."""
        return self.stick_stiffness

    def in_series(self, count: float) -> Self:
        """See `FrictionLaw`."""
        return replace(self, elastic_slip=count * self.elastic_slip, stick_stiffness=self.stick_stiffness / count)


def slip_update(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, bool]:
    """Elastic slip (m), limited to the disc of radius mu p / k_t, and whether the point slides."""
    return clip(trial_h, trial_z, laws.mu[k] * p / laws.stick[k])


def slip_derivatives(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Derivatives of the elastic slip: with respect to the trial slip, then with respect to the increment (zero)."""
    a00, a01, a10, a11 = clip_derivatives(trial_h, trial_z, laws.mu[k] * p / laws.stick[k])
    return a00, a01, a10, a11, 0.0, 0.0, 0.0, 0.0
