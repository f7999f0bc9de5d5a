"""Stiffness of a stack of web through its thickness, as a function of the pressure on it."""

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
    """Broken line E_r(P): linear between its knots, constant below the first.

    Attributes
    ----------
    pressures, moduli
        (n,) knots, Pa.
    slope
        Growth beyond the last knot, Pa/Pa.
    """

    pressures: FloatArray
    moduli: FloatArray
    slope: float = 0.0

    @classmethod
    def constant(cls, modulus: float) -> RadialModulus:
        """Return the same modulus in Pa at every pressure."""
        return cls(np.zeros(1), np.array([float(modulus)]))

    @classmethod
    def pfeiffer(cls, K1: float, K2: float) -> RadialModulus:
        """E_r = K2 (K1 + P): equation 2.9 of the source with K1 in Pa and K2 without a unit."""
        return cls(np.zeros(1), np.array([K1 * K2]), float(K2))

    @classmethod
    def table(cls, pressures: list[float], moduli: list[float]) -> RadialModulus:
        """Linear between measured points, constant beyond them."""
        return cls(np.array(pressures, float), np.array(moduli, float))

    @classmethod
    def of(cls, section: RadialModulusSection) -> RadialModulus:
        """Law of the case file."""
        if section.law == "constant":
            return cls.constant(section.E_r)
        if section.law == "pfeiffer":
            return cls.pfeiffer(section.K1, section.K2)
        return cls.table(section.pressure, section.modulus)

    @property
    def knots(self) -> tuple[FloatArray, FloatArray, float]:
        """What the kernels take."""
        return self.pressures, self.moduli, self.slope

    def __call__(self, pressure: FloatArray | float) -> FloatArray:
        """Modulus in Pa at ``pressure`` in Pa, same shape."""
        values = np.atleast_1d(np.asarray(pressure, float))
        found = np.array([kernels.radial_modulus(p, *self.knots) for p in values.ravel()])
        return found.reshape(np.shape(pressure))
