"""Stress in a cantilevered tube under a distributed load and a tip load (thesis, section 2.3).

Only the mandrel resists bending; the roll contributes its inertia, which is part of the distributed load. z is the
height above the base and theta the angle from the direction of the load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray


@dataclass(frozen=True)
class Cantilever:
    """Cantilevered tube, clamped at z = 0, under transverse loads.

    Parameters
    ----------
    length, outer_radius, wall
        Dimensions, m; wall = outer_radius gives a solid bar.
    distributed
        Load per length, N/m; in vibration (mass per length) x (acceleration).
    tip
        Load at z = length, N.

    Raises
    ------
    InputError
        If a dimension is not positive, or the wall is thicker than the radius.

    Notes
    -----
    Euler-Bernoulli beam: plane cross-sections, linear elastic. The shear stress is the mean through the wall on radial
    cuts. It is in equilibrium with the shear force for any wall thickness (equation 2.20 with t = 2 x wall); in a thick
    tube the largest local value is up to about 10 % higher.
    """

    length: float
    outer_radius: float
    wall: float
    distributed: float = 0.0
    tip: float = 0.0

    def __post_init__(self) -> None:
        for key in ("length", "outer_radius", "wall"):
            if not getattr(self, key) > 0.0:
                raise InputError(
                    f"must be greater than 0, got {getattr(self, key)}", key=key, remedy="give a length in m"
                )
        if self.wall > self.outer_radius:
            raise InputError(
                f"the wall is thicker than the radius, got {self.wall:g}", key="wall",
                remedy=f"use {self.outer_radius:g} m or less",
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
        """Shear force V in N at heights z (m), an array of the shape of z: the resultant of the loads above z."""
        return self.distributed * (self.length - np.asarray(z, float)) + self.tip

    def moment(self, z: FloatArray | float) -> FloatArray:
        """Bending moment M in N m at heights z (m), an array of the shape of z."""
        above = self.length - np.asarray(z, float)
        return 0.5 * self.distributed * above**2 + self.tip * above

    def bending_stress(self, theta: FloatArray | float, z: FloatArray | float) -> FloatArray:
        """Axial stress at the outer surface, Pa, positive in tension: M y / I with y = -r cos(theta) (equation 2.19).

        The side at theta = 0, towards which the load acts, is in compression. theta in rad, z in m.
        """
        return -self.moment(z) * self.outer_radius * np.cos(theta) / self.second_moment

    def first_moment(self, theta: FloatArray | float) -> FloatArray:
        """First moment of area Q, m^3, of the part of the cross-section within +-theta (rad) of the load direction."""
        return 2.0 / 3.0 * (self.outer_radius**3 - self.inner_radius**3) * np.sin(theta)

    def shear_stress(self, theta: FloatArray | float, z: FloatArray | float) -> FloatArray:
        """Transverse shear stress averaged through the wall, Pa: V Q / (I t) with t = 2 x wall (equation 2.20).

        Zero at theta = 0 and pi and largest at the neutral axis: 2 V/A in a thin tube, 4 V/(3 A) in a solid bar.
        """
        return self.shear_force(z) * self.first_moment(theta) / (self.second_moment * 2.0 * self.wall)
