r"""Autoregressive noise of a record: its coefficients from residuals, and the filter that removes its correlation.

.. math:: r_k = \sum_{j=1}^{q} \phi_j\, r_{k-j} + w_k

with independent w. The order q is the one of the smallest information criterion of Akaike; the coefficients solve the
Yule-Walker equations.

References
----------
.. [1] Box, Jenkins, Reinsel (2008), Time Series Analysis, 4th ed., sections 3.2 and 7.3 (Yule-Walker), 8.2.2 (the
   portmanteau test of Ljung and Box), doi:10.1002/9781118619193.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter
from scipy.special import chdtrc

from wroll_fem.typing import FloatArray

LARGEST_ORDER = 8
"""Largest order of the noise model."""

FEWEST = 20
"""Residuals for each coefficient; shorter series have independent noise."""

DOUBT = 1e-4
"""Probability of the remaining correlation by chance, below which it is reported."""

PENALTY = 2.0
"""Gain of the logarithm of the likelihood, doubled, that each further coefficient of the noise has to bring."""

LARGEST_SUM = 50.0
"""Largest sum of the autocovariances over all lags, relative to the variance, that a correction uses."""

LAGS = 20
"""Lags of the test of the remaining correlation."""


@dataclass(frozen=True)
class NoiseModel:
    """Autoregressive model of the noise of series.

    Attributes
    ----------
    coefficients
        (q,) phi_1 to phi_q; empty if the noise is independent.
    """

    coefficients: tuple[float, ...] = ()

    @property
    def order(self) -> int:
        """Order q of the model."""
        return len(self.coefficients)

    def whiten(self, values: FloatArray, lengths: Sequence[int]) -> FloatArray:
        """Values (n,) or (n, m) of series of the given lengths, filtered; the first q samples of each are left out."""
        if not self.coefficients:
            return values
        kernel = np.concatenate([[1.0], -np.asarray(self.coefficients)])
        parts = np.split(values, np.cumsum(lengths)[:-1])
        return np.concatenate([np.asarray(lfilter(kernel, 1.0, part, axis=0))[self.order :] for part in parts])


def noise_model(residuals: FloatArray, lengths: Sequence[int], *, fitted: int = 0) -> NoiseModel:
    """Noise model of residuals (n,) of series of the given lengths.

    Parameters
    ----------
    residuals
        (n,) residuals of all series, one after the other.
    lengths
        Number of residuals of each series.
    fitted
        Number of fitted parameters. A fit takes slow noise out of the residuals: from the autocovariance at each lag,
        about its sum over all lags times fitted/n, which is put back.
    """
    order = min(LARGEST_ORDER, min(lengths) // FEWEST)
    if order < 1 or not np.any(residuals):
        return NoiseModel()
    covariance = _covariance(residuals, lengths, order)
    first, variance = _best(covariance, len(residuals))
    slow = min(variance / (1.0 - first.sum()) ** 2, LARGEST_SUM * covariance[0]) if first.size else covariance[0]
    found, _ = _best(covariance + slow * fitted / len(residuals), len(residuals))
    return NoiseModel(tuple(float(value) for value in found))


def _best(covariance: FloatArray, total: int) -> tuple[FloatArray, float]:
    """Coefficients of the best order, and variance of the driving noise."""
    best, found = np.inf, (np.zeros(0), float(covariance[0]))
    for q in range(len(covariance)):
        phi = solve_toeplitz(covariance[:q], covariance[1 : q + 1]) if q else np.zeros(0)
        variance = float(covariance[0] - phi @ covariance[1 : q + 1])
        if not variance > 0.0:
            break
        criterion = total * np.log(variance) + PENALTY * q
        if criterion < best - 1e-9:
            best, found = criterion, (phi, variance)
    return found


def stays_correlated(whitened: FloatArray, lengths: Sequence[int], order: int) -> bool:
    """Whether the residuals of the whole model, noise included, are correlated (Ljung and Box)."""
    lags = min(LAGS, min(lengths) // 4)
    if lags <= order or not np.any(whitened):
        return False
    covariance = _covariance(whitened, lengths, lags)
    total = len(whitened)
    ratios = covariance[1:] / covariance[0]
    statistic = total * (total + 2.0) * np.sum(ratios**2 / (total - np.arange(1, lags + 1)))
    return bool(chdtrc(lags - order, statistic) < DOUBT)


def _covariance(values: FloatArray, lengths: Sequence[int], lags: int) -> FloatArray:
    """(lags + 1,) autocovariance of series about zero."""
    parts = np.split(values, np.cumsum(lengths)[:-1])
    sums = [[part[k:] @ part[: len(part) - k] for part in parts] for k in range(lags + 1)]
    return np.sum(sums, axis=1) / len(values)
