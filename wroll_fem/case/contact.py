"""Case section `contact`: friction and normal contact at the interfaces."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, Union

from pydantic import BeforeValidator, Field, create_model, field_validator, model_validator

from wroll_fem.case.base import Real, Section, Switch, TaggedSection, _number, validation_error
from wroll_fem.case.units import WrongQuantity
from wroll_fem.contact.law import FrictionLaw, parameters
from wroll_fem.contact.rate_table import table_problem
from wroll_fem.contact.registry import BY_NAME, LAWS

_ELASTIC_SLIP = "allowable elastic slip gamma*, m: relative displacement at which sliding starts"


class PenaltyFriction(Section):
    """Coulomb friction with an elastic slip before sliding."""

    law: Literal["penalty_coulomb"] = Field(
        default="penalty_coulomb", description="penalty_coulomb: Coulomb friction with an elastic slip before sliding"
    )
    mu: Real = Field(ge=0, description="coefficient of friction, dimensionless")
    elastic_slip: Real = Field(gt=0, description=_ELASTIC_SLIP)


class RateTable(Section):
    """Table of the coefficient of friction versus slip rate: linear between rows, constant beyond the last row."""

    slip_rate: list[Real] = Field(description="slip rates, m/s, rising from 0")
    mu: list[Real] = Field(description="coefficient of friction at each slip rate, dimensionless")

    @model_validator(mode="after")
    def _admissible(self) -> Self:
        found = table_problem(self.slip_rate, self.mu)
        if found is not None:
            raise validation_error(
                found.problem, key=found.column, value=getattr(self, found.column), remedy=found.remedy
            )
        return self


def _at_rest(given: dict[str, Any]) -> float:
    """Coefficient of friction at rest: the first value of the table."""
    table = given.get("rate_table")
    return math.nan if table is None else table.mu[0]


class RateFriction(TaggedSection):
    """Coulomb friction whose coefficient depends on the slip rate."""

    law: Literal["rate_coulomb"] = Field(
        default="rate_coulomb",
        description="rate_coulomb: as penalty_coulomb with a coefficient that depends on the slip rate",
    )
    elastic_slip: Real = Field(gt=0, description=_ELASTIC_SLIP)
    rate_table: RateTable = Field(description="coefficient of friction versus slip rate")
    mu: Real = Field(
        default_factory=_at_rest,
        description="coefficient of friction at rest, dimensionless; default: the first value of rate_table",
    )

    @model_validator(mode="after")
    def _first_of_table(self) -> Self:
        first = self.rate_table.mu[0]
        if self.mu != first:
            raise validation_error(
                f"must equal the first coefficient of rate_table, {first:g}", key="mu", value=self.mu,
                remedy="leave mu out, or change rate_table.mu too",
            )  # fmt: skip
        return self


class SmoothedFriction(TaggedSection):
    """Regularised Coulomb friction: a smooth function of the slip rate, zero at rest."""

    law: Literal["smoothed_coulomb"] = Field(
        default="smoothed_coulomb",
        description="smoothed_coulomb: mu p S(slip rate / reference_speed), S(x) = 2/(1 + exp(-x)) - 1; "
        "no elastic slip",
    )
    mu: Real = Field(ge=0, description="coefficient of friction well above reference_speed, dimensionless")
    reference_speed: Real = Field(
        gt=0, description="slip rate, m/s, below which friction acts as a viscous damper; S is 0.46 there"
    )


def _law_of(value: Any) -> Any:
    """Content of the section `friction`; a missing `law` is set to penalty_coulomb."""
    if isinstance(value, dict) and "law" not in value:
        return {"law": "penalty_coulomb", **value}
    return value


def derived_section(law: type[FrictionLaw]) -> type[Section]:
    """Case section of a friction law; keys, bounds and descriptions are taken from the parameters of the law."""
    keys: dict[str, Any] = {"law": (Literal[law.name], Field(description=f"{law.name}: {law.sentence}"))}
    for name, parameter in parameters(law).items():
        keys[name] = (Real, Field(gt=parameter.above, ge=parameter.least, description=parameter.meaning))
    first_line = (law.__doc__ or law.sentence).partition("\n")[0]
    return create_model(f"{law.__name__}Friction", __base__=Section, __module__=__name__, __doc__=first_line, **keys)


WRITTEN: dict[str, type[Section]] = {
    "penalty_coulomb": PenaltyFriction,
    "rate_coulomb": RateFriction,
    "smoothed_coulomb": SmoothedFriction,
}
"""Friction law -> its case section, for laws whose section is written in this file. The sections of all other laws are
generated from `contact.registry`."""

if TYPE_CHECKING:
    Friction = PenaltyFriction | RateFriction | SmoothedFriction
else:
    _SECTIONS = tuple(WRITTEN.get(law.name) or derived_section(law) for law in LAWS if law.in_rolls)
    Friction = Annotated[Union[_SECTIONS], Field(discriminator="law"), BeforeValidator(_law_of)]  # noqa: UP007


def friction_law(friction: Friction) -> FrictionLaw:
    """Friction law of one interface, from the case section `contact.friction`."""
    return BY_NAME[friction.law].from_section(friction)


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
        plain = isinstance(value, str) and not isinstance(value, WrongQuantity)
        number = _text_number(value, remedy) if plain else _number(value)
        if not isinstance(number, int | float) or not 0 < number < float("inf"):
            raise validation_error("must be auto or a positive number", remedy=remedy, value=value)
        return float(number)


def _text_number(text: str, remedy: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise validation_error("must be auto or a positive number", remedy=remedy, value=text) from None


class Contact(Section):
    """Contact between mandrel and layers, and between layers."""

    friction: Friction = Field(description="tangential behaviour")
    normal: Normal = Field(default_factory=Normal, description="normal behaviour")
