"""What every estimator returns, and what it asks of a curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, nan
from typing import Any

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.typing import ComplexArray, FloatArray

_DIFFERENCE = 4  # order of the differences that leave noise and take a smooth curve away
_DIFFERENCE_GAIN = np.sqrt(70.0)  # norm of (1, -4, 6, -4, 1)


@dataclass(frozen=True)
class DampingEstimate:
    """One reading of frequency and damping.

    Attributes
    ----------
    f_n
        Hz. Of the peak (half power), of the fitted bell (Gaussian), undamped natural frequency |pole| / 2 pi
        (rational fraction).
    zeta
        Damping ratio; nan when the method has no answer, `reason` says why.
    f_n_error, zeta_error
        Standard errors from the scatter of the data alone, Hz and 1. A model that does not fit the curve
        (`misfit`) and the bias of the method (`lower_bound`) come on top.
    method
        "half power", "Gaussian fit" or "rational fraction".
    reason
        Why this method was chosen, or why there is no number.
    misfit
        Root mean square distance of fit and curve over the fitted window, over the curve's peak; nan without a fit.
    window
        (low, high) frequencies used, Hz.
    details
        Numbers of the method by name, as its function documents.
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
        """Whether there is a damping ratio."""
        return isfinite(self.zeta)


def no_estimate(method: str, reason: str, f_n: float = nan) -> DampingEstimate:
    """Result of a method that has no answer."""
    return DampingEstimate(f_n, nan, nan, nan, method, reason)


def checked_curve(
    frequency: npt.ArrayLike, transmissibility: npt.ArrayLike
) -> tuple[FloatArray, ComplexArray | None, FloatArray]:
    """Frequencies, complex values (None for a magnitude) and magnitudes of a curve, each (n,).

    Raises
    ------
    InputError
        For unequal or short series, frequencies that do not rise, values not finite, or a negative magnitude.
    """
    f, values = np.asarray(frequency, dtype=np.float64), np.asarray(transmissibility)
    if f.ndim != 1 or f.shape != values.shape or f.size < 8:
        raise InputError(f"a curve of shapes {f.shape} and {values.shape}", remedy="give two equal series of 8 or more")
    if not np.isfinite(f).all() or not np.isfinite(values).all() or np.any(np.diff(f) <= 0.0) or f[0] < 0.0:
        raise InputError(
            "a curve whose frequencies do not rise from 0 Hz or more, or with values that are not finite",
            remedy="sort it, and leave out what was not measured",
        )
    if np.iscomplexobj(values):
        complex_values = values.astype(np.complex128)
        return f, complex_values, np.abs(complex_values)
    magnitude = values.astype(np.float64)
    if np.any(magnitude < 0.0):
        raise InputError("a negative magnitude", remedy="give |T|, not a level in dB, or the complex transmissibility")
    return f, None, magnitude


def noise_level(magnitude: FloatArray) -> float:
    """Standard deviation of the scatter of a curve, from its fourth differences (median, so peaks do not count).

    Exact in the mean for white noise on a smooth curve of any grid with a slowly varying step; noise that is smooth
    from point to point (a demodulated or filtered curve) is not seen.
    """
    middle = np.abs(np.diff(magnitude, _DIFFERENCE))
    return float(np.median(middle) / (0.6745 * _DIFFERENCE_GAIN))


def scatter(
    magnitude: FloatArray, read: Callable[[FloatArray], tuple[float, float] | None], draws: int, seed: int
) -> tuple[float, float]:
    """Standard deviations of a reading (f_n, zeta) when white noise of the curve's own level is added once more.

    Parameters
    ----------
    read
        From a magnitude (n,) to (f_n, zeta), or None when there is no answer; such draws are left out.
    """
    noise = noise_level(magnitude)
    if noise < 1e-6 * float(magnitude.max()):
        return 0.0, 0.0
    random = np.random.default_rng(seed)
    found = (read(np.abs(magnitude + noise * random.standard_normal(magnitude.size))) for _ in range(draws))
    again = np.array([pair for pair in found if pair is not None])
    if len(again) < 3:
        return nan, nan
    f_error, zeta_error = again.std(axis=0, ddof=1)
    return float(f_error), float(zeta_error)
