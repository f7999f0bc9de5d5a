"""Case sections that describe a roll."""

from __future__ import annotations

from pydantic import Field

from wroll_fem.case.base import Section
from wroll_fem.case.coil import Coil
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.mandrel import Mandrel
from wroll_fem.case.mesh import Mesh

ROLL = ("geometry", "mandrel", "coil")
"""Required case sections of a roll."""


class RollSections(Section):
    """Geometry, mandrel, coil and mesh of a roll.

    Every case on a roll is an instance of this class. An instance can also be made from the four sections alone.
    """

    geometry: Geometry = Field(description="tube of the mandrel")
    mandrel: Mandrel = Field(description="material and end conditions of the mandrel")
    coil: Coil = Field(description="model of the wound web")
    mesh: Mesh = Field(default_factory=Mesh, description="element counts or a mesh file")

    @property
    def structure_text(self) -> str:
        """Text that is the same for cases with the same bodies."""
        return " ".join(part.model_dump_json() for part in (self.geometry, self.mandrel, self.coil, self.mesh))

    @property
    def suits_fourier(self) -> bool:
        """Whether Fourier elements describe walls and coil: no plies, a uniform wall, no margins."""
        return not (self.mandrel.is_layered or self.coil.is_layered or self.coil.margins is not None)

    @property
    def clamped_width(self) -> float:
        """Width of the clamped annulus at the base of a solid coil, from the mandrel outwards, m; 0 for a bare edge."""
        if not self.coil.rubs or self.coil.base != "inner_edge":
            return 0.0
        width = self.coil.base_width
        return min(self.geometry.mandrel_thickness, self.coil.total_thickness) if width is None else width

    @property
    def coil_span(self) -> tuple[float, float]:
        """Heights at which the coil begins and ends, m."""
        margins, length = self.coil.margins, self.geometry.length
        return (0.0, length) if margins is None else (margins.base, length - margins.tip)
