"""Rigid ends of a mandrel: mass matrix of a tip mass, and stiffness of the springs at tip and base."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wroll_fem.typing import FloatArray


def rigid_mass(mass: float, transverse: float, polar: float, offset: float) -> FloatArray:
    """(6, 6) mass matrix of a rigid body for the motion [U, Omega] of a point on its axis.

    Parameters
    ----------
    mass
        kg.
    transverse, polar
        Moments of inertia about x and y, and about the axis z, at the centre of mass, kg m^2.
    offset
        Height of the centre of mass above the point, m.
    """
    inertia = transverse + mass * offset**2
    matrix = np.diag([mass, mass, mass, inertia, inertia, polar]).astype(float)
    matrix[0, 4] = matrix[4, 0] = mass * offset  # u_x of the centre of mass = U_x + offset Omega_y
    matrix[1, 3] = matrix[3, 1] = -mass * offset
    return matrix


def spring_matrix(springs: Sequence[float | None]) -> FloatArray:
    """(6, 6) stiffness of springs along and about x, y, z; None (held) has no entry."""
    return np.diag([0.0 if k is None else float(k) for k in springs])
