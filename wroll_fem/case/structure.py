"""Case section `structure`: matrices from a file in place of geometry, mandrel, coil and mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field, field_validator

from wroll_fem.case.base import Section, Whole, validation_error
from wroll_fem.results.storage.paths import path_problem

SUFFIXES = (".npz", ".mat")


class Structure(Section):
    """Externally assembled structure: matrices, interfaces, preload and influence vector from a file."""

    file: Path = Field(
        description="matrices and interfaces, .npz or .mat as in docs/matrices.md (path, relative to the case file)"
    )
    preload_steps: Whole = Field(
        default=10,
        ge=1,
        le=10000,
        description="load steps of the preload if the file contains a preload load without a state (count)",
    )

    @field_validator("file", mode="before")
    @classmethod
    def _a_path(cls, value: Any) -> Any:
        if not isinstance(value, str | Path):
            raise validation_error("must be the path of a .npz or .mat file", remedy="write a path", value=value)
        return value

    @field_validator("file")
    @classmethod
    def _exists(cls, value: Path) -> Path:
        if problem := path_problem(value):
            raise validation_error(problem, remedy="give another path", value=str(value))
        if value.suffix.lower() not in SUFFIXES:
            raise validation_error(
                "must be a .npz or .mat file", remedy="write one with `wroll export`", value=str(value)
            )
        if not value.is_file():
            remedy = "give the path of a .npz or .mat file, relative to the case file"
            raise validation_error("structure file not found", remedy=remedy, value=str(value))
        return value
