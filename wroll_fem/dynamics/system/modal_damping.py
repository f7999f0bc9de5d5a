r"""Damping of the modes of a structure with sticking interfaces: damping ratios, or loss factors of the materials.

Each mode has its own dashpot, :math:`c_i = 2 \zeta_i \omega_i` at modal mass 1. The modes are those of the preloaded
structure whose interfaces stick. With loss factors, :math:`\zeta_i` is half of the loss factor that the strain energy
of the mode gives,

.. math:: \zeta_i = \frac{1}{2 \omega_i^2} \phi_i^T \Big(\sum_b \eta_b K_b\Big) \phi_i

for bodies b with stiffness K_b; the contact springs have no loss. At the natural frequency this is the loss of
:math:`(1 + i \eta_b) K_b`.

References
----------
Johnson, Kienholz (1982), AIAA J. 20, 1284, doi:10.2514/3.51190 (modal strain energy method).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.typing import FloatArray

SAME = 1e-6
"""Relative difference of two natural frequencies up to which they count as one, as those of a pair of modes that
differ by a turn about the axis."""

FLOATING = 1e-15
"""Eigenvalue of a mode, relative to the largest one, below which it counts as a rigid motion and has no dashpot. With
stiff contact springs the largest one is some 1e10 times that of the first bending mode."""


@dataclass(frozen=True)
class ModalDamping:
    """Damping ratios of the modes; one of the three descriptions is given.

    Attributes
    ----------
    ratios
        (k,) damping ratios of the natural frequencies 1 to k, lowest first; the last one holds for all higher modes.
    table
        (k, 2) frequencies, Hz, increasing, and damping ratios; linear between them and constant outside.
    loss
        (n, n) sparse sum of the stiffness matrices of the bodies, each times its loss factor, N/m.
    """

    ratios: tuple[float, ...] = ()
    table: tuple[tuple[float, float], ...] = ()
    loss: sp.csr_matrix | None = None

    def of_modes(self, eigenvalues: FloatArray, losses: FloatArray | None = None) -> FloatArray:
        """(r,) damping ratios of r modes.

        Parameters
        ----------
        eigenvalues
            (r,) squared natural frequencies, rad^2/s^2, in any order.
        losses
            (r,) products of the mode shapes with ``loss`` on both sides, at modal mass 1; needed with ``loss``.
        """
        restrained = eigenvalues > FLOATING * eigenvalues.max(initial=0.0)
        squares = np.where(restrained, eigenvalues, 1.0)
        if losses is not None:
            found = 0.5 * losses / squares
        elif self.table:
            at, values = np.array(self.table).T
            found = np.interp(np.sqrt(squares) / (2.0 * np.pi), at, values)
        else:
            values = np.sort(eigenvalues[restrained])
            lowest = values[np.diff(values, prepend=-np.inf) > 2.0 * SAME * values]  # of each natural frequency
            number = np.searchsorted(lowest, squares, side="right") - 1
            found = np.array(self.ratios)[np.clip(number, 0, len(self.ratios) - 1)]
        return np.where(restrained, found, 0.0)
