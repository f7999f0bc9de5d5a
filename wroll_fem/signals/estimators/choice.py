"""Which estimator a curve asks for: prominence and symmetry of its peak (thesis, appendix D, algorithm 1)."""

from __future__ import annotations

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
"""Thresholds that the source leaves open; see `choose`."""

Alternative = Literal["gaussian", "rational_fraction"]


@dataclass(frozen=True)
class CurveShape:
    """How well a peak stands out.

    Attributes
    ----------
    prominence
        Height of the peak above the higher of the lowest points on either side inside the band, over the peak: 0 to 1.
    symmetry
        Smaller over larger of the distances from the peak to its half-power points: 0 to 1; 0 when one is missing.
    """

    prominence: float
    symmetry: float


def curve_shape(frequency: npt.ArrayLike, transmissibility: npt.ArrayLike) -> CurveShape:
    """Prominence and symmetry of the highest peak.

    Notes
    -----
    A single degree of freedom seen from rest on has a prominence of 1 - 1 / T_pk: 0.5 at a peak of 2, which is a
    damping ratio of 0.30. A band that starts close to the peak shows less of it.
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
) -> DampingEstimate:
    """Half power where the peak is prominent and symmetric, a fit where it is not (thesis, algorithm 1).

    Parameters
    ----------
    frequency
        (n,) rising, Hz.
    transmissibility
        (n,) complex T, or |T|.
    otherwise
        What to fit: "gaussian" is the source's algorithm as printed; "rational_fraction" (default) is exact for a
        linear structure, and a Gaussian fit (centre free, narrowest window) takes its place where it misses the curve
        by more than a tenth of the peak (and five times the noise) anywhere, as on a leaning curve.
    prominence, symmetry
        Thresholds, 0 to 1. The source names none. At 0.5 the peak is at least twice as high as its feet, and no side
        of it is more than twice as wide as the other (skewness -0.5 to 1).

    Returns
    -------
    DampingEstimate
        `reason` tells the two numbers and what followed from them.

    Raises
    ------
    InputError
        For arrays that are no curve, or thresholds outside 0 to 1.

    Notes
    -----
    Two modes closer than a half-power width make one peak that passes both tests; half power then reads their sum.
    `rational_fraction` tells them apart.
    """
    for name, value in (("prominence", prominence), ("symmetry", symmetry)):
        if not 0.0 <= value <= 1.0:
            raise InputError(f"a threshold of {value} for {name}", remedy="give a number from 0 to 1")
    if otherwise not in ("gaussian", "rational_fraction"):
        raise InputError(f"no estimator {otherwise!r}", remedy="use gaussian or rational_fraction")
    f, values, magnitude = checked_curve(frequency, transmissibility)
    shape = curve_shape(f, magnitude)
    told = f"prominence {shape.prominence:.2f} (threshold {prominence:g}), symmetry {shape.symmetry:.2f} ({symmetry:g})"
    if shape.prominence > prominence and shape.symmetry > symmetry:
        return _because(half_power_estimate(f, magnitude), told)
    if otherwise == "gaussian":
        return _because(gaussian_fit(f, magnitude), told)
    fitted = rational_fraction(f, magnitude if values is None else values)
    if not fitted.found:
        why = fitted.reason
    else:
        largest = float((fitted.details or {})["largest_misfit"])
        if largest <= MISFIT + 5.0 * noise_level(magnitude) / float(magnitude.max()):
            return _because(fitted, told)
        why = f"it misses the curve by up to {largest:.0%} of the peak"
    return _because(
        gaussian_fit(f, magnitude, centre="free", window="narrowest"), f"{told}; no rational fraction: {why}"
    )


def _because(estimate: DampingEstimate, why: str) -> DampingEstimate:
    return replace(estimate, reason=f"{why}; {estimate.reason}" if estimate.reason else why)
