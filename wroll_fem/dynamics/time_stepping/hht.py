r"""Hilber-Hughes-Taylor integration: parameters of the named schemes.

.. math::
    M a_{n+1} + (1 + \alpha) r_{n+1} - \alpha r_n = 0, \qquad r = K u + G^T W t - f
    \qquad
    u_{n+1} = u_n + h v_n + h^2 [(\tfrac12 - \beta) a_n + \beta a_{n+1}], \quad
    v_{n+1} = v_n + h [(1 - \gamma) a_n + \gamma a_{n+1}]

with :math:`\alpha \le 0` (classical range [-1/3, 0]; the thesis also uses -0.41421),
:math:`\beta = (1 - \alpha)^2 / 4`, :math:`\gamma = 1/2 - \alpha`.

Damping ratio and relative lengthening of the period that a scheme gives to an undamped oscillator:

===============  ==============  ====================  ====================  ===============
steps per cycle  no_damping      transient_fidelity    moderate_dissipation  quasi_static
===============  ==============  ====================  ====================  ===============
10               0 / +3.2 %      0.12 % / +3.6 %       0.36 % / +4.6 %       28 % / +12 %
20               0 / +0.82 %     0.017 % / +0.93 %     0.052 % / +1.2 %      15 % / +3.2 %
21.7             0 / +0.69 %     0.013 % / +0.79 %     0.041 % / +1.0 %      14 % / +2.7 %
40               0 / +0.21 %     0.0022 % / +0.23 %    0.0068 % / +0.30 %    7.8 % / +0.82 %
80               0 / +0.05 %     0.0003 % / +0.06 %    0.0009 % / +0.08 %    3.9 % / +0.21 %
160              0 / +0.01 %     0.00003 % / +0.01 %   0.0001 % / +0.02 %    2.0 % / +0.05 %
===============  ==============  ====================  ====================  ===============

For small steps the damping ratio of HHT is -alpha (1 + alpha)^2 / 8 (omega h)^3, and the relative lengthening of the
period is (1/12 - alpha/4 - 3 alpha^2/8) (omega h)^2. For backward Euler they are omega h / 2 and (omega h)^2 / 3.
Choose the step so that both are small compared with the damping and the frequency shift to be determined, up to the
highest frequency of interest.

References
----------
Hilber, Hughes, Taylor (1977), Earthquake Eng. Struct. Dyn. 5, 283, doi:10.1002/eqe.4290050306.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.errors import InputError


@dataclass(frozen=True)
class Scheme:
    """Parameters of the HHT family (alpha, beta, gamma), dimensionless.

    With ``exact_modes`` the scheme is trigonometric instead: the modes of the sticking structure are propagated exactly
    (`dynamics.trigonometric`).
    """

    alpha: float
    beta: float
    gamma: float
    exact_modes: bool = False

    @classmethod
    def hht(cls, alpha: float) -> Scheme:
        """Second-order, unconditionally stable scheme for ``alpha``; -0.41421 is the value of the thesis, Table B.1."""
        if not -0.41422 <= alpha <= 0.0:
            raise InputError(f"alpha = {alpha} is outside [-0.41421, 0]", key="integrator.alpha", remedy="use -0.05")
        return cls(alpha, (1.0 - alpha) ** 2 / 4.0, 0.5 - alpha)

    @classmethod
    def named(cls, name: str, alpha: float = -0.05) -> Scheme:
        """Scheme with the given name in the case file; ``alpha`` is used for "hht" only."""
        if name == "hht":
            return cls.hht(alpha)
        named = {
            "transient_fidelity": cls.hht(-0.05),
            "moderate_dissipation": cls(-0.41421, 0.5, 0.91421),
            "no_damping": cls.hht(0.0),
            "quasi_static": cls(0.0, 1.0, 1.5),
            "trigonometric": cls(0.0, 0.25, 0.5, exact_modes=True),
        }
        if name not in named:
            raise InputError(f"unknown scheme {name!r}", key="integrator.scheme", remedy=f"use hht, {', '.join(named)}")
        return named[name]


def amplification_matrix(scheme: Scheme, omega_dt: float) -> np.ndarray:
    """(3, 3) matrix to advance (u, h v, h^2 a) of an undamped oscillator by a step h; ``omega_dt`` = omega h (rad)."""
    square, alpha, beta, gamma = omega_dt**2, scheme.alpha, scheme.beta, scheme.gamma
    # a_new = -omega^2 [(1 + alpha) u_new - alpha u], with u_new by Newmark's formula
    new = -np.array([1.0, 1.0 + alpha, (1.0 + alpha) * (0.5 - beta)]) * square / (1.0 + (1.0 + alpha) * beta * square)
    u = np.array([1.0, 1.0, 0.5 - beta]) + beta * new
    v = np.array([0.0, 1.0, 1.0 - gamma]) + gamma * new
    return np.array([u, v, new])


def numerical_damping(scheme: Scheme, omega_dt: float) -> tuple[float, float]:
    r"""Damping ratio and period error that a scheme gives to an undamped oscillator.

    Parameters
    ----------
    scheme
        Any member of the family, or backward Euler.
    omega_dt
        omega h in rad: 2 pi divided by the number of steps per cycle.

    Returns
    -------
    tuple
        (damping ratio, relative lengthening of the period), dimensionless; zero for a scheme with exact modes.

    Raises
    ------
    InputError
        If ``omega_dt`` is not positive, or so large that the numerical motion no longer oscillates.

    Notes
    -----
    The complex pair of eigenvalues of the amplification matrix is that of an oscillator with viscous damping,
    :math:`\lambda = \exp(-\zeta \bar\omega h \pm i \bar\omega \sqrt{1 - \zeta^2} h)`. The third eigenvalue is real and
    small; it is due to the residual of the previous step in the HHT equation.

    References
    ----------
    Hughes (1987), The Finite Element Method, section 9.1.3.
    """
    if not (np.isfinite(omega_dt) and omega_dt > 0.0):
        raise InputError(f"omega dt = {omega_dt} is not a positive angle", remedy="give 2 pi / steps per cycle")
    if scheme.exact_modes:
        return 0.0, 0.0
    eigenvalues = np.linalg.eigvals(amplification_matrix(scheme, omega_dt))
    root = eigenvalues[np.argmax(eigenvalues.imag)]
    if root.imag <= 0.0:
        raise InputError(
            f"the solution does not oscillate at omega dt = {omega_dt:g}", remedy="use more steps per cycle"
        )
    exponent = np.log(root)
    return float(-exponent.real / abs(exponent)), float(omega_dt / exponent.imag - 1.0)
