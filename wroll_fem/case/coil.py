"""Case section `coil`: model of the wound web."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.case.base import Real, Section, Switch, Whole, validation_error
from wroll_fem.case.material import (
    IsotropicMaterial,
    LaminaMaterial,
    LaminateMaterial,
    Material,
    OrthotropicMaterial,
    as_section,
)
from wroll_fem.case.units import in_si

#: Keys that every coil model except `none` needs.
_NEEDED = ("total_thickness", "material")

#: Keys of shells; a solid coil does not use them.
_OF_SHELLS = ("layers", "bending")

SHELL_COILS = ("layers", "bonded")
"""Coil models that consist of shells."""


def _lab_layer() -> IsotropicMaterial:
    return IsotropicMaterial(E=2.8e9, nu=0.35, rho=2000.0)


def _number(data: Mapping[str, Any], keys: tuple[str, ...], section: type[Section]) -> float | None:
    """Positive number in SI of the first key that is given; None without one."""
    key = next((name for name in keys if data.get(name) is not None), None)
    value = None if key is None else data[key]
    if key is not None and isinstance(value, str):
        value = in_si(value, section.unit_of(key))
    try:
        return number if value is not None and (number := float(value)) > 0 else None
    except (TypeError, ValueError):
        return None


def _written_thickness(given: dict[str, Any]) -> float:
    """Default of `total_thickness`, m: the value of `thickness` if given, else the layer thickness of the lab roll.

    Only `model: none`, which has no coil, may leave out both keys.
    """
    written: float | None = given.get("thickness")
    return 1.25e-3 if written is None else written


class Margins(Section):
    """Lengths of the mandrel that the coil does not cover."""

    base: Real = Field(default=0.0, ge=0, description="length without coil at the base, m")
    tip: Real = Field(default=0.0, ge=0, description="length without coil at the tip, m")


class WrapInterfaces(Section):
    """Interfaces between the wraps, which make a solid coil softer than its web: the more, the lower the pressure."""

    elastic_slip: Real = Field(
        ge=0,
        description="elastic slip gamma* of an interface between two wraps at its friction limit, m: with the pressure "
        "P(r), mu and wrap_thickness h of section winding the shear modulus between the wraps is 1/G = 1/G_r_theta + "
        "gamma*/(mu P h); 0: that of the web",
    )
    radial_modulus: Literal["material", "winding"] = Field(
        default="material",
        description="radial modulus of the coil: material (E_r of coil.material), or winding (the law "
        "winding.web.radial_modulus at the pressure P(r))",
    )


class Coil(Section):
    """Model of the wound web: layers with or without slip, a homogenised solid, mass without stiffness, or no coil."""

    model: Literal["layers", "solid", "bonded", "nonstructural_mass", "none"] = Field(
        description="layers: concentric shells with friction between them; solid: homogenised solid bonded to the "
        "mandrel (coiled-stiff); bonded: layers without slip; nonstructural_mass: mass without stiffness; "
        "none: the mandrel alone"
    )
    layers: Whole = Field(default=1, ge=1, le=200, description="number of concentric layers (count)")
    per_wrap: Switch = Field(
        default=False,
        description="contact.friction is that of one interface between two wraps (model: layers, section winding): an "
        "interface between two layers has the elastic slip of all wrap interfaces it stands for, wraps / layers of "
        "them, and the interface at the mandrel that of (wraps / layers + 1) / 2; false: of one",
    )
    thickness: Real | None = Field(
        default=None, gt=0, description="thickness of the coil, m: alias of total_thickness, used with solid"
    )
    total_thickness: Real = Field(
        default_factory=_written_thickness,
        gt=0,
        description="thickness of all layers together, m (each layer has total_thickness divided by layers)",
    )
    material: Material = Field(
        default_factory=_lab_layer,
        description="material of the coil: isotropic (a section, or a name as in `wroll materials`), kind: lamina or "
        "laminate for layers, or kind: cylindrical_orthotropic for solid",
    )
    areal_mass: Real | None = Field(
        default=None, gt=0,
        description="mass per area of all wraps together, kg/m^2; in place of material.rho, which becomes areal_mass / "
        "total_thickness",
    )  # fmt: skip
    yield_stress: Real | None = Field(
        default=None, gt=0, description="yield stress of the layers, Pa; left out: no margin is computed"
    )
    base: Literal["free", "clamped", "inner_edge", "guided"] = Field(
        default="free",
        description="base of the coil: free (held by friction or the bond alone), clamped (moves with the shaker), "
        "inner_edge (only the innermost layer, or the inner edge of the solid, is clamped), guided (the ring of every "
        "layer moves with the shaker in the radial and hoop direction and is held by base_stiffness along the axis)",
    )
    interface: Literal["bonded", "friction"] = Field(
        default="bonded",
        description="between a solid coil and the mandrel: bonded (no slip), or friction (sections contact and "
        "preload); model: layers always has friction",
    )
    inside: Literal["stiff", "slipping"] = Field(
        default="stiff",
        description="wraps of a solid coil: stiff (they do not slip), or slipping (they slide where the shear stress "
        "reaches the friction capacity of section winding; slip_damping, harmonic, backbone, random_response, sweep, "
        "dwell)",
    )
    pressure: Literal["fixed", "varying"] = Field(
        default="fixed",
        description="pressure between the wraps that slide (inside: slipping): fixed (that of the wound roll at rest), "
        "or varying (less the radial stress of the motion, and zero where this is the larger one)",
    )
    wrap_interfaces: WrapInterfaces | None = Field(
        default=None,
        description="shear modulus between the wraps from their interfaces (inside: slipping): G_r_theta of the "
        "material is then that of the web alone; left out: G_r_theta is that of the coil",
    )
    base_width: Real | None = Field(
        default=None, ge=0,
        description="width of the clamped annulus at the base of a solid coil, from the mandrel outwards, m; with "
        "base: inner_edge and interface: friction; left out: the wall thickness of the mandrel; 0: the bare edge, "
        "whose stiffness falls with the size of the elements",
    )  # fmt: skip
    base_stiffness: Real = Field(
        default=0.0,
        ge=0,
        description="axial spring between the ring of each layer and the base, per length of the ring, N/m^2; "
        "with base: guided",
    )
    margins: Margins | None = Field(
        default=None, description="lengths of the mandrel without coil at both ends (layers, bonded); left out: none"
    )
    bending: Switch = Field(default=True, description="layers resist bending (shells); false: membranes")

    @model_validator(mode="before")
    @classmethod
    def _density_from_areal_mass(cls, data: Any) -> Any:
        """Replace `areal_mass` by the density of the material."""
        if not isinstance(data, Mapping) or data.get("areal_mass") is None:
            return data
        written, known = data.get("material"), as_section(data.get("material"))
        mass, thickness = (_number(data, keys, cls) for keys in (("areal_mass",), ("total_thickness", "thickness")))
        if not isinstance(known, Mapping) or mass is None or thickness is None:
            return data  # `_complete` and the keys refuse the rest
        if isinstance(written, Mapping) and ("rho" in known or "plies" in known):
            raise validation_error(
                f"does not go with material.{'rho' if 'rho' in known else 'plies'}, which has the density too",
                key="areal_mass", value=mass, remedy="give one of them",
            )  # fmt: skip
        rest = {key: value for key, value in data.items() if key != "areal_mass"}
        return rest | {"material": {**known, "rho": mass / thickness}}

    @model_validator(mode="after")
    def _complete(self) -> Self:
        given = self.model_fields_set
        if self.areal_mass is not None:
            raise validation_error(
                "needs the thickness and the material of the coil", key="areal_mass", value=self.areal_mass,
                remedy="give total_thickness and material",
            )  # fmt: skip
        if self.thickness is not None and self.total_thickness != self.thickness:
            raise validation_error(
                f"differs from total_thickness = {self.total_thickness:g} m, although both keys set the same thickness",
                key="thickness", value=self.thickness, remedy="give only one of them",
            )  # fmt: skip
        for key in _NEEDED:
            if self.model != "none" and key not in given and not (key == "total_thickness" and self.thickness):
                name = "thickness" if self.model == "solid" and key == "total_thickness" else key
                what = type(self).model_fields[name].description
                remedy = f"add it ({what}); only model: none works without it"
                raise validation_error("required key is missing", key=name, remedy=remedy, show_value=False)
        return self

    @model_validator(mode="after")
    def _fits_the_model(self) -> Self:
        for key in _OF_SHELLS:
            if self.model == "solid" and key in self.model_fields_set:
                raise validation_error(
                    "does not apply to a solid coil", key=key, value=getattr(self, key),
                    remedy="leave it out (in a solid coil, mesh.radial sets the number of elements through the "
                    "thickness), or use model: layers",
                )  # fmt: skip
        if self.per_wrap and self.model != "layers":
            other = "inside: slipping with wrap_interfaces" if self.model == "solid" else "model: layers"
            raise validation_error(
                f"is for layers that stand for several wraps, not for model: {self.model}", key="per_wrap", value=True,
                remedy=f"leave it out, or use {other}",
            )  # fmt: skip
        if self.base == "guided" and self.model not in SHELL_COILS:
            raise validation_error(
                f"applies to shells, not to model: {self.model}", key="base", value=self.base,
                remedy="use free, clamped or inner_edge, or model: layers",
            )  # fmt: skip
        if self.margins is not None and self.model not in SHELL_COILS:
            raise validation_error(
                f"apply to shells, not to model: {self.model}", key="margins", show_value=False,
                remedy="leave them out, or use model: layers or bonded",
            )  # fmt: skip
        if self.margins is not None and self.margins.base and self.base != "free":
            raise validation_error(
                "holds the coil to the shaker, but the coil begins above the base (margins.base)", key="base",
                value=self.base, remedy="use base: free, or leave margins.base out",
            )  # fmt: skip
        if self.yield_stress is not None and self.is_layered:
            raise validation_error(
                "does not apply to plies, whose strength differs along and across their fibres", key="yield_stress",
                value=self.yield_stress, remedy="leave it out; runs give the stresses of the plies (ply_stress_max)",
            )  # fmt: skip
        self._check_interface()
        if self.base != "guided" and "base_stiffness" in self.model_fields_set:
            raise validation_error(
                f"does not apply to base: {self.base}", key="base_stiffness", value=self.base_stiffness,
                remedy="leave it out, or use base: guided",
            )  # fmt: skip
        if self.model in SHELL_COILS and isinstance(self.material, OrthotropicMaterial):
            raise validation_error(
                f"shells (model: {self.model}) have no modulus through the stack of wraps", key="material.kind",
                value=self.material.kind, remedy="use kind: lamina, give E, nu and rho, or use model: solid",
            )  # fmt: skip
        if self.model == "solid" and isinstance(self.material, LaminaMaterial | LaminateMaterial):
            raise validation_error(
                "describes a shell, not a solid", key="material.kind", value=self.material.kind,
                remedy="use kind: cylindrical_orthotropic, or model: layers",
            )  # fmt: skip
        return self

    def _check_interface(self) -> None:
        if self.interface == "friction" and self.model != "solid":
            reason = "has friction between all shells" if self.model == "layers" else "has no interfaces"
            raise validation_error(
                f"is for a solid coil; model: {self.model} {reason}", key="interface", value=self.interface,
                remedy="leave it out, or use model: solid",
            )  # fmt: skip
        if self.inside == "slipping":
            self._check_inside()
        elif self.wrap_interfaces is not None:
            raise validation_error(
                "are for a solid coil whose wraps slide", key="wrap_interfaces", show_value=False,
                remedy="leave them out, or use inside: slipping and analysis: slip_damping",
            )  # fmt: skip
        elif self.pressure == "varying":
            raise validation_error(
                "is for a solid coil whose wraps slide", key="pressure", value=self.pressure,
                remedy="leave it out, or use inside: slipping and analysis: slip_damping",
            )  # fmt: skip
        if self.base_width is None:
            return
        if self.base != "inner_edge" or not self.rubs:
            raise validation_error(
                "is the width of the clamped edge of a solid coil that rubs on its mandrel", key="base_width",
                value=self.base_width, remedy="leave it out, or use base: inner_edge and interface: friction",
            )  # fmt: skip
        if self.base_width > self.total_thickness:
            raise validation_error(
                f"is wider than the coil, {self.total_thickness:g} m", key="base_width", value=self.base_width,
                remedy="give a smaller width, or use base: clamped",
            )  # fmt: skip

    def _check_inside(self) -> None:
        if self.model != "solid":
            raise validation_error(
                "is for a solid coil", key="inside", value=self.inside, remedy="leave it out, or use model: solid"
            )
        if isinstance(self.material, LaminaMaterial | LaminateMaterial):
            return  # the material is refused
        moduli = self.solid()
        if moduli.G_r_z != moduli.G_r_theta:
            raise validation_error(
                f"needs one shear modulus between the wraps, but G_r_z is {moduli.G_r_z:g} Pa and G_r_theta is "
                f"{moduli.G_r_theta:g} Pa: the limit would be an ellipse", key="inside", value=self.inside,
                remedy="give the same G_r_z and G_r_theta, or leave G_r_z out",
            )  # fmt: skip

    @model_serializer(mode="wrap")
    def _plain(self, plain: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Serialise without the alias of the thickness and without keys that the model does not use."""
        data = dict(plain(self))
        unused = set() if self.yield_stress is not None else {"yield_stress"}
        unused |= {"total_thickness" if self.thickness is not None else "thickness"}
        unused |= set(_OF_SHELLS) if self.model == "solid" else set()
        unused |= set() if self.base == "guided" else {"base_stiffness"}
        unused |= set() if self.rubs else {"interface"}
        unused |= set() if self.per_wrap else {"per_wrap"}
        unused |= set() if self.inside == "slipping" else {"inside"}
        unused |= set() if self.pressure == "varying" else {"pressure"}
        unused |= {key for key in ("base_width", "wrap_interfaces") if getattr(self, key) is None}
        unused |= {"areal_mass"} | (set() if self.margins is not None else {"margins"})
        return {key: value for key, value in data.items() if key not in unused}

    @property
    def layer_material(self) -> IsotropicMaterial | LaminaMaterial | LaminateMaterial:
        """Material of the layers.

        Raises
        ------
        TypeError
            If the material is that of a solid.
        """
        if isinstance(self.material, OrthotropicMaterial):
            raise TypeError(f"the {self.model} coil has no material of a layer")
        return self.material

    def solid(self) -> CylindricalOrthotropic:
        """Constitutive law of the coil in three dimensions.

        Raises
        ------
        TypeError
            If the material is that of a shell.
        """
        if isinstance(self.material, LaminaMaterial | LaminateMaterial):
            raise TypeError(f"the {self.model} coil has no material of a solid")
        return self.material.solid()

    @property
    def rubs(self) -> bool:
        """Whether the coil is a solid with friction on its mandrel."""
        return self.model == "solid" and self.interface == "friction"

    @property
    def slips(self) -> bool:
        """Whether the coil is a solid whose wraps slide."""
        return self.model == "solid" and self.inside == "slipping"

    @property
    def has_interfaces(self) -> bool:
        """Whether the coil can slip: layers, or a solid with friction on its mandrel."""
        return self.model == "layers" or self.rubs

    def holds(self, layer: int) -> bool:
        """Whether the base holds a layer (1: at the mandrel) in every direction."""
        if self.base == "guided":
            return self.base_stiffness > 0.0
        return self.base == "clamped" or (self.base == "inner_edge" and layer == 1)

    @property
    def is_layered(self) -> bool:
        """Whether the layers are shells with plies."""
        return self.model in SHELL_COILS and not isinstance(self.material, IsotropicMaterial)

    def interfaces_in_series(self, wraps: int) -> list[float]:
        """Number of wrap interfaces, of ``wraps`` wraps, that each interface of the layers stands for, inner first.

        A layer of m = wraps / layers wraps contains m - 1 wrap interfaces, one half of them on either side of its
        mid-surface. The interface of two layers stands for those between their mid-surfaces: (m - 1) / 2 in each, and
        itself. The interface at the mandrel has a layer on one side only.
        """
        count = wraps / self.layers
        return [0.5 * (count + 1.0)] + [count] * (self.layers - 1)

    @property
    def layer_thickness(self) -> float:
        """Thickness of one layer, m."""
        return self.total_thickness / self.layers
