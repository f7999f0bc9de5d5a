r"""Laminated shell wall: stiffness, transverse shear, mass, and the stresses in its plies.

The axes of the wall are z (along the roll) and theta; heights xi are measured outwards from its middle. The
strains at a height are :math:`\varepsilon + \xi \kappa`, with the vectors (z, theta, z-theta) and engineering shear.
Forces N (N/m) and moments M (N) follow from the classical laminate theory (Jones 1999, chapter 4):

    N = A eps + B kappa,    M = B eps + D kappa,    (A, B, D) = int Q (1, xi, xi^2) dxi

Transverse shear follows from equilibrium (Rohwer 1988). In bending by the shear forces Q_z and Q_theta the membrane
forces vanish, and the shear stresses are tau(xi) = f(xi) (Q_z, Q_theta), because

    tau_z,xi = -(sigma_z,z + sigma_ztheta,theta),    tau_theta,xi = -(sigma_ztheta,z + sigma_theta,theta)

The shear stiffness has the same energy: its inverse is :math:`\int f^T G^{-1} f \, d\xi`. For one isotropic ply it is
5/6 G t.

References
----------
R. M. Jones, Mechanics of Composite Materials, 2nd ed. 1999, chapters 2 and 4.
K. Rohwer, Improved transverse shear stiffnesses for layered finite elements, DFVLR-FB 88-32, 1988.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wroll_fem.typing import FloatArray

_GAUSS = np.polynomial.legendre.leggauss(3)
"""Points and weights that integrate polynomials of degree 5 exactly; those of the shear energy have degree 4."""


@dataclass(frozen=True)
class Lamina:
    """Material of a ply: orthotropic in plane stress, direction 1 along its fibres.

    Attributes
    ----------
    E_1, E_2
        Young's moduli along and across the fibres, Pa.
    nu_12
        Poisson's ratio: -strain_2 / strain_1 under stress along 1.
    G_12, G_13, G_23
        Shear moduli, Pa; 3 is the direction through the thickness.
    rho
        Density, kg/m^3.
    """

    E_1: float
    E_2: float
    nu_12: float
    G_12: float
    G_13: float
    G_23: float
    rho: float

    @classmethod
    def isotropic(cls, E: float, nu: float, rho: float) -> Lamina:
        """Isotropic ply of Young's modulus ``E`` (Pa), Poisson's ratio ``nu`` and density ``rho`` (kg/m^3)."""
        G = E / (2 * (1 + nu))
        return cls(E, E, nu, G, G, G, rho)

    @property
    def is_isotropic(self) -> bool:
        """Whether the ply is isotropic in its plane."""
        shear = self.E_1 / (2 * (1 + self.nu_12))
        return self.E_1 == self.E_2 and abs(self.G_12 - shear) <= 1e-9 * shear

    def plane_stress(self, angle: float = 0.0) -> FloatArray:
        """(3, 3) stiffness in plane stress, Pa, of (z, theta, z-theta); fibres at ``angle`` (rad) from z to theta."""
        nu_21 = self.nu_12 * self.E_2 / self.E_1
        rest = 1.0 - self.nu_12 * nu_21
        own = np.zeros((3, 3))
        own[:2, :2] = [[self.E_1, self.nu_12 * self.E_2], [nu_21 * self.E_1, self.E_2]]
        own[:2, :2] /= rest
        own[2, 2] = self.G_12
        turn = strain_rotation(angle)
        return np.asarray(turn.T @ own @ turn)

    def transverse_shear(self, angle: float = 0.0) -> FloatArray:
        """(2, 2) transverse shear moduli, Pa, of (z, theta); fibres at ``angle`` (rad) from z to theta."""
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, s], [-s, c]])
        return np.asarray(turn.T @ np.diag([self.G_13, self.G_23]) @ turn)


def strain_rotation(angle: float) -> FloatArray:
    """(3, 3) map from strains (z, theta, z-theta) to strains (1, 2, 12) of a ply at ``angle`` (rad) from z to theta."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])


@dataclass(frozen=True)
class Ply:
    """One layer of a laminate: material, thickness (m) and angle of its fibres from z to theta (rad)."""

    material: Lamina
    thickness: float
    angle: float = 0.0


@dataclass(frozen=True)
class Laminate:
    """Plies of a wall, innermost first; heights xi are measured from the middle of the wall."""

    plies: tuple[Ply, ...]

    @property
    def thickness(self) -> float:
        """Thickness of all plies, m."""
        return sum(ply.thickness for ply in self.plies)

    @cached_property
    def heights(self) -> FloatArray:
        """(n + 1,) heights of the borders of the n plies, m, from the inside."""
        ends = np.cumsum([0.0, *(ply.thickness for ply in self.plies)])
        return np.asarray(ends - 0.5 * ends[-1])

    @cached_property
    def abd(self) -> FloatArray:
        """(6, 6) stiffness [[A, B], [B, D]], N/m, N and N m, of (eps, kappa)."""
        total = np.zeros((6, 6))
        for ply, low, high in zip(self.plies, self.heights, self.heights[1:], strict=False):
            Q = ply.material.plane_stress(ply.angle)
            moments = [(high**k - low**k) / k for k in (1, 2, 3)]
            total += np.block([[Q * moments[0], Q * moments[1]], [Q * moments[1], Q * moments[2]]])
        return total

    @cached_property
    def transverse_shear(self) -> FloatArray:
        """(2, 2) transverse shear stiffness, N/m, of (z, theta)."""
        of_moments = np.linalg.inv(self.abd)[:, 3:]  # strains and curvatures per moment, without membrane forces
        stress = np.zeros((3, 3))  # -f at the inner border of a ply, before the rows are picked
        flexibility = np.zeros((2, 2))
        points, weights = _GAUSS
        for ply, low, high in zip(self.plies, self.heights, self.heights[1:], strict=False):
            Q = ply.material.plane_stress(ply.angle)
            soft = np.linalg.inv(ply.material.transverse_shear(ply.angle))
            for at, weight in zip(0.5 * (low + high) + 0.5 * (high - low) * points, weights, strict=True):
                f = _of_shear_forces(stress + Q @ _integral(of_moments, low, at))
                flexibility += 0.5 * (high - low) * weight * f.T @ soft @ f
            stress = stress + Q @ _integral(of_moments, low, high)
        return np.asarray(np.linalg.inv(flexibility))

    def mass_moments_about(self, height: float) -> FloatArray:
        """(3,) integrals of density times (1, x, x^2), kg/m^2, kg/m and kg; x is the distance above a ``height``, m."""
        density = np.array([ply.material.rho for ply in self.plies])
        return np.array([float(density @ np.diff((self.heights - height) ** k)) / k for k in (1, 2, 3)])

    def engineering_constants(self) -> tuple[float, float, float, float]:
        """In-plane moduli E_z, E_theta (Pa), nu_theta_z and G_z_theta (Pa) of the wall, which is free to bend."""
        a = np.linalg.inv(self.abd)[:3, :3] * self.thickness
        return 1 / a[0, 0], 1 / a[1, 1], -a[0, 1] / a[1, 1], 1 / a[2, 2]

    @property
    def is_mirrored(self) -> bool:
        """Whether the wall is its own mirror image about a plane through the axis: nothing couples shear to stretch."""
        scale = np.sqrt(np.abs(np.diag(self.abd)))
        coupling = np.abs(self.abd / np.outer(scale, scale))[np.ix_([0, 1, 3, 4], [2, 5])]
        shear = self.transverse_shear
        return bool(coupling.max() < 1e-12 and abs(shear[0, 1]) < 1e-12 * shear.trace())

    def ply_stresses(self, strains: FloatArray) -> FloatArray:
        """Stresses in the axes of each ply, at its inner and its outer border.

        Parameters
        ----------
        strains
            (6, ...) strains eps and curvatures kappa (1/m) of the middle of the wall, in the axes (z, theta, z-theta).

        Returns
        -------
        (n_plies, 2, 3, ...) stresses along 1 and 2 and shear 12, Pa.
        """
        found = []
        for ply, low, high in zip(self.plies, self.heights, self.heights[1:], strict=False):
            own = ply.material.plane_stress() @ strain_rotation(ply.angle)
            found.append([np.tensordot(own, strains[:3] + at * strains[3:], axes=1) for at in (low, high)])
        return np.asarray(found)


def _integral(of_moments: FloatArray, low: float, high: float) -> FloatArray:
    """(3, 3) integral from ``low`` to ``high`` (m) of the strains per moment, given by (6, 3) ``of_moments``."""
    return np.asarray((high - low) * of_moments[:3] + 0.5 * (high**2 - low**2) * of_moments[3:])


def _of_shear_forces(integral: FloatArray) -> FloatArray:
    """(2, 2) shear stress (z, theta) per shear force (z, theta), 1/m, from the integrated stress per moment (3, 3)."""
    return -np.array([[integral[0, 0], integral[2, 1]], [integral[2, 0], integral[1, 1]]])


def laminate(material: Lamina, ply_thickness: float, angles: Sequence[float]) -> Laminate:
    """Laminate of equal plies, m, with fibres at ``angles`` (degrees, from z to theta), innermost first."""
    return Laminate(tuple(Ply(material, ply_thickness, float(np.radians(angle))) for angle in angles))
