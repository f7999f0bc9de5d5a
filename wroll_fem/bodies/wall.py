r"""Wall of plies of a cylindrical shell, as coefficients of its energy per area of the reference surface.

The energy is written with the membrane strain of the surface on which membrane and bending are uncoupled,
:math:`\hat\varepsilon = \varepsilon + C \kappa` with :math:`C = A^{-1} B`:

    2 W = eps^ . A eps^ + kappa . (D - B C) kappa + gamma . S gamma

so that membrane strains, and only they, are integrated with the mixed rule of the shell.

The outer surface of a wall of variable thickness is a cylinder. Its middle then lies at the height e above the
reference surface of radius R, where lengths along theta and areas are larger by the factor :math:`s = 1 + e/R`. A point
there moves by :math:`u + e \beta` with the change beta of the director, and the strains that a shell with its reference
surface in the middle would have follow from those of this shell (`LayeredSection.to_middle`):

    eps_z     + e kappa_z,              kappa_z
    ((1 - e/R) eps_theta + e kappa_theta) / s = m,     (kappa_theta - (eps_theta - m) / R) / s
    (gamma + (e + e^2 / 2R) chi) / s,   chi

gamma is the shear and chi twice the twist. The last line is exact in torsion; otherwise beta_theta,z is taken as half
of chi, which neglects e^2 / R^2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wroll_fem.bodies.laminate import Laminate, Ply
from wroll_fem.typing import FloatArray

COLUMNS = {
    "membrane": slice(0, 9), "shift": slice(9, 18), "bending": slice(18, 27), "shear": slice(27, 31),
    "drilling": slice(31, 32), "mass": slice(32, 35),
}  # fmt: skip
"""Columns of `LayeredSection.coefficients`: A, C and D - B C (3 x 3), S (2 x 2), G t, moments of the mass."""
COUNT = 35
"""Number of these columns."""


@dataclass(frozen=True)
class WallTable:
    """Thickness of a wall over the height, linear between the rows of a table and constant outside them.

    Attributes
    ----------
    heights
        Heights z, m, ascending; two equal heights are a step.
    thicknesses
        Thickness at each of them, m.
    """

    heights: tuple[float, ...]
    thicknesses: tuple[float, ...]

    def __call__(self, z: FloatArray) -> FloatArray:
        """Thickness, m, at heights ``z``, m; at a step the one above it."""
        return np.asarray(np.interp(z, self.heights, self.thicknesses))


@dataclass(frozen=True)
class LayeredSection:
    """Plies of a cylindrical shell about the z axis.

    Attributes
    ----------
    plies
        Plies at the nominal thickness, innermost first.
    radius
        Radius of the reference surface, m, which lies half the nominal thickness below the outer surface.
    table
        Thickness over the height; None: the nominal thickness. The plies keep their shares of it.
    bending
        Factor on the bending stiffness; with 0 the shell is a membrane.
    extra_mass
        Non-structural mass per area of the reference surface, kg/m^2.
    """

    plies: tuple[Ply, ...]
    radius: float
    table: WallTable | None = None
    bending: float = 1.0
    extra_mass: float = 0.0

    @cached_property
    def thickness(self) -> float:
        """Nominal thickness, m."""
        return Laminate(self.plies).thickness

    def thickness_at(self, z: FloatArray) -> FloatArray:
        """Thickness, m, at heights ``z`` (n,), m."""
        return np.full(np.shape(z), self.thickness) if self.table is None else self.table(z)

    def laminate(self, thickness: float) -> Laminate:
        """Plies where the wall has a ``thickness``, m."""
        if thickness == self.thickness:
            return Laminate(self.plies)
        share = thickness / self.thickness
        return Laminate(tuple(Ply(ply.material, share * ply.thickness, ply.angle) for ply in self.plies))

    def stretch(self, thickness: float) -> float:
        """Length along theta in the middle of a wall of ``thickness``, m, divided by that on the reference surface."""
        return 1.0 + 0.5 * (self.thickness - thickness) / self.radius

    def to_middle(self, thickness: float) -> FloatArray:
        """(6, 6) map from strains and curvatures of the reference surface to those of the middle of the wall."""
        s, R = self.stretch(thickness), self.radius
        e = (s - 1.0) * R
        found = np.eye(6)
        found[0, 3] = e
        found[1, [1, 4]] = np.array([1.0 - e / R, e]) / s
        found[2, [2, 5]] = np.array([1.0, e + 0.5 * e**2 / R]) / s
        found[4] = (found[4] + (found[1] - np.eye(6)[1]) / R) / s
        return found

    def coefficients(self, z: FloatArray) -> FloatArray:
        """(n, COUNT) coefficients of energy and mass per area at heights ``z`` (n,), m; `COLUMNS` names them."""
        return _at_each(self._of_thickness, self.thickness_at(z))

    def _of_thickness(self, thickness: float) -> FloatArray:
        wall, s, to_middle = self.laminate(thickness), self.stretch(thickness), self.to_middle(thickness)
        abd = s * to_middle.T @ wall.abd @ to_middle
        A, B, D = abd[:3, :3], abd[:3, 3:], abd[3:, 3:]
        if not self.bending:
            B, D = 0.0 * B, 0.0 * D
        shift = np.linalg.solve(A, B)
        hoop = np.array([1.0, 1.0 / s])
        shear = s * wall.transverse_shear * np.outer(hoop, hoop)
        mass = s * wall.mass_moments_about((1.0 - s) * self.radius) + [self.extra_mass, 0.0, 0.0]
        bending = self.bending * (D - B.T @ shift)
        return np.concatenate([A.ravel(), shift.ravel(), bending.ravel(), shear.ravel(), [A[2, 2]], mass])


def _at_each(function: Callable[[float], FloatArray], values: FloatArray) -> FloatArray:
    """(n, COUNT) values of a function at (n,) ``values``, which is called once for each different value."""
    different, place = np.unique(values, return_inverse=True)
    return np.array([function(float(value)) for value in different])[place.ravel()]
