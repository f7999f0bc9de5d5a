r"""Coulomb friction whose coefficient depends on the slip rate, given as a table.

.. math:: e = \operatorname{clip}(e_c + \Delta g_t), \quad |e| \le \gamma^* \frac{\mu(V)}{\mu(0)}, \qquad
          V = \frac{|\Delta g_t|}{\Delta t}, \qquad \tau = \frac{\mu(0)\, p}{\gamma^*} e

The coefficient is linear between the rates of the table and constant beyond the last one. The stick stiffness keeps its
value at rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Self

from wroll_fem.contact.law import FrictionLaw, Parameter
from wroll_fem.contact.penalty_coulomb import check_stick, clip, clip_derivatives
from wroll_fem.contact.rate_table import table_problem, weakening_slope
from wroll_fem.errors import InputError

RATES, COEFFICIENTS = 0, 1
"""Second index of `PointLaws.tables`: slip rates, m/s, and the coefficient of friction at each slip rate."""


@dataclass(frozen=True)
class RateCoulomb(FrictionLaw):
    """Coulomb friction with elastic slip before sliding; the coefficient is tabulated versus the slip rate.

    Attributes
    ----------
    mu
        Coefficient of friction at rest; equal to the first coefficient of the table.
    elastic_slip
        Largest elastic relative displacement at rest, gamma* in m.
    rates
        Slip rates of the table in m/s, rising from 0.
    coefficients
        Coefficient of friction at each slip rate.
    """

    name: ClassVar[str] = "rate_coulomb"
    sentence: ClassVar[str] = "as penalty_coulomb with a coefficient that depends on the slip rate"
    mu: Annotated[float, Parameter("coefficient of friction at rest, dimensionless", least=0.0)]
    elastic_slip: Annotated[float, Parameter("allowable elastic slip at rest, m", above=0.0)]
    rates: Annotated[tuple[float, ...], Parameter("slip rates, m/s, rising from 0")]
    coefficients: Annotated[tuple[float, ...], Parameter("coefficient of friction at each slip rate, dimensionless")]

    def __post_init__(self) -> None:
        for name in ("rates", "coefficients"):  # any sequence will do
            object.__setattr__(self, name, tuple(float(value) for value in getattr(self, name)))
        check_stick(self.mu, self.elastic_slip)
        wrong = table_problem(self.rates, self.coefficients)
        if wrong:
            raise InputError(f"{wrong.column} {wrong.problem}", key="contact.friction.rate_table", remedy=wrong.remedy)
        if self.mu != self.coefficients[0]:
            raise InputError(
                f"coefficient of friction at rest {self.mu} differs from the first coefficient of the table, "
                f"{self.coefficients[0]}",
                key="contact.friction.mu",
                remedy="give the same value in both places",
            )

    @property
    def weakening_slope(self) -> float:
        """Velocity-weakening slope: largest -d mu / dV of the table, s/m; 0 if mu never decreases."""
        return weakening_slope(self.rates, self.coefficients)

    def in_series(self, count: float) -> Self:
        """See `FrictionLaw`."""
        rates = tuple(count * rate for rate in self.rates)
        return replace(self, elastic_slip=count * self.elastic_slip, rates=rates)

    @classmethod
    def from_section(cls, section: Any) -> Self:
        """Law from a case section whose table has the columns slip_rate and mu."""
        table = section.rate_table
        return cls(section.mu, section.elastic_slip, tuple(table.slip_rate), tuple(table.mu))


def coefficient(speed: float, row: int, tables: Any) -> tuple[float, float]:
    """Coefficient of friction of table ``row`` at the slip rate ``speed`` (m/s), and its slope (s/m).

    At a slip rate of the table the slope is the one towards higher slip rates. ``tables`` (n_tables, 2, L) is as in
    `PointLaws`.
    """
    last = tables.shape[2] - 1
    for i in range(last):
        if speed < tables[row, RATES, i + 1]:
            rise = tables[row, COEFFICIENTS, i + 1] - tables[row, COEFFICIENTS, i]
            slope = rise / (tables[row, RATES, i + 1] - tables[row, RATES, i])
            return tables[row, COEFFICIENTS, i] + slope * (speed - tables[row, RATES, i]), slope
    return tables[row, COEFFICIENTS, last], 0.0


def slip_update(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, bool]:
    """Elastic slip (m), limited to the disc of radius gamma* mu(V) / mu(0), and whether the point slides."""
    gamma, row = laws.gamma[k], laws.table[k]
    mu, _ = coefficient(math.sqrt(dg_h * dg_h + dg_z * dg_z) / dt, row, laws.tables)
    at_rest = laws.tables[row, COEFFICIENTS, 0]
    radius = gamma * mu / at_rest if at_rest > 0.0 else gamma
    return clip(trial_h, trial_z, radius)


def slip_derivatives(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Derivatives of the elastic slip: with respect to the trial slip, then with respect to the increment.

    Each derivative is a 2 x 2 matrix, given by its entries 00, 01, 10, 11 (0: hoop, 1: axial).
    """
    gamma, row = laws.gamma[k], laws.table[k]
    size = math.sqrt(dg_h * dg_h + dg_z * dg_z)
    mu, slope = coefficient(size / dt, row, laws.tables)
    at_rest = laws.tables[row, COEFFICIENTS, 0]
    radius = gamma * mu / at_rest if at_rest > 0.0 else gamma
    a00, a01, a10, a11 = clip_derivatives(trial_h, trial_z, radius)
    length = math.sqrt(trial_h * trial_h + trial_z * trial_z)
    if length <= radius or size == 0.0 or at_rest == 0.0 or slope == 0.0:
        return a00, a01, a10, a11, 0.0, 0.0, 0.0, 0.0
    c = gamma * slope / (at_rest * dt) / (length * size)
    return (
        a00, a01, a10, a11,
        c * trial_h * dg_h, c * trial_h * dg_z, c * trial_z * dg_h, c * trial_z * dg_z,
    )  # fmt: skip
