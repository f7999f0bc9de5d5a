"""Stress in thin shells, from the displacements of a structure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.wall import LayeredSection
from wroll_fem.typing import FloatArray

SURFACES = (-1.0, 1.0)
"""Inner and outer surface: sign of the bending stress there."""


@dataclass(frozen=True)
class ShellStress:
    """Map from the degrees of freedom of a structure to the stress resultants of one shell.

    Attributes
    ----------
    name
        Name of the body.
    operator
        (6 k, n) sparse; for each of k points the membrane forces n_11, n_22, n_12 (N/m) and the moments m_11, m_22,
        m_12 (N) in a local orthonormal basis.
    points
        (k, 3) Cartesian coordinates, m.
    thickness
        Thickness of the shell, m.
    """

    name: str
    operator: sp.csr_matrix
    points: FloatArray
    thickness: float

    def resultants(self, displacement: FloatArray) -> FloatArray:
        """(6 k, ...) stress resultants of displacements (n, ...)."""
        return np.asarray(self.operator @ displacement)

    def von_mises(self, resultants: FloatArray) -> FloatArray:
        """(k, 2, ...) von Mises stress, Pa, on the inner and the outer surface, from stress resultants (6 k, ...)."""
        parts = resultants.reshape(len(self.points), 6, *resultants.shape[1:])
        t = self.thickness
        stress = [parts[:, :3] / t + sign * 6.0 * parts[:, 3:] / t**2 for sign in SURFACES]
        return _von_mises(np.moveaxis(np.stack(stress, axis=1), 2, 0))

    def plies(self, resultants: FloatArray) -> FloatArray | None:
        """Stresses in the axes of the plies; None for a homogeneous isotropic wall."""
        return None


@dataclass(frozen=True)
class PlyStress(ShellStress):
    """Map from the degrees of freedom of a structure to the strains of a shell with plies, and their stresses.

    The six rows of a point are, in place of resultants, the membrane strains and the curvatures (1/m) of the reference
    surface in the axes (z, theta, z-theta).

    Attributes
    ----------
    section
        Plies of the wall.
    """

    section: LayeredSection

    def von_mises(self, resultants: FloatArray) -> FloatArray:
        """(k, 2 n_plies, ...) von Mises stress, Pa, at the borders of the plies; nan in plies that are orthotropic."""
        stress = self._stresses(resultants)  # (k, n_plies, 2, 3, ...)
        found = _von_mises(np.moveaxis(stress, 3, 0))
        for number, ply in enumerate(self.section.plies):
            if not ply.material.is_isotropic:
                found[:, number] = np.nan
        return found.reshape(len(found), -1, *found.shape[3:])

    def plies(self, resultants: FloatArray) -> FloatArray | None:
        """(k, n_plies, 2, 3, ...) stresses along 1 and 2 and shear 12, Pa, at the inner and outer border of each ply.

        None if all plies are isotropic; `von_mises` describes these.
        """
        isotropic = all(ply.material.is_isotropic for ply in self.section.plies)
        return None if isotropic else self._stresses(resultants)

    def _stresses(self, strains: FloatArray) -> FloatArray:
        parts = np.moveaxis(strains.reshape(len(self.points), 6, *strains.shape[1:]), 1, 0)  # (6, k, ...)
        thickness = self.section.thickness_at(self.points[:, 2])
        found = np.empty((len(self.section.plies), 2, 3, *parts.shape[1:]))
        for value in np.unique(thickness):
            here = thickness == value
            middle = np.tensordot(self.section.to_middle(float(value)), parts[:, here], axes=1)
            found[:, :, :, here] = self.section.laminate(float(value)).ply_stresses(middle)
        return np.moveaxis(found, 3, 0)


def largest_von_mises(constant: FloatArray, cosine: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Largest von Mises stress on circles, where the plane stress varies as constant + cosine x cos theta.

    Its square is quadratic in cos theta, so the largest value on each circle is exact.

    Parameters
    ----------
    constant, cosine
        (3, ...) amplitudes of the normal stresses 11 and 22 and of the shear 12, Pa; the shear of ``constant`` is zero,
        that of ``cosine`` varies with sin theta.

    Returns
    -------
    stress : (...) largest von Mises stress, Pa.
    theta : (...) angle of this stress, 0 to pi, rad.
    """
    (a0, b0), (a1, b1), shear = constant[:2], cosine[:2], cosine[2]
    fixed = a0**2 + b0**2 - a0 * b0 + 3.0 * shear**2
    linear = 2.0 * (a0 * a1 + b0 * b1) - a0 * b1 - a1 * b0
    square = a1**2 + b1**2 - a1 * b1 - 3.0 * shear**2
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = np.where(square < 0.0, np.clip(-0.5 * linear / square, -1.0, 1.0), 1.0)
    at = np.stack([np.ones_like(linear), -np.ones_like(linear), vertex])
    found = fixed + linear * at + square * at**2
    best = found.argmax(axis=0)[None]
    where, most = (np.take_along_axis(values, best, axis=0)[0] for values in (at, found))
    return np.sqrt(np.maximum(most, 0.0)), np.arccos(where)


def _von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises stress of plane stresses (3, ...): normal stresses 11 and 22, shear 12."""
    s11, s22, s12 = stress
    return np.asarray(np.sqrt(s11**2 + s22**2 - s11 * s22 + 3.0 * s12**2))
