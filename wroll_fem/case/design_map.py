"""Case section `design_map`: mandrels of the map, and softest coil."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Literal

from pydantic import Field, field_validator

from wroll_fem.case.base import Section, _number, validation_error


class DesignMap(Section):
    """Mandrel radii and wall thicknesses of the map, and the softest coil; the coil of the case is the stiffest."""

    mandrel_radius: list[float] = Field(description="outer radii of the mandrel, m, ascending")
    mandrel_thickness: list[float] = Field(description="wall thicknesses of the mandrel, m, ascending")
    softest: Literal["fundamental_bending"] | float = Field(
        default="fundamental_bending",
        description="shear modulus between wraps of the softest coil, Pa, or fundamental_bending: for each mandrel the "
        "smallest modulus for which the fundamental mode is bending",
    )

    @field_validator("mandrel_radius", "mandrel_thickness", mode="before")
    @classmethod
    def _ascending(cls, value: Any) -> Any:
        remedy = "write lengths in m, positive and ascending, for example [0.02, 0.03, 0.04]"
        if not isinstance(value, list | tuple) or not value:
            raise validation_error("must be a list of lengths", remedy=remedy, value=value)
        lengths = [_number(entry) for entry in value]
        numbers = all(isinstance(entry, int | float) for entry in lengths)
        if not numbers or lengths[0] <= 0 or any(b <= a for a, b in pairwise(lengths)):
            raise validation_error("must be positive and ascending", remedy=remedy, value=value)
        return lengths

    @field_validator("softest", mode="before")
    @classmethod
    def _modulus(cls, value: Any) -> Any:
        if value == "fundamental_bending":
            return value
        remedy = "write a shear modulus in Pa, or fundamental_bending"
        if isinstance(value, str | bool) and not str(value)[:1].isdigit():
            raise validation_error("must be a number or fundamental_bending", remedy=remedy, value=value)
        number = _number(value)
        if not isinstance(number, int | float) or number <= 0:
            raise validation_error("must be positive", remedy=remedy, value=value)
        return number
