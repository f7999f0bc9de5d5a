"""Case section `random_response`: levels and limits of the random response of a backbone."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from pydantic import Field, field_validator

from wroll_fem.case.base import Real, Section, validation_error


class ResponseLimits(Section):
    """Limits of the response, each for `sigma` times the rms; the run gives the level of the base that reaches them."""

    tip_displacement: Real | None = Field(default=None, gt=0, description="displacement of the tip to the base, m")
    tip_acceleration: Real | None = Field(default=None, gt=0, description="absolute acceleration of the tip, m/s^2")
    slip: Real | None = Field(
        default=None, gt=0, description="relative displacement of two layers at the point where it is largest, m"
    )
    stress: Real | None = Field(
        default=None,
        gt=0,
        description="von Mises stress of the vibration, without the preload, at the point where it is largest, Pa",
    )

    @property
    def given(self) -> dict[str, float]:
        """Limits that are given: name -> value."""
        return {name: value for name in type(self).model_fields if (value := getattr(self, name)) is not None}


class RandomResponse(Section):
    """Levels and limits of the response of a backbone to a random base motion."""

    levels_db: list[float] = Field(
        default=[-20.0, -15.0, -10.0, -5.0, 0.0, 5.0, 10.0],
        description="levels of the PSD relative to excitation.psd, dB (10 dB: ten times the PSD), ascending",
    )
    sigma: Real = Field(
        default=3.0, gt=0, le=10, description="multiple of the rms that a limit holds for, dimensionless"
    )
    limits: ResponseLimits = Field(default_factory=ResponseLimits, description="limits of the response")

    @field_validator("levels_db", mode="before")
    @classmethod
    def _ascending(cls, value: Any) -> Any:
        remedy = "write levels in dB in ascending order, for example [-10, 0, 10]"
        levels = value if isinstance(value, list | tuple) else [value]
        numbers = all(isinstance(level, int | float) and not isinstance(level, bool) for level in levels)
        if not levels or not numbers or not all(abs(level) <= 120 for level in levels):
            raise validation_error("must be numbers between -120 and 120 dB", remedy=remedy, value=value)
        if any(high <= low for low, high in pairwise(levels)):
            raise validation_error("must ascend", remedy=remedy, value=value)
        return [float(level) for level in levels]
