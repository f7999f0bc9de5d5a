"""Plausibility of the numbers of a case: warnings that name the unit in which a number was probably meant."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pydantic import BaseModel


class Plausible(NamedTuple):
    """Usual range of a quantity, and the units in which it is often written by mistake, with their values in SI."""

    what: str
    unit: str
    low: float
    high: float
    mistakes: tuple[tuple[str, float], ...]


_MODULUS = Plausible("a Young's modulus", "Pa", 1e5, 1.3e12, (("GPa", 1e9), ("MPa", 1e6)))
_DENSITY = Plausible("a density", "kg/m^3", 10.0, 2.3e4, (("g/cm^3", 1e3), ("t/mm^3", 1e12)))
_SIZE = Plausible("a length", "m", 1e-3, 50.0, (("mm", 1e-3), ("um", 1e-6)))
_WALL = Plausible("a thickness", "m", 1e-6, 1.0, (("mm", 1e-3), ("um", 1e-6)))
_WEB = Plausible("the thickness of a web", "m", 1e-7, 2e-2, (("mm", 1e-3), ("um", 1e-6)))
_SLIP = Plausible("an elastic slip", "m", 1e-10, 1e-3, (("um", 1e-6), ("nm", 1e-9)))
_PRESSURE = Plausible("a pressure", "Pa", 1.0, 1e9, (("MPa", 1e6), ("bar", 1e5), ("kPa", 1e3)))
_TENSION = Plausible("a tension stress", "Pa", 1e3, 1e10, (("MPa", 1e6), ("kPa", 1e3)))
_BASE = Plausible("a base acceleration", "m/s^2", 1e-6, 5e3, (("mm/s^2", 1e-3),))

_SOLID = _WALL._replace(what="the thickness of a solid coil", high=5.0)

USUAL = {
    "E": _MODULUS, "E_theta": _MODULUS, "E_z": _MODULUS, "E_1": _MODULUS, "E_2": _MODULUS, "rho": _DENSITY,
    "length": _SIZE, "mandrel_outer_diameter": _SIZE, "outer_radius": _SIZE, "web_width": _SIZE,
    "mandrel_thickness": _WALL, "total_thickness": _WALL, "thickness": _WALL, "wall": _WALL, "wrap_thickness": _WEB,
    "elastic_slip": _SLIP, "pressure": _PRESSURE, "tension_stress": _TENSION, "amplitude": _BASE,
}  # fmt: skip
"""Last part of a case key -> usual range of its numbers. Zero is always allowed where a case allows it."""


def implausible(case: BaseModel) -> list[str]:
    """Warnings about numbers of a case that are far outside their usual range, each with the unit probably meant."""
    return [_warning(key, value, usual) for key, value, usual in _numbers(case) if _outside(value, usual)]


def _numbers(section: BaseModel, path: str = "") -> Iterator[tuple[str, float, Plausible]]:
    """Key, number and usual range of every number of a case section for which there is such a range."""
    for name in type(section).model_fields:
        value, key = getattr(section, name), f"{path}{name}"
        for label, entry in _entries(key, value):
            if isinstance(entry, BaseModel):
                yield from _numbers(entry, f"{label}.")
            elif name in USUAL and isinstance(entry, int | float) and not isinstance(entry, bool):
                solid = USUAL[name] is _WALL and getattr(section, "model", None) == "solid"
                yield label, float(entry), _SOLID if solid else USUAL[name]


def _entries(key: str, value: Any) -> list[tuple[str, Any]]:
    if isinstance(value, Mapping):
        return [(f"{key}.{name}", entry) for name, entry in value.items()]
    if isinstance(value, list | tuple):
        return [(f"{key}.{k}", entry) for k, entry in enumerate(value)]
    return [(key, value)]


def _outside(value: float, usual: Plausible) -> bool:
    return value != 0.0 and not usual.low <= value <= usual.high


def _warning(key: str, value: float, usual: Plausible) -> str:
    meant = next((name for name, factor in usual.mistakes if not _outside(value * factor, usual)), None)
    remedy = f"did you mean {value:g} {meant}? write the unit" if meant else "check its unit"
    return (
        f"{key}: {value:g} {usual.unit} is far outside the usual range of {usual.what}, "
        f"{usual.low:g} to {usual.high:g} {usual.unit}; {remedy}"
    )
