r"""Nonlinear spring without loss: the traction is a polynomial of the relative displacement from the reference state.

.. math:: \tau = p \sum_i c_i \left(\frac{g}{L}\right)^i, \qquad i = 1, 2, \ldots

in each tangential direction by itself. It is meant for the joints of a structure from matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from wroll_fem.contact.law import FrictionLaw, Parameter
from wroll_fem.errors import InputError


@dataclass(frozen=True)
class PolynomialSpring(FrictionLaw):
    """Nonlinear spring without loss: a polynomial of the relative displacement.

    Attributes
    ----------
    elastic_slip
        Length L in m that divides the displacement; Newton's tolerance refers to it.
    coefficients
        Coefficients c_1, c_2, ..., dimensionless.
    """

    name: ClassVar[str] = "polynomial_spring"
    sentence: ClassVar[str] = "nonlinear spring without loss: a polynomial of the relative displacement"
    sticks: ClassVar[bool] = False
    elastic: ClassVar[bool] = True
    in_rolls: ClassVar[bool] = False
    elastic_slip: Annotated[float, Parameter("length L, m, that divides the displacement", above=0.0)]
    coefficients: Annotated[tuple[float, ...], Parameter("coefficients of the powers 1, 2, ..., dimensionless")]

    def __post_init__(self) -> None:
        given = tuple(float(value) for value in self.coefficients)
        # a table repeats its last number (`PointLaws`), which therefore has to be zero
        object.__setattr__(self, "coefficients", given if given[-1:] == (0.0,) else (*given, 0.0))
        if not self.elastic_slip > 0.0:
            raise InputError(f"length {self.elastic_slip} m is not positive", remedy="give a length in m")
        if not any(self.coefficients):
            raise InputError(
                "all coefficients of a polynomial spring are zero", remedy="give those of the powers 1, 2, ..."
            )

    @property
    def mu(self) -> float:  # type: ignore[override]
        """One: the force of the spring is the pressure times the polynomial."""
        return 1.0

    def rest_length(self, dt: float) -> float:
        """Infinite: the linear part of a spring belongs to the stiffness matrix, the rest has no stiffness at rest."""
        return float("inf")


def polynomial(x: float, row: int, tables: Any) -> tuple[float, float]:
    """Value and slope at ``x`` of the polynomial whose coefficients are in table ``row``."""
    factor, change = 0.0, 0.0
    for i in range(tables.shape[2] - 1, -1, -1):
        change = change * x + factor
        factor = factor * x + tables[row, 0, i]
    return x * factor, factor + x * change


def slip_update(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, bool]:
    """Traction divided by p / L, in m; the trial slip is the displacement from the reference state. It never slides."""
    length, row = laws.gamma[k], laws.table[k]
    value_h, _ = polynomial(trial_h / length, row, laws.tables)
    value_z, _ = polynomial(trial_z / length, row, laws.tables)
    return length * value_h, length * value_z, False


def slip_derivatives(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Derivatives of the traction divided by p / L: with respect to the displacement, then to the increment (zero)."""
    length, row = laws.gamma[k], laws.table[k]
    _, slope_h = polynomial(trial_h / length, row, laws.tables)
    _, slope_z = polynomial(trial_z / length, row, laws.tables)
    return slope_h, 0.0, 0.0, slope_z, 0.0, 0.0, 0.0, 0.0
