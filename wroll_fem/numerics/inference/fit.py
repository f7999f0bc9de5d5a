r"""Least squares with confidence: covariance from the Jacobian, correlated noise, parameters that are not identifiable.

With the residuals r = y - f(x) and their Jacobian J, both filtered by the noise model,

.. math:: \operatorname{Cov}(x) = s^2 (J^T J)^{-1}, \qquad s^2 = \frac{r^T r}{n - p}

and x_i lies within t_{n-p} standard errors. Noise model and parameters are estimated in turn until both stay the same
(generalised least squares).

References
----------
.. [1] Seber, Wild (2003), Nonlinear Regression, sections 5.1 (intervals) and 6.2 (autocorrelated errors),
   doi:10.1002/0471725315.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from wroll_fem.errors import InputError
from wroll_fem.numerics.inference.estimate import Estimate
from wroll_fem.numerics.inference.noise import NoiseModel, noise_model, stays_correlated
from wroll_fem.typing import FloatArray

Model = Callable[[FloatArray], FloatArray]

ROUNDS = 12
"""Most turns of noise model and parameters."""

SAME = 1e-3
"""Change of the noise coefficients at which the turns end."""

EVALUATIONS = 100
"""Most evaluations of a model in a turn, per parameter and one."""

LARGEST = 300.0
"""Largest magnitude of a logarithm; exp does not overflow."""

FLAT = 1e-7
"""Singular value of the scaled Jacobian, relative to the largest, below which the data do not determine a direction."""

EXACT = 1e-7
"""Standard deviation of the residuals, relative to that of the data, below which a fit is exact."""

WIDE = 1.0
"""Standard error of the logarithm of a positive parameter above which it is not identifiable."""


@dataclass(frozen=True)
class Fit:
    """Fitted parameters.

    Attributes
    ----------
    names
        Names of the parameters, (p,).
    x
        (p,) fitted values; the logarithm of those in `positive`.
    covariance
        (p, p) covariance of x.
    positive
        Names of the parameters that are fitted by their logarithm.
    residuals
        (n,) data minus model.
    lengths
        Number of residuals of each series.
    noise
        Model of the noise.
    noise_level
        Standard deviation of the noise, with its correlation, in the unit of the data.
    freedom
        Degrees of freedom of the covariance.
    unidentified
        Names of the parameters that the data do not determine.
    correlated
        Whether correlation remains that the noise model does not describe: then the intervals may be too narrow.
    """

    names: tuple[str, ...]
    x: FloatArray
    covariance: FloatArray
    positive: frozenset[str]
    residuals: FloatArray
    lengths: tuple[int, ...]
    noise: NoiseModel
    noise_level: float
    freedom: float
    unidentified: tuple[str, ...]
    correlated: bool

    def __getitem__(self, name: str) -> Estimate:
        """Estimate of a parameter."""
        k = self.names.index(name)
        logarithmic = name in self.positive
        value = float(np.exp(self.x[k]) if logarithmic else self.x[k])
        error = float(np.sqrt(self.covariance[k, k])) if name not in self.unidentified else np.inf
        return Estimate(value, error, self.freedom, logarithmic)

    def predicted(self, gradient: FloatArray, value: float) -> Estimate:
        """Estimate of a function of the parameters with the given value and gradient (p,) with respect to x."""
        return Estimate(value, float(np.sqrt(np.maximum(0.0, gradient @ self.covariance @ gradient))), self.freedom)

    def criterion(self, noise: NoiseModel | None = None) -> float:
        """Akaike's information criterion with its correction for short records, with this noise or another one."""
        model = self.noise if noise is None else noise
        white = model.whiten(self.residuals, self.lengths)
        n, k = len(white), len(self.x) + 1
        return float(n * np.log(np.mean(white**2) + 1e-300) + 2.0 * k + 2.0 * k * (k + 1.0) / max(1.0, n - k - 1.0))


def fit(
    model: Model,
    data: FloatArray,
    start: dict[str, float],
    *,
    lengths: Sequence[int] | None = None,
    positive: Sequence[str] = (),
    scales: dict[str, float] | None = None,
    correlated: bool = True,
    solve: bool = True,
) -> Fit:
    """Fit the parameters of a model to data with noise of unknown level.

    Parameters
    ----------
    model
        Values (n,) of the model at parameters (p,), in the order of ``start``.
    data
        (n,) measured values, in order of time within each series.
    start
        Parameters and their starting values.
    lengths
        Number of values of each series; one series by default.
    positive
        Parameters that are fitted by their logarithm; their intervals are symmetric on a logarithmic axis.
    scales
        Usual size of parameters that are not in ``positive``; by default the starting value.
    correlated
        Whether correlation of the noise is estimated; False if the values are in no order of time.
    solve
        Whether the parameters are fitted; False for the confidence at the starting values alone.

    Raises
    ------
    InputError
        If there are not more values than parameters.
    """
    names, logs = tuple(start), frozenset(positive)
    counts = tuple(lengths) if lengths is not None else (len(data),)
    if len(data) <= len(names):
        raise InputError(
            f"{len(data)} values do not determine {len(names)} parameters", remedy="give a longer record, or fit less"
        )
    chosen = scales or {}
    unit = np.array([1.0 if n in logs else chosen.get(n) or abs(start[n]) or 1.0 for n in names])
    mask = np.array([name in logs for name in names])
    x = np.array([np.log(start[n]) if n in logs else start[n] for n in names])

    def residuals(z: FloatArray) -> FloatArray:
        values = z * unit
        return data - model(np.where(mask, np.exp(np.where(mask, np.clip(values, -LARGEST, LARGEST), 0.0)), values))

    noise, z = NoiseModel(), x / unit
    for _ in range(ROUNDS):
        used = noise
        if solve:
            z = _solved(lambda v: used.whiten(residuals(v), counts), z)  # noqa: B023
        if np.std(residuals(z)) <= EXACT * np.std(data):
            break  # correlation of rounding errors means nothing
        noise = noise_model(residuals(z), counts, fitted=len(names)) if correlated else used
        if _same(noise, used):
            break
    jacobian = _jacobian(lambda v: used.whiten(residuals(v), counts), z)
    return _read(names, z, unit, logs, residuals(z), counts, used, jacobian, float(np.std(data)))


def linear_fit(
    columns: dict[str, FloatArray],
    data: FloatArray,
    *,
    lengths: Sequence[int] | None = None,
    weights: FloatArray | None = None,
    instruments: dict[str, FloatArray] | None = None,
    correlated: bool = True,
) -> Fit:
    """Fit the coefficients of given columns (n,) to data (n,).

    Parameters
    ----------
    columns
        Parameter -> the column that it multiplies.
    data
        (n,) measured values, in order of time within each series.
    lengths
        Number of values of each series; one series by default.
    weights
        (n,) factors of the residuals: reciprocals of the standard deviations of the data, up to a common factor.
    instruments
        As many columns without noise, such as time, that vary with the measured ones: the residuals are orthogonal to
        them. Noise in ``columns``, which otherwise lowers a slope, then does not matter.
    correlated
        Whether correlation of the noise is estimated; False if the values are in no order of time.

    Raises
    ------
    InputError
        If there are not more values than columns.
    """
    names, counts = tuple(columns), tuple(lengths) if lengths is not None else (len(data),)
    if len(data) <= len(names):
        raise InputError(
            f"{len(data)} values do not determine {len(names)} parameters", remedy="give a longer record, or fit less"
        )
    matrix = np.column_stack(list(columns.values()))
    other = matrix if instruments is None else np.column_stack(list(instruments.values()))
    if weights is not None:
        matrix, other, data = weights[:, None] * matrix, weights[:, None] * other, weights * data
    unit = 1.0 / np.maximum(np.linalg.norm(matrix, axis=0), np.finfo(float).tiny)
    scaled, noise = matrix * unit, NoiseModel()
    for _ in range(ROUNDS):
        used = noise
        white = used.whiten(scaled, counts)
        if instruments is not None:  # columns as the instruments explain them: two-stage least squares
            basis = used.whiten(other, counts)
            white = basis @ np.linalg.lstsq(basis, white, rcond=None)[0]
        z = np.linalg.lstsq(white, used.whiten(data, counts), rcond=None)[0]
        if np.std(data - scaled @ z) <= EXACT * np.std(data):
            break
        noise = noise_model(data - scaled @ z, counts, fitted=len(names)) if correlated else used
        if _same(noise, used):
            break
    return _read(names, z, unit, frozenset(), data - scaled @ z, counts, used, -white, float(np.std(data)))


def _solved(residuals: Model, start: FloatArray) -> FloatArray:
    most = EVALUATIONS * (len(start) + 1)
    return np.asarray(least_squares(residuals, start, method="lm", xtol=1e-10, ftol=1e-12, max_nfev=most).x)


def _same(one: NoiseModel, other: NoiseModel) -> bool:
    return one.order == other.order and bool(np.allclose(one.coefficients, other.coefficients, rtol=0.0, atol=SAME))


def _jacobian(function: Model, z: FloatArray) -> FloatArray:
    """Central differences (n, p)."""
    steps = 1e-5 * np.maximum(1.0, np.abs(z))
    columns = []
    for k, step in enumerate(steps):
        shift = np.zeros(len(z))
        shift[k] = step
        columns.append((function(z + shift) - function(z - shift)) / (2.0 * step))
    return np.column_stack(columns)


def _read(
    names: tuple[str, ...], z: FloatArray, unit: FloatArray, logs: frozenset[str], residuals: FloatArray,
    lengths: tuple[int, ...], noise: NoiseModel, jacobian: FloatArray, size: float,
) -> Fit:  # fmt: skip
    """Result of a fit from its last residuals and their filtered Jacobian with respect to the scaled parameters z.

    Residuals of rounding errors, far below the ``size`` of the data, are not tested for correlation.
    """
    white = noise.whiten(residuals, lengths)
    freedom = max(1, len(white) - len(names))
    variance = float(white @ white) / freedom
    norms = np.linalg.norm(jacobian, axis=0)
    norms = np.where(norms > FLAT * norms.max(), norms, np.inf)  # a parameter without effect has a column of zeros
    _, sizes, directions = np.linalg.svd(jacobian / norms, full_matrices=False)
    kept = sizes > FLAT * sizes[0]
    lost = np.sum(directions[~kept] ** 2, axis=0) > 1e-2
    inverse = np.where(kept, 1.0 / np.where(kept, sizes, 1.0) ** 2, 0.0)
    covariance = variance * ((directions.T * inverse) @ directions) / np.outer(norms, norms)
    spread = np.sqrt(np.diag(covariance))
    wide = np.array([name in logs and spread[k] > WIDE for k, name in enumerate(names)])
    unknown = tuple(name for name, flag in zip(names, lost | wide, strict=True) if flag)
    shorter = tuple(length - noise.order for length in lengths)
    return Fit(
        names, z * unit, covariance * np.outer(unit, unit), logs, residuals, lengths, noise,
        float(np.std(residuals)), float(freedom), unknown,
        bool(np.std(residuals) > EXACT * size) and stays_correlated(white, shorter, noise.order),
    )  # fmt: skip
