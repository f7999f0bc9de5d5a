"""Radial modulus of a wound web as a function of the interlayer pressure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.typing import FloatArray
from wroll_fem.winding import kernels

if TYPE_CHECKING:
    from wroll_fem.case.winding import RadialModulus as RadialModulusSection


@dataclass(frozen=True)
class RadialModulus:
    """Piecewise linear radial modulus E_r(P), constant below its first knot.

    Attributes
    ----------
    pressures, moduli
        (n,) pressures and moduli at the knots, Pa.
    slope
        Slope beyond the last knot, Pa/Pa.
    """

    pressures: FloatArray
    moduli: FloatArray
    slope: float = 0.0

    @classmethod
    def constant(cls, modulus: float) -> RadialModulus:
        """Radial modulus (Pa) that does not depend on the pressure."""
        return cls(np.zeros(1), np.array([float(modulus)]))

    @classmethod
    def pfeiffer(cls, K1: float, K2: float) -> RadialModulus:
        """Pfeiffer's law E_r = K2 (K1 + P), with K1 in Pa and K2 dimensionless (thesis, equation 2.9)."""
        return cls(np.zeros(1), np.array([K1 * K2]), float(K2))

    @classmethod
    def table(cls, pressures: list[float], moduli: list[float]) -> RadialModulus:
        """Piecewise linear law through measured pressures and moduli (Pa), constant outside the measured range."""
        return cls(np.array(pressures, float), np.array(moduli, float))

    @classmethod
    def from_case(cls, section: RadialModulusSection) -> RadialModulus:
        """Radial modulus from the case section `winding.web.radial_modulus`."""
        if section.law == "constant":
            return cls.constant(section.E_r)
        if section.law == "pfeiffer":
            return cls.pfeiffer(section.K1, section.K2)
        return cls.table(section.pressure, section.modulus)

    @property
    def knots(self) -> tuple[FloatArray, FloatArray, float]:
        """Pressures, moduli and slope, in the order of the arguments of the compiled kernels."""
        return self.pressures, self.moduli, self.slope

    def __call__(self, pressure: FloatArray | float) -> FloatArray:
        """Radial modulus (Pa) at given pressures (Pa), in the same shape."""
        values = np.atleast_1d(np.asarray(pressure, float))
        found = np.array([kernels.radial_modulus(p, *self.knots) for p in values.ravel()])
        return found.reshape(np.shape(pressure))
