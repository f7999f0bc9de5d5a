"""Section `contact`: what acts between facing surfaces."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, field_validator

from .base import Real, Section, Switch, _number, wrong


class Friction(Section):
    """Friction law of the interfaces."""

    law: Literal["penalty_coulomb"] = Field(
        default="penalty_coulomb", description="penalty_coulomb: Coulomb friction with an elastic slip before sliding"
    )
    mu: Real = Field(ge=0, description="coefficient of friction, dimensionless")
    elastic_slip: Real = Field(
        gt=0,
        description="allowable elastic slip gamma*, m: relative displacement at which sliding starts (physics)",
    )


class Normal(Section):
    """Normal contact of the interfaces."""

    penalty: Literal["auto"] | float = Field(
        default="auto", description="normal contact stiffness, Pa/m; auto derives it from the layers' stiffness"
    )
    separation: Switch = Field(default=True, description="surfaces may separate; false: normal contact never opens")

    @field_validator("penalty", mode="before")
    @classmethod
    def _auto_or_positive(cls, value: Any) -> Any:
        if value == "auto":
            return value
        remedy = "write auto, or a positive stiffness in Pa/m"
        number = _number(value) if not isinstance(value, str) else _text_number(value, remedy)
        if not isinstance(number, int | float) or not 0 < number < float("inf"):
            raise wrong("must be auto or a positive number", remedy=remedy, value=value)
        return float(number)


def _text_number(text: str, remedy: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise wrong("must be auto or a positive number", remedy=remedy, value=text) from None


class Contact(Section):
    """Contact between mandrel and layers, and between layers."""

    friction: Friction = Field(description="tangential behaviour")
    normal: Normal = Field(default_factory=Normal, description="normal behaviour")
