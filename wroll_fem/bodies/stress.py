"""Stress in thin shells, from the displacements of a structure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

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
        s11, s22, s12 = np.moveaxis(np.stack(stress, axis=1), 2, 0)
        return np.asarray(np.sqrt(s11**2 + s22**2 - s11 * s22 + 3.0 * s12**2))
