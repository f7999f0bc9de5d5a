"""Section `structure`: matrices from a file in place of geometry, mandrel, coil and mesh."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from pydantic import Field, field_validator

from wroll_fem.case.base import Section, Whole, wrong
from wroll_fem.case.coil import Coil
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.material import IsotropicMaterial

SUFFIXES = (".npz", ".mat")


class Structure(Section):
    """A structure assembled elsewhere: the file also holds interfaces, preload and the influence of the base motion."""

    file: Path = Field(
        description="matrices and interfaces, .npz or .mat as in docs/matrices.md (path, relative to the case file)"
    )
    preload_steps: Whole = Field(
        default=10, ge=1, description="load steps of the preload when the file holds its load and no state (count)"
    )

    @field_validator("file", mode="before")
    @classmethod
    def _a_path(cls, value: Any) -> Any:
        if not isinstance(value, str | Path):
            raise wrong("must be the path of a .npz or .mat file", remedy="write a path", value=value)
        return value

    @field_validator("file")
    @classmethod
    def _exists(cls, value: Path) -> Path:
        if value.suffix.lower() not in SUFFIXES:
            raise wrong("must be a .npz or .mat file", remedy="write one with `wroll export`", value=str(value))
        if not value.is_file():
            remedy = "give the path of a .npz or .mat file, relative to the case file"
            raise wrong("structure file not found", remedy=remedy, value=str(value))
        return value


# one object each, so that cases with these placeholders are equal although NaN differs from itself
_NO_GEOMETRY = Geometry.model_construct(length=math.nan, mandrel_outer_diameter=math.nan, mandrel_thickness=math.nan)
_NO_MANDREL = Mandrel.model_construct(
    material=IsotropicMaterial.model_construct(E=math.nan, nu=math.nan, rho=math.nan), tip_mass=0.0, tip="rigid",
    base="clamped",
)  # fmt: skip
_NO_COIL = Coil(model="none")


def unused_geometry() -> Geometry:
    """Placeholder of a case with `structure`: every number is NaN."""
    return _NO_GEOMETRY


def unused_mandrel() -> Mandrel:
    """Placeholder of a case with `structure`: material of NaN."""
    return _NO_MANDREL


def unused_coil() -> Coil:
    """Placeholder of a case with `structure`: model "none"."""
    return _NO_COIL
