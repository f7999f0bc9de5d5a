"""Sine motions of the base: chirp, dwell, and steady sine at several levels."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, field_validator, model_serializer, model_validator

from wroll_fem.case.base import Real, Section, TaggedSection, validation_error
from wroll_fem.case.excitation.shared import STANDARD_GRAVITY, AmplitudeSection, Direction, positive


class ProfileSection(Section):
    """Factor of the amplitude of a sweep over its frequency, as in notched test specifications."""

    frequency: list[Real] = Field(min_length=2, description="ascending frequencies, Hz")
    factor: list[Real] = Field(
        min_length=2, description="factors of the amplitude, dimensionless, log-log between the frequencies; the first "
        "and the last one hold outside"
    )  # fmt: skip

    @model_validator(mode="after")
    def _rows(self) -> Self:
        rising = all(b > a for a, b in pairwise(self.frequency)) and min(*self.frequency, *self.factor) > 0.0
        if len(self.frequency) != len(self.factor) or not rising:
            raise validation_error(
                f"{len(self.frequency)} frequencies and {len(self.factor)} factors, which have to be as many, above "
                "zero, and sorted by frequency", show_value=False,
                remedy="write for example {frequency: [20, 90, 110, 200], factor: [1, 1, 0.5, 0.5]}",
            )  # fmt: skip
        return self


class ChirpExcitation(AmplitudeSection):
    """Sine sweep, geometric (exponential) or linear in time, upward or downward."""

    kind: Literal["chirp"] = Field(default="chirp", description="chirp: sine sweep")
    f_start: Real = Field(gt=0, description="first frequency, Hz")
    f_end: Real = Field(gt=0, description="last frequency, Hz; below f_start for a downward sweep (analysis: sweep)")
    rate_oct_per_min: Real | None = Field(
        default=None, gt=0, description="sweep rate of a geometric sweep, octaves per minute"
    )
    rate_hz_per_s: Real | None = Field(
        default=None, gt=0, description="sweep rate of a linear sweep, Hz/s: in place of rate_oct_per_min"
    )
    ramp_cycles: Real = Field(default=0.0, ge=0, description="length of the smooth start, cycles")
    profile: ProfileSection | None = Field(default=None, description="factor of the amplitude over the frequency")
    sweep_direction: Literal["up", "down", "up_down"] | None = Field(
        default=None,
        description="up, down, or up_down: from f_start up to f_end and back in one run (analysis: sweep); by default "
        "from f_start to f_end",
    )

    @model_validator(mode="after")
    def _one_rate(self) -> Self:
        if self.f_end == self.f_start:
            raise validation_error(
                f"is excitation.f_start = {self.f_start:g} Hz", key="f_end", value=self.f_end,
                remedy="give two different frequencies, in Hz, or use kind: dwell",
            )  # fmt: skip
        if self.rate_oct_per_min is not None and self.rate_hz_per_s is not None:
            raise validation_error(
                f"the rate is given twice: rate_oct_per_min = {self.rate_oct_per_min:g}", key="rate_hz_per_s",
                value=self.rate_hz_per_s, remedy="give only one of them",
            )  # fmt: skip
        if self.rate_oct_per_min is None and self.rate_hz_per_s is None:
            raise validation_error(
                "required key is missing", key="rate_oct_per_min", show_value=False,
                remedy="add it (sweep rate, octaves per minute), or rate_hz_per_s for a linear sweep",
            )  # fmt: skip
        return self

    @model_validator(mode="after")
    def _ends_follow_the_direction(self) -> Self:
        if self.sweep_direction is None or (self.f_end < self.f_start) == (self.sweep_direction == "down"):
            return self
        side = "below" if self.sweep_direction == "down" else "above"
        raise validation_error(
            f"the frequency runs from {self.f_start:g} to {self.f_end:g} Hz", key="sweep_direction",
            value=self.sweep_direction, remedy=f"give f_end {side} f_start, or leave sweep_direction out",
        )  # fmt: skip

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency of the base motion, Hz."""
        return max(self.f_start, self.f_end)

    @property
    def most_cycles(self) -> float:
        """Length of the motion times its highest frequency, cycles."""
        if self.rate_hz_per_s is not None:
            return self.highest_frequency_hz * abs(self.f_end - self.f_start) / self.rate_hz_per_s
        octaves = abs(math.log2(self.f_end) - math.log2(self.f_start))
        return self.highest_frequency_hz * 60.0 * octaves / (self.rate_oct_per_min or math.inf)

    @property
    def attributes(self) -> dict[str, float | str]:
        """Attributes of results that describe the motion."""
        linear, geometric = self.rate_hz_per_s, self.rate_oct_per_min
        rate = {"rate_hz_per_s": linear} if linear is not None else {"rate_oct_per_min": geometric or 0.0}
        found: dict[str, float | str] = {"f_start_hz": self.f_start, "f_end_hz": self.f_end, **rate}
        if self.sweep_direction is not None:
            found["sweep_direction"] = self.sweep_direction
        return found | {"amplitude_m_s2": self.amplitude}


class DwellExcitation(AmplitudeSection):
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
    def most_cycles(self) -> float:
        """Length of the motion, cycles."""
        return self.cycles

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency of the base motion, Hz."""
        return self.frequency

    @property
    def attributes(self) -> dict[str, float]:
        """Attributes of results that describe the motion."""
        return {"frequency_hz": self.frequency, "amplitude_m_s2": self.amplitude}


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
        return value if value == "resonance" else positive(value, "write a frequency in Hz, or resonance")

    @field_validator("amplitude_g", mode="before")
    @classmethod
    def _levels(cls, value: Any) -> Any:
        remedy = "write positive levels in ascending order, in g, for example [1, 5, 15]"
        levels = [positive(entry, remedy) for entry in (value if isinstance(value, list | tuple) else [value])]
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
