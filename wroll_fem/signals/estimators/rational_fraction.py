"""Rational fraction fit: poles of a linear structure from its transmissibility.

Complex T: partial fractions with a real residual term for the modes outside the window (constant and f^2),

    T(s) = sum_k [ R_k / (s - p_k) + conj(R_k) / (s - conj(p_k)) ] + d + e s^2,      s = i f / f_ref,

with starting values from vector fitting [1] and a final least-squares fit of T. This is the rational fraction
polynomial of [2] in a well-conditioned basis. f_n = |p| f_ref, zeta = -Re p / |p|.
Only |T|: |T|^2 = (b0 + b1 x + b2 x^2) / ((x - f_n^2)^2 + 4 zeta^2 f_n^2 x), x = f^2, for one mode.

References
----------
[1] B. Gustavsen, A. Semlyen, Rational approximation of frequency domain responses by vector fitting, IEEE Transactions
on Power Delivery 14 (1999) 1052-1061, doi:10.1109/61.772353.
[2] M. H. Richardson, D. L. Formenti, Parameter estimation from frequency response measurements using rational fraction
polynomials, 1st International Modal Analysis Conference (1982) 167-181.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from wroll_fem.errors import InputError
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.estimators.estimate import DampingEstimate, checked_curve, no_estimate
from wroll_fem.typing import ComplexArray, FloatArray

METHOD = "rational fraction"
LEVEL = 0.3
"""Default |T|, relative to the peak, down to which the window of the fit extends."""
MOST_MODES = 2
"""Largest number of modes tried automatically."""
_EXACT = 1e-9  # misfit at rounding level
_GAIN = 0.6  # largest ratio of the misfits with and without a further mode for which that mode is accepted


def rational_fraction(
    frequency: npt.ArrayLike,
    transmissibility: npt.ArrayLike,
    *,
    modes: int | None = None,
    level: float = LEVEL,
) -> DampingEstimate:
    """Natural frequency and damping ratio of the mode that dominates the highest peak of a linear structure.

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz, ascending.
    transmissibility
        (n,) complex T, or |T|, which allows a single mode only.
    modes
        Number of modes in the window. None tries one and two. Two are accepted if their misfit is below 0.6 times the
        misfit with one mode and both natural frequencies lie inside the window.
    level
        The window extends on both sides to the last point at which |T| exceeds `level` times the peak.

    Returns
    -------
    DampingEstimate
        `details`: `modes`; `f_n_all`, `zeta_all` (all modes, by ascending frequency); `frequency` (frequencies in the
        window); `fit` (fitted values there); `largest_misfit` (largest distance between fit and curve, divided by the
        peak).

    Raises
    ------
    InputError
        If the arrays do not form a curve, `level` is outside 0 to 1, or several modes are requested for |T| alone.

    Notes
    -----
    The standard errors follow from the residual of the fit, assumed to be white. There is no estimate from fewer than
    three values per unknown, nor of a mode outside the band. For a nonlinear structure the poles are those of the
    nearest linear curve; check `misfit`.
    """
    if not 0.0 < level < 1.0:
        raise InputError(f"level must lie between 0 and 1, got {level}", remedy="give a fraction of the peak")
    if modes is not None and modes < 1:
        raise InputError(f"the number of modes must be positive, got {modes}", remedy="use 1 or more")
    f, values, magnitude = checked_curve(frequency, transmissibility)
    band = float(f[0]), float(f[-1])
    if values is None and modes is not None and modes > 1:
        raise InputError("|T| is not enough to fit several modes", remedy="give the complex transmissibility")
    read = half_power(f, magnitude)
    window = np.flatnonzero(magnitude > level * magnitude.max())
    window = np.arange(window[0], window[-1] + 1)
    f, top = f[window], read.peak
    if values is None:
        return _within(band, _magnitude_fit(f, magnitude[window], read.f_n, read.zeta))
    T, best = values[window], no_estimate(METHOD, "no fit", read.f_n)
    for count in (modes,) if modes is not None else range(1, MOST_MODES + 1):
        if 2 * f.size < 3 * (4 * count + 2):
            short = f"{f.size} points above {level:g} of the peak are too few for {count} modes"
            return _within(band, best) if best.found else no_estimate(METHOD, short, read.f_n)
        found = _complex_fit(f, T, count, read.f_n, top)
        if not best.found or (found.found and found.misfit < _GAIN * best.misfit and _inside(found, f)):
            best = found
        if best.found and best.misfit < _EXACT:
            break
    return _within(band, best)


def _within(band: tuple[float, float], estimate: DampingEstimate) -> DampingEstimate:
    """Unchanged estimate if its natural frequency lies inside the band; otherwise a result without damping ratio."""
    if not estimate.found or band[0] <= estimate.f_n <= band[1]:
        return estimate
    return no_estimate(METHOD, f"the fitted mode, {estimate.f_n:.5g} Hz, lies outside the band")


def _inside(estimate: DampingEstimate, f: FloatArray) -> bool:
    every = np.asarray((estimate.details or {})["f_n_all"])
    return bool(np.all((every > f[0]) & (every < f[-1])))


def _basis(s: ComplexArray, poles: ComplexArray) -> ComplexArray:
    """(n, 2 k) basis functions of k poles at n points ``s``; coefficients: real and imaginary parts of the residues."""
    first, second = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    return np.stack([first + second, 1j * (first - second)], axis=2).reshape(s.size, -1)


def _solve(columns: ComplexArray, right: ComplexArray) -> FloatArray:
    """Real least-squares solution of complex linear equations; the columns are scaled.

    Raises
    ------
    LinAlgError
        If an entry is not finite, because a pole lies on a frequency or a column is zero, or nothing converges.
    """
    A, b = np.vstack([columns.real, columns.imag]), np.concatenate([right.real, right.imag])
    scale = np.linalg.norm(A, axis=0)
    if not (np.isfinite(A).all() and np.isfinite(b).all() and scale.all()):
        raise np.linalg.LinAlgError("the equations of the fit are not finite")  # LAPACK may end in a SystemError
    return np.linalg.lstsq(A / scale, b, rcond=None)[0] / scale


def _vector_fit(s: ComplexArray, T: ComplexArray, poles: ComplexArray, iterations: int = 20) -> ComplexArray:
    """(k,) poles by vector fitting from k starting ``poles``; imaginary parts positive, unstable poles mirrored."""
    background = np.stack([np.ones_like(s), s**2], axis=1)
    for _ in range(iterations):
        basis = _basis(s, poles)
        x = _solve(np.hstack([basis, background, -T[:, None] * basis]), T)[-2 * poles.size :]
        blocks = [np.array([[p.real, p.imag], [-p.imag, p.real]]) for p in poles]
        A = block_diag(*blocks) - np.outer(np.tile([2.0, 0.0], poles.size), x)
        roots = np.linalg.eigvals(A)
        upper = roots[roots.imag > 0.0]
        real = np.sort(roots[roots.imag == 0.0].real)
        pairs = [complex(0.5 * (a + b), 0.5 * (b - a) + 1e-3) for a, b in zip(real[::2], real[1::2], strict=True)]
        new = np.concatenate([upper, np.array(pairs, dtype=complex)])
        new = -np.abs(new.real) + 1j * new.imag
        new = new[np.argsort(new.imag)]
        done = bool(np.abs(new - poles).max() < 1e-12)
        poles = new
        if done:
            break
    return poles


def _complex_fit(f: FloatArray, T: ComplexArray, count: int, f_pk: float, peak: float) -> DampingEstimate:
    s = 1j * f / f_pk
    width = (f[-1] - f[0]) / f_pk
    start = np.array([f_pk]) if count == 1 else np.linspace(f[0], f[-1], count + 2)[1:-1]
    try:
        poles = _vector_fit(s, T, start / f_pk * 1j - max(0.02 * width, 1e-4))
        x = _solve(np.hstack([_basis(s, poles), np.stack([np.ones_like(s), s**2], axis=1)]), T)
        whole = least_squares(
            lambda q: _split(_model(q, s, count) - T), np.concatenate([_split(poles), x]),
            lambda q: _jacobian(q, s, count), method="lm", xtol=1e-14, ftol=1e-14, x_scale="jac",
        )  # fmt: skip
    except np.linalg.LinAlgError:
        return no_estimate(METHOD, f"no fit of {count} modes converged", f_pk)
    q = whole.x
    poles = q[:count] + 1j * q[count : 2 * count]
    size, zeta = np.abs(poles), -poles.real / np.abs(poles)
    if np.any(zeta <= 0.0) or np.any(zeta >= 1.0) or not np.isfinite(q).all():
        return no_estimate(
            METHOD, f"the fit of {count} modes has a mode whose damping ratio is not between 0 and 1", f_pk
        )
    fitted = _model(q, s, count)
    residual = np.abs(fitted - T)
    misfit = sqrt(float(np.mean(residual**2))) / peak
    J = whole.jac
    scale = np.linalg.norm(J, axis=0)
    inverse = np.linalg.pinv((J / scale).T @ (J / scale)) / np.outer(scale, scale)
    covariance = float(residual @ residual) / max(1, 2 * f.size - q.size) * inverse
    order = np.argsort(size)
    residues = np.hypot(q[2 * count : 4 * count : 2], q[2 * count + 1 : 4 * count : 2])
    near = np.abs(1j - poles)  # distance of each pole from the frequency of the peak
    k = int(np.argmax(residues / near))  # mode with the largest contribution at the peak
    pair = np.ix_([k, count + k], [k, count + k])
    to_size = np.array([poles[k].real, poles[k].imag]) / size[k]
    to_zeta = np.array([-(poles[k].imag ** 2), poles[k].real * poles[k].imag]) / size[k] ** 3
    return DampingEstimate(
        float(size[k] * f_pk), float(zeta[k]),
        f_pk * sqrt(max(0.0, to_size @ covariance[pair] @ to_size)),
        sqrt(max(0.0, to_zeta @ covariance[pair] @ to_zeta)), METHOD, misfit=misfit, window=(float(f[0]), float(f[-1])),
        details={
            "modes": count, "f_n_all": (size[order] * f_pk).tolist(), "zeta_all": zeta[order].tolist(),
            "fit": fitted, "frequency": f, "largest_misfit": float(residual.max()) / peak,
        },
    )  # fmt: skip


def _split(values: ComplexArray) -> FloatArray:
    return np.concatenate([values.real, values.imag])


def _model(q: FloatArray, s: ComplexArray, count: int) -> ComplexArray:
    """(n,) fitted transmissibility at the n points s = i f / f_ref, for the fit parameters q.

    q contains Re p and Im p of all poles p, Re R and Im R of the residue R of each mode, and the coefficients d and e
    of the residual term (docstring of the module).
    """
    poles = q[:count] + 1j * q[count : 2 * count]
    return np.asarray(_basis(s, poles) @ q[2 * count : 4 * count] + q[-2] + q[-1] * s**2)


def _jacobian(q: FloatArray, s: ComplexArray, count: int) -> FloatArray:
    poles = q[:count] + 1j * q[count : 2 * count]
    residues = q[2 * count : 4 * count : 2] + 1j * q[2 * count + 1 : 4 * count : 2]
    first = residues / (s[:, None] - poles) ** 2
    second = residues.conj() / (s[:, None] - poles.conj()) ** 2
    columns = [first + second, 1j * (first - second), _basis(s, poles), np.ones((s.size, 1)), (s**2)[:, None]]
    whole = np.hstack(columns)
    return np.vstack([whole.real, whole.imag])


def _magnitude_fit(f: FloatArray, magnitude: FloatArray, f_pk: float, zeta: float) -> DampingEstimate:
    """Fit of one mode to |T|. The residual (fitted |T|^2 - |T|^2) / (2 |T|) is, to first order, fitted |T| - |T|."""
    if f.size < 3 * 5:
        return no_estimate(METHOD, f"{f.size} points around the peak are too few", f_pk)
    x, peak = (f / f_pk) ** 2, float(magnitude.max())
    square, weight = (magnitude / peak) ** 2, 0.5 * peak / np.maximum(magnitude, 0.01 * peak)
    powers = np.stack([np.ones_like(x), x, x**2], axis=1)

    def denominator(q: FloatArray) -> FloatArray:
        return (x - q[0] ** 2) ** 2 + 4.0 * q[1] ** 2 * q[0] ** 2 * x

    def residual(q: FloatArray) -> FloatArray:
        return weight * (powers @ q[2:] / denominator(q) - square)

    def jacobian(q: FloatArray) -> FloatArray:
        below = denominator(q)
        slope = -(powers @ q[2:]) / below**2
        to_f = slope * (-4.0 * q[0] * (x - q[0] ** 2) + 8.0 * q[1] ** 2 * q[0] * x)
        to_zeta = slope * 8.0 * q[1] * q[0] ** 2 * x
        return weight[:, None] * np.column_stack([to_f, to_zeta, powers / below[:, None]])

    best, least = None, inf
    guess = zeta if np.isfinite(zeta) else 0.3
    for first in (guess, 0.7 * guess, 0.5):
        first = min(first, 0.7)
        f_0 = 1.0 / sqrt(2.0 / (sqrt(1.0 + 8.0 * first**2) + 1.0))
        start = np.array([f_0, first, 0.0, 0.0, 0.0])
        below = denominator(start)
        start[2:] = np.linalg.lstsq(weight[:, None] * powers / below[:, None], weight * square, rcond=None)[0]
        tried = least_squares(residual, start, jacobian, method="lm", xtol=1e-14, ftol=1e-14, x_scale="jac")
        if tried.cost < least:
            best, least = tried, float(tried.cost)
    if best is None:
        return no_estimate(METHOD, "no fit converged", f_pk)
    q, J = best.x, best.jac
    ratio, found = abs(q[0]), abs(q[1])
    if not 0.0 < found < 1.0:
        return no_estimate(METHOD, "the fit is not a damped vibration", f_pk)
    scale = np.linalg.norm(J, axis=0)
    inverse = np.linalg.pinv((J / scale).T @ (J / scale)) / np.outer(scale, scale)
    covariance = 2.0 * least / (f.size - q.size) * inverse
    fitted = peak * np.sqrt(np.maximum(0.0, powers @ q[2:] / denominator(q)))
    return DampingEstimate(
        ratio * f_pk, found, f_pk * sqrt(covariance[0, 0]), sqrt(covariance[1, 1]), METHOD,
        misfit=float(np.linalg.norm(fitted - magnitude)) / sqrt(f.size) / peak, window=(float(f[0]), float(f[-1])),
        details={"modes": 1, "f_n_all": [ratio * f_pk], "zeta_all": [found], "fit": fitted, "frequency": f,
            "largest_misfit": float(np.abs(fitted - magnitude).max()) / peak},
    )  # fmt: skip
