"""Case section `excitation`: base motion."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import (
    Field,
    GetJsonSchemaHandler,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from wroll_fem.case.base import Real, TaggedSection, _number, validation_error

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of gravity, m/s^2; `scipy.constants.g` is slow to import."""

Direction = Annotated[
    Literal["x", "y"],
    Field(
        description="direction of the base motion; with y the whole roll is solved, because the symmetry plane "
        "does not apply"
    ),
]


def _from_gravities(given: dict[str, Any]) -> float:
    """Default of `amplitude`, m/s^2: the value of `amplitude_g` in SI; NaN if neither was given."""
    level: float | None = given.get("amplitude_g")
    return math.nan if level is None else float(f"{level * STANDARD_GRAVITY:.15g}")


class _BaseMotion(TaggedSection):
    amplitude_g: Real | None = Field(
        default=None,
        gt=0,
        exclude=True,
        description="amplitude of the base acceleration, multiples of 9.80665 m/s^2, 0-peak: in place of amplitude",
    )
    amplitude: Real = Field(
        default_factory=_from_gravities, gt=0, description="amplitude of the base acceleration, m/s^2, 0-peak"
    )
    direction: Direction = "x"

    @model_validator(mode="after")
    def _one_amplitude(self) -> Self:
        if self.amplitude_g is not None and "amplitude" in self.model_fields_set:
            raise validation_error(
                f"the amplitude is given twice: amplitude = {self.amplitude:g} m/s^2", key="amplitude_g",
                value=self.amplitude_g, remedy="give only one of them",
            )  # fmt: skip
        if math.isnan(self.amplitude):
            what = _BaseMotion.model_fields["amplitude"].description
            remedy = f"add it ({what}), or amplitude_g in multiples of 9.80665 m/s^2"
            raise validation_error("required key is missing", key="amplitude", show_value=False, remedy=remedy)
        if self.amplitude_g is not None:  # the case is in SI: the same as if amplitude had been given
            self.__dict__["amplitude_g"] = None
            self.model_fields_set.symmetric_difference_update({"amplitude", "amplitude_g"})
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """JSON schema in which one of the two amplitudes is required."""
        schema = super().__get_pydantic_json_schema__(core, handler)
        return schema | {"oneOf": [{"required": ["amplitude"]}, {"required": ["amplitude_g"]}]}


class ChirpExcitation(_BaseMotion):
    """Geometric (exponential) chirp of constant acceleration amplitude."""

    kind: Literal["chirp"] = Field(default="chirp", description="chirp: geometric sine sweep upwards in frequency")
    f_start: Real = Field(gt=0, description="first frequency, Hz")
    f_end: Real = Field(gt=0, description="last frequency, Hz")
    rate_oct_per_min: Real = Field(gt=0, description="sweep rate, octaves per minute")
    ramp_cycles: Real = Field(default=0.0, ge=0, description="length of the smooth start, cycles")

    @model_validator(mode="after")
    def _upwards(self) -> Self:
        if self.f_end <= self.f_start:
            raise validation_error(
                f"must be above excitation.f_start = {self.f_start:g} Hz", key="f_end", value=self.f_end,
                remedy="give f_end > f_start, in Hz",
            )  # fmt: skip
        return self

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency of the base motion, Hz."""
        return self.f_end


class DwellExcitation(_BaseMotion):
    """Sine motion of the base with constant frequency and amplitude."""

    kind: Literal["dwell"] = Field(default="dwell", description="dwell: sine at one frequency")
    frequency: Real = Field(gt=0, description="frequency, Hz")
    cycles: Real = Field(gt=0, description="length, cycles")
    ramp_cycles: Real = Field(default=5.0, ge=0, description="length of the smooth start, cycles")

    @model_validator(mode="after")
    def _ramp_fits(self) -> Self:
        if self.ramp_cycles > self.cycles:
            raise validation_error(
                f"the smooth start is longer than the dwell of {self.cycles:g} cycles", key="ramp_cycles",
                value=self.ramp_cycles, remedy="use fewer ramp_cycles or more cycles",
            )  # fmt: skip
        return self

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency of the base motion, Hz."""
        return self.frequency


class SineExcitation(TaggedSection):
    """Steady sine motion of the base at several acceleration levels, for modal_transient and slip_damping."""

    kind: Literal["sine"] = Field(
        default="sine", description="sine: steady, at one frequency and several levels (modal_transient, slip_damping)"
    )
    frequency: Literal["resonance"] | float = Field(
        description="frequency, Hz, or resonance: the natural frequency of the mode with the largest effective mass "
        "along the direction (the first bending mode of a cantilevered roll)"
    )
    direction: Direction = "x"
    amplitude_g: list[float] = Field(
        description="levels of the base acceleration, multiples of 9.80665 m/s^2, 0-peak, ascending"
    )

    mode: Literal["bending", "torsion", "axial"] = Field(
        default="bending",
        description="mode that slip_damping follows: bending (the base moves along direction), torsion (the base turns "
        "about the axis of the roll; levels are the acceleration at the outer surface of the mandrel), axial (the base "
        "moves along the axis)",
    )

    @model_validator(mode="after")
    def _without_direction(self) -> Self:
        if self.mode != "bending" and "direction" in self.model_fields_set:
            raise validation_error(
                f"is the direction of bending; mode: {self.mode} has none", key="direction", value=self.direction,
                remedy="leave it out, or use mode: bending",
            )  # fmt: skip
        return self

    @model_serializer(mode="wrap")
    def _plain(self, plain: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Serialise without the mode if it is bending, and without the direction otherwise."""
        unused = "mode" if self.mode == "bending" else "direction"
        return {key: value for key, value in dict(plain(self)).items() if key != unused}

    @field_validator("frequency", mode="before")
    @classmethod
    def _hertz(cls, value: Any) -> Any:
        return value if value == "resonance" else _positive(value, "write a frequency in Hz, or resonance")

    @field_validator("amplitude_g", mode="before")
    @classmethod
    def _levels(cls, value: Any) -> Any:
        remedy = "write positive levels in ascending order, in g, for example [1, 5, 15]"
        levels = [_positive(entry, remedy) for entry in (value if isinstance(value, list | tuple) else [value])]
        if not levels or any(b <= a for a, b in pairwise(levels)):
            raise validation_error("must be an ascending list of levels", remedy=remedy, value=value)
        return levels

    @property
    def amplitude(self) -> float:
        """Largest level of the base acceleration, m/s^2, 0-peak."""
        return STANDARD_GRAVITY * self.amplitude_g[-1]

    @property
    def highest_frequency_hz(self) -> float:
        """Frequency of the base motion, Hz; NaN for `resonance`, because that frequency is computed in the run."""
        return math.nan if isinstance(self.frequency, str) else self.frequency


def _positive(value: Any, remedy: str) -> float:
    number = _number(value)
    if not isinstance(number, int | float) or not 0 < number < math.inf:
        raise validation_error("must be a number above zero", remedy=remedy, value=value)
    return float(number)


Excitation = Annotated[ChirpExcitation | DwellExcitation | SineExcitation, Field(discriminator="kind")]
