"""Case section `winding`: web, tension, wraps and mandrel of the wound roll."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from wroll_fem.case.base import Real, Section, SparseSection, Whole, validation_error
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.errors import InputError

LARGEST_K2 = 1.0e4
"""Largest accepted K2, the slope of the radial modulus versus pressure. Measured values are 10 to a few thousand; a
larger number is probably a modulus in Pa."""


class ConstantModulus(Section):
    """Constant radial modulus."""

    law: Literal["constant"] = Field(description="constant: the same radial modulus at every pressure")
    E_r: Real = Field(gt=0, description="radial modulus of the stack, Pa")


class PfeifferModulus(Section):
    """Radial modulus that grows with the pressure: E_r = K2 (K1 + P) (thesis, equation 2.9)."""

    law: Literal["pfeiffer"] = Field(description="pfeiffer: E_r = K2 (K1 + P), P the pressure between the wraps")
    K1: Real = Field(gt=0, description="pressure offset K1, Pa")
    K2: Real = Field(gt=0, description="slope K2 of the radial modulus versus pressure, dimensionless")

    @field_validator("K2", mode="before")
    @classmethod
    def _without_unit(cls, value: Any) -> Any:
        try:
            number = math.nan if isinstance(value, bool) else float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not number <= LARGEST_K2:
            unit = "a number without a unit" if math.isnan(number) else "dimensionless, not a modulus in Pa"
            raise validation_error(
                f"K2 must be {unit}", value=value,
                remedy=f"give K2 of E_r = K2 (K1 + P) as a number up to {LARGEST_K2:g}; only K1 is in Pa "
                "(Table 2.3 of the thesis prints K2 = 40 GPa where 40 is meant)",
            )  # fmt: skip
        return number


class TableModulus(Section):
    """Table of the measured radial modulus versus pressure: linear between rows, constant beyond the ends."""

    law: Literal["table"] = Field(description="table: measured values, linear between the rows")
    pressure: list[Real] = Field(min_length=1, description="pressure between the wraps, Pa, rising from 0 or more")
    modulus: list[Real] = Field(min_length=1, description="radial modulus at each pressure, Pa")

    @model_validator(mode="after")
    def _a_table(self) -> Self:
        _check_table(self.pressure, self.modulus, "pressure", "modulus", least=0.0)
        if not min(self.modulus) > 0:
            raise validation_error(
                "must be positive", key="modulus", value=self.modulus, remedy="give moduli above 0 Pa"
            )
        return self


def _check_table(x: list[float], y: list[float], name_x: str, name_y: str, *, least: float) -> None:
    if len(x) != len(y):
        raise validation_error(
            f"{len(y)} values for {len(x)} values of {name_x}", key=name_y, value=y,
            remedy=f"give one value per {name_x}",
        )  # fmt: skip
    if any(b <= a for a, b in pairwise(x)) or x[0] < least:
        problem = f"must not be below {least:g}" if x[0] < least else "must rise from row to row"
        raise validation_error(problem, key=name_x, value=x, remedy=f"sort the rows by {name_x}, from {least:g} up")


def _law_named(value: Any) -> Any:
    if isinstance(value, dict) and "law" not in value:
        raise validation_error(
            "required key is missing", key="law", show_value=False, remedy="add law: constant, pfeiffer or table"
        )
    return value


RadialModulus = Annotated[
    ConstantModulus | PfeifferModulus | TableModulus, Field(discriminator="law"), BeforeValidator(_law_named)
]


class ConstantTension(Section):
    """Constant tension."""

    kind: Literal["constant"] = Field(default="constant", description="constant: the same tension in every wrap")


class TaperTension(Section):
    """Tension that changes linearly with the radius."""

    kind: Literal["taper"] = Field(description="taper: the tension changes linearly from mandrel to outer radius")
    taper: Real = Field(lt=1, ge=-10, description="relative loss of tension at the outer radius, dimensionless")


class TableTension(Section):
    """Table of tension versus radius: linear between rows, constant beyond the ends."""

    kind: Literal["table"] = Field(description="table: relative tension versus radius, linear between the rows")
    radius: list[Real] = Field(min_length=1, description="radius at which a wrap is laid, m, rising")
    factor: list[Real] = Field(
        min_length=1, description="tension at that radius relative to tension_stress or tension_newton, dimensionless"
    )

    @model_validator(mode="after")
    def _a_table(self) -> Self:
        _check_table(self.radius, self.factor, "radius", "factor", least=0.0)
        if not min(self.factor) > 0:
            raise validation_error(
                "must be positive",
                key="factor",
                value=self.factor,
                remedy="give positive factors: winding needs tension",
            )
        return self


def _constant_without_kind(value: Any) -> Any:
    return {"kind": "constant"} if value == {} else value


TensionProfile = Annotated[
    ConstantTension | TaperTension | TableTension,
    Field(discriminator="kind"),
    BeforeValidator(_constant_without_kind),
]


class WindingMandrel(Section):
    """Mandrel under the first wrap: an elastic tube, or a stiffness."""

    outer_radius: Real = Field(gt=0, description="outer radius of the mandrel, m")
    wall: Real | None = Field(default=None, gt=0, description="wall thickness, m; the outer radius for a solid core")
    E: Real | None = Field(default=None, gt=0, description="Young's modulus of the mandrel, Pa")
    nu: Real = Field(default=0.33, gt=-1, lt=0.5, description="Poisson's ratio of the mandrel, dimensionless")
    stiffness: Real | None = Field(
        default=None, gt=0, description="pressure divided by hoop strain at the surface, Pa, in place of wall and E"
    )

    @model_validator(mode="after")
    def _tube_or_number(self) -> Self:
        if self.stiffness is not None:
            for key in ("wall", "E", "nu"):
                if key in self.model_fields_set:
                    raise validation_error(
                        "cannot be combined with stiffness, which replaces it", key=key, value=getattr(self, key),
                        remedy="give wall and E, or stiffness",
                    )  # fmt: skip
            return self
        for key in ("wall", "E"):
            if getattr(self, key) is None:
                what = type(self).model_fields[key].description
                raise validation_error("required key is missing", key=key, show_value=False, remedy=f"add it ({what})")
        if self.wall is not None and self.wall > self.outer_radius:
            raise validation_error(
                "the wall is thicker than the radius", key="wall", value=self.wall,
                remedy=f"use at most outer_radius = {self.outer_radius:g} m (this value describes a solid core)",
            )  # fmt: skip
        return self

    @property
    def tube(self) -> tuple[float, float]:
        """Wall thickness, m, and Young's modulus, Pa, of an elastic tube.

        Raises
        ------
        ValueError
            If the mandrel has a stiffness instead.
        """
        if self.wall is None or self.E is None:
            raise ValueError("a mandrel given by its stiffness has no wall")
        return self.wall, self.E

    @model_serializer(mode="wrap")
    def _plain(self, plain: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Serialise the outer radius, and either the stiffness, if given, or the other keys of the tube."""
        used = ("outer_radius", "stiffness") if self.stiffness is not None else ("outer_radius", "wall", "E", "nu")
        return {key: value for key, value in dict(plain(self)).items() if key in used}


class Web(Section):
    """Material of the web."""

    E_theta: Real = Field(gt=0, description="Young's modulus along the web, Pa")
    nu_theta: Real = Field(
        default=0.3,
        gt=-1,
        lt=1,
        description="Poisson's ratio, dimensionless: -strain_r / strain_theta under stress along theta",
    )
    radial_modulus: RadialModulus = Field(description="stiffness of the stack through its thickness")


class Winding(SparseSection):
    """A web wound under tension onto a mandrel."""

    tension_stress: Real | None = Field(
        default=None, gt=0, description="tension of the web divided by its cross-sectional area, Pa"
    )
    tension_newton: Real | None = Field(
        default=None, gt=0, description="tension of the web as a force, N, with web_width in place of tension_stress"
    )
    web_width: Real | None = Field(default=None, gt=0, description="width of the web along the axis, m")
    tension_profile: TensionProfile = Field(
        default_factory=ConstantTension, description="profile of the tension versus radius"
    )
    wraps: Whole = Field(ge=1, le=20000, description="number of wraps (count)")
    wrap_thickness: Real = Field(gt=0, description="thickness of the web, m")
    mandrel: WindingMandrel | None = Field(
        default=None, description="mandrel; may be left out if geometry and mandrel describe it"
    )
    web: Web = Field(description="material of the web")
    mu: Real | None = Field(
        default=None,
        ge=0,
        description="coefficient of friction between wraps, dimensionless; friction capacity is mu times pressure",
    )
    growth: Literal["wraps", "continuous"] = Field(
        default="wraps",
        description="wraps: discrete wraps of finite thickness; continuous: infinitely thin wraps of the same "
        "total thickness",
    )
    cells: Whole = Field(
        default=2400,
        ge=50,
        le=20000,
        description="cells of the finer of the two refined grids, at least 2 per wrap (count)",
    )

    @model_validator(mode="after")
    def _one_tension(self) -> Self:
        if (self.tension_stress is None) == (self.tension_newton is None):
            both = self.tension_stress is not None
            raise validation_error(
                "cannot be combined with tension_stress" if both else "the tension is missing",
                key="tension_newton" if both else "tension_stress", value=self.tension_newton, show_value=both,
                remedy="give tension_stress in Pa, or tension_newton in N with web_width in m",
            )  # fmt: skip
        if self.tension_newton is not None and self.web_width is None:
            remedy = "add it (width of the web, m), or give tension_stress in Pa"
            raise validation_error("tension_newton needs the width", key="web_width", show_value=False, remedy=remedy)
        return self

    @model_validator(mode="after")
    def _thin_web(self) -> Self:
        if self.mandrel is not None and self.wrap_thickness >= self.mandrel.outer_radius:
            raise validation_error(
                "must be less than the mandrel radius", key="wrap_thickness", value=self.wrap_thickness,
                remedy=f"use less than mandrel.outer_radius = {self.mandrel.outer_radius:g} m",
            )  # fmt: skip
        return self

    @property
    def stress(self) -> float:
        """Web tension divided by the cross-sectional area of the web, Pa, before the tension profile is applied.

        Raises
        ------
        ValueError
            If no tension is set.
        """
        if self.tension_stress is not None:
            return self.tension_stress
        if self.tension_newton is None or self.web_width is None:
            raise ValueError("tension is not set: the case section has not been validated")
        return self.tension_newton / (self.web_width * self.wrap_thickness)

    @property
    def core(self) -> WindingMandrel:
        """Mandrel onto which the web is wound.

        Raises
        ------
        InputError
            When it was left out and `on_mandrel` has not taken it from the rest of the case.
        """
        if self.mandrel is None:
            remedy = "add it (outer_radius with wall and E, or with stiffness)"
            raise InputError("required section is missing", key="winding.mandrel", remedy=remedy)
        return self.mandrel

    @property
    def friction_coefficient(self) -> float:
        """Coefficient of friction between wraps, dimensionless.

        Raises
        ------
        InputError
            When `mu` was left out.
        """
        if self.mu is None:
            remedy = "add it (coefficient of friction between wraps)"
            raise InputError("required key is missing", key="winding.mu", remedy=remedy)
        return self.mu

    @property
    def build_up(self) -> float:
        """Thickness of all wraps together, m."""
        return self.wraps * self.wrap_thickness

    def on_mandrel(self, geometry: Geometry, mandrel: Mandrel) -> Winding:
        """Return this case section; if it has no mandrel, add the mandrel that `geometry` and `mandrel` describe."""
        if self.mandrel is not None:
            return self
        wall = mandrel.material.in_plane
        tube = WindingMandrel(
            outer_radius=0.5 * geometry.mandrel_outer_diameter, wall=geometry.mandrel_thickness,
            E=wall.E_theta, nu=wall.nu_theta_z,
        )  # fmt: skip
        return self.model_copy(update={"mandrel": tube})
