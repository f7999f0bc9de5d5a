"""Homogeneous tube: geometry, material and non-structural mass."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Tube:
    """Homogeneous isotropic tube.

    Attributes
    ----------
    length, outer_radius, thickness
        m.
    E, nu, rho
        Young's modulus (Pa), Poisson's ratio, density (kg/m^3).
    extra_mass
        Non-structural mass, spread evenly over the mid-surface, kg.
    """

    length: float
    outer_radius: float
    thickness: float
    E: float
    nu: float
    rho: float
    extra_mass: float = 0.0

    @property
    def radius(self) -> float:
        """Radius of the mid-surface, m."""
        return self.outer_radius - 0.5 * self.thickness

    @property
    def area(self) -> float:
        """Area of the cross-section, m^2."""
        return 2.0 * math.pi * self.radius * self.thickness

    @property
    def mass(self) -> float:
        """Mass of the wall without the non-structural mass, kg."""
        return self.rho * self.area * self.length

    @property
    def edge_decay(self) -> float:
        """Decay rate of axisymmetric edge bending, 1/m: beta^4 = 3 (1 - nu^2) / (R t)^2."""
        return float((3.0 * (1.0 - self.nu**2)) ** 0.25 / math.sqrt(self.radius * self.thickness))
