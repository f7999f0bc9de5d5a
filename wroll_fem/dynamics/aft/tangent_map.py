"""Derivative of the contact forces of a periodic motion as a linear map, without its matrix."""

from __future__ import annotations

import numpy as np

from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.periodic_contact import PeriodicContact
from wroll_fem.typing import FloatArray


class TangentMap:
    """Derivative of `HarmonicContact.force` at a motion, the shift of the samples included.

    It is the matrix of `HarmonicContact.jacobian` and `HarmonicContact.add_shift`, in the same precision. A product
    costs as much as two evaluations of the force.

    Attributes
    ----------
    by_log : (R, m) derivative of the force with respect to ln(frequency)

    Parameters
    ----------
    owner
        Contact forces of the reduced model.
    coefficients
        (R, m) Fourier coefficients of the motion of ``contact``.
    contact
        Contact during a period.
    threshold
        See `HarmonicContact.point_blocks`.
    """

    def __init__(self, owner: HarmonicContact, coefficients: FloatArray, contact: PeriodicContact, threshold: float):
        points, blocks, by_frequency = owner.weighted_blocks(contact, threshold)
        size, count = owner.sampling.size, len(points)
        self.shape, self.dofs = (size, owner.model.size), owner.dofs[points].ravel()
        operator, jump = owner.newton_operators
        self.precision = operator.dtype
        self.blocks = blocks.reshape(count, 3 * size, 3 * size)
        self.parts = [
            (np.ix_(rows, columns), rows, jump[np.ix_(self.dofs, columns)], operator[np.ix_(columns, self.dofs)])
            for rows, columns in owner.groups
            if len(columns)
        ]
        tangential = np.zeros((count, 3, size))
        tangential[:, :2] = by_frequency
        self.by_log = self._collected(tangential.reshape(3 * count, size))
        self.by_angle: FloatArray | None = None
        if contact.shift != 0.0:
            self.by_motion = owner.shift_slope(contact)
            self.by_angle = self.product(owner.turn(coefficients)) - owner.turn(owner.force(contact))

    def product(self, change: FloatArray) -> FloatArray:
        """(R, m) change of the force, at constant frequency, due to a ``change`` (R, m) of the coefficients."""
        size, change = self.shape[0], change.astype(self.precision, copy=False)
        motion = np.zeros((len(self.dofs), size), self.precision)
        for place, rows, jump, _ in self.parts:
            motion[:, rows] = jump @ change[place].T
        count = len(self.blocks)
        traction = np.matmul(self.blocks, motion.reshape(count, 3 * size, 1)).reshape(3 * count, size)
        out = self._collected(traction)
        if self.by_angle is not None:
            out += self.by_angle * float(np.vdot(self.by_motion, change))
        return out

    def _collected(self, traction: np.ndarray) -> FloatArray:
        """(R, m) forces of the Fourier coefficients (3 a, R) of tractions at the points of the map."""
        out = np.zeros(self.shape)
        for place, rows, _, operator in self.parts:
            out[place] = (operator @ traction[:, rows].astype(self.precision, copy=False)).T
        return out
