r"""Bouc-Wen hysteresis with a limit: the elastic slip approaches gamma* smoothly (Bouc 1967, Wen 1976).

.. math:: \frac{de}{d\lambda} = u - \left(\frac{|e|}{\gamma^*}\right)^{n}
          \frac{b\, |e \cdot u| + (1 - b)\, e \cdot u}{|e|^2}\, e, \qquad u = \frac{dg}{|dg|}, \quad d\lambda = |dg|

In one direction this is :math:`\dot z = \dot x - \beta |\dot x| |z|^{n-1} z - \gamma \dot x |z|^n` with
:math:`\beta = b / \gamma^{*n}` and :math:`\gamma = (1 - b) / \gamma^{*n}`. The law does not depend on the slip rate.
An increment is integrated by the classical Runge-Kutta method in substeps; its derivatives are central differences.

References
----------
Wen (1976), J. Eng. Mech. Div. ASCE 102, 249, doi:10.1061/JMCEA3.0002106.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from wroll_fem.contact.law import DIFFERENCE, FrictionLaw, Parameter
from wroll_fem.contact.penalty_coulomb import check_stick
from wroll_fem.errors import InputError

EXPONENT, UNLOADING = 0, 1
"""Columns of `PointLaws.own`."""

SUBSTEP, MOST_SUBSTEPS = 0.037, 1000
"""Length of a Runge-Kutta substep, relative to gamma* and to 1 / max(1, n / 2), and the largest number of them. Where
the number changes, the elastic slip jumps by the error of the method, 1e-9 gamma*."""

SECANTS = 4
"""Number of secant steps to the place where e . u changes its sign."""

SLIDES = 0.9
"""Elastic slip, relative to gamma*, above which a point counts as sliding."""


@dataclass(frozen=True)
class BoucWen(FrictionLaw):
    """Bouc-Wen hysteresis: the traction approaches mu p without a corner.

    Attributes
    ----------
    mu
        Coefficient of friction of the limit mu p.
    elastic_slip
        gamma* in m: the limit divided by the stiffness at rest.
    exponent
        n: the larger, the sharper the transition from sticking to sliding.
    unloading
        b = beta / (beta + gamma): 0.5 unloads with the stiffness at rest, 1 with up to twice this stiffness.
    """

    name: ClassVar[str] = "bouc_wen"
    sentence: ClassVar[str] = "Bouc-Wen hysteresis: approaches mu p without a corner"
    sticks: ClassVar[bool] = False
    exact_increment: ClassVar[bool] = True
    mu: Annotated[float, Parameter("coefficient of friction of the limit mu p, dimensionless", least=0.0)]
    elastic_slip: Annotated[
        float, Parameter("elastic slip gamma*, m: limit mu p divided by the stiffness at rest", above=0.0)
    ]
    exponent: Annotated[
        float, Parameter("exponent n, dimensionless: sharpness of the transition to sliding", least=1.0)
    ]
    unloading: Annotated[
        float, Parameter("beta / (beta + gamma), dimensionless: 0.5 unloads with the stiffness at rest", least=0.5)
    ]

    def __post_init__(self) -> None:
        check_stick(self.mu, self.elastic_slip)
        if not self.exponent >= 1.0:
            raise InputError(
                f"exponent {self.exponent} is below 1", key="contact.friction.exponent", remedy="give 1 or more"
            )
        if not self.unloading >= 0.5:
            raise InputError(
                f"unloading {self.unloading} is below 0.5: the loop would create energy",
                key="contact.friction.unloading",
                remedy="give beta / (beta + gamma) of 0.5 or more",
            )


def flow(e_h: float, e_z: float, u_h: float, u_z: float, gamma: float, n: float, b: float) -> tuple[float, float]:
    """Rate de/d lambda of the elastic slip for motion in the unit direction u."""
    square = e_h * e_h + e_z * e_z
    if square == 0.0:
        return u_h, u_z
    along = e_h * u_h + e_z * u_z
    c = (math.sqrt(square) / gamma) ** n * (b * abs(along) + (1.0 - b) * along) / square
    return u_h - c * e_h, u_z - c * e_z


def runge_kutta(
    e_h: float, e_z: float, u_h: float, u_z: float, step: float, gamma: float, n: float, b: float
) -> tuple[float, float]:
    """Elastic slip (m) after one Runge-Kutta step of length ``step`` (m) in the unit direction u."""
    a_h, a_z = flow(e_h, e_z, u_h, u_z, gamma, n, b)
    b_h, b_z = flow(e_h + 0.5 * step * a_h, e_z + 0.5 * step * a_z, u_h, u_z, gamma, n, b)
    c_h, c_z = flow(e_h + 0.5 * step * b_h, e_z + 0.5 * step * b_z, u_h, u_z, gamma, n, b)
    d_h, d_z = flow(e_h + step * c_h, e_z + step * c_z, u_h, u_z, gamma, n, b)
    return e_h + step / 6.0 * (a_h + 2.0 * (b_h + c_h) + d_h), e_z + step / 6.0 * (a_z + 2.0 * (b_z + c_z) + d_z)


def advance(
    e_h: float, e_z: float, dg_h: float, dg_z: float, gamma: float, n: float, b: float, count: int
) -> tuple[float, float]:
    """Elastic slip (m) after an increment, in ``count`` Runge-Kutta substeps.

    Where e . u changes its sign the rate has a corner; the substep is divided there.
    """
    size = math.sqrt(dg_h * dg_h + dg_z * dg_z)
    if size == 0.0:
        return e_h, e_z
    u_h, u_z, step = dg_h / size, dg_z / size, size / count
    for _ in range(count):
        before = e_h * u_h + e_z * u_z
        n_h, n_z = runge_kutta(e_h, e_z, u_h, u_z, step, gamma, n, b)
        after = n_h * u_h + n_z * u_z
        if before < 0.0 < after:
            part, low, high, least, most = 0.0, before, after, 0.0, step
            for _ in range(SECANTS):
                part = least - low * (most - least) / (high - low)
                n_h, n_z = runge_kutta(e_h, e_z, u_h, u_z, part, gamma, n, b)
                here = n_h * u_h + n_z * u_z
                if here < 0.0:
                    low, least = here, part
                else:
                    high, most = here, part
            n_h, n_z = runge_kutta(n_h, n_z, u_h, u_z, step - part, gamma, n, b)
        e_h, e_z = n_h, n_z
    return e_h, e_z


def substeps(dg_h: float, dg_z: float, gamma: float, n: float) -> int:
    """Number of Runge-Kutta substeps of an increment."""
    size = math.sqrt(dg_h * dg_h + dg_z * dg_z)
    return 1 + int(min(size * max(1.0, 0.5 * n) / (SUBSTEP * gamma), MOST_SUBSTEPS))


def integrated(
    trial_h: float, trial_z: float, dg_h: float, dg_z: float, gamma: float, n: float, b: float
) -> tuple[float, float]:
    """Elastic slip (m) after an increment, from the trial slip."""
    return advance(trial_h - dg_h, trial_z - dg_z, dg_h, dg_z, gamma, n, b, substeps(dg_h, dg_z, gamma, n))


def slip_update(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, bool]:
    """Elastic slip (m) after the increment, and whether it exceeds `SLIDES` gamma*."""
    gamma = laws.gamma[k]
    e_h, e_z = integrated(trial_h, trial_z, dg_h, dg_z, gamma, laws.own[k, EXPONENT], laws.own[k, UNLOADING])
    return e_h, e_z, e_h * e_h + e_z * e_z > (SLIDES * gamma) ** 2


def differences(
    t_h: float, t_z: float, g_h: float, g_z: float, gamma: float, n: float, b: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Central differences for the arguments of `integrated`: by trial slip ``t``, then by increment ``g``."""
    d = DIFFERENCE * gamma
    half = 0.5 / d
    r_h, r_z = integrated(t_h + d, t_z, g_h, g_z, gamma, n, b)
    l_h, l_z = integrated(t_h - d, t_z, g_h, g_z, gamma, n, b)
    a00, a10 = half * (r_h - l_h), half * (r_z - l_z)
    r_h, r_z = integrated(t_h, t_z + d, g_h, g_z, gamma, n, b)
    l_h, l_z = integrated(t_h, t_z - d, g_h, g_z, gamma, n, b)
    a01, a11 = half * (r_h - l_h), half * (r_z - l_z)
    r_h, r_z = integrated(t_h, t_z, g_h + d, g_z, gamma, n, b)
    l_h, l_z = integrated(t_h, t_z, g_h - d, g_z, gamma, n, b)
    b00, b10 = half * (r_h - l_h), half * (r_z - l_z)
    r_h, r_z = integrated(t_h, t_z, g_h, g_z + d, gamma, n, b)
    l_h, l_z = integrated(t_h, t_z, g_h, g_z - d, gamma, n, b)
    return a00, a01, a10, a11, b00, half * (r_h - l_h), b10, half * (r_z - l_z)


def slip_derivatives(
    k: int, trial_h: float, trial_z: float, dg_h: float, dg_z: float, p: float, laws: Any, dt: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Derivatives of the elastic slip: with respect to the trial slip, then with respect to the increment.

    Each derivative is a 2 x 2 matrix, given by its entries 00, 01, 10, 11 (0: hoop, 1: axial). Eight integrations in a
    function of numbers alone: with the arrays of ``laws`` in them, all other laws would take four times as long.
    """
    gamma = laws.gamma[k]
    return differences(trial_h, trial_z, dg_h, dg_z, gamma, laws.own[k, EXPONENT], laws.own[k, UNLOADING])


CALLED = ("advance", "differences", "runge_kutta", "substeps")
"""Functions that numba compiles once and calls; it would inline them otherwise. Their arguments are numbers."""
