r"""Modes of a structure in the span of a quasi-static load path, for the dynamics of contact that fills a body.

A coil with friction at every point has thousands of contact points, but its motion near a resonance stays close to the
states of the quasi-static path with the shape of the mode. The basis of this path, orthonormal in the stiffness with
sticking contact, is turned into modes: with :math:`\Phi^T K_s \Phi = I` the eigenproblem is that of
:math:`\Phi^T M \Phi`.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from wroll_fem.dynamics.reduction.condensation import Condensation, modal_losses, viscous_damping
from wroll_fem.dynamics.reduction.cyclic_blocks import by_component
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.typing import FloatArray


def path_modes(path: LoadPath) -> Condensation:
    """Modes of the sticking structure in the span of the basis of ``path``, with the damping of its system."""
    system, basis = path.system, path.vectors.T
    inertia = system.mass @ basis
    flexibilities, ritz = la.eigh(basis.T @ inertia)
    order = np.argsort(-flexibilities)
    eigenvalues = 1.0 / flexibilities[order]
    vectors = (basis @ ritz[:, order]) * np.sqrt(eigenvalues)
    coupled = [] if system.damping is None else [vectors.T @ (system.damping @ vectors)]
    whole = sp.identity(system.n_dofs, format="csc")
    losses = modal_losses(system, whole, vectors)
    return Condensation(
        eigenvalues=eigenvalues,
        blocks=np.array([0, len(eigenvalues)]),
        vectors=[(whole, vectors)],
        jump=[np.ascontiguousarray((system.jump @ vectors)[by_component(system.n_points)])],
        profiles=np.ones((1, 1, 3, 1)),
        base=vectors.T @ (system.mass @ system.influence),
        tip=vectors.T @ system.probes["tip"],
        probes=system.output_rows @ vectors,
        springs=path.springs,
        exact=False,
        damping=viscous_damping(system, eigenvalues, [len(eigenvalues)], coupled, losses),
        rigid_tip=system.rigid_tip,
    )


def cycle(path: LoadPath, load: FloatArray, steps: int = 16) -> None:
    """Follow a cycle of ``load`` (n_dofs,), N, from its maximum on; its states enrich the basis."""
    for share in np.cos(np.linspace(0.0, 2.0 * np.pi, steps + 1))[1:]:
        path.to(share * load)
