"""Estimated number with its standard error and its confidence interval by the t-distribution."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from wroll_fem.typing import FloatArray

LEVEL = 0.95
"""Confidence of the intervals."""


@dataclass(frozen=True)
class Estimate:
    """Estimated number.

    Attributes
    ----------
    value
        Estimate, in its own unit.
    error
        Standard error: of the value, or of its natural logarithm if `logarithmic`; infinite or NaN if it is unknown.
    freedom
        Degrees of freedom of the standard error.
    logarithmic
        Whether the logarithm is normally distributed, as for a positive parameter fitted by its logarithm.
    """

    value: float
    error: float
    freedom: float
    logarithmic: bool = False

    @property
    def standard_error(self) -> float:
        """Standard error of the value, in its unit."""
        return abs(self.value) * self.error if self.logarithmic else self.error

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        """Lower and upper end of the confidence interval; infinite ends if the standard error is unknown."""
        if not (math.isfinite(self.error) and self.freedom > 0.0):
            return (0.0 if self.logarithmic else -math.inf), math.inf
        reach = float(stdtrit(self.freedom, 0.5 + 0.5 * level)) * self.error
        if self.logarithmic:
            wide = min(reach, 700.0)  # exp does not overflow
            return self.value * math.exp(-wide), self.value * math.exp(wide)
        return self.value - reach, self.value + reach

    def scaled(self, factor: float) -> Estimate:
        """The estimate times a number that is known exactly."""
        return Estimate(
            factor * self.value, self.error if self.logarithmic else abs(factor) * self.error, self.freedom,
            self.logarithmic,
        )  # fmt: skip


def mean_estimate(values: FloatArray) -> Estimate:
    """Mean of independent values (n,), with the standard error from their scatter; infinite if there is one value."""
    count = len(values)
    error = float(np.std(values, ddof=1)) / math.sqrt(count) if count > 1 else math.inf
    return Estimate(float(np.mean(values)), error, count - 1.0)


def combined_freedom(variances: tuple[float, ...], freedoms: tuple[float, ...]) -> float:
    """Degrees of freedom of a sum of independent estimates (Welch and Satterthwaite)."""
    total = sum(variances)
    below = sum(v**2 / f for v, f in zip(variances, freedoms, strict=True) if v > 0.0)
    return float(total**2 / below) if below > 0.0 else float(np.inf)
