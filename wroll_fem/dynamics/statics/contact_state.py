"""Committed state of the contact, and trial evaluation of tractions and tangents from this state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact import kernels
from wroll_fem.contact.laws import PointLaws
from wroll_fem.contact.point import contact_dofs, normals
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

LEAST_TANGENT = 1e-6
"""Smallest stiffness of a contact degree of freedom in the Jacobian of Newton's method, relative to the normal penalty.
The residual does not contain it."""


@dataclass(frozen=True)
class ContactState:
    """Committed state of a system at rest or between two steps.

    Attributes
    ----------
    displacement
        (n_dofs,) m.
    jump
        (3 n_points,) relative displacement in the order of `contact.point`, m.
    elastic_slip
        (2 n_points,) m.
    traction
        (3 n_points,) Pa; tangential components first; normal components are negative in compression.
    status
        (n_points,) `contact.kernels.STICK`, ``SLIP`` or ``OPEN``.
    """

    displacement: FloatArray
    jump: FloatArray
    elastic_slip: FloatArray
    traction: FloatArray
    status: np.ndarray

    @property
    def pressure(self) -> FloatArray:
        """(n_points,) contact pressure, Pa, positive in compression."""
        return np.maximum(0.0, -normals(self.traction))

    @classmethod
    def unloaded(cls, system: System) -> ContactState:
        """State of an unloaded system: displacements, jumps and tractions are zero."""
        n = system.n_points
        return cls(np.zeros(system.n_dofs), np.zeros(3 * n), np.zeros(2 * n), np.zeros(3 * n), np.zeros(n, np.int64))

    @classmethod
    def pressed(cls, system: System, pressure: FloatArray) -> ContactState:
        """State under the initial stress of a wound roll: ``pressure`` (n_points,), Pa, without displacement or shear.

        The pressure is in equilibrium with the hoop stress of the roll. The jump that the normal penalty needs for it
        is a reference, no displacement.
        """
        state, normal = cls.unloaded(system), contact_dofs(system.n_points)[:, 2]
        state.jump[normal] = -pressure / system.laws.kn
        state.traction[normal] = -pressure
        return state


def contact_energy_limit(laws: PointLaws, pressure: FloatArray) -> float:
    """Energy, J, stored in the contact when every point is about to slip under the ``pressure`` (n,), Pa."""
    return float(laws.area @ (0.5 * pressure**2 / laws.kn + 0.5 * laws.mu * pressure * laws.gamma))


def point_blocks(d: FloatArray) -> sp.csr_matrix:
    """(3 n, 3 n) sparse tangent in contact degrees of freedom from point tangents (n, 3, 3) (hoop, axial, normal)."""
    n = len(d)
    dofs = contact_dofs(n)
    rows = np.repeat(dofs, 3, axis=1).ravel()
    cols = np.tile(dofs, (1, 3)).ravel()
    return sp.csr_matrix((d.ravel(), (rows, cols)), shape=(3 * n, 3 * n))


class WithLaws(Protocol):
    """Object that holds the contact-law parameters of its points: a system, or some of its contact points."""

    @property
    def laws(self) -> PointLaws:
        """Areas and contact-law parameters of the contact points."""
        ...


class TrialContact:
    """Trial evaluation of all interfaces from a committed state, which is never changed."""

    def __init__(self, system: WithLaws):
        self.laws = system.laws
        n = self.laws.n
        self.traction, self.elastic_slip = np.zeros(3 * n), np.zeros(2 * n)
        self.status, self.tangent = np.zeros(n, np.int64), np.zeros((n, 3, 3))

    def __call__(self, jump: FloatArray, state: ContactState, dt: float = np.inf) -> FloatArray:
        """Trial traction (3 n_points,), Pa, ``dt`` s after ``state``; also updates ``elastic_slip`` and ``status``."""
        kernels.trial_traction(
            jump, state.jump, state.elastic_slip, self.laws, dt, self.traction, self.elastic_slip, self.status
        )
        return self.traction

    def stiffness(self, jump: FloatArray, state: ContactState, floor: float = 0.0, dt: float = np.inf) -> sp.csr_matrix:
        """(3 n, 3 n) consistent tangent, Pa/m; its diagonal is at least ``floor`` where a point does not stick."""
        kernels.consistent_tangent(jump, state.jump, state.elastic_slip, self.laws, dt, self.tangent)
        if floor > 0.0:
            # weak friction that sticks is what holds a layer: a floor in its place would stall Newton's method
            sticks = (self.status == kernels.STICK) & (self.tangent[:, 0, 0] > 0.0)
            for c in range(3):
                least = np.where(sticks, self.tangent[:, c, c], floor)
                self.tangent[:, c, c] = np.maximum(self.tangent[:, c, c], least)
        return point_blocks(self.tangent)

    def committed(self, displacement: FloatArray, jump: FloatArray) -> ContactState:
        """Committed state that results if the last trial is accepted."""
        return ContactState(
            displacement, jump.copy(), self.elastic_slip.copy(), self.traction.copy(), self.status.copy()
        )


def open_fraction(system: System, preload: ContactState) -> float:
    """Share of contact points that are open in the preload state."""
    gaps = normals(preload.jump)
    return float(np.mean((gaps > 0.0) & system.laws.separation)) if system.n_points else 0.0


def unpressed(system: System, preload: ContactState) -> bool:
    """Whether, in the preload state, at least one interface with separable points has no pressure at any point."""
    ends = np.cumsum([interface.n_points for interface in system.interfaces])[:-1]
    free = np.split(system.laws.separation, ends)
    pressed = np.split(preload.pressure > 0.0, ends)
    return any(bool(f.any()) and not p.any() for f, p in zip(free, pressed, strict=True)) if system.n_points else False
