"""Case section `mesh`: element counts or a mesh file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field, SerializerFunctionWrapHandler, field_validator, model_serializer

from wroll_fem.case.base import Real, Section, Whole, validation_error
from wroll_fem.results.storage.paths import path_problem


class Mesh(Section):
    """Structured mesh: quadrilaterals on cylinders, hexahedra in a solid coil, with matching nodes."""

    circumferential: Whole = Field(
        default=24, ge=8, le=2000, description="elements around the circumference (count, even)"
    )
    axial: Whole = Field(default=12, ge=2, le=2000, description="elements along the axis (count)")
    grading: Real = Field(
        default=8.0, ge=1, le=1e6, description="ratio of element heights, tip to root, dimensionless; 1 is uniform"
    )
    radial: Whole = Field(default=3, ge=1, le=200, description="elements through a solid coil (count)")
    radial_grading: Real = Field(
        default=10.0,
        ge=1,
        le=1e6,
        description="ratio of element thicknesses, outer surface to mandrel, dimensionless; 1 is uniform",
    )
    discretisation: Literal["three_dimensional", "fourier"] = Field(
        default="three_dimensional",
        description="three_dimensional: shells and hexahedra; fourier: semi-analytical (Fourier) elements on a "
        "mesh of the r-z "
        "half plane, mandrel and solid coil as solids (fast; modes only)",
    )
    file: Path | None = Field(
        default=None,
        description="Gmsh .msh file with the named groups (path, relative to the case file); null: generated mesh",
    )

    OF_SOLID: ClassVar[tuple[str, ...]] = ("radial", "radial_grading")
    """Keys that only a solid coil uses; with another coil, the resolved case contains them only if they were given."""

    @model_serializer(mode="wrap")
    def _plain(self, plain: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Serialise `discretisation` only if it was given, so that the hash of older cases does not change."""
        data = dict(plain(self))
        if "discretisation" not in self.model_fields_set:
            data.pop("discretisation", None)
        return data

    @field_validator("circumferential")
    @classmethod
    def _even(cls, value: int) -> int:
        if value % 2:
            raise validation_error(
                "must be even, because of the symmetry plane", remedy=f"use {value - 1} or {value + 1}", value=value
            )
        return value

    @field_validator("file", mode="before")
    @classmethod
    def _a_path(cls, value: Any) -> Any:
        if value is not None and not isinstance(value, str | Path):
            raise validation_error("must be the path of a .msh file", remedy="write a path, or null", value=value)
        return value

    @field_validator("file")
    @classmethod
    def _exists(cls, value: Path | None) -> Path | None:
        if value is not None and (problem := path_problem(value)):
            raise validation_error(problem, remedy="give another path", value=str(value))
        if value is not None and not value.is_file():
            remedy = "give the path of a .msh file, relative to the case file, or null for a generated mesh"
            raise validation_error("mesh file not found", remedy=remedy, value=str(value))
        return value
