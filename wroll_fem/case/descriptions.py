"""Units, labels and meanings of choices, parsed from the descriptions of case fields for reference and reports."""

from __future__ import annotations

import re
from typing import Any, get_args

from pydantic import BaseModel

UNITS = (
    "px^2", "px", "grey values", "bytes",
    "octaves per minute", "Hz/s", "cycles", "count", "dimensionless", "multiples of 9.80665 m/s^2", "kg/m^3", "kg m^2",
    "N s/m", "N m/rad", "N/m^2", "g^2/Hz",
    "N/m", "m/N", "s/m", "Pa/m", "m/s^2", "m/s", "rad/s", "rad", "deg", "Pa", "Hz", "dB", "1/s", "kg/m^2", "kg",
    "m^2", "m", "s", "N", "V", "A",
)  # fmt: skip
"""Units, spelled as in the descriptions of case fields."""

_UNIT = re.compile(rf"(?:, |\()({'|'.join(re.escape(unit) for unit in UNITS)})(?=[,;:)]|$| \(|, )")


def unit_of(description: str) -> str:
    """Unit found in a description, as spelled there; "" if it has no unit."""
    found = _UNIT.search(description)
    return found[1] if found else ""


def name_of(description: str) -> str:
    """Label from a description: the text before the unit, with "(0-peak)" if the description contains it."""
    found = _UNIT.search(description)
    if not found:
        return re.split(r"[;:(]", description)[0].strip()
    words = description[: found.start()].strip()
    return f"{words} (0-peak)" if "0-peak" in description[found.end() :] else words


def meaning_of(description: str, choice: str) -> str:
    """Meaning of a choice, from "choice: meaning; ..." or "choice (meaning)" in a description; "" if not found."""
    for part in re.split(r"; (?![^()]*\))", description):
        if part.startswith(f"{choice}: "):
            return part.removeprefix(f"{choice}: ")
    found = re.search(rf"(?:^|[ ;]){re.escape(choice)} \(([^()]*)\)", description)
    return found[1] if found else ""


def sections(annotation: Any) -> list[type[BaseModel]]:
    """Pydantic models in a type annotation, in order."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in sections(argument)]
