"""The single degree of freedom on a moving base: exact curve, exact half-power reading, and the bias it shows.

All numbers are for the absolute transmissibility of displacement (equally of acceleration), not for a receptance.
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

HIGHEST_READABLE = 0.5411961001461969
"""Damping ratio from which half power has no lower point: the peak is sqrt 2 there, and T = 1 at rest."""


def single_dof_transmissibility(frequency: npt.ArrayLike, f_n: float, zeta: float) -> ComplexArray:
    """(n,) absolute transmissibility T = (1 + 2 i zeta r) / (1 - r^2 + 2 i zeta r), r = f / f_n."""
    r = np.asarray(frequency, dtype=np.float64) / f_n
    numerator = 1.0 + 2j * zeta * r
    return np.asarray(numerator / (numerator - r**2))


def leaning_transmissibility(frequency: npt.ArrayLike, f_n: float, zeta: float, lean: float) -> ComplexArray:
    """(n,) the same with a cubic spring, one harmonic, upper branch: a curve that leans and, past a limit, jumps.

    With the relative amplitude z over the base's, the stiffness is 1 + k |z|^2, k = 4 zeta^2 lean, so that it changes
    by about `lean` at the peak; |z|^2 is the largest root of u ((1 - r^2 + k u)^2 + 4 zeta^2 r^2) = r^4.
    """
    r = np.asarray(frequency, dtype=np.float64) / f_n
    k = 4.0 * zeta**2 * lean
    square = np.empty(r.size)
    for i, x in enumerate(r**2):
        roots = np.roots([k**2, 2.0 * k * (1.0 - x), (1.0 - x) ** 2 + 4.0 * zeta**2 * x, -(x**2)])
        square[i] = roots.real[np.abs(roots.imag) < 1e-9 * np.abs(roots)].max(initial=0.0)
    return np.asarray(1.0 + r**2 / (1.0 + k * square - r**2 + 2j * zeta * r))


def peak_transmissibility(zeta: float) -> tuple[float, float]:
    """Frequency ratio r_pk and height of the peak, r_pk^2 = (sqrt(1 + 8 zeta^2) - 1) / (4 zeta^2)."""
    if not 0.0 < zeta < 1.0:
        raise InputError(f"a damping ratio of {zeta}", remedy="give one between 0 and 1")
    square = 2.0 / (sqrt(1.0 + 8.0 * zeta**2) + 1.0)  # the same without cancellation
    top = (1.0 + 4.0 * zeta**2 * square) / ((1.0 - square) ** 2 + 4.0 * zeta**2 * square)
    return sqrt(square), sqrt(top)


def half_power_reading(zeta: float) -> float:
    """What half power reads from the exact curve; nan from `HIGHEST_READABLE` on.

    |T|^2 = h with h = T_pk^2 / 2 is h x^2 + (4 zeta^2 h - 2 h - 4 zeta^2) x + h - 1 = 0 in x = r^2.
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
def _gaussian_readings(centre: Centre) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Damping ratios of exact curves and what the Gaussian fit reads from each."""
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
    """Lower end of the error bar of the source: zeta less the method's error on a single degree of freedom (Fig. D.1).

    The prescribed damping that gives this reading is looked up (half power: closed form; Gaussian fit: the fit to exact
    curves); the bar reaches down by the distance of the two, whichever is larger. One standard error is taken off too.
    For a rational fraction, exact on such a curve, that is all. Readings above the largest of the exact curves use
    their error there. nan without an estimate, and for a Gaussian fit whose window the constraint did not set: that
    reading depends on the band.
    """
    if not estimate.found:
        return nan
    reading, bias = estimate.zeta, 0.0
    if estimate.method == HALF_POWER:
        top = HIGHEST_READABLE - 1e-6
        capped = min(reading, half_power_reading(top))
        if capped > half_power_reading(1e-6):
            bias = abs(capped - brentq(lambda z: half_power_reading(z) - capped, 1e-6, top, xtol=1e-12))
    elif estimate.method == GAUSSIAN:
        details = estimate.details or {}
        if not details.get("at_constraint"):
            return nan
        given, read = _gaussian_readings(details["centre"])
        capped = min(max(reading, read[0]), read[-1])
        bias = abs(capped - float(np.interp(capped, read, given))) * min(1.0, reading / capped)
    error = estimate.zeta_error if np.isfinite(estimate.zeta_error) else 0.0
    return max(0.0, reading - bias - error)
