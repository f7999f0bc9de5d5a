"""Case section `mandrel`: material and end conditions."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from wroll_fem.case.base import Real, SparseSection
from wroll_fem.case.material import Isotropic


class Mandrel(SparseSection):
    """Elastic tube of the mandrel with its end conditions."""

    material: Isotropic = Field(description="material of the mandrel: a section, or a name as in `wroll materials`")
    yield_stress: Real | None = Field(
        default=None, gt=0, description="yield stress, Pa; left out: no margin is computed"
    )
    tip_mass: Real = Field(default=0.0, ge=0, description="point mass on the axis at the tip, kg")
    tip: Literal["rigid", "free"] = Field(
        default="rigid",
        description="rigid: the tip ring moves as a rigid body (spool cap); free: the tip ring is unconstrained",
    )
    base: Literal["clamped", "free"] = Field(
        default="clamped",
        description="clamped: the base ring moves with the shaker; free: free-free mandrel (modal only)",
    )
