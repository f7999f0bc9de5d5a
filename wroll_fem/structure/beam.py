"""Stress in a cantilevered tube under a distributed load and one at the tip: estimates of section 2.3 of the source.

The mandrel alone bends; the roll counts by its inertia, in the distributed load. z is the height above the base,
theta the angle from the direction of the load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray


@dataclass(frozen=True)
class Cantilever:
    """Tube clamped at z = 0 under transverse loads.

    Parameters
    ----------
    length, outer_radius, wall
        m; wall = outer_radius is a solid bar.
    distributed
        Load along the length, N/m; for vibration (mass per length) x (acceleration).
    tip
        Load at z = length, N.

    Raises
    ------
    InputError
        For a length or radius that is not positive, or a wall that does not fit the radius.

    Notes
    -----
    Euler-Bernoulli: plane cross-sections, linear elastic. The shear stress is the mean through the wall on radial cuts,
    exact for the given shear force whatever the wall (equation 2.20 with the cut width t = 2 x wall); in a thick
    tube the largest local value is higher by up to some 10 %.
    """

    length: float
    outer_radius: float
    wall: float
    distributed: float = 0.0
    tip: float = 0.0

    def __post_init__(self) -> None:
        for key in ("length", "outer_radius", "wall"):
            if not getattr(self, key) > 0.0:
                raise InputError(f"must be greater than 0, got {getattr(self, key)}", key=key, remedy="give it in m")
        if self.wall > self.outer_radius:
            raise InputError(
                f"the wall is thicker than the radius, got {self.wall:g}", key="wall",
                remedy=f"use outer_radius = {self.outer_radius:g} m or less",
            )  # fmt: skip

    @property
    def inner_radius(self) -> float:
        """Inner radius, m."""
        return self.outer_radius - self.wall

    @property
    def area(self) -> float:
        """Area of the cross-section, m^2."""
        return float(np.pi * (self.outer_radius**2 - self.inner_radius**2))

    @property
    def second_moment(self) -> float:
        """Second moment of area about the neutral axis, I, m^4."""
        return float(np.pi / 4.0 * (self.outer_radius**4 - self.inner_radius**4))

    def shear_force(self, z: FloatArray | float) -> FloatArray:
        """V at height z in m, N, same shape: what hangs on above."""
        return self.distributed * (self.length - np.asarray(z, float)) + self.tip

    def moment(self, z: FloatArray | float) -> FloatArray:
        """M at height z in m, N m, same shape."""
        above = self.length - np.asarray(z, float)
        return 0.5 * self.distributed * above**2 + self.tip * above

    def bending_stress(self, theta: FloatArray | float, z: FloatArray | float) -> FloatArray:
        """Axial stress at the outer surface, Pa: M y / I with y = -r cos(theta) (equation 2.19).

        Positive in tension; the face that looks along the load (theta = 0) is compressed.
        """
        return -self.moment(z) * self.outer_radius * np.cos(theta) / self.second_moment

    def first_moment(self, theta: FloatArray | float) -> FloatArray:
        """Q of the part of the cross-section within +-theta of the load's direction, m^3: integral of y dA."""
        return 2.0 / 3.0 * (self.outer_radius**3 - self.inner_radius**3) * np.sin(theta)

    def shear_stress(self, theta: FloatArray | float, z: FloatArray | float) -> FloatArray:
        """Transverse shear stress along the wall, mean through it, Pa: V Q / (I t), t = 2 x wall (equation 2.20).

        Zero at theta = 0 and pi, largest at the neutral axis; 2 V/A sin(theta) in a thin tube, 4 V/(3 A) in a bar.
        """
        return self.shear_force(z) * self.first_moment(theta) / (self.second_moment * 2.0 * self.wall)
