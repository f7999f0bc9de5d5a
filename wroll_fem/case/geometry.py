"""Case section `geometry`: dimensions of the mandrel tube."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from wroll_fem.case.base import Real, Section, validation_error


class Geometry(Section):
    """Length, diameter and wall thickness of the mandrel; the z-axis points upwards from the base."""

    length: Real = Field(gt=0, description="length of mandrel and coil from base to tip, m")
    mandrel_outer_diameter: Real = Field(gt=0, description="outer diameter of the mandrel, m")
    mandrel_thickness: Real = Field(gt=0, description="wall thickness of the mandrel, m")

    @model_validator(mode="after")
    def _wall_fits(self) -> Self:
        if self.mandrel_thickness >= self.mandrel_outer_diameter / 2:
            raise validation_error(
                "the mandrel wall must be thinner than its radius",
                key="mandrel_thickness",
                value=self.mandrel_thickness,
                remedy=f"use less than mandrel_outer_diameter / 2 = {self.mandrel_outer_diameter / 2:g} m",
            )
        return self
