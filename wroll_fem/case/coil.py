"""Section `coil`: how the wound web is modelled."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from .base import Real, Section, Switch, Whole, wrong
from .material import IsotropicMaterial

#: Keys that every model of the coil except `none` needs.
_NEEDED = ("total_thickness", "material")


def _lab_layer() -> IsotropicMaterial:
    return IsotropicMaterial(E=2.8e9, nu=0.35, rho=2000.0)


class Coil(Section):
    """The wound web as concentric layers, or as something simpler to compare with."""

    model: Literal["layers", "bonded", "nonstructural_mass", "none"] = Field(
        description="layers: concentric shells with friction between them; bonded: the same without slip; "
        "nonstructural_mass: mass without stiffness; none: the mandrel alone"
    )
    layers: Whole = Field(default=1, ge=1, description="number of concentric layers (count)")
    total_thickness: Real = Field(
        default_factory=lambda: 1.25e-3,
        gt=0,
        description="thickness of all layers together, m (each is total / layers)",
    )
    material: IsotropicMaterial = Field(default_factory=_lab_layer, description="material of the layers")
    base: Literal["free", "clamped", "inner_edge"] = Field(
        default="free",
        description="base ring of the layers: free (held by friction alone), clamped (moves with the shaker), "
        "inner_edge (only the innermost layer is clamped)",
    )
    bending: Switch = Field(default=True, description="layers resist bending (shells); false: membranes")

    @field_validator("model", mode="before")
    @classmethod
    def _available(cls, value: Any) -> Any:
        if value == "solid":
            remedy = "use layers, bonded, nonstructural_mass or none"
            raise wrong("the solid (homogenised) coil is not available yet", remedy=remedy, value=value)
        return value

    @model_validator(mode="after")
    def _complete(self) -> Self:
        for key in _NEEDED:
            if self.model != "none" and key not in self.model_fields_set:
                what = type(self).model_fields[key].description
                remedy = f"add it ({what}); only model: none goes without"
                raise wrong("required key is missing", key=key, remedy=remedy, show_value=False)
        return self

    @property
    def layer_thickness(self) -> float:
        """Thickness of one layer, m."""
        return self.total_thickness / self.layers
