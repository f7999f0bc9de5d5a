"""Material sections of the case file."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from wroll_fem.bodies.material_library import LIBRARY
from wroll_fem.bodies.materials import CONSTANTS, CylindricalOrthotropic, violation
from wroll_fem.case.base import Real, Section, validation_error


class IsotropicMaterial(Section):
    """Linear elastic isotropic material."""

    kind: Literal["isotropic"] = Field(
        default="isotropic", exclude=True, description="isotropic: the same in every direction; may be left out"
    )
    E: Real = Field(gt=0, description="Young's modulus, Pa")
    nu: Real = Field(gt=-1, lt=0.5, description="Poisson's ratio, dimensionless; admissible when -1 < nu < 0.5")
    rho: Real = Field(gt=0, description="density, kg/m^3")

    def solid(self) -> CylindricalOrthotropic:
        """Constitutive law in three dimensions."""
        return CylindricalOrthotropic.isotropic(self.E, self.nu, self.rho)


def _like(key: str) -> Callable[[dict[str, Any]], float]:
    """Function that returns the value of the elastic constant ``key`` as the default of another elastic constant."""
    return lambda given: given.get(key, math.nan)


def _isotropic_shear(given: dict[str, Any]) -> float:
    """In-plane shear modulus, Pa, of a web that is isotropic in its plane."""
    E, nu = given.get("E_theta", math.nan), given.get("nu_theta_z", math.nan)
    return 0.0 if nu <= -1 else E / (2 * (1 + nu))


class OrthotropicMaterial(Section):
    """Linear elastic, cylindrically orthotropic material of a homogenised coil (axes r, theta, z)."""

    kind: Literal["cylindrical_orthotropic"] = Field(
        description="cylindrical_orthotropic: nine elastic constants in the axes r, theta, z (coil.model: solid)"
    )
    E_theta: Real = Field(gt=0, description="Young's modulus along the web, Pa")
    E_z: Real = Field(
        default_factory=_like("E_theta"),
        gt=0,
        description="Young's modulus along the roll's axis, Pa; default: E_theta",
    )
    E_r: Real = Field(gt=0, description="Young's modulus through the stack of wraps, Pa")
    nu_theta_z: Real = Field(
        description="Poisson's ratio, dimensionless: -strain_z / strain_theta under stress along theta"
    )
    nu_theta_r: Real = Field(
        description="Poisson's ratio, dimensionless: -strain_r / strain_theta under stress along theta"
    )
    nu_z_r: Real = Field(description="Poisson's ratio, dimensionless: -strain_r / strain_z under stress along z")
    G_z_theta: Real = Field(
        default_factory=_isotropic_shear, gt=0,
        description="in-plane shear modulus of the web, Pa; default: E_theta / (2 (1 + nu_theta_z)), for "
        "in-plane isotropy",
    )  # fmt: skip
    G_r_theta: Real = Field(gt=0, description="shear modulus between wraps around the roll, Pa")
    G_r_z: Real = Field(
        default_factory=_like("G_r_theta"),
        gt=0,
        description="shear modulus between wraps along the axis, Pa; default: G_r_theta",
    )
    rho: Real = Field(gt=0, description="density, kg/m^3")

    @model_validator(mode="after")
    def _isotropic_in_plane(self) -> Self:
        """Require the in-plane shear modulus unless the web is isotropic in its plane."""
        if "G_z_theta" not in self.model_fields_set and self.E_z != self.E_theta:
            raise validation_error(
                f"required key is missing: the web is not isotropic in its plane (E_z = {self.E_z:g} Pa, "
                f"E_theta = {self.E_theta:g} Pa)",
                key="G_z_theta", show_value=False, remedy="give the in-plane shear modulus of the web, Pa",
            )  # fmt: skip
        return self

    @model_validator(mode="after")
    def _admissible(self) -> Self:
        found = violation(self)
        if found is not None:
            raise validation_error(found.problem, key=found.key, value=found.value, remedy=found.remedy)
        return self

    def solid(self) -> CylindricalOrthotropic:
        """Constitutive law in three dimensions."""
        return CylindricalOrthotropic(**{name: getattr(self, name) for name in CONSTANTS})


def _known(value: Any) -> Any:
    """Content of a material section that is given by a name of the library; anything else is returned unchanged."""
    if not isinstance(value, str):
        return value
    found = LIBRARY.get(value.lower().replace("-", "_"))
    if found is None:
        near = difflib.get_close_matches(value.lower(), LIBRARY, n=1, cutoff=0.4)
        meant = f"did you mean {near[0]}? " if near else ""
        remedy = f"{meant}use one of {', '.join(LIBRARY)}, or a section with E, nu and rho"
        raise validation_error("is not a known material", remedy=remedy, value=value)
    return {"E": found.E, "nu": found.nu, "rho": found.rho}


def _kind_of(value: Any) -> Any:
    """Content of a material section; a missing `kind` is set to isotropic."""
    if isinstance(value, dict) and "kind" not in value:
        return {"kind": "isotropic", **value}
    return value


class _OrName:
    """Annotation of a material section that may also be a name of the library."""

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"anyOf": [handler(core), {"enum": list(LIBRARY)}]}


Isotropic = Annotated[IsotropicMaterial, BeforeValidator(_known), _OrName]
"""Section of an isotropic material, or a name of the library."""

Material = Annotated[
    IsotropicMaterial | OrthotropicMaterial,
    Field(discriminator="kind"),
    BeforeValidator(_kind_of),
    BeforeValidator(_known),
    _OrName,
]
"""Section of a material, or a name of the library."""
