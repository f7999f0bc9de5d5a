"""Case section `sizing`: mandrel of a coiled structure under a transverse acceleration and an external pressure."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from wroll_fem.case.base import Real, Section, SparseSection, Whole, validation_error

Reading = Literal[
    "membrane", "surface", "membrane_away_from_ends", "surface_away_from_ends", "membrane_without_pressure",
    "surface_without_pressure", "membrane_away_from_ends_without_pressure", "surface_away_from_ends_without_pressure",
]  # fmt: skip
"""Places and loads for which the largest stress is read."""

THICKEST = 0.1
"""Thickest wall divided by the outer diameter of the mandrel; beyond it a shell is not the model for a tube."""


class Sizing(SparseSection):
    """Structure, loads, margin and material of the mandrel (thesis, sections 6.2 and 6.3)."""

    structure: str = Field(default="mandrel", min_length=1, description="name of the structure; used in titles")
    length: Real = Field(gt=0, description="length of mandrel and coil, m")
    mandrel_outer_diameter: Real = Field(gt=0, description="outer diameter of the mandrel, m")
    coil_outer_diameter: Real = Field(gt=0, description="outer diameter of the coil, m")
    coil_mass: Real = Field(ge=0, description="mass of the coil, spread over the mandrel without stiffness, kg")
    acceleration_g: Real = Field(gt=0, description="quasi-static transverse acceleration, multiples of 9.80665 m/s^2")
    pressure: Real = Field(ge=0, description="external pressure on the mandrel, from the coil, Pa")
    margin: Real = Field(default=0.25, gt=-1, description="wanted margin against yield, dimensionless")
    factor_of_safety: Real = Field(default=1.2, gt=0, description="factor of safety on the stress, dimensionless")
    E: Real = Field(default=70e9, gt=0, description="Young's modulus of the mandrel, Pa")
    nu: Real = Field(default=0.33, ge=0, lt=0.5, description="Poisson's ratio of the mandrel, dimensionless")
    rho: Real = Field(default=2700.0, gt=0, description="density of mandrel and end cap, kg/m^3")
    yield_stress: Real = Field(default=280e6, gt=0, description="yield stress of the mandrel, Pa")
    reading: Reading = Field(
        default="surface_away_from_ends",
        description="reading of the stress that sets the wall; buckling, stiffness, frequencies and ratios are those "
        "of this wall",
    )
    wall: Real | None = Field(
        default=None, gt=0, description="thickness of a known wall, m, which is evaluated in place of the search"
    )

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        if self.coil_outer_diameter <= self.mandrel_outer_diameter:
            raise validation_error(
                f"must exceed mandrel_outer_diameter = {self.mandrel_outer_diameter:g} m", key="coil_outer_diameter",
                value=self.coil_outer_diameter, remedy="give the outer diameter of the coil around the mandrel",
            )  # fmt: skip
        thickest = THICKEST * self.mandrel_outer_diameter
        if self.wall is not None and self.wall > thickest:
            raise validation_error(
                f"is too thick for a shell: at most {THICKEST:g} of the outer diameter, {thickest:g} m", key="wall",
                value=self.wall, remedy="give a thinner wall",
            )  # fmt: skip
        return self


class SizingMesh(Section):
    """Cells of the mandrel along its axis; theta needs no mesh."""

    axial: Whole = Field(
        default=160, ge=20, le=600, description="cells along the axis (count); 30 % of them in each end zone"
    )
