"""Quantities with units, such as "1200 mm" or "70 GPa": converted to SI when a case is read."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import pint

_QUANTITY = re.compile(
    r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(?!e[+-]?\d)((?:1\s*/|[A-Za-zµμ°%]).{0,60})", re.I
)
"""Number and unit. A unit does not start with a digit, except in "1/min", so that "1 200 mm" is not 200 mm."""

QUANTITY_PATTERN = r"^[+-]?\.?\d"
"""Start of a text with a number, for the JSON schema of case files; `in_si` is stricter."""

_GRAVITY = re.compile(r"\bg(?:_?[0n])?\b")
_DIGITS = 15  # 1200 mm is 1.2 m, not 1.2000000000000002 m


class Kind(NamedTuple):
    """Kind of a quantity: its name, its unit for the library pint, and an example in another unit."""

    name: str
    unit: str
    example: str


KINDS = {
    "m": Kind("length", "m", "1200 mm"),
    "kg": Kind("mass", "kg", "250 g"),
    "s": Kind("time", "s", "20 ms"),
    "N": Kind("force", "N", "0.2 kN"),
    "Pa": Kind("stress or pressure", "Pa", "70 GPa"),
    "N/m^2": Kind("stress or pressure", "Pa", "70 GPa"),
    "Hz": Kind("frequency", "turn/s", "30 min^-1"),
    "1/s": Kind("rate", "1/s", "300 1/min"),
    "rad/s": Kind("angular frequency", "rad/s", "30 rpm"),
    "dimensionless": Kind("pure number", "", "1 %"),
    "rad": Kind("angle", "rad", "90 deg"),
    "deg": Kind("angle", "deg", "0.5 rad"),
    "kg/m^2": Kind("mass per area", "kg/m^2", "300 g/m^2"),
    "m/s": Kind("speed", "m/s", "5 mm/s"),
    "s/m": Kind("reciprocal speed", "s/m", "2 s/mm"),
    "m/s^2": Kind("acceleration", "m/s^2", "0.5 g"),
    "multiples of 9.80665 m/s^2": Kind("acceleration", "standard_gravity", "0.5 g"),
    "kg/m^3": Kind("density", "kg/m^3", "1.4 g/cm^3"),
    "N/m": Kind("stiffness", "N/m", "5 N/mm"),
    "N s/m": Kind("damping coefficient", "N s/m", "5 N s/mm"),
    "N m/rad": Kind("rotational stiffness", "N m/rad", "5 kN m/rad"),
    "kg m^2": Kind("moment of inertia", "kg m^2", "3 kg mm^2"),
    "m/N": Kind("compliance", "m/N", "50 nm/N"),
    "m^2": Kind("area", "m^2", "20 cm^2"),
    "Pa/m": Kind("stiffness per area", "Pa/m", "5 MPa/mm"),
    "V": Kind("voltage", "V", "500 mV"),
    "A": Kind("current", "A", "200 mA"),
}
"""Unit in the description of a case key -> kind of quantity. Keys with other units (counts, cycles) take no texts."""


class WrongQuantity(str):
    """Text that is not a quantity of the wanted kind.

    Attributes
    ----------
    problem, remedy : what is wrong, and what to write
    """

    problem: str
    remedy: str

    def __new__(cls, text: str, problem: str, remedy: str) -> WrongQuantity:
        """Mark ``text`` as wrong."""
        made = super().__new__(cls, text)
        made.problem, made.remedy = problem, remedy
        return made


def in_si(text: str, unit: str) -> float | str:
    """Value in the SI unit ``unit`` (a key of `KINDS`) of a number with a unit.

    A text that is no number with a unit is returned unchanged; a wrong one as `WrongQuantity`. In accelerations g is
    the standard gravity, elsewhere the gram. A frequency in Hz may be given in turns (rpm) or angles (rad/s) per time;
    one in rad/s may be given in Hz.
    """
    found = _QUANTITY.fullmatch(text.strip())
    if found is None or unit not in KINDS:
        return text
    kind = KINDS[unit]
    number, written = float(found[1]), found[2].strip()
    registry = _registry()
    given = _parsed(_GRAVITY.sub("standard_gravity", written) if kind.name == "acceleration" else written)
    if given is None:
        return WrongQuantity(text, f"unknown unit {written!r}", _remedy(kind, unit, _meant(written)))
    wanted = registry.parse_units(kind.unit)
    if given.dimensionality != wanted.dimensionality:
        return WrongQuantity(text, f"must be {_article(kind.name)}, not {_what(given)}", _remedy(kind, unit))
    if kind.unit.startswith(("turn", "rad/")) and not _has_angle(given):
        given = given * registry.turn
    try:
        value = registry.Quantity(number, given).to(wanted).magnitude
    except Exception:  # products with logarithmic units or with an offset, by the version of pint
        return WrongQuantity(text, f"unit without a value {written!r}", _remedy(kind, unit))
    return float(f"{value:.{_DIGITS}g}")


_POWER = re.compile(r"(?:\^|\*\*)\s*\(?\s*[+-]?\s*[0-9](?:\.[0-9])?\s*\)?")


def _simple(written: str) -> bool:
    """Whether the powers of a unit are single numbers below 10: pint would compute 9^9^9^9."""
    bases = _POWER.sub("|", written)
    return not re.search(r"\^|\*\*|[0-9]{2}|[0-9.]\s*\||\|\s*\||\)\s*\|", bases)


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry:
    import pint  # 0.2 s, and most cases are written in SI

    return pint.UnitRegistry()


def _parsed(written: str, *, exact: bool = True) -> pint.Unit | None:
    """Unit of a text; None if pint cannot read it."""
    if not _simple(written):
        return None
    try:
        found = _registry().parse_units(written, case_sensitive=exact)
        return found if found.dimensionality is not None else None  # of the logarithmic units it raises KeyError
    except Exception:  # also what Python's tokenizer and pint's own parser raise: TokenError, AssertionError, ...
        return None


def _has_angle(unit: pint.Unit) -> bool:
    """Whether a unit of a frequency counts angles or turns; pint takes both for pure numbers."""
    registry = _registry()
    angles = ("turn", "revolution", "radian", "degree", "rpm", "revolutions_per_minute", "revolutions_per_second")
    return any(name in angles or (name in dir(registry) and name.startswith("rad")) for name in dict(unit._units))


def _meant(written: str) -> str:
    """Unit that differs from the written one only by capital letters; "" if there is none, or more than one."""
    found = _parsed(written, exact=False)
    return "" if found is None else f"{found:~}".replace(" ", "")


def _what(unit: pint.Unit) -> str:
    for own in KINDS.values():
        if _registry().parse_units(own.unit).dimensionality == unit.dimensionality:
            return _article(own.name)
    return f"a quantity in {unit:~}"


def _article(name: str) -> str:
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _remedy(kind: Kind, unit: str, meant: str = "") -> str:
    plain = "a plain number" if unit == "dimensionless" else f"a number in {unit}"
    first = f"did you mean {meant}? " if meant else ""
    return f"{first}give {plain}, or {_article(kind.name)} with its unit, for example {kind.example}"
