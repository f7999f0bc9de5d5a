"""Natural frequencies of a uniform Timoshenko beam on springs with a rigid body at its tip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from wroll_fem.typing import FloatArray

ELEMENTS = 16


@dataclass(frozen=True)
class SprungBeam:
    """Uniform beam; every displacement is lateral, every rotation a tilt.

    Attributes
    ----------
    length : m
    bending, shear : bending stiffness E I, N m^2, and shear stiffness k G A, N
    mass, rotary : mass per length, kg/m, and rotary inertia per length, kg m
    base : lateral stiffness, N/m, and tilt stiffness, N m/rad, at the base; None: held
    tip_stiffness, tip_mass : (2, 2) matrices for lateral motion and tilt of the tip
    """

    length: float
    bending: float
    shear: float
    mass: float
    rotary: float = 0.0
    base: tuple[float | None, float | None] = (None, None)
    tip_stiffness: FloatArray | None = None
    tip_mass: FloatArray | None = None

    def frequencies(self, count: int = 1) -> FloatArray:
        """(count,) lowest natural frequencies, Hz; those of free motions are zero."""
        n, h = ELEMENTS, self.length / ELEMENTS
        stiffness, mass = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros((2 * n + 2, 2 * n + 2))
        k, m = self._element(h)
        for e in range(n):
            here = slice(2 * e, 2 * e + 4)
            stiffness[here, here] += k
            mass[here, here] += m
        for i, spring in enumerate(self.base):
            stiffness[i, i] += spring or 0.0
        if self.tip_stiffness is not None:
            stiffness[-2:, -2:] += self.tip_stiffness
        if self.tip_mass is not None:
            mass[-2:, -2:] += self.tip_mass
        keep = [*(i for i, spring in enumerate(self.base) if spring is not None), *range(2, 2 * n + 2)]
        kept = np.ix_(keep, keep)
        values = la.eigh(stiffness[kept], mass[kept], eigvals_only=True, subset_by_index=(0, count - 1))
        return np.asarray(np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi))

    def _element(self, h: float) -> tuple[FloatArray, FloatArray]:
        """(4, 4) stiffness and mass of an element of height ``h`` with cubic shapes (Przemieniecki 1968).

        A tilt turns the tip of a beam that stands on z towards positive displacements.
        """
        p = 12.0 * self.bending / (self.shear * h**2)
        k = self.bending / (h**3 * (1.0 + p)) * np.array(
            [[12, 6 * h, -12, 6 * h], [6 * h, (4 + p) * h**2, -6 * h, (2 - p) * h**2],
             [-12, -6 * h, 12, -6 * h], [6 * h, (2 - p) * h**2, -6 * h, (4 + p) * h**2]]
        )  # fmt: skip
        a, b = 13 / 35 + 7 * p / 10 + p**2 / 3, (11 / 210 + 11 * p / 120 + p**2 / 24) * h
        c, d = 9 / 70 + 3 * p / 10 + p**2 / 6, -(13 / 420 + 3 * p / 40 + p**2 / 24) * h
        e, f = (1 / 105 + p / 60 + p**2 / 120) * h**2, -(1 / 140 + p / 60 + p**2 / 120) * h**2
        shift = np.array([[a, b, c, d], [b, e, -d, f], [c, -d, a, -b], [d, f, -b, e]])
        a, b = 6 / 5, (1 / 10 - p / 2) * h
        c, d = (2 / 15 + p / 6 + p**2 / 3) * h**2, (-1 / 30 - p / 6 + p**2 / 6) * h**2
        turn = np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]]) / h**2
        return k, h / (1.0 + p) ** 2 * (self.mass * shift + self.rotary * turn)
