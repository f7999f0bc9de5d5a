r"""Modes in the span of a quasi-static load path, and what motions in this span lack.

The residual r of the whole structure tells what a motion in the span lacks, as along the path: its static response
:math:`z = K_s^{-1} r`, with the energy norm :math:`\sqrt{r^T z}`. The residual is orthogonal to the span, and the span
contains the modes that the base excites, so that the missing part moves quasi-statically. Its shapes may join the span.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.reduction.path_modes import path_modes
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.typing import FloatArray

SERIES = 3
"""Number of terms of K^{-1} L, K^{-1} M K^{-1} L, ... for the loads L of base motion and tip force in the span."""

DEPENDENT = 1e-6
"""Norm of the part of a vector outside the span, relative to the vector, below which it is not added; energy norms."""


class ModalMotion(NamedTuple):
    """Motion in r modes at k times, or k of its Fourier coefficients.

    Attributes
    ----------
    displacement, velocity, acceleration : (r, k) modal coordinates, kg^(1/2) m, and their derivatives
    correction : (3 n_points, k) contact traction without its linear part, Pa (see `dynamics.periodic.aft`)
    base : (k,) base acceleration, m/s^2
    """

    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    correction: FloatArray
    base: FloatArray


class PathSpan:
    """Modes in the span of a path, and what motions in this span lack.

    Attributes
    ----------
    modes : modes in the present span
    """

    def __init__(self, path: LoadPath):
        self.path = path
        system = path.system
        for load in (system.mass @ system.influence, system.probes["tip"]):
            for _ in range(SERIES):
                response = path.stuck(load)
                self._add(response)
                load = system.mass @ response
        self._renew()

    def _add(self, vector: FloatArray) -> None:
        path = self.path
        size, inside = float(vector @ (path.stiffness @ vector)), float(np.sum((path.forces @ vector) ** 2))
        if size - inside > DEPENDENT**2 * size:
            path.add(vector)

    def _renew(self) -> None:
        path, system = self.path, self.path.system
        self.modes = path_modes(path)
        (_, vectors), *_ = self.modes.vectors
        self._stiffness, self._mass = path.stiffness @ vectors, system.mass @ vectors
        self._base = system.mass @ system.influence

    def lacking(self, motion: ModalMotion) -> tuple[FloatArray, float]:
        """What a motion lacks: (n_dofs, k) displacements, and their energy norm relative to that of the motion."""
        system = self.path.system
        force = self._stiffness @ motion.displacement + self._mass @ motion.acceleration
        if self.modes.damping:
            force += self._mass @ self.modes.viscous_force(motion.velocity)
        force += system.jump.T @ (system.weights[:, None] * motion.correction) + np.outer(self._base, motion.base)
        found = np.column_stack([self.path.stuck(column) for column in force.T])
        size = float(np.sum(self.modes.eigenvalues[:, None] * motion.displacement**2))
        return -found, float(np.sqrt(max(np.sum(found * force), 0.0) / size)) if size > 0.0 else 0.0

    def enlarge(self, displacements: FloatArray, least: float) -> None:
        """Add the principal shapes of ``displacements`` (n_dofs, k) whose energy norm exceeds ``least``."""
        gram = displacements.T @ (self.path.stiffness @ displacements)
        squares, turn = la.eigh(0.5 * (gram + gram.T))
        for column in np.flatnonzero(squares > least**2)[::-1]:
            self._add(displacements @ turn[:, column])
        self._renew()
