"""Material sections of the case file."""

from __future__ import annotations

from pydantic import Field

from .base import Real, Section


class IsotropicMaterial(Section):
    """Linear elastic isotropic material."""

    E: Real = Field(gt=0, description="Young's modulus, Pa")
    nu: Real = Field(gt=-1, lt=0.5, description="Poisson's ratio, dimensionless; admissible when -1 < nu < 0.5")
    rho: Real = Field(gt=0, description="density, kg/m^3")
