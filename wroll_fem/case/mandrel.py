"""Case section `mandrel`: material and end conditions."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from wroll_fem.bodies.materials import CylindricalOrthotropic
from wroll_fem.case.base import Real, Section, SparseSection, validation_error
from wroll_fem.case.material import IsotropicMaterial, WallMaterial
from wroll_fem.case.supports import PINNED, BaseSprings, TipInertia, TipSprings


class WallRow(Section):
    """Thickness of the wall at one height."""

    z: Real = Field(ge=0, description="height above the base, m; two rows with the same height are a step")
    thickness: Real = Field(gt=0, description="thickness of the wall there, m")


class Mandrel(SparseSection):
    """Elastic tube of the mandrel with its end conditions."""

    material: WallMaterial = Field(
        description="material of the mandrel: isotropic (a section, or a name as in `wroll materials`), or "
        "kind: lamina or laminate"
    )
    wall: list[WallRow] | None = Field(
        default=None, min_length=2,
        description="thickness of the wall over the height, linear between the rows; the outer surface stays a "
        "cylinder. geometry.mandrel_thickness is then the nominal thickness",
    )  # fmt: skip
    yield_stress: Real | None = Field(
        default=None, gt=0, description="yield stress, Pa; left out: no margin is computed"
    )
    tip_mass: Real = Field(default=0.0, ge=0, description="point mass on the axis at the tip, kg")
    tip_offset: Real | None = Field(
        default=None, description="height of the centre of the tip mass above the tip ring, m (rigid tip)"
    )
    tip_inertia: TipInertia | None = Field(
        default=None, description="moments of inertia of the tip mass about its centre (rigid tip)"
    )
    tip: Literal["rigid", "free"] = Field(
        default="rigid",
        description="rigid: the tip ring moves as a rigid body (spool cap); free: the tip ring is unconstrained",
    )
    tip_springs: TipSprings | None = Field(
        default=None, description="springs between a rigid tip and the base: a second bearing, a launch lock"
    )
    base: Literal["clamped", "free", "pinned", "sprung"] = Field(
        default="clamped",
        description="clamped: the base ring moves with the shaker; free: free-free mandrel (modal only); "
        "pinned: the base ring is rigid and tilts freely; sprung: the base ring is rigid and stands on base_springs",
    )
    base_springs: BaseSprings | None = Field(
        default=None, description="springs between a rigid base ring and the base (base: sprung)"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.base == "sprung") != (self.base_springs is not None):
            given = self.base_springs is not None
            raise validation_error(
                f"base is {self.base}, but base_springs are given" if given else "required key is missing",
                key="base_springs", show_value=False,
                remedy="write base: sprung, or leave base_springs out" if given else "add it, for example {tilt: 1e4}",
            )  # fmt: skip
        for key in ("tip_springs", "tip_inertia", "tip_offset"):
            if getattr(self, key) is not None and self.tip != "rigid":
                raise validation_error(
                    "needs a rigid tip ring", key=key, show_value=False, remedy="use tip: rigid, or leave it out"
                )
        if self.tip_offset and not self.tip_mass:
            raise validation_error(
                "has no effect without a tip mass", key="tip_offset", value=self.tip_offset, remedy="give tip_mass too"
            )
        return self

    @model_validator(mode="after")
    def _yields(self) -> Self:
        if self.yield_stress is not None and not isinstance(self.material, IsotropicMaterial):
            raise validation_error(
                "does not apply to plies, whose strength differs along and across their fibres", key="yield_stress",
                value=self.yield_stress, remedy="leave it out; runs give the stresses of the plies (ply_stress_max)",
            )  # fmt: skip
        return self

    @model_validator(mode="after")
    def _wall_ascends(self) -> Self:
        heights = [row.z for row in self.wall or []]
        if heights != sorted(heights):
            raise validation_error(
                "the heights of the rows must ascend", key="wall", show_value=False, remedy="sort the rows by z"
            )
        return self

    def solid(self) -> CylindricalOrthotropic:
        """Constitutive law of the mandrel in three dimensions.

        Raises
        ------
        TypeError
            If the material is that of a shell.
        """
        if not isinstance(self.material, IsotropicMaterial):
            raise TypeError(f"a mandrel of kind {self.material.kind} has no material of a solid")
        return self.material.solid()

    @property
    def is_layered(self) -> bool:
        """Whether the wall has plies, or a thickness that varies."""
        return self.wall is not None or not isinstance(self.material, IsotropicMaterial)

    @property
    def springs(self) -> BaseSprings | None:
        """Springs at a pinned or sprung base; None for a clamped or free base."""
        return PINNED if self.base == "pinned" else self.base_springs

    @property
    def is_cantilever(self) -> bool:
        """Whether the base is clamped and the tip carries nothing but a point mass at its ring."""
        bare = self.tip_springs is None and self.tip_inertia is None and not self.tip_offset
        return self.base == "clamped" and bare
