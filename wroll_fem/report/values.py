"""Formatting of values of summary.json: units, SI prefixes, per cent."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any

from wroll_fem.results.summary import SUMMARY, unit_of

SMALL_SHARE = 1e-5
"""Share below which only this limit is printed: no error of a run is known to more digits."""


def open_balance(summary: Mapping[str, Any]) -> float | None:
    """Energy balance error if it exceeds 0.1 %, else None."""
    gap = summary.get("energy_balance_error")
    return float(gap) if gap not in (None, "") and float(gap) > 1e-3 else None


def shown(name: str, value: Any) -> str:
    """Value with its unit: four digits, SI prefixes, fractions in per cent; "none" if there is no number."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        if not value:
            return "none"
        return ", ".join(shown(name, item) for item in value)
    if isinstance(value, Mapping):
        own = {str(key): str(key) if unit_of(str(key)) else name for key in value}  # a key without unit has the entry's
        return ", ".join(f"{key}: {shown(own[str(key)], item)}" for key, item in value.items())
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f") + _behind(unit_of(name))
    if not isinstance(value, float):
        return str(value)
    if not isfinite(value):
        return "none"
    unit, style = unit_of(name), SUMMARY[name].style if name in SUMMARY else "si"
    if style == "share":
        if 1e-12 < abs(value) < SMALL_SHARE:
            return f"below {100 * SMALL_SHARE:g} %"
        return f"{100.0 * value:.4g} %" if abs(value) > 1e-12 else "0 %"
    if not unit or style == "number":
        return f"{value:.6g}{_behind(unit)}" if unit == "Hz" else f"{value:.4g}{_behind(unit)}"
    return quantity(value, unit)


def quantity(value: float, unit: str) -> str:
    """Number with four digits and SI prefix, "12.34 mJ"; times above 1 s and masses from 0.1 kg have no prefix."""
    if unit == "kg" and abs(value) < 0.1:
        value, unit = 1e3 * value, "g"
    if value == 0.0 or unit == "kg" or (unit == "s" and abs(value) >= 1.0):
        return f"{abs(value) if value == 0.0 else value:.4g} {unit}"
    if abs(value) < 1e-15:  # rounding errors of what should be zero
        return f"{value:.1g} {unit}"
    digits = f"{abs(value):.3e}"
    exponent = max(-12, min(9, int(digits.split("e")[1]) // 3 * 3))
    prefix = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}[exponent]
    return f"{value / 10.0**exponent:.4g} {prefix}{unit}"


def _behind(unit: str) -> str:
    return f" {unit}" if unit else ""
