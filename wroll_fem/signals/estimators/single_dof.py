"""Single degree of freedom on a moving base: exact curve, exact half-power damping, and bias of the estimators.

All values refer to the absolute transmissibility of displacement or acceleration, not to a receptance.
"""

from __future__ import annotations

from functools import lru_cache
from math import nan, sqrt

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from wroll_fem.errors import InputError
from wroll_fem.signals.estimators.estimate import DampingEstimate
from wroll_fem.signals.estimators.gaussian import METHOD as GAUSSIAN
from wroll_fem.signals.estimators.gaussian import Centre, gaussian_fit
from wroll_fem.signals.estimators.half_power import METHOD as HALF_POWER
from wroll_fem.typing import ComplexArray

HALF_POWER_LIMIT = 0.5411961001461969
"""Damping ratio above which there is no lower half-power point, because T(0) = 1 and the peak is below sqrt 2."""


def single_dof_transmissibility(frequency: npt.ArrayLike, f_n: float, zeta: float) -> ComplexArray:
    """Absolute transmissibility T = (1 + 2 i zeta r) / (1 - r^2 + 2 i zeta r) with r = f / f_n.

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz.
    f_n
        Natural frequency, Hz.
    zeta
        Damping ratio.

    Returns
    -------
    (n,) complex T
    """
    r = np.asarray(frequency, dtype=np.float64) / f_n
    numerator = 1.0 + 2j * zeta * r
    return np.asarray(numerator / (numerator - r**2))


def cubic_spring_transmissibility(frequency: npt.ArrayLike, f_n: float, zeta: float, lean: float) -> ComplexArray:
    """Absolute transmissibility with a cubic spring: a skewed curve from one-term harmonic balance (upper branch).

    The relative stiffness is 1 + k |z|^2 with k = 4 zeta^2 lean, where z is the relative displacement divided by the
    base displacement; |z|^2 is the largest root u of u ((1 - r^2 + k u)^2 + 4 zeta^2 r^2) = r^4.

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz.
    f_n, zeta
        Natural frequency (Hz) and damping ratio at small amplitudes.
    lean
        Approximate relative change of the stiffness at the peak.

    Returns
    -------
    (n,) complex T
    """
    r = np.asarray(frequency, dtype=np.float64) / f_n
    k = 4.0 * zeta**2 * lean
    square = np.empty(r.size)
    for i, x in enumerate(r**2):
        roots = np.roots([k**2, 2.0 * k * (1.0 - x), (1.0 - x) ** 2 + 4.0 * zeta**2 * x, -(x**2)])
        square[i] = roots.real[np.abs(roots.imag) < 1e-9 * np.abs(roots)].max(initial=0.0)
    return np.asarray(1.0 + r**2 / (1.0 + k * square - r**2 + 2j * zeta * r))


def peak_transmissibility(zeta: float) -> tuple[float, float]:
    """Frequency ratio r_pk and height T_pk of the peak, with r_pk^2 = (sqrt(1 + 8 zeta^2) - 1) / (4 zeta^2).

    Raises
    ------
    InputError
        If zeta does not lie between 0 and 1.
    """
    if not 0.0 < zeta < 1.0:
        raise InputError(f"the damping ratio must lie between 0 and 1, got {zeta}", remedy="use 0.02 for 2 %")
    square = 2.0 / (sqrt(1.0 + 8.0 * zeta**2) + 1.0)  # the same without cancellation
    top = (1.0 + 4.0 * zeta**2 * square) / ((1.0 - square) ** 2 + 4.0 * zeta**2 * square)
    return sqrt(square), sqrt(top)


def single_dof_half_power(zeta: float) -> float:
    """Half-power damping of the exact curve with damping ratio zeta; nan at and above `HALF_POWER_LIMIT`.

    With h = T_pk^2 / 2 and x = r^2, the equation |T|^2 = h is h x^2 + (4 zeta^2 h - 2 h - 4 zeta^2) x + h - 1 = 0.

    Raises
    ------
    InputError
        If zeta does not lie between 0 and 1.
    """
    r_peak, peak = peak_transmissibility(zeta)
    h = 0.5 * peak**2
    if h <= 1.0:
        return nan
    middle = 4.0 * zeta**2 * (h - 1.0) - 2.0 * h
    high = (-middle + sqrt(middle**2 - 4.0 * h * (h - 1.0))) / (2.0 * h)
    low = (h - 1.0) / (h * high)
    return (sqrt(high) - sqrt(low)) / (2.0 * r_peak)


@lru_cache(maxsize=2)
def _gaussian_bias(centre: Centre) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Damping ratios of exact curves, and the damping ratios that the Gaussian fit gives for these curves."""
    given: list[float] = []
    read: list[float] = []
    for zeta in (0.005, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5):
        r_peak, _ = peak_transmissibility(zeta)
        f = np.linspace(max(0.0, r_peak - 6.0 * zeta), r_peak + 6.0 * zeta, 1201)
        estimate = gaussian_fit(f, np.abs(single_dof_transmissibility(f, 1.0, zeta)), centre=centre, window="narrowest")
        if estimate.found and (not read or estimate.zeta > read[-1]):
            given.append(zeta)
            read.append(estimate.zeta)
    return tuple(given), tuple(read)


def lower_bound(estimate: DampingEstimate) -> float:
    """Lower end of the error bar defined in the thesis: zeta minus the bias of the method (Fig. D.1).

    The bias is that for a single-degree-of-freedom oscillator: the difference between the estimate and the damping
    ratio of the exact curve that gives this estimate (half power: closed form; Gaussian fit: fits to exact curves;
    rational fraction: no bias). For estimates beyond the range of the exact curves the bias at the end of the range is
    used. One standard error is subtracted as well.

    Returns
    -------
    Lower bound of zeta; nan without an estimate, and for a Gaussian fit whose window is not determined by the
    constraint, because that estimate depends on the band
    """
    if not estimate.found:
        return nan
    found, bias = estimate.zeta, 0.0
    if estimate.method == HALF_POWER:
        top = HALF_POWER_LIMIT - 1e-6
        capped = min(found, single_dof_half_power(top))
        if capped > single_dof_half_power(1e-6):
            bias = abs(capped - brentq(lambda z: single_dof_half_power(z) - capped, 1e-6, top, xtol=1e-12))
    elif estimate.method == GAUSSIAN:
        details = estimate.details or {}
        if not details.get("at_constraint"):
            return nan
        given, read = _gaussian_bias(details["centre"])
        capped = min(max(found, read[0]), read[-1])
        bias = abs(capped - float(np.interp(capped, read, given))) * min(1.0, found / capped)
    error = estimate.zeta_error if np.isfinite(estimate.zeta_error) else 0.0
    return max(0.0, found - bias - error)
