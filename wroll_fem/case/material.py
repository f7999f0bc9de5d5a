"""Material sections of the case file."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Self

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from wroll_fem.bodies.material_library import LIBRARY
from wroll_fem.bodies.materials import CONSTANTS, CylindricalOrthotropic, violation
from wroll_fem.case.base import Real, Section, Switch, validation_error

if TYPE_CHECKING:
    from wroll_fem.bodies.laminate import Lamina, Laminate, Ply


class InPlane(NamedTuple):
    """Elastic constants of a wall in its plane: Young's moduli along z and theta and shear modulus, Pa."""

    E_z: float
    E_theta: float
    nu_theta_z: float
    G_z_theta: float


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

    @property
    def in_plane(self) -> InPlane:
        """Elastic constants in the plane of a wall."""
        return InPlane(self.E, self.E, self.nu, self.E / (2 * (1 + self.nu)))

    def lamina(self) -> Lamina:
        """Constitutive law of a ply."""
        from wroll_fem.bodies.laminate import Lamina

        return Lamina.isotropic(self.E, self.nu, self.rho)

    def as_plies(self, thickness: float) -> tuple[Ply, ...]:
        """Plies of a wall of ``thickness``, m."""
        return _single_ply(self.lamina(), thickness)


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

    @property
    def in_plane(self) -> InPlane:
        """Elastic constants in the plane of the web."""
        return InPlane(self.E_z, self.E_theta, self.nu_theta_z, self.G_z_theta)


class LaminaMaterial(Section):
    """Linear elastic, orthotropic material of a ply or of a whole wall, with direction 1 along its fibres."""

    kind: Literal["lamina"] = Field(
        default="lamina",
        description="lamina: orthotropic in its plane (shells); direction 1 along the axis, or at the angle of the ply",
    )
    E_1: Real = Field(gt=0, description="Young's modulus along direction 1, Pa")
    E_2: Real = Field(gt=0, description="Young's modulus across it, in the plane, Pa")
    nu_12: Real = Field(description="Poisson's ratio, dimensionless: -strain_2 / strain_1 under stress along 1")
    G_12: Real = Field(gt=0, description="shear modulus in the plane, Pa")
    G_13: Real = Field(
        default_factory=_like("G_12"), gt=0,
        description="transverse shear modulus along 1, Pa; default: G_12, exact for fibres in direction 1",
    )  # fmt: skip
    G_23: Real = Field(gt=0, description="transverse shear modulus along 2, Pa")
    rho: Real = Field(gt=0, description="density, kg/m^3")

    @model_validator(mode="after")
    def _admissible(self) -> Self:
        bound = math.sqrt(self.E_1 / self.E_2)
        if not abs(self.nu_12) < bound:
            raise validation_error(
                f"violates |nu_12| < sqrt(E_1 / E_2) = {bound:.4g}: the strain energy is not positive definite",
                key="nu_12", value=self.nu_12, remedy="reduce nu_12, or exchange E_1 and E_2 if 1 is not the fibre",
            )  # fmt: skip
        return self

    @property
    def in_plane(self) -> InPlane:
        """Elastic constants in the plane of a wall with direction 1 along the axis."""
        return InPlane(self.E_1, self.E_2, self.nu_12 * self.E_2 / self.E_1, self.G_12)

    def lamina(self) -> Lamina:
        """Constitutive law of a ply."""
        from wroll_fem.bodies.laminate import Lamina

        return Lamina(self.E_1, self.E_2, self.nu_12, self.G_12, self.G_13, self.G_23, self.rho)

    def as_plies(self, thickness: float) -> tuple[Ply, ...]:
        """Plies of a wall of ``thickness``, m."""
        return _single_ply(self.lamina(), thickness)


def _single_ply(lamina: Lamina, thickness: float) -> tuple[Ply, ...]:
    from wroll_fem.bodies.laminate import Ply

    return (Ply(lamina, thickness),)


def as_section(value: Any) -> Any:
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
    """Content of a material section; a missing `kind` follows from its keys, and is isotropic otherwise."""
    if isinstance(value, dict) and "kind" not in value:
        kind = "laminate" if "plies" in value else "lamina" if "E_1" in value else "isotropic"
        return {"kind": kind, **value}
    return value


class _OrName:
    """Annotation of a material section that may also be a name of the library."""

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"anyOf": [handler(core), {"enum": list(LIBRARY)}]}


Isotropic = Annotated[IsotropicMaterial, BeforeValidator(as_section), _OrName]
"""Section of an isotropic material, or a name of the library."""


PlyMaterial = Annotated[
    IsotropicMaterial | LaminaMaterial,
    Field(discriminator="kind"),
    BeforeValidator(_kind_of),
    BeforeValidator(as_section),
    _OrName,
]
"""Section of the material of a ply, or a name of the library."""


class PlySection(Section):
    """One ply of a laminate."""

    material: PlyMaterial = Field(description="material of the ply: a section, or a name as in `wroll materials`")
    thickness: Real = Field(gt=0, description="thickness of the ply, m")
    angle: Real = Field(
        default=0.0, ge=-180, le=180,
        description="angle of direction 1 from the roll's axis z towards theta, deg",
    )  # fmt: skip


class LaminateMaterial(Section):
    """Plies of a wall, innermost first."""

    kind: Literal["laminate"] = Field(
        default="laminate", description="laminate: plies with material, thickness and angle (shells)"
    )
    plies: list[PlySection] = Field(min_length=1, description="plies, innermost first")
    symmetric: Switch = Field(
        default=False, description="whether the plies are followed by the same plies in reverse order"
    )

    def as_plies(self, thickness: float) -> tuple[Ply, ...]:
        """Plies of the wall; their own thicknesses sum to ``thickness``, m, which `case.checks_walls` has checked."""
        from wroll_fem.bodies.laminate import Ply

        stack = [Ply(p.material.lamina(), p.thickness, math.radians(p.angle)) for p in self.plies]
        return (*stack, *(reversed(stack) if self.symmetric else ()))

    @property
    def thickness(self) -> float:
        """Thickness of all plies, m."""
        return (2 if self.symmetric else 1) * math.fsum(ply.thickness for ply in self.plies)

    @property
    def rho(self) -> float:
        """Mean density, kg/m^3."""
        mass = math.fsum(ply.thickness * ply.material.rho for ply in self.plies)
        return mass / math.fsum(ply.thickness for ply in self.plies)

    @property
    def in_plane(self) -> InPlane:
        """Elastic constants of the wall in its plane."""
        return InPlane(*self._laminate().engineering_constants())

    def _laminate(self) -> Laminate:
        from wroll_fem.bodies.laminate import Laminate

        return Laminate(self.as_plies(self.thickness))


WallMaterial = Annotated[
    IsotropicMaterial | LaminaMaterial | LaminateMaterial,
    Field(discriminator="kind"),
    BeforeValidator(_kind_of),
    BeforeValidator(as_section),
    _OrName,
]
"""Section of the material of the mandrel, or a name of the library."""

Material = Annotated[
    IsotropicMaterial | OrthotropicMaterial | LaminaMaterial | LaminateMaterial,
    Field(discriminator="kind"),
    BeforeValidator(_kind_of),
    BeforeValidator(as_section),
    _OrName,
]
"""Section of the material of a coil, or a name of the library."""
