"""Linear structure in modal coordinates, prepared for time steps of one size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.state import Dashpots, Modal
from wroll_fem.typing import FloatArray, IntArray


def modal_step(
    structure: Condensation | ReducedModel, damping: Sequence[FloatArray], scheme: Scheme, dt: float
) -> Modal:
    """Matrices of a structure for steps of ``dt`` (s).

    Parameters
    ----------
    structure
        Structure in m coordinates with unit mass and diagonal stiffness.
    damping
        Viscous damping of each block of coordinates, 1/s: (m_b,), or (m_b, m_b) if it couples them; empty without
        damping.
    """
    factor, rate = 1.0 + scheme.alpha, scheme.gamma / (scheme.beta * dt)
    stiffness = structure.eigenvalues
    inertia = 1.0 / (scheme.beta * dt**2)
    given = structure.eigenvalues, structure.base, structure.tip, structure.probes
    none = np.zeros(0)
    if not damping:
        inverse = 1.0 / (inertia + factor * stiffness)
        return Modal(*given, inverse, Dashpots(none, np.zeros(1, np.int64), none, none, none))
    starts = np.concatenate([[0], np.cumsum([len(part) for part in damping])]).astype(np.int64)
    if all(part.ndim == 1 for part in damping):
        rates = np.concatenate(damping)
        inverse = 1.0 / (inertia + factor * (stiffness + rate * rates))
        return Modal(*given, inverse, Dashpots(rates, starts, none, none, none))
    matrices = [
        np.diag(inertia + factor * values) + factor * rate * part
        for values, part in zip(np.split(stiffness, starts[1:-1]), damping, strict=True)
    ]
    flat = [np.concatenate([m.ravel() for m in blocks]) for blocks in (damping, matrices, map(la.inv, matrices))]
    return Modal(*given, none, Dashpots(none, starts, *flat))


def inverse_blocks(modal: Modal, starts: IntArray) -> list[FloatArray]:
    """Displacement per unit force of a step, s^2: for each block (m_b,), or (m_b, m_b) if damping couples it.

    ``starts`` (n_blocks + 1,) are the indices of the first coordinate of each block, then m.
    """
    if not modal.dashpots.solution.size:
        return np.split(modal.inverse, starts[1:-1])
    sizes = np.diff(starts)
    parts = np.split(modal.dashpots.solution, np.cumsum(sizes**2)[:-1])
    return [part.reshape(size, size) for part, size in zip(parts, sizes, strict=True)]
