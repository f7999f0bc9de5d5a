r"""What the balance of the whole structure adds to a motion of a reduced model.

The balance of the *whole* structure (all modes of `condensation`) is evaluated and linearised at the motion, exactly
as in Newton's method but with every point of the interface and every mode:

.. math:: (I + F D)\, z = -G L^{-1} r, \qquad \delta = -L^{-1} (r + G^T W D z), \qquad F = G L^{-1} G^T W

for the jump z of the correction :math:`\delta`; L is the dynamic stiffness of each harmonic, D the exact derivative
of the contact law. GMRES needs some ten products with F.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.numerics.krylov import gmres
from wroll_fem.typing import FloatArray

NEAR_RESONANCE = 0.02
"""The dynamic stiffness of a mode is kept above this share of the larger of eigenvalue and frequency squared."""

KRYLOV, KRYLOV_TOLERANCE, ROUGH_TOLERANCE = 150, 1e-5, 1e-4
"""Maximum number of GMRES iterations, and the relative residuals at which they end: of an estimate, and of shapes for a
basis alone. The solution is less exact near a resonance: with 1e-3 the estimate could not fall below 1e-3."""


@dataclass(frozen=True)
class Correction:
    """What the whole structure adds to a motion of a reduced model.

    Attributes
    ----------
    modal : (r, R) first-order correction in modes of the condensation
    shapes : (r, R) the same for unit energy norm of the motion
    energy : its energy norm over that of the motion
    tip : change of the fundamental of the tip over that of the motion
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
    """First-order correction of a motion (R, m) at ``frequency`` (rad/s) by the balance of the whole structure.

    ``along`` (k, R, m) are directions in which a change does not count: that of the curve, since on a steep flank any
    small change of the frequency looks large; of a mode also its amplitude and its phase, in which it is free.
    ``damping`` is the negative modal damping of a nonlinear mode, ``tolerance`` the relative residual of GMRES.
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
    if c.damping is not None or damping:
        speed = balance.velocity(coefficients, frequency) @ model.vectors.T  # (R, r)
        viscous = -2.0 * damping * frequency * speed
        if c.damping is not None:
            viscous += speed @ c.damping.T
        for force, part in zip(residual, every.split(viscous.T), strict=True):
            force += part
    points, blocks, _ = contact.point_blocks(state, threshold=0.0)
    rank = np.zeros(contact.n, np.int64)
    rank[every.points] = np.arange(contact.n)
    order = np.argsort(rank[points])
    count, size = len(points), 3 * len(orders)
    own = slice(None) if count == contact.n else rank[points][order]
    square = blocks.reshape(count, size, size)[order] * contact.laws.area[points][order][:, None, None]

    def answer(z: FloatArray) -> list[FloatArray]:
        """L^{-1} G^T W D z: modal displacements of a jump (n, 3, R)."""
        traction = np.zeros_like(z)
        traction[own] = (square @ z[own].reshape(count, size, 1)).reshape(count, 3, len(orders))
        return [part * force for part, force in zip(inverse, every.force(traction), strict=True)]

    direct = [-part * force for part, force in zip(inverse, residual, strict=True)]
    z = gmres(lambda v: v + every.motion(answer(v)), every.motion(direct), tolerance=tolerance, iterations=KRYLOV)
    delta = [part - change for part, change in zip(direct, answer(z), strict=True)]
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
