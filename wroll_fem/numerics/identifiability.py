r"""Confidence intervals of a least-squares fit, and directions of the parameters that the data do not determine.

With the logarithms x of the parameters, the Jacobian J of the residuals at the minimum, and the variance s^2 of a
residual, the covariance of x is s^2 (J^T J)^{-1}. In the singular vectors of J it is diagonal: along the k-th vector x
is known with the standard error s / sigma_k. A direction with a large error is a combination of parameters, a product
of powers, that the data do not determine, even where other combinations of the same parameters are known well [1]_.

References
----------
.. [1] G. A. F. Seber, C. J. Wild, Nonlinear Regression, Wiley 1989, sections 2.1 and 3.4, doi:10.1002/0471725315.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from wroll_fem.typing import FloatArray

LOOSE = 0.35
"""Standard error of a direction of the logarithms from which the data do not determine it: 95 % within a factor 2."""

SHARE = 0.2
"""Smallest component of a parameter in a direction that is named."""


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Confidence of fitted parameters.

    Attributes
    ----------
    names
        Names of the parameters.
    errors
        (n,) standard errors of the logarithms.
    low, high
        (n,) 95 % intervals of the parameters.
    correlation
        (n, n) correlation of the logarithms.
    undetermined
        Sentences about directions that the data do not determine; empty if there are none.
    """

    names: tuple[str, ...]
    errors: FloatArray
    low: FloatArray
    high: FloatArray
    correlation: FloatArray
    undetermined: tuple[str, ...]


def uncertainty(
    names: Sequence[str], x: FloatArray, jacobian: FloatArray, residuals: FloatArray, *, scaled: bool = False,
    freedom: int | None = None,
) -> Uncertainty:  # fmt: skip
    """Confidence of the logarithms ``x`` of parameters.

    Parameters
    ----------
    names
        Names of the parameters.
    x
        (n,) logarithms at the minimum.
    jacobian
        (m, n) derivatives of the residuals.
    residuals
        (m,) residuals at the minimum.
    scaled
        Whether the residuals are divided by known standard deviations. Their variance then is 1, or that of the
        residuals if it is larger; otherwise that of the residuals, with Student's factor of m - n.
    freedom
        Degrees of freedom in place of m - n, if other unknowns were eliminated.

    Notes
    -----
    The residuals are taken as independent, and the model as linear in x within its errors.
    """
    count = len(x)
    freedom = max(1, len(residuals) - count if freedom is None else freedom)
    variance = float(residuals @ residuals) / freedom
    _, sigma, vectors = np.linalg.svd(jacobian, full_matrices=False)
    sigma = np.maximum(sigma, 1e-12 * max(float(sigma[0]), 1e-300))
    size = np.sqrt(max(1.0, variance) if scaled else variance)
    each = size / sigma
    covariance = (vectors.T * each**2) @ vectors
    errors = np.sqrt(np.diag(covariance))
    factor = float(norm.ppf(0.975) if scaled else student.ppf(0.975, freedom))
    half = np.minimum(factor * errors, 300.0)  # of a logarithm
    safe = np.maximum(errors, 1e-300)
    loose = [_sentence(names, vectors[k], float(each[k])) for k in range(count) if each[k] > LOOSE]
    return Uncertainty(
        tuple(names), errors, np.exp(x - half), np.exp(x + half), covariance / np.outer(safe, safe), tuple(loose)
    )


def _sentence(names: Sequence[str], direction: FloatArray, error: float) -> str:
    """Sentence about a direction: the product of powers that is not determined."""
    direction = direction / direction[np.argmax(np.abs(direction))]
    parts = [(name, float(power)) for name, power in zip(names, direction, strict=True) if abs(power) > SHARE]
    if len(parts) == 1:
        what = parts[0][0]
    else:
        what = "a common change of " + ", ".join(f"{name} (power {power:.2g})" for name, power in parts)
    within = np.exp(min(1.96 * error, 300.0))
    size = f"by a factor of {within:.2g}" if within < 1e4 else "by any factor"
    return f"the data do not determine {what}: {size} at 95 %"
