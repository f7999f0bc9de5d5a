"""Case section `probes`: named points on the shells; results contain their motion and the motion of the tip."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from wroll_fem.case.base import Real, Section


class ProbePoint(Section):
    """Point on the mid-surface of the mandrel or of a layer, and direction of its displacement."""

    z: Real = Field(ge=0, description="height above the base, m")
    theta: Real = Field(default=0.0, description="angle from the x-axis, rad")
    direction: Literal["x", "y", "z", "radial", "hoop"] = Field(
        default="x", description="direction of the displacement: x, y, z (axial), radial (outward) or hoop"
    )
    body: str = Field(
        default="mandrel", description="shell that holds the point: mandrel, layer_01, layer_02, ... (inner first)"
    )


Probes = dict[str, ProbePoint]
