"""Result of a damping estimator, check of its input, noise level of a curve, and scatter of estimates due to noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, nan
from typing import Any

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.typing import ComplexArray, FloatArray


@dataclass(frozen=True)
class DampingEstimate:
    """Estimate of frequency and damping from one curve.

    Attributes
    ----------
    f_n
        Frequency, Hz: of the peak (half power), of the centre of the bell (Gaussian fit), or the undamped natural
        frequency |pole| / 2 pi (rational fraction).
    zeta
        Damping ratio; nan if the method fails, with the cause in `reason`.
    f_n_error, zeta_error
        Standard errors due to the scatter of the data, Hz and dimensionless. They do not include the error of a model
        that does not fit the curve (`misfit`) or the bias of the method (`lower_bound`).
    method
        "half power", "Gaussian fit" or "rational fraction".
    reason
        Why this method was chosen, or why there is no estimate.
    misfit
        Root mean square difference between fit and curve in the window, relative to the peak; nan without a fit.
    window
        Lower and upper end of the frequency window used, Hz.
    details
        Further results, documented with each method.
    """

    f_n: float
    zeta: float
    f_n_error: float
    zeta_error: float
    method: str
    reason: str = ""
    misfit: float = nan
    window: tuple[float, float] = (nan, nan)
    details: dict[str, Any] | None = None

    @property
    def found(self) -> bool:
        """Whether the method found a damping ratio."""
        return isfinite(self.zeta)


def no_estimate(method: str, reason: str, f_n: float = nan) -> DampingEstimate:
    """Result of a method that finds no damping ratio.

    Parameters
    ----------
    method
        Name of the method.
    reason
        Why there is no estimate.
    f_n
        Frequency of the peak, Hz, if known.
    """
    return DampingEstimate(f_n, nan, nan, nan, method, reason)


def checked_curve(
    frequency: npt.ArrayLike, transmissibility: npt.ArrayLike
) -> tuple[FloatArray, ComplexArray | None, FloatArray]:
    """Check a curve and split it into frequencies, complex values and magnitudes.

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz, ascending, n >= 8.
    transmissibility
        (n,) complex T, or |T|.

    Returns
    -------
    frequency : (n,) Hz
    values : (n,) complex T, or None if only |T| is given
    magnitude : (n,) |T|

    Raises
    ------
    InputError
        If the series are unequal or too short, the frequencies do not increase, or values are not finite or negative.
    """
    f, values = np.asarray(frequency, dtype=np.float64), np.asarray(transmissibility)
    if f.ndim != 1 or f.shape != values.shape or f.size < 8:
        raise InputError(
            f"frequency and transmissibility have the shapes {f.shape} and {values.shape}",
            remedy="give two series of the same length, 8 points or more",
        )
    if not np.isfinite(f).all() or not np.isfinite(values).all() or np.any(np.diff(f) <= 0.0) or f[0] < 0.0:
        raise InputError(
            "the frequencies of a curve must be 0 Hz or more and must increase, and its values must be finite",
            remedy="sort the points by frequency and remove invalid ones",
        )
    if np.iscomplexobj(values):
        complex_values = values.astype(np.complex128)
        return f, complex_values, np.abs(complex_values)
    magnitude = values.astype(np.float64)
    if np.any(magnitude < 0.0):
        raise InputError("magnitudes must not be negative", remedy="give the complex T, or |T| that is not in dB")
    return f, None, magnitude


def noise_level(frequency: FloatArray, magnitude: FloatArray) -> float:
    """Standard deviation of the noise on a curve |T| (n,) at ascending frequencies (n,), Hz.

    Each point is compared with the cubic through its four neighbours; the estimate is the median of the differences.
    It is unbiased for white noise on a smooth curve, whatever its steps. Noise that is smooth from point to point (on
    a demodulated or filtered curve) is not detected.
    """
    if magnitude.size < 5:
        return 0.0
    size = magnitude.size - 4
    places = [frequency[k : k + size] - frequency[2 : 2 + size] for k in (0, 1, 3, 4)]
    difference, gain = magnitude[2 : 2 + size].copy(), np.ones(size)
    for k, offset in enumerate(places):
        others = [x for j, x in enumerate(places) if j != k]
        weight = np.prod([x / (x - offset) for x in others], axis=0)
        difference -= weight * magnitude[(0, 1, 3, 4)[k] :][:size]
        gain += weight**2
    return float(np.median(np.abs(difference) / np.sqrt(gain)) / 0.6745)


def scatter(
    frequency: FloatArray,
    magnitude: FloatArray,
    read: Callable[[FloatArray], tuple[float, float] | None],
    draws: int,
    seed: int,
    noise: float | None = None,
) -> tuple[float, float]:
    """Standard deviations of f_n and zeta, from copies of a curve with added white noise of the curve's own level.

    Parameters
    ----------
    frequency, magnitude
        (n,) frequencies, Hz, ascending, and curve |T|.
    read
        Function from a magnitude (n,) to (f_n, zeta), or None if there is no estimate; such draws are ignored.
    draws
        Number of noisy repetitions.
    seed
        Seed of the noise.
    noise
        Standard deviation of |T|, if it is known; by default it is estimated from the curve (`noise_level`).

    Returns
    -------
    Standard deviations of f_n (Hz) and zeta; 0 without noise, nan with fewer than three estimates
    """
    noise = noise_level(frequency, magnitude) if noise is None else noise
    if noise < 1e-6 * float(magnitude.max()):
        return 0.0, 0.0
    random = np.random.default_rng(seed)
    found = (read(np.abs(magnitude + noise * random.standard_normal(magnitude.size))) for _ in range(draws))
    again = np.array([pair for pair in found if pair is not None])
    if len(again) < 3:
        return nan, nan
    f_error, zeta_error = again.std(axis=0, ddof=1)
    return float(f_error), float(zeta_error)
