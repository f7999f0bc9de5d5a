"""Parts of the case section `mandrel`: springs at its ends and the inertia of the tip mass."""

from __future__ import annotations

from pydantic import Field

from wroll_fem.case.base import Real, SparseSection


class BaseSprings(SparseSection):
    """Springs between the base ring of the mandrel, which stays rigid, and the base; a direction left out is held."""

    lateral: Real | None = Field(default=None, ge=0, description="stiffness along x and along y, N/m; left out: held")
    axial: Real | None = Field(default=None, ge=0, description="stiffness along the axis, N/m; left out: held")
    tilt: Real | None = Field(default=None, ge=0, description="stiffness about x and about y, N m/rad; left out: held")
    torsion: Real | None = Field(default=None, ge=0, description="stiffness about the axis, N m/rad; left out: held")

    @property
    def six(self) -> tuple[float | None, ...]:
        """Stiffness along and about x, y, z; None where the ring is held."""
        return (self.lateral, self.lateral, self.axial, self.tilt, self.tilt, self.torsion)


class TipSprings(SparseSection):
    """Springs between the rigid tip of the mandrel and the base, for example a second bearing or a launch lock."""

    lateral: Real = Field(default=0.0, ge=0, description="stiffness along x and along y, N/m")
    axial: Real = Field(default=0.0, ge=0, description="stiffness along the axis, N/m")
    tilt: Real = Field(default=0.0, ge=0, description="stiffness about x and about y, N m/rad")
    torsion: Real = Field(default=0.0, ge=0, description="stiffness about the axis, N m/rad")

    @property
    def six(self) -> tuple[float, ...]:
        """Stiffness along and about x, y, z."""
        return (self.lateral, self.lateral, self.axial, self.tilt, self.tilt, self.torsion)


class TipInertia(SparseSection):
    """Moments of inertia of the tip mass about its centre of mass."""

    transverse: Real = Field(default=0.0, ge=0, description="moment of inertia about x and about y, kg m^2")
    polar: Real = Field(default=0.0, ge=0, description="moment of inertia about the axis, kg m^2")


PINNED = BaseSprings(tilt=0.0)
"""Springs of a pinned base: it can tilt freely."""
