"""Case section `two_dof`: two masses coupled by friction, under sine motion of the base (thesis, chapter 5)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from wroll_fem.case.base import Real, Section, SparseSection, Switch, Whole, _number, validation_error


class Span(Section):
    """Evenly spaced values."""

    start: Real = Field(gt=0, description="first value, rad/s, kg or N/m as the enclosing key")
    stop: Real = Field(gt=0, description="last value, rad/s, kg or N/m as the enclosing key")
    points: Whole = Field(ge=2, le=20000, description="number of values (count)")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.stop <= self.start:
            raise validation_error(
                f"must be above start = {self.start:g}", key="stop", value=self.stop, remedy="give stop > start"
            )
        return self

    @property
    def values(self) -> list[float]:
        """All values, evenly spaced."""
        step = (self.stop - self.start) / (self.points - 1)
        return [self.start + step * k for k in range(self.points - 1)] + [self.stop]


class TwoDofDesignSpace(Section):
    """Secondary masses and spring stiffnesses for which the largest damping ratio is computed (thesis, Fig. 5.7)."""

    m2: Span = Field(description="secondary mass, kg")
    k2: Span = Field(description="spring stiffness of the secondary mass, N/m")
    points: Whole = Field(
        default=48, ge=24, le=2000, description="frequencies per curve before its peaks are refined (count)"
    )


class TwoDof(SparseSection):
    """Masses, springs, dashpots, friction and base motion in SI or any consistent units."""

    m1: Real = Field(default=1.0, gt=0, description="primary mass (mandrel), kg")
    k1: Real = Field(default=1.0, gt=0, description="spring stiffness of the primary mass, N/m")
    c1: Real = Field(default=0.002, gt=0, description="dashpot of the primary mass, N s/m")
    m2: Real = Field(default=0.85, gt=0, description="secondary mass (roll), kg")
    k2: Real = Field(default=1.15, gt=0, description="spring stiffness of the secondary mass, N/m")
    c2: Real = Field(default=0.0025, gt=0, description="dashpot of the secondary mass, N s/m")
    Y0: Real = Field(default=1.5, gt=0, description="displacement of the base, m, 0-peak")
    friction_capacity: list[float] = Field(description="friction capacities mu F_N, N, ascending")
    omega: Span = Field(description="frequencies of the base, rad/s")
    smoothing: Real = Field(
        default=1.0, gt=0, description="parameter s of the regularised sign S(s v), s/m, with v the relative velocity"
    )
    arrangement: Literal["both_on_base", "secondary_isolated", "secondary_on_primary"] = Field(
        default="both_on_base",
        description="support of the secondary spring: the base, a wall at rest or the primary mass",
    )
    preload_dependent: Switch = Field(
        default=True,
        description="secondary mass and its stiffness depend on the friction capacity (equations 5.6 and 5.7 "
        "of the thesis)",
    )
    method: Literal["periodic", "time"] = Field(
        default="periodic", description="harmonic balance, or time integration from rest until the motion repeats"
    )
    design_space: TwoDofDesignSpace | None = Field(
        default=None, description="map of the largest damping versus secondary mass and stiffness"
    )

    @field_validator("friction_capacity", mode="before")
    @classmethod
    def _ascending(cls, value: Any) -> Any:
        remedy = "write forces in N, positive and ascending, for example [1, 2, 5, 10, 100]"
        entries = value if isinstance(value, list | tuple) else [value]
        forces = [_number(entry) for entry in entries]
        if not forces or not all(isinstance(force, int | float) for force in forces):
            raise validation_error("must be a list of forces", remedy=remedy, value=value)
        if forces[0] <= 0 or any(b <= a for a, b in pairwise(forces)):
            raise validation_error("must be positive and ascending", remedy=remedy, value=value)
        return forces

    @model_validator(mode="after")
    def _enough(self) -> Self:
        if self.omega.points < 5:
            raise validation_error(
                "too few frequencies for a curve", key="omega.points", value=self.omega.points, remedy="use 5 or more"
            )
        return self
