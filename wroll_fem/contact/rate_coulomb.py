r"""Coulomb friction whose coefficient depends on the slip rate, given as a table.

.. math:: e = \operatorname{clip}(e_c + \Delta g_t), \quad |e| \le \gamma^* \frac{\mu(V)}{\mu(0)}, \qquad
          V = \frac{|\Delta g_t|}{\Delta t}, \qquad \tau = \frac{\mu(0)\, p}{\gamma^*} e

Linear between the table's rates, constant beyond its last one. The stick stiffness stays that at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from wroll_fem.contact import penalty_coulomb
from wroll_fem.contact.penalty_coulomb import check_stick
from wroll_fem.contact.rate_table import steepest_fall, table_problem
from wroll_fem.errors import InputError

KIND = 1


@dataclass(frozen=True)
class RateCoulomb:
    """Coulomb friction with a tabulated coefficient over slip rate and an elastic slip branch.

    Attributes
    ----------
    mu
        Coefficient at rest; equals the table's first.
    elastic_slip
        Largest elastic relative displacement at rest, gamma* in m.
    rates
        Slip rates of the table in m/s, from 0, rising.
    coefficients
        Coefficient at each.
    """

    mu: float
    elastic_slip: float
    rates: tuple[float, ...]
    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("rates", "coefficients"):  # any sequence will do
            object.__setattr__(self, name, tuple(float(value) for value in getattr(self, name)))
        check_stick(self.mu, self.elastic_slip)
        wrong = table_problem(self.rates, self.coefficients)
        if wrong:
            raise InputError(f"{wrong.column} {wrong.problem}", key="contact.friction.rate_table", remedy=wrong.remedy)
        if self.mu != self.coefficients[0]:
            raise InputError(
                f"coefficient at rest {self.mu} is not the table's first, {self.coefficients[0]}",
                key="contact.friction.mu",
                remedy="give the same",
            )

    @property
    def steepest_fall(self) -> float:
        """Largest -d mu / dV of the table, s/m; 0 when it never falls."""
        return steepest_fall(self.rates, self.coefficients)


@numba.njit(cache=True, inline="always")
def coefficient(speed: float, row: int, rates: np.ndarray, coefficients: np.ndarray) -> tuple[float, float]:
    """Coefficient of table ``row`` at ``speed`` (m/s) and its slope (s/m); at a corner that of the segment above."""
    last = rates.shape[1] - 1
    for i in range(last):
        if speed < rates[row, i + 1]:
            rise = coefficients[row, i + 1] - coefficients[row, i]
            slope = rise / (rates[row, i + 1] - rates[row, i])
            return coefficients[row, i] + slope * (speed - rates[row, i]), slope
    return coefficients[row, last], 0.0


@numba.njit(cache=True, inline="always")
def slip_update(
    trial_h: float,
    trial_z: float,
    dg_h: float,
    dg_z: float,
    gamma: float,
    row: int,
    rates: np.ndarray,
    coefficients: np.ndarray,
    dt: float,
) -> tuple[float, float, bool]:
    """Elastic slip (m) clipped to the disc of the current coefficient, and whether the point slides."""
    speed = np.sqrt(dg_h * dg_h + dg_z * dg_z) / dt
    mu, _ = coefficient(speed, row, rates, coefficients)
    at_rest = coefficients[row, 0]
    radius = gamma * mu / at_rest if at_rest > 0.0 else gamma
    return penalty_coulomb.slip_update(trial_h, trial_z, radius)


@numba.njit(cache=True, inline="always")
def slip_derivatives(
    trial_h: float,
    trial_z: float,
    dg_h: float,
    dg_z: float,
    gamma: float,
    row: int,
    rates: np.ndarray,
    coefficients: np.ndarray,
    dt: float,
) -> tuple[float, float, float, float, float, float, float, float]:
    """Derivatives (00, 01, 10, 11) with respect to the trial slip, then with respect to the increment."""
    size = np.sqrt(dg_h * dg_h + dg_z * dg_z)
    mu, slope = coefficient(size / dt, row, rates, coefficients)
    at_rest = coefficients[row, 0]
    radius = gamma * mu / at_rest if at_rest > 0.0 else gamma
    a00, a01, a10, a11 = penalty_coulomb.slip_derivatives(trial_h, trial_z, radius)
    length = np.sqrt(trial_h * trial_h + trial_z * trial_z)
    if length <= radius or size == 0.0 or at_rest == 0.0 or slope == 0.0:
        return a00, a01, a10, a11, 0.0, 0.0, 0.0, 0.0
    c = gamma * slope / (at_rest * dt) / (length * size)
    return (
        a00, a01, a10, a11,
        c * trial_h * dg_h, c * trial_h * dg_z, c * trial_z * dg_h, c * trial_z * dg_z,
    )  # fmt: skip
