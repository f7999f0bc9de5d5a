r"""Modes of a structure in the span of a quasi-static load path, for the dynamics of contact that fills a body.

A coil with friction at every point has thousands of contact points, but its motion near a resonance stays close to the
states of the quasi-static path with the shape of the mode. The basis of this path, orthonormal in the stiffness with
sticking contact, is turned into modes: with :math:`\Phi^T K_s \Phi = I` the eigenproblem is that of
:math:`\Phi^T M \Phi`.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.reduction.condensation import Condensation, in_one_block
from wroll_fem.dynamics.statics.load_path import LoadPath


def path_modes(path: LoadPath) -> Condensation:
    """Modes of the sticking structure in the span of the basis of ``path``, with the damping of its system."""
    system, basis = path.system, path.vectors.T
    inertia = system.mass @ basis
    flexibilities, ritz = la.eigh(basis.T @ inertia)
    order = np.argsort(-flexibilities)
    eigenvalues = 1.0 / flexibilities[order]
    vectors = (basis @ ritz[:, order]) * np.sqrt(eigenvalues)
    return in_one_block(system, path.springs, eigenvalues, vectors, exact=False)
