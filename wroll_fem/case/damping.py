"""Case section `damping`: material damping of the structure."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Self

from pydantic import Field, field_validator, model_validator

from wroll_fem.case.base import Real, Section, SparseSection, _number, validation_error

LARGEST = 0.5
"""Largest damping ratio of a mode; a lightly damped structure is assumed."""

_REMEDY = "write one damping ratio, one per natural frequency (lowest first), or pairs [frequency in Hz, damping ratio]"


class Rayleigh(Section):
    """Viscous damping C = alpha M + beta K; K is the stiffness of the bodies without the interfaces."""

    alpha: Real = Field(default=0.0, ge=0, description="factor of the mass matrix, 1/s")
    beta: Real = Field(default=0.0, ge=0, description="factor of the stiffness matrix, s")


class LossFactor(Section):
    """Loss factors of the materials; each mode is damped by the share of its strain energy in mandrel and coil."""

    mandrel: Real = Field(default=0.0, ge=0, le=2 * LARGEST, description="loss factor of the mandrel, dimensionless")
    coil: Real = Field(default=0.0, ge=0, le=2 * LARGEST, description="loss factor of the coil, dimensionless")


class Damping(SparseSection):
    """Material damping in addition to friction: one of modal, rayleigh and loss_factor."""

    modal: float | list[float] | list[tuple[float, float]] | None = Field(
        default=None,
        description="damping ratio of the modes with sticking interfaces, dimensionless: one number for all modes; a "
        "list for natural frequencies 1, 2, ... of the model (its last number holds for all higher modes; modes of "
        "equal frequency count as one); or pairs [frequency in Hz, damping ratio], linear between them",
    )
    rayleigh: Rayleigh | None = Field(default=None, description="damping proportional to mass and stiffness")
    loss_factor: LossFactor | None = Field(default=None, description="loss factors of mandrel and coil")

    @field_validator("modal", mode="before")
    @classmethod
    def _ratios(cls, value: Any) -> Any:
        if value is None or not isinstance(value, list | tuple):
            return None if value is None else _ratio(value, value)
        pairs = [isinstance(entry, list | tuple) for entry in value]
        if not value or (any(pairs) and not (all(pairs) and all(len(entry) == 2 for entry in value))):
            raise validation_error("is neither a list of numbers nor a list of pairs", remedy=_REMEDY, value=value)
        if not any(pairs):
            return [_ratio(entry, value) for entry in value]
        table = [(float(_number(at)), _ratio(ratio, value)) for at, ratio in value]
        if any(later <= sooner for (sooner, _), (later, _) in pairwise(table)) or table[0][0] <= 0:
            raise validation_error(
                "frequencies are not positive and rising", remedy="sort the pairs by frequency, Hz", value=value
            )
        return table

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            raise validation_error(
                f"has {' and '.join(given) or 'no key'}, but must describe the damping once", show_value=False,
                remedy="give modal, rayleigh or loss_factor; for an undamped structure leave section damping out",
            )  # fmt: skip
        return self

    @property
    def ratios(self) -> tuple[float, ...]:
        """Damping ratios of the natural frequencies, lowest first; empty for another description."""
        if isinstance(self.modal, list):
            return tuple(entry for entry in self.modal if not isinstance(entry, tuple))
        return () if self.modal is None else (self.modal,)

    @property
    def table(self) -> tuple[tuple[float, float], ...]:
        """Pairs of frequency, Hz, and damping ratio; empty for another description."""
        return tuple(entry for entry in self.modal if isinstance(entry, tuple)) if isinstance(self.modal, list) else ()


def _ratio(value: Any, given: Any) -> float:
    number = _number(value)
    if not isinstance(number, int | float) or not 0.0 <= number <= LARGEST:
        raise validation_error(f"is not between 0 and {LARGEST:g}", remedy=_REMEDY, value=given)
    return float(number)
