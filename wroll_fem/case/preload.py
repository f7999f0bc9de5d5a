"""Section `preload`: what presses the layers onto the mandrel."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, field_validator

from .base import Section, Whole, _number, wrong


class Preload(Section):
    """Nonlinear static step before the vibration."""

    kind: Literal["external_pressure"] = Field(
        default="external_pressure", description="external_pressure: pressure on the outside of layers"
    )
    pressure: float | list[float] = Field(
        description="external pressure, Pa: one number acts on the outermost layer, a list on each layer (inner first)"
    )
    steps: Whole = Field(default=10, ge=1, description="load steps of the static preload (count)")

    @field_validator("pressure", mode="before")
    @classmethod
    def _pressures(cls, value: Any) -> Any:
        if not isinstance(value, list | tuple):
            return _pressure(value)
        if not value:
            remedy = "write one pressure, or one per layer (inner first), Pa"
            raise wrong("the list of pressures is empty", remedy=remedy, value=value)
        return [_pressure(entry) for entry in value]

    def per_layer(self, layers: int) -> list[float]:
        """Pressure on the outside of each layer, inner first, Pa."""
        if isinstance(self.pressure, list):
            return list(self.pressure)
        return [0.0] * (layers - 1) + [self.pressure]


def _pressure(value: Any) -> float:
    number = _number(value)
    if not isinstance(number, int | float) or not 0 <= number < float("inf"):
        remedy = "write a pressure of 0 Pa or more, or a list with one per layer"
        raise wrong("must be a pressure that presses inwards", remedy=remedy, value=value)
    return float(number)
