"""Damping by half power or by a fit, depending on prominence and symmetry of the peak (thesis, appendix D)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.estimators.estimate import DampingEstimate, checked_curve, noise_level
from wroll_fem.signals.estimators.gaussian import gaussian_fit
from wroll_fem.signals.estimators.half_power import half_power_estimate
from wroll_fem.signals.estimators.rational_fraction import rational_fraction

PROMINENCE, SYMMETRY, MISFIT = 0.5, 0.5, 0.1
"""Thresholds of `choose` for prominence and symmetry of the peak and misfit of the fit; the thesis gives no values."""

Alternative = Literal["gaussian", "rational_fraction"]


@dataclass(frozen=True)
class CurveShape:
    """Shape of the highest peak of a curve.

    Attributes
    ----------
    prominence
        Relative height of the peak above its higher foot (the lowest point on one side within the band), 0 to 1.
    symmetry
        Ratio of the smaller to the larger distance between the peak and its half-power points, 0 to 1; 0 if one of them
        is missing.
    """

    prominence: float
    symmetry: float


def curve_shape(frequency: npt.ArrayLike, transmissibility: npt.ArrayLike) -> CurveShape:
    """Prominence and symmetry of the highest peak of a curve.

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz, ascending.
    transmissibility
        (n,) complex T, or |T|.

    Raises
    ------
    InputError
        If the arrays do not form a curve.

    Notes
    -----
    The curve of a single degree of freedom from 0 Hz has a prominence of 1 - 1 / T_pk, for example 0.5 at a peak of 2
    (damping ratio 0.30). In a band that starts close to the peak the prominence is smaller.
    """
    f, _, magnitude = checked_curve(frequency, transmissibility)
    read = half_power(f, magnitude)
    k = int(np.argmax(magnitude))
    base = max(magnitude[: k + 1].min(), magnitude[k:].min())
    symmetry = 0.0
    if read.complete:
        low, high = read.f_n - read.f_low, read.f_high - read.f_n
        symmetry = min(low, high) / max(low, high)
    return CurveShape(float(1.0 - base / magnitude[k]), float(symmetry))


def choose(
    frequency: npt.ArrayLike,
    transmissibility: npt.ArrayLike,
    *,
    otherwise: Alternative = "rational_fraction",
    prominence: float = PROMINENCE,
    symmetry: float = SYMMETRY,
    fits: Mapping[str, DampingEstimate] | None = None,
) -> DampingEstimate:
    """Damping from half power if the peak is prominent and symmetric, otherwise from a fit (thesis, algorithm 1).

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz, ascending.
    transmissibility
        (n,) complex T, or |T|.
    otherwise
        Method of the fit. "gaussian" is the algorithm of the thesis as printed. "rational_fraction" (default) is exact
        for a linear structure. If its largest misfit exceeds a tenth of the peak plus five times the noise, as on a
        strongly skewed curve, it is replaced by a Gaussian fit with free centre and narrowest window.
    prominence, symmetry
        Thresholds, 0 to 1; the thesis does not specify them. With 0.5, the peak is at least twice as high as its feet
        and neither side is more than twice as wide as the other (skewness -0.5 to 1).
    fits
        Estimates of `ESTIMATORS` for this curve that are known already, by name; they are not computed again.

    Returns
    -------
    DampingEstimate
        `reason` gives prominence and symmetry and the resulting choice.

    Raises
    ------
    InputError
        If the arrays do not form a curve, a threshold is outside 0 to 1, or `otherwise` is unknown.

    Notes
    -----
    Two modes closer than a half-power width form one peak that passes both tests; half power then gives one damping
    ratio for both. `rational_fraction` separates them.
    """
    for name, value in (("prominence", prominence), ("symmetry", symmetry)):
        if not 0.0 <= value <= 1.0:
            raise InputError(
                f"the threshold {name} must lie between 0 and 1, got {value}", remedy="use for example 0.5"
            )
    if otherwise not in ("gaussian", "rational_fraction"):
        raise InputError(f"unknown estimator {otherwise!r}", remedy="use gaussian or rational_fraction")
    f, values, magnitude = checked_curve(frequency, transmissibility)
    shape = curve_shape(f, magnitude)
    shape_text = (
        f"prominence {shape.prominence:.2f} (threshold {prominence:g}), symmetry {shape.symmetry:.2f} ({symmetry:g})"
    )
    if shape.prominence > prominence and shape.symmetry > symmetry:
        return _because(half_power_estimate(f, magnitude), shape_text)
    if otherwise == "gaussian":
        return _because(gaussian_fit(f, magnitude), shape_text)
    known = {} if fits is None else fits
    fitted = known.get("rational_fraction") or rational_fraction(f, magnitude if values is None else values)
    if not fitted.found:
        why = fitted.reason
    else:
        largest = float((fitted.details or {})["largest_misfit"])
        if largest <= MISFIT + 5.0 * noise_level(f, magnitude) / float(magnitude.max()):
            return _because(fitted, shape_text)
        why = f"its largest misfit is {largest:.0%} of the peak"
    bell = known.get("gaussian_fit") or gaussian_fit(f, magnitude, centre="free", window="narrowest")
    return _because(bell, f"{shape_text}; rational fraction rejected: {why}")


def _because(estimate: DampingEstimate, why: str) -> DampingEstimate:
    return replace(estimate, reason=f"{why}; {estimate.reason}" if estimate.reason else why)
