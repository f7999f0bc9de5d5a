r"""Correction of a motion of a reduced model by the harmonic balance of the full model.

The harmonic balance of the full model (all modes of `condensation`) has a residual r at this motion. It is
linearised there as in Newton's method, with every contact point and every mode:

.. math:: (I + F D)\, z = -G L^{-1} r, \qquad \delta = -L^{-1} (r + G^T W D z), \qquad F = G L^{-1} G^T W

Here z is the jump of the correction :math:`\delta`, L the dynamic stiffness of each harmonic and D the exact derivative
of the contact law. GMRES needs about ten products with F.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.periodic.every_mode import EveryMode
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.numerics.krylov import gmres
from wroll_fem.typing import FloatArray

NEAR_RESONANCE = 0.02
"""Smallest magnitude of the dynamic stiffness of a mode, relative to the larger of its eigenvalue and the squared
frequency of the harmonic. Smaller magnitudes are raised to this limit."""

KRYLOV, KRYLOV_TOLERANCE, ROUGH_TOLERANCE = 150, 1e-5, 1e-4
"""Limits of GMRES: largest number of iterations, relative residual for an error estimate, and relative residual for
shapes that only enrich a basis. Near a resonance the solution is less accurate: with a relative residual of 1e-3, an
error estimate could not fall below 1e-3 there."""


@dataclass(frozen=True)
class Correction:
    """Correction of a motion of a reduced model by the harmonic balance of the full model.

    Attributes
    ----------
    modal : (r, R) first-order correction in modal coordinates of the condensation
    shapes : (r, R) ``modal`` divided by the energy norm of the motion
    energy : energy norm of the correction divided by the energy norm of the motion
    tip : change of the fundamental of the tip displacement, relative to this fundamental
    """

    modal: FloatArray
    shapes: FloatArray
    energy: float
    tip: float


def correction(
    balance: HarmonicBalance,
    coefficients: FloatArray,
    frequency: float,
    along: FloatArray | None = None,
    damping: float = 0.0,
    *,
    tolerance: float = KRYLOV_TOLERANCE,
) -> Correction:
    """First-order correction of a motion (R, m) at ``frequency`` (rad/s) from the residual of the full model.

    ``along`` (k, R, m) are directions whose components are removed from the correction. One is the direction of the
    curve: on a steep flank, a small shift in frequency would look like a large error. For a nonlinear mode, the
    directions of amplitude and phase are added, as both are free. ``damping`` is the modal damping ratio of a nonlinear
    mode, which its negative damping compensates. ``tolerance`` is the relative residual of GMRES.
    """
    contact, model = balance.contact, balance.model
    c, orders, every = model.condensation, balance.orders, contact.every_mode
    groups = every.groups
    state = contact.evaluate(contact.motion(coefficients), frequency)
    weights = contact.laws.area[every.points][:, None, None]
    modal = every.split(model.vectors @ coefficients.T)
    residual = every.force(weights * state.coefficients[every.dofs])
    inverse, root = [], []
    for group, motion, force in zip(groups, modal, residual, strict=True):
        squares = (orders[group.columns] * frequency) ** 2
        values = group.of_modes(c.eigenvalues, fill=1.0)[:, :, None]
        stiffness = values - squares
        force += stiffness * motion
        force[:, :, group.columns == 1] += balance.acceleration * group.of_modes(c.base)[:, :, None]
        least = NEAR_RESONANCE * np.maximum(values, squares)
        stiffness = np.where(np.abs(stiffness) < least, np.where(stiffness < 0.0, -least, least), stiffness)
        inverse.append(1.0 / stiffness)
        root.append(np.sqrt(np.maximum(values, 0.0) + frequency**2))
    if c.forces:
        for force, part in zip(residual, every.split(balance.further_load().T), strict=True):
            force -= part
    if c.damping or damping:
        speed = balance.velocity(coefficients, frequency) @ model.vectors.T  # (R, r)
        viscous = -2.0 * damping * frequency * speed
        if c.damping:
            viscous += c.viscous_force(speed.T).T
        for force, part in zip(residual, every.split(viscous.T), strict=True):
            force += part
    points, blocks, _ = contact.point_blocks(state, threshold=0.0)
    rank = np.zeros(contact.n, np.int64)
    rank[every.points] = np.arange(contact.n)
    order = np.argsort(rank[points])
    count, size = len(points), 3 * len(orders)
    own = slice(None) if count == contact.n else rank[points][order]
    square = blocks.reshape(count, size, size)[order] * contact.laws.area[points][order][:, None, None]
    short_square, short_inverse = square.astype(np.float32), [part.astype(np.float32) for part in inverse]

    def forces(maps: EveryMode, square: FloatArray, z: FloatArray) -> list[FloatArray]:
        """Modal forces G^T W D z due to the tractions that a jump z (n, 3, R) causes."""
        traction = np.zeros_like(z)
        traction[own] = (square @ z[own].reshape(count, size, 1)).reshape(count, 3, len(orders))
        return maps.force(traction)

    def product(z: FloatArray) -> FloatArray:
        """(I + F D) z, with F D z in single precision."""
        acting = forces(every.single, short_square, z.astype(np.float32))
        return z + every.single.motion([part * force for part, force in zip(short_inverse, acting, strict=True)])

    direct = [-part * force for part, force in zip(inverse, residual, strict=True)]
    z = gmres(product, every.motion(direct), tolerance=tolerance, iterations=KRYLOV)
    after = forces(every, square, z)
    delta = [part - share * force for part, share, force in zip(direct, inverse, after, strict=True)]
    scaled = _stacked([r * part for r, part in zip(root, delta, strict=True)])
    if along is not None:
        shapes = [every.split(model.vectors @ one.T) for one in along]
        directions = np.column_stack([_stacked([r * p for r, p in zip(root, one, strict=True)]) for one in shapes])
        directions = la.qr(directions, mode="economic", check_finite=False)[0]
        scaled -= directions @ (directions.T @ scaled)
    ends = np.cumsum([0, *(part.size for part in delta)])
    delta = [
        scaled[first:last].reshape(part.shape) / r
        for first, last, part, r in zip(ends[:-1], ends[1:], delta, root, strict=True)
    ]
    found = every.joined(delta)
    norm = float(np.linalg.norm(_stacked([r * part for r, part in zip(root, modal, strict=True)])))
    return Correction(
        found,
        found / norm,
        float(np.linalg.norm(scaled)) / norm,
        float(np.linalg.norm(c.tip @ found[:, 1:3]) / np.linalg.norm(coefficients[1:3] @ model.tip)),
    )


def _stacked(parts: list[FloatArray]) -> FloatArray:
    return np.concatenate([part.ravel() for part in parts])
