r"""Part of its steady peak that a swept resonance reaches, and the lag of the swept peak (guide of thesis, Fig. 3.8).

Near its resonance an oscillator follows the envelope equation
:math:`\dot A = -(\sigma + i (\omega_n - \omega(t))) A + F` with :math:`\sigma = \zeta \omega_n`. For
:math:`\omega(t) = \omega_n + \dot\omega t`, with the time in 1 / sigma and the dimensionless rate
:math:`p = \dot\omega / \sigma^2`, the envelope relative to the steady peak is

.. math::

    a(\delta) = \int_0^\infty e^{-(1 + i\delta) s + i p s^2 / 2}\, ds
    = \tfrac12 \sqrt{\pi / c}\; w\!\left(\frac{i (1 + i \delta)}{2 \sqrt c}\right), \qquad c = -i p / 2,

where the frequency at that time is :math:`\omega_n + \delta \sigma`, and w is the Faddeeva function. The largest value
depends on p alone. At R oct/min, :math:`p = R \ln 2 / (120 \pi \zeta^2 f_n)`; p = 0.574 is the limit of ISO 7626-2.

An oscillator of finite damping differs in the first order of zeta, upward sweeps by -zeta k(p), downward ones by
+zeta k(p), because the rate of a geometric sweep and the response vary over the width of the peak. k is tabulated from
exact swept responses. With it the error is below 0.2 % for zeta up to 5 % and four times the limit
(`tests/signals/test_attainment.py`).

References
----------
.. [1] F. M. Lewis, Vibration during acceleration through a critical speed, Trans. ASME 54 (1932) 253-261.
.. [2] ISO 7626-2:2015, Mechanical vibration and shock - Experimental determination of mechanical mobility.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.special import wofz

from wroll_fem.errors import InputError

LIMIT = 312.0 * np.log(2.0) / (120.0 * np.pi)
"""Dimensionless rate p of the limit of ISO 7626-2."""

_SHARES = np.array([0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0])
_FIRST_ORDER = np.array([0.0143, 0.0277, 0.0617, 0.1030, 0.1573, 0.2234, 0.2968])
"""Rate over the limit of ISO 7626-2, and k there. k is proportional to the rate below the first value."""

SLOWEST = 1e-4
"""Rate over the limit below which the loss of the peak, p^2 / 2, is neglected."""


class SweptPeak(NamedTuple):
    """Peak of a swept resonance.

    Attributes
    ----------
    attainment
        Largest response over the steady peak, dimensionless.
    lag
        Shift of the peak along the sweep over the half of the half-power width, (f - f_n) / (zeta f_n), above zero.
    """

    attainment: float
    lag: float


def _envelope(p: float, delta: float) -> float:
    """Size of the envelope over the steady peak at the dimensionless rate ``p`` and frequency ``delta``."""
    root = np.sqrt(-0.5j * p)
    return float(abs(0.5 * np.sqrt(np.pi) / root * wofz(0.5j * (1.0 + 1j * delta) / root)))


def swept_peak(f_n: float, zeta: float, rate_oct_per_min: float, *, downward: bool = False) -> SweptPeak:
    """Peak of an oscillator under a geometric sweep of the base, relative to its steady peak.

    Parameters
    ----------
    f_n
        Natural frequency, Hz.
    zeta
        Damping ratio; accurate up to 0.05.
    rate_oct_per_min
        Sweep rate, octaves per minute.
    downward
        Whether the frequency falls.

    Raises
    ------
    InputError
        If a value is not above zero.
    """
    values = {"f_n": f_n, "zeta": zeta, "rate_oct_per_min": rate_oct_per_min}
    for name, value in values.items():
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value:g} is not a positive number", key=name, remedy="give a number above 0")
    share = rate_oct_per_min / (312.0 * zeta**2 * f_n)
    if share < SLOWEST:
        return SweptPeak(1.0, 2.0 * LIMIT * share)
    p = LIMIT * share
    found = minimize_scalar(lambda delta: -_envelope(p, delta), bounds=(0.0, 2.0 + 2.0 * p), method="bounded")
    first = float(np.interp(np.log(share), np.log(_SHARES), _FIRST_ORDER)) * min(1.0, share / _SHARES[0])
    return SweptPeak(-float(found.fun) + (zeta if downward else -zeta) * first, float(found.x))


def rate_for_attainment(f_n: float, zeta: float, attainment: float = 0.9, *, downward: bool = False) -> float:
    """Highest sweep rate, octaves per minute, at which a resonance reaches a part of its steady peak.

    Parameters
    ----------
    f_n, zeta, downward
        As for `swept_peak`.
    attainment
        Part of the steady peak, 0.75 to 0.999.

    Raises
    ------
    InputError
        If the attainment is outside its range.
    """
    if not 0.75 <= attainment <= 0.999:
        raise InputError(
            f"attainment = {attainment:g} is outside 0.75 to 0.999", key="attainment", remedy="give for example 0.9"
        )
    limit = 312.0 * zeta**2 * f_n

    def missing(x: float) -> float:
        return swept_peak(f_n, zeta, limit * float(np.exp(x)), downward=downward).attainment - attainment

    return limit * float(np.exp(brentq(missing, np.log(1e-3), np.log(12.0), xtol=1e-6)))
