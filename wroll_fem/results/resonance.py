"""Resonance of a transmissibility curve, from the attributes of the results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, nan
from typing import Any

import xarray as xr

from wroll_fem.errors import InputError

RISES_AGAIN = "rises above half power again"
"""Words in the attribute half_power_reason of a curve with further points above the half-power level."""


@dataclass(frozen=True)
class Resonance:
    """Peak of a transmissibility curve and the damping estimated from it.

    Attributes
    ----------
    f_n, peak
        Natural frequency, Hz, and largest transmissibility.
    f_low, f_high
        Half-power frequencies, Hz; nan if the frequency lies outside the band.
    zeta, method
        Damping ratio, whatever its quality (nan if none was estimated), and its estimator.
    quality
        "ok", "doubtful" or "invalid" (`wroll_fem.signals.quality`); "" if it was not judged.
    skewness
        (f_high - f_n) / (f_n - f_low) - 1; nan without both half-power points.
    reason
        Why there is no damping ratio, or what makes it doubtful; "" otherwise.
    again
        Whether the curve rises above the half-power level again outside the half-power points.
    """

    f_n: float
    peak: float
    f_low: float
    f_high: float
    zeta: float
    method: str
    skewness: float
    reason: str
    again: bool
    quality: str = ""

    @property
    def damped(self) -> bool:
        """Whether the damping ratio was estimated."""
        return isfinite(self.zeta)

    @property
    def stated(self) -> bool:
        """Whether there is a damping ratio that is not invalid."""
        return self.damped and self.quality != "invalid"

    @property
    def rings(self) -> bool:
        """Whether there is a damping ratio although it is invalid, or the curve rises above the half-power level again.

        This happens when the response rings after a fast sweep through a sharp resonance. A half-power damping ratio
        then measures the width of the highest ripple.
        """
        return self.damped and (self.again or not self.stated)


def resonance(dataset: xr.Dataset, prefix: str = "") -> Resonance:
    """Resonance from the attributes of the results whose names start with ``prefix`` ("down_": downward branch).

    Raises
    ------
    InputError
        If the results contain none.
    """
    attrs: Mapping[str, Any] = {
        str(name).removeprefix(prefix): value for name, value in dataset.attrs.items() if str(name).startswith(prefix)
    }
    if "f_n_hz" not in attrs or "peak_transmissibility" not in attrs:
        remedy = "add one: dataset.assign_attrs(wf.half_power(frequency, magnitude).as_attrs())"
        raise InputError("the results have no resonance (attributes f_n_hz, peak_transmissibility)", remedy=remedy)

    def number(name: str) -> float:
        value = attrs.get(name)
        return nan if value is None else float(value)

    return Resonance(
        number("f_n_hz"),
        number("peak_transmissibility"),
        number("half_power_low_hz"),
        number("half_power_high_hz"),
        number("zeta_apparent" if "zeta_apparent" in attrs else "zeta"),
        str(attrs.get("zeta_method", "half power")).partition(",")[0],
        number("skewness"),
        str(attrs.get("zeta_reason") or attrs.get("half_power_reason") or ""),
        RISES_AGAIN in str(attrs.get("half_power_reason")),
        str(attrs.get("zeta_quality", "")),
    )
