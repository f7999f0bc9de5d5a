r"""Hilber-Hughes-Taylor integration: parameters of the named schemes.

.. math::
    M a_{n+1} + (1 + \alpha) r_{n+1} - \alpha r_n = 0, \qquad r = K u + G^T W t - f
    \qquad
    u_{n+1} = u_n + h v_n + h^2 [(\tfrac12 - \beta) a_n + \beta a_{n+1}], \quad
    v_{n+1} = v_n + h [(1 - \gamma) a_n + \gamma a_{n+1}]

with :math:`\alpha \le 0` (classical range [-1/3, 0]; the source also uses -0.41421),
:math:`\beta = (1 - \alpha)^2 / 4`, :math:`\gamma = 1/2 - \alpha`.

=====================  ========  ========  =======
scheme (Table B.1)     alpha     beta      gamma
=====================  ========  ========  =======
transient_fidelity     -0.05     0.275625  0.55
moderate_dissipation   -0.41421  0.5       0.91421
no_damping              0        0.25      0.5
quasi_static            backward Euler: beta = 1, gamma = 1, alpha = 0
=====================  ========  ========  =======

Backward Euler for second-order systems (u' and v' both backward) is exactly the Newmark form with
beta = gamma = 1: v_{n+1} = v_n + h a_{n+1}, u_{n+1} = u_n + h v_{n+1} = u_n + h v_n + h^2 a_{n+1}.

References
----------
Hilber, Hughes, Taylor (1977), Earthquake Eng. Struct. Dyn. 5, 283, doi:10.1002/eqe.4290050306.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import InputError


@dataclass(frozen=True)
class Scheme:
    """Parameters of the HHT family (alpha, beta, gamma), dimensionless."""

    alpha: float
    beta: float
    gamma: float

    @classmethod
    def hht(cls, alpha: float) -> Scheme:
        """Second-order, unconditionally stable member of the family; the printed -0.41421 gives Table B.1."""
        if not -0.41422 <= alpha <= 0.0:
            raise InputError(f"alpha = {alpha} is outside [-0.41421, 0]", key="integrator.alpha", remedy="use -0.05")
        return cls(alpha, (1.0 - alpha) ** 2 / 4.0, 0.5 - alpha)

    @classmethod
    def named(cls, name: str, alpha: float = -0.05) -> Scheme:
        """Scheme by its name in the case file."""
        if name == "hht":
            return cls.hht(alpha)
        named = {
            "transient_fidelity": cls.hht(-0.05),
            "moderate_dissipation": cls(-0.41421, 0.5, 0.91421),
            "no_damping": cls.hht(0.0),
            "quasi_static": cls(0.0, 1.0, 1.0),
        }
        if name not in named:
            raise InputError(f"unknown scheme {name!r}", key="integrator.scheme", remedy=f"use hht, {', '.join(named)}")
        return named[name]
