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
from wroll_fem.dynamics.reduction.reduced_model import contact_jump, modal_force
from wroll_fem.numerics.krylov import gmres
from wroll_fem.typing import FloatArray

NEAR_RESONANCE = 0.02
"""The dynamic stiffness of a mode is kept above this share of the larger of eigenvalue and frequency squared."""

KRYLOV, KRYLOV_TOLERANCE = 150, 1e-5
"""Maximum number of GMRES iterations, and the relative residual at which they end. The solution is less exact near a
resonance: with 1e-3 the estimate could not fall below 1e-3."""


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
) -> Correction:
    """First-order correction of a motion (R, m) at ``frequency`` (rad/s) by the balance of the whole structure.

    ``along`` (k, R, m) are directions in which a change does not count: that of the curve, since on a steep flank any
    small change of the frequency looks large; of a mode also its amplitude and its phase, in which it is free.
    ``damping`` is the negative modal damping of a nonlinear mode.
    """
    contact, model = balance.contact, balance.model
    c, orders = model.condensation, balance.orders
    modal = model.vectors @ coefficients.T  # (r, R)
    state = contact.evaluate(contact.motion(coefficients), frequency)
    squares = (orders * frequency) ** 2
    weights = contact.all_weights[:, None]
    force = modal_force(c, weights * contact.spread(state.coefficients))
    residual = (c.eigenvalues[:, None] - squares) * modal + force
    residual[:, 1] += balance.acceleration * c.base
    if c.damping is not None:
        w = orders[1::2] * frequency
        residual[:, 1::2] += w * (c.damping @ modal[:, 2::2])
        residual[:, 2::2] -= w * (c.damping @ modal[:, 1::2])
    if damping:
        w = orders[1::2] * frequency
        residual[:, 1::2] -= 2.0 * damping * frequency * w * modal[:, 2::2]
        residual[:, 2::2] += 2.0 * damping * frequency * w * modal[:, 1::2]
    each = (np.unique(orders) * frequency) ** 2
    stiffness = c.eigenvalues - each[:, None]  # (H + 1, r)
    least = NEAR_RESONANCE * np.maximum(c.eigenvalues, each[:, None])
    stiffness = np.where(np.abs(stiffness) < least, np.where(stiffness < 0.0, -least, least), stiffness)
    inverse = 1.0 / stiffness[orders.astype(int)].T  # (r, R)
    points, blocks, _ = contact.point_blocks(state, threshold=0.0)
    dofs, own = contact.dofs[points], contact.own
    square = blocks.reshape(len(points), 3 * len(orders), 3 * len(orders))

    def changed(z: FloatArray) -> FloatArray:
        """D z: traction (3 n, R) of a jump (3 n, R)."""
        out = np.zeros_like(z)
        moved = z[dofs]  # (a, 3, R)
        out[dofs] = (square @ moved.reshape(len(points), square.shape[1], 1)).reshape(moved.shape)
        return out

    def answer(z: FloatArray) -> FloatArray:
        """L^{-1} G^T W D z: modal displacement (r, R)."""
        return np.asarray(inverse * modal_force(c, weights * contact.spread(changed(z))))

    direct = -inverse * residual
    z = gmres(
        lambda v: v + contact_jump(c, answer(v))[own],
        contact_jump(c, direct)[own],
        tolerance=KRYLOV_TOLERANCE,
        iterations=KRYLOV,
    )
    delta = direct - answer(z)
    root = np.sqrt(np.maximum(c.eigenvalues, 0.0) + frequency**2)[:, None]
    if along is not None:
        shapes = root * (along @ model.vectors.T).transpose(0, 2, 1)
        directions = la.qr(shapes.reshape(len(along), -1).T, mode="economic")[0]
        scaled = (root * delta).ravel()
        delta = (scaled - directions @ (directions.T @ scaled)).reshape(delta.shape) / root
    tip, moved = c.tip @ delta[:, 1:3], c.tip @ modal[:, 1:3]
    size = float(np.linalg.norm(root * modal))
    return Correction(
        delta,
        delta / size,
        float(np.linalg.norm(root * delta)) / size,
        float(np.linalg.norm(tip) / np.linalg.norm(moved)),
    )
