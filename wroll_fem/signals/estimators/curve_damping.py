"""Damping and half-power points of a transmissibility curve, by the estimator that a case names (`output.damping`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import hypot, isfinite, nan
from typing import Any

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.signals.damping import HalfPower, half_power
from wroll_fem.signals.estimators.choice import choose
from wroll_fem.signals.estimators.estimate import DampingEstimate, no_estimate
from wroll_fem.signals.estimators.gaussian import gaussian_fit
from wroll_fem.signals.estimators.half_power import METHOD as HALF_POWER
from wroll_fem.signals.estimators.half_power import half_power_estimate
from wroll_fem.signals.estimators.rational_fraction import rational_fraction
from wroll_fem.signals.estimators.single_dof import lower_bound

Estimator = Callable[..., DampingEstimate]

ESTIMATORS: dict[str, Estimator] = {
    "half_power": half_power_estimate,
    "gaussian_fit": partial(gaussian_fit, centre="free", window="narrowest"),
    "rational_fraction": rational_fraction,
    "choose": choose,
}
"""Estimator for each value of `output.damping`. The Gaussian fit uses the narrowest window that its half-power
constraint allows, so that the result does not depend on the frequency band of the curve."""

FEWEST_POINTS = 8
"""Smallest number of points for an estimator with error bars; half power without error bars needs five."""

LEAST_QUADRATURE = 0.2
"""Smallest |Im T| / |T| at which the highest point counts as a resonance. At the peak of a system with one degree of
freedom this ratio is 0.27 for a damping ratio of 1, and 0.85 for a damping ratio of 0.2. Away from resonances the
response is in phase or in antiphase with the base, and maxima are ripples."""

LARGEST_RIPPLE = 10.0
"""|T| above which the highest point counts as a resonance whatever its phase, because the ringing after a sweep through
a sharp resonance can have any phase. Without damping, |T| exceeds this value only within 5 % of f_n."""

LOOSE_FIT = 0.05
"""Root mean square misfit, relative to the peak, above which the fitted model does not describe the curve.
A known noise of the curve is added, times 1.5, as squares."""


@dataclass(frozen=True)
class CurveDamping:
    """Damping estimate of one curve.

    Attributes
    ----------
    shape
        Peak, half-power points and skewness; the same for every method.
    damping
        Frequency and damping ratio by the chosen method, with error bars.
    noise
        Standard deviation of |T| at the peak, relative to it, if the curve has a known noise.
    """

    shape: HalfPower
    damping: DampingEstimate
    noise: float = 0.0

    def as_attrs(self, curve: str) -> dict[str, Any]:
        """Values as attributes of a Dataset, named as in summary.json; uncertainties only where they were estimated.

        Parameters
        ----------
        curve
            Description of the curve, which is added to the name of the method.
        """
        found = self.damping
        attrs: dict[str, Any] = self.shape.as_attrs()
        if found.method != HALF_POWER:
            attrs |= {"f_n_hz": found.f_n, "zeta": found.zeta}
        attrs["zeta_method"] = f"{found.method}, {curve}"
        errors = {
            "f_n_error_hz": found.f_n_error, "zeta_error": found.zeta_error,
            "zeta_lower_bound": lower_bound(found), "zeta_misfit": found.misfit,
        }  # fmt: skip
        attrs |= {name: value for name, value in errors.items() if isfinite(value)}
        if found.method != HALF_POWER and found.reason:
            attrs["zeta_reason"] = found.reason
        return attrs

    @property
    def warnings(self) -> list[str]:
        """Warnings about a missing or doubtful damping ratio; empty if there are none."""
        found, shape = self.damping, self.shape
        if found.method == HALF_POWER:
            return [text for text in ("" if shape.complete else shape.reason, shape.note) if text]
        if not found.found:
            return [f"{found.method} gives no damping: {found.reason}"]
        if found.misfit > hypot(LOOSE_FIT, 1.5 * self.noise):
            return [
                f"the misfit of the {found.method} is {100 * found.misfit:.0f} % of the peak (zeta_misfit): this is "
                "not the curve of one linear mode, and zeta depends on the method; compare with output.damping: "
                "half_power"
            ]
        return []


def estimate_damping(
    frequency: npt.ArrayLike,
    transmissibility: npt.ArrayLike,
    method: str = "half_power",
    *,
    noise: float | None = None,
) -> CurveDamping:
    """Estimate frequency and damping of the highest peak of a transmissibility curve.

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz, ascending (or rad/s; all frequencies of the result then are in rad/s).
    transmissibility
        (n,) complex T, or |T|.
    method
        One of the keys of `ESTIMATORS`.
    noise
        Standard deviation of |T| for the error bars of half power and the Gaussian fit, if it is known, as on a
        computed curve. By default it is estimated from the curve.

    Returns
    -------
    CurveDamping
        If there is no damping ratio, zeta is nan, `damping.reason` gives the cause, and f_n is that of the highest
        point. If that point is no resonance (`shape.resonant`), f_n is nan as well.

    Raises
    ------
    InputError
        If the arrays do not form a curve, or the method is unknown.
    """
    if method not in ESTIMATORS:
        raise InputError(f"unknown estimator {method!r}", remedy=f"use one of: {', '.join(ESTIMATORS)}")
    f, values = np.asarray(frequency, dtype=np.float64), np.asarray(transmissibility)
    shape = half_power(f, np.hypot(values.real, values.imag))
    if f.size >= FEWEST_POINTS:
        known = {"noise": noise} if noise is not None and method in ("half_power", "gaussian_fit") else {}
        found = ESTIMATORS[method](f, values, **known)
    elif method in ("half_power", "choose"):
        found = DampingEstimate(shape.f_n, shape.zeta, nan, nan, HALF_POWER, shape.reason or shape.note)
    else:
        found = no_estimate(
            method.replace("_", " "), f"{f.size} points are too few; at least {FEWEST_POINTS} are needed"
        )
    if shape.resonant and np.iscomplexobj(values):
        shape = _in_quadrature(shape, f, values)
    if not shape.resonant:
        return CurveDamping(shape, no_estimate(found.method, shape.reason if found.found else found.reason))
    if not isfinite(found.f_n):
        found = replace(found, f_n=shape.f_n)
    return CurveDamping(shape, found)


def without_half_power_points(read: CurveDamping, frequency: npt.ArrayLike, response: npt.ArrayLike) -> CurveDamping:
    """Estimate by the rational fraction if a resonance has no half-power points, and this fit is close.

    The foot of a peak with a damping ratio above some 15 % may lie above the half-power level. For steady curves: a
    sweep that is too fast loses its half-power points too, and its damping with them.

    Parameters
    ----------
    read
        Estimate by half power.
    frequency, response
        (n,) frequencies, Hz, ascending, and complex T.
    """
    if read.shape.complete or not read.shape.resonant:
        return read
    other = estimate_damping(frequency, response, "rational_fraction")
    if not other.damping.found or other.damping.misfit > LOOSE_FIT:
        return read
    return replace(other, damping=replace(other.damping, reason=f"{read.shape.reason}; read by the rational fraction"))


def _in_quadrature(shape: HalfPower, f: npt.NDArray[np.float64], values: npt.NDArray[Any]) -> HalfPower:
    """Return `shape`, marked as no resonance if the highest point is about in phase or in antiphase with the base.

    A highest point with |T| above `LARGEST_RIPPLE` always counts as a resonance.
    """
    at = values[int(np.argmin(np.abs(f - shape.f_n)))]
    if abs(at.imag) >= LEAST_QUADRATURE * abs(at) or abs(at) > LARGEST_RIPPLE:
        return shape
    return shape.without_resonance(
        f"the highest point, at {shape.f_n:.5g} Hz, has a phase of {np.degrees(np.angle(at)):.0f} degrees instead of "
        "about -90: no resonance inside"
    )
