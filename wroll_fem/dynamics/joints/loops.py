"""Hysteresis loops of joints during one period of a periodic motion."""

from __future__ import annotations

import numpy as np
import xarray as xr

from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

MOST = 50
"""Largest number of interfaces whose loops are recorded."""


def loops(system: System, balance: HarmonicBalance, coefficients: FloatArray, frequency: float) -> xr.Dataset:
    """Relative displacement and force of every interface during the period of a motion (R, m) at ``frequency`` (rad/s).

    The displacement is that of the first point along its first tangential direction, or towards the stop where this row
    is zero; the force is the sum of all points in this direction. They are recorded where interfaces have no
    coordinates, as joints have none: on a contact surface the motion differs from point to point.
    """
    contact = balance.contact
    spatial = any(np.isfinite(interface.points).all() for interface in system.interfaces)
    if not system.interfaces or spatial or contact.symmetry is not None or len(system.interfaces) > MOST:
        return xr.Dataset()
    period = contact.evaluate(contact.motion(coefficients), frequency)
    motion, reference = period.sampled.motion, contact.reference
    force = reference.traction[:, None] + reference.springs[:, None] * motion + period.correction
    force *= contact.weights[:, None]
    displacements, forces, first, every = [], [], 0, contact_dofs(contact.n)
    for interface in system.interfaces:
        points = np.arange(first, first + interface.n_points)
        slides = interface.operator[1::3].nnz > 0
        dofs = every[points, 0 if slides else 2]
        rows = interface.operator[1::3] if slides else interface.operator[::3]
        onto = np.asarray((rows @ rows[0].T).todense()).ravel() / max(float((rows[0] @ rows[0].T).sum()), 1e-300)
        sign = 1.0 if slides else -1.0  # a stop closes towards a negative normal displacement
        displacements.append(sign * motion[dofs[0]])
        forces.append(sign * onto @ force[dofs])
        first += interface.n_points
    phase = 360.0 * np.arange(motion.shape[1]) / motion.shape[1]
    dims = ("interface", "phase")
    return xr.Dataset(
        {"loop_displacement": (dims, np.array(displacements)), "loop_force": (dims, np.array(forces))}, {"phase": phase}
    )
