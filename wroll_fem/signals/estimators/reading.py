"""Reading of a curve by the estimator that a case names (`output.damping`), beside its half-power points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite, nan
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

Estimator = Callable[[npt.ArrayLike, npt.ArrayLike], DampingEstimate]

ESTIMATORS: dict[str, Estimator] = {
    "half_power": half_power_estimate,
    "gaussian_fit": partial(gaussian_fit, centre="free", window="narrowest"),
    "rational_fraction": rational_fraction,
    "choose": choose,
}
"""Value of `output.damping` -> estimator; the Gaussian bell is the one that does not depend on the band."""

FEWEST_POINTS = 8
"""Points that an estimator with error bars asks for; half power alone reads five."""

LOOSE_FIT = 0.05
"""Root mean square distance of fit and curve over the peak above which the curve is not that of the fitted model."""


@dataclass(frozen=True)
class Reading:
    """What is read from one curve.

    Attributes
    ----------
    shape
        Peak, half-power points and skewness, whatever method reads the damping.
    damping
        Frequency and damping ratio by that method, with error bars.
    """

    shape: HalfPower
    damping: DampingEstimate

    def as_attrs(self, curve: str) -> dict[str, Any]:
        """Attributes under the names of summary.json; `curve` says in words what was read.

        Error bars are left out where there are none.
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
    def doubts(self) -> list[str]:
        """Sentences about a missing or doubtful damping ratio; empty when there is nothing to say."""
        found, shape = self.damping, self.shape
        if found.method == HALF_POWER:
            return [text for text in ("" if shape.complete else shape.reason, shape.note) if text]
        if not found.found:
            return [f"{found.method} gives no damping: {found.reason}"]
        if found.misfit > LOOSE_FIT:
            return [
                f"the {found.method} misses the curve by {100 * found.misfit:.0f} % of its peak (zeta_misfit): this is "
                "not the curve of one linear mode, and zeta depends on the method; compare output.damping: half_power"
            ]
        return []


def read_curve(frequency: npt.ArrayLike, transmissibility: npt.ArrayLike, method: str = "half_power") -> Reading:
    """Read frequency and damping of the highest peak.

    Parameters
    ----------
    frequency
        (n,) rising, Hz (or rad/s: every frequency of the result then is in rad/s).
    transmissibility
        (n,) complex T, or |T|.
    method
        Key of `ESTIMATORS`.

    Returns
    -------
    Reading
        Without a damping ratio zeta is nan, `damping.reason` says why, and f_n is that of the highest point.

    Raises
    ------
    InputError
        For arrays that are no curve, or an unknown method.
    """
    if method not in ESTIMATORS:
        raise InputError(f"no estimator {method!r}", remedy=f"use one of: {', '.join(ESTIMATORS)}")
    f, values = np.asarray(frequency, dtype=np.float64), np.asarray(transmissibility)
    shape = half_power(f, np.hypot(values.real, values.imag))
    if f.size >= FEWEST_POINTS:
        found = ESTIMATORS[method](f, values)
    elif method in ("half_power", "choose"):
        found = DampingEstimate(shape.f_n, shape.zeta, nan, nan, HALF_POWER, shape.reason or shape.note)
    else:
        found = no_estimate(method.replace("_", " "), f"{f.size} points are too few; {FEWEST_POINTS} are needed")
    if not isfinite(found.f_n):
        found = replace(found, f_n=shape.f_n)
    return Reading(shape, found)
