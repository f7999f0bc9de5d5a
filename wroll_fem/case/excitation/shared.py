"""What all base motions of the case file share: direction, amplitude, checks of numbers."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import Field, GetJsonSchemaHandler, model_validator
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


class AmplitudeSection(TaggedSection):
    """Base motion with one amplitude of acceleration, in m/s^2 or in g."""

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
            what = AmplitudeSection.model_fields["amplitude"].description
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


def positive(value: Any, remedy: str) -> float:
    """Return ``value``, a number or a text that contains one, as a finite number above zero; refuse anything else."""
    number = _number(value)
    if not isinstance(number, int | float) or not 0 < number < math.inf:
        raise validation_error("must be a number above zero", remedy=remedy, value=value)
    return float(number)
