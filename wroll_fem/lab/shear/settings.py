"""Settings shared by the evaluations `shear` and `friction`: columns, units, preload, fixture, profiles."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from wroll_fem.case.base import Real, Section, Whole
from wroll_fem.lab.settings import LabSettings
from wroll_fem.lab.shear.events import DROP
from wroll_fem.lab.shear.rates import STEADY
from wroll_fem.lab.shear.stiffness import WINDOW

Profile = Literal["auto", "ramp", "loops", "sliding"]


class ShearColumns(Section):
    """Columns of the files: a name, or the place counted from 1."""

    time: str | int = Field("time", description="column of the time: name, or place (count)")
    displacement: str | int = Field(
        "displacement", description="column of the displacement of the platen: name, or place (count)"
    )
    force: str | int = Field(
        "force", description="column of the force of the machine on both stacks: name, or place (count)"
    )
    normal_force: str | int | None = Field(
        None,
        description="column of the normal force, in place of the key normal_force: name, or place (count)",
    )


class ShearUnits(Section):
    """Units of the columns."""

    time: str = Field("s", description="unit of the time, such as s or ms")
    displacement: str = Field(description="unit of the displacement, such as mm or um")
    force: str = Field(description="unit of the force, such as N or kN")
    normal_force: str = Field("N", description="unit of the column of the normal force, such as N or kN")


class ShearRecordSettings(LabSettings):
    """Settings shared by `shear` and `friction`."""

    PATHS: ClassVar[tuple[str, ...]] = ("rigid",)

    columns: ShearColumns = Field(default_factory=ShearColumns, description="columns of the files")
    units: ShearUnits = Field(description="units of the columns; those of displacement and force are required")
    normal_force: Real | list[Real] | None = Field(
        None, description="normal force of one piston, N: one number, or one per file"
    )
    profile: Profile | list[Profile] = Field(
        "auto",
        description="kind of test, one for all files or one per file: ramp up to slip, loops between two limits, "
        "sliding at constant rates; auto finds it",
    )
    fixture_stiffness: Real | None = Field(None, gt=0, description="stiffness of fixture and machine, N/m, removed")
    fixture_stiffness_error: Real = Field(0.0, ge=0, description="standard error of fixture_stiffness, N/m")
    rigid: str | None = Field(
        None, description="record of a rigid specimen with the same columns; its compliance is removed"
    )
    rigid_degree: Whole = Field(1, ge=1, le=4, description="degree of its polynomial over the force (count)")
    event_rule: Literal["auto", "force_drop", "displacement_jump", "none"] = Field(
        "auto", description="onset of slip in ramps: rule that finds it; auto takes the first, none skips the capacity"
    )
    event_drop: Real = Field(DROP, gt=0, description="force drop at the onset of slip, N")
    event_jump: Real | None = Field(
        None, gt=0, description="distance from the elastic line at the onset of slip, m; default: 20 % of the "
        "elastic displacement at the largest force"
    )  # fmt: skip
    window: Annotated[list[Real], Field(min_length=2, max_length=2)] = Field(
        default_factory=lambda: list(WINDOW),
        description="fractions of the capacity between which the stiffness is fitted, dimensionless",
    )
    skip: Real = Field(0.0, ge=0, description="displacement at the start of sliding records that is left out, m")
    steady: Real = Field(
        STEADY, gt=0, le=1, description="last part of a stretch of constant rate that is averaged, dimensionless"
    )
    skip_cycles: Whole = Field(1, ge=0, description="first cycles of loops that are left out (count)")
    moving_mass: Real = Field(0.0, ge=0, description="mass between load cell and specimen, kg; its inertia is removed")


class ShearSettings(ShearRecordSettings):
    """Settings of the evaluation `shear`."""

    area: Real | None = Field(None, gt=0, description="contact area of a stack, m^2, for the shear modulus")
    thickness: Real | None = Field(None, gt=0, description="thickness of a stack, m, for the shear modulus")
