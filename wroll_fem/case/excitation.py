"""Section `excitation`: the motion of the base."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from .base import Real, Section, wrong


class _BaseMotion(Section):
    amplitude: Real = Field(gt=0, description="amplitude of the base acceleration, m/s^2, 0-peak")
    direction: Literal["x", "y"] = Field(
        default="x",
        description="direction of the base motion; y cannot use the symmetry plane and solves the whole roll",
    )


class ChirpExcitation(_BaseMotion):
    """Geometric (exponential) chirp of constant acceleration amplitude."""

    kind: Literal["chirp"] = Field(description="chirp: geometric sine sweep upwards in frequency")
    f_start: Real = Field(gt=0, description="first frequency, Hz")
    f_end: Real = Field(gt=0, description="last frequency, Hz")
    rate_oct_per_min: Real = Field(gt=0, description="sweep rate, octaves per minute")
    ramp_cycles: Real = Field(default=0.0, ge=0, description="length of the smooth start, cycles")

    @model_validator(mode="after")
    def _upwards(self) -> Self:
        if self.f_end <= self.f_start:
            raise wrong(
                f"must be above excitation.f_start = {self.f_start:g} Hz", key="f_end", value=self.f_end,
                remedy="chirps run upwards: give f_end > f_start, in Hz",
            )  # fmt: skip
        return self

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency of the base motion, Hz."""
        return self.f_end


class DwellExcitation(_BaseMotion):
    """Sine of constant frequency and amplitude."""

    kind: Literal["dwell"] = Field(description="dwell: sine at one frequency")
    frequency: Real = Field(gt=0, description="frequency, Hz")
    cycles: Real = Field(gt=0, description="length, cycles")
    ramp_cycles: Real = Field(default=5.0, ge=0, description="length of the smooth start, cycles")

    @model_validator(mode="after")
    def _ramp_fits(self) -> Self:
        if self.ramp_cycles > self.cycles:
            raise wrong(
                f"the smooth start is longer than the dwell of {self.cycles:g} cycles", key="ramp_cycles",
                value=self.ramp_cycles, remedy="use fewer ramp_cycles or more cycles",
            )  # fmt: skip
        return self

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency of the base motion, Hz."""
        return self.frequency


Excitation = Annotated[ChirpExcitation | DwellExcitation, Field(discriminator="kind")]
