"""Case section `preload`: kind of preload, and external pressure on the layers."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from wroll_fem.case.base import SparseSection, Switch, Whole, _number, validation_error

DEFAULT_STEPS = 10
"""Default number of load steps of the static preload."""


class Preload(SparseSection):
    """Nonlinear static preload, computed before the vibration."""

    kind: Literal["external_pressure", "interface_pressure", "winding_stress", "winding_tension"] = Field(
        default="external_pressure",
        description="external_pressure: pressure on the outside of layers; interface_pressure: external pressures that "
        "give every interface a mean pressure; winding_stress: the coil presses on the mandrel with its own winding "
        "stress, uniformly and without an external load; winding_tension: external pressures that give every interface "
        "the mean pressure of the wound roll (case section winding)",
    )
    pressure: float | list[float] | None = Field(
        default=None,
        description="pressure, Pa: with external_pressure one number acts on the outermost layer, a list on each layer "
        "(inner first); with interface_pressure and winding_stress one number applies to every interface, a list to "
        "each (inner first); winding_stress without it takes the pressure of the wound roll (case section winding); "
        "left out with winding_tension",
    )
    steps: Whole = Field(default=DEFAULT_STEPS, ge=1, le=10000, description="load steps of the static preload (count)")
    geometric_stiffness: Switch = Field(
        default=False,
        description="add the geometric stiffness of the preload to the structure: membrane stress of the shells, "
        "follower pressure, contact pressure between sliding surfaces; refused above the linear buckling load",
    )

    @field_validator("pressure", mode="before")
    @classmethod
    def _pressures(cls, value: Any) -> Any:
        if value is None:
            return value
        if not isinstance(value, list | tuple):
            return _pressure(value)
        if not value:
            remedy = "write one pressure, or one per layer (inner first), Pa"
            raise validation_error("the list of pressures is empty", remedy=remedy, value=value)
        return [_pressure(entry) for entry in value]

    @model_validator(mode="after")
    def _pressure_or_winding(self) -> Self:
        if self.kind == "winding_tension" and self.pressure is not None:
            raise validation_error(
                "must be left out with kind: winding_tension, which computes "
                "the pressure", key="pressure", value=self.pressure,
                remedy="leave it out, or use kind: external_pressure",
            )  # fmt: skip
        if self.kind in ("external_pressure", "interface_pressure") and self.pressure is None:
            what = "external pressure, Pa: one number acts on the outermost layer, a list on each layer (inner first)"
            if self.kind == "interface_pressure":
                what = "mean pressure of every interface, Pa: one number, or a list (inner first)"
            raise validation_error(
                "required key is missing", key="pressure", show_value=False, remedy=f"add it ({what})"
            )
        given = self.pressure if isinstance(self.pressure, list) else [self.pressure]
        if self.kind == "interface_pressure" and 0.0 in given:
            raise validation_error(
                "no external pressure gives an interface a mean pressure of zero", key="pressure", value=self.pressure,
                remedy="give pressures above 0 Pa, or use kind: external_pressure",
            )  # fmt: skip
        return self

    @property
    def needs_winding(self) -> bool:
        """Whether the pressures follow from the case section `winding`."""
        return self.kind == "winding_tension" or (self.kind == "winding_stress" and self.pressure is None)

    def per_interface(self, interfaces: int) -> list[float]:
        """Prescribed pressure of each interface, Pa, inner first (kinds interface_pressure, winding_stress).

        Raises
        ------
        ValueError
            If the pressures follow from the section `winding`.
        """
        if self.pressure is None:
            raise ValueError(f"the pressures of {self.kind} follow from the section winding")
        return list(self.pressure) if isinstance(self.pressure, list) else [self.pressure] * interfaces

    def per_layer(self, layers: int) -> list[float]:
        """External pressure on the outside of each layer, Pa, inner first (kind external_pressure).

        Raises
        ------
        ValueError
            For kind winding_tension.
        """
        if self.pressure is None:
            raise ValueError("the pressures of winding_tension follow from the structure: `winding_preload`")
        if isinstance(self.pressure, list):
            return list(self.pressure)
        return [0.0] * (layers - 1) + [self.pressure]

    def bare_interfaces(self, layers: int) -> list[int]:
        """Interfaces that the given pressures leave without pressure, counted from 1 at the mandrel.

        Empty for pressures that are computed. An external pressure on a layer presses every interface further in.
        """
        if self.pressure is None or self.kind not in ("external_pressure", "winding_stress"):
            return []
        if self.kind == "winding_stress":
            return [k for k, pressure in enumerate(self.per_interface(layers), 1) if pressure == 0.0]
        outside = self.per_layer(layers)
        return [k for k in range(1, layers + 1) if not any(outside[k - 1 :])]


def _pressure(value: Any) -> float:
    number = _number(value)
    if not isinstance(number, int | float) or not 0 <= number < float("inf"):
        remedy = "write a pressure of 0 Pa or more, or a list with one per layer"
        raise validation_error("must be 0 or positive (inward pressure)", remedy=remedy, value=value)
    return float(number)
