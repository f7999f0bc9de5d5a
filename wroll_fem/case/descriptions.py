"""Unit, words and meaning of choices in the descriptions of case fields, for the reference and the report."""

from __future__ import annotations

import re
from typing import Any, get_args

from pydantic import BaseModel

UNITS = (
    "octaves per minute", "cycles", "count", "dimensionless", "multiples of 9.80665 m/s^2", "kg/m^3", "N s/m", "N/m",
    "s/m", "Pa/m", "m/s^2", "m/s", "rad/s", "rad", "Pa", "Hz", "kg", "m", "s", "N",
)  # fmt: skip
"""Units as descriptions spell them."""

_UNIT = re.compile(rf"(?:, |\()({'|'.join(re.escape(unit) for unit in UNITS)})(?=[,;:)]|$| \(|, )")


def unit_of(description: str) -> str:
    """Unit that a description names, as written there; "" when it names none."""
    found = _UNIT.search(description)
    return found[1] if found else ""


def name_of(description: str) -> str:
    """Words of a description before its unit, with "(0-peak)" where the rest says so."""
    found = _UNIT.search(description)
    if not found:
        return re.split(r"[;:(]", description)[0].strip()
    words = description[: found.start()].strip()
    return f"{words} (0-peak)" if "0-peak" in description[found.end() :] else words


def meaning_of(description: str, choice: str) -> str:
    """Meaning of one of the choices that a description lists as "choice: meaning; ...", or "choice (meaning)"."""
    for part in re.split(r"; (?![^()]*\))", description):
        if part.startswith(f"{choice}: "):
            return part.removeprefix(f"{choice}: ")
    found = re.search(rf"(?:^|[ ;]){re.escape(choice)} \(([^()]*)\)", description)
    return found[1] if found else ""


def sections(annotation: Any) -> list[type[BaseModel]]:
    """Models that an annotation allows, in order."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in sections(argument)]
