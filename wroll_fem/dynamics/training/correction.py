r"""Correction of a motion of a reduced model by the harmonic balance of the full model.

The harmonic balance of the full model (all modes of `condensation`) has a residual r at this motion. It is
linearised there as in Newton's method, with every contact point and every mode:

.. math:: (I + F D)\, z = -G L^{-1} r, \qquad \delta = -L^{-1} (r + G^T W D z), \qquad F = G L^{-1} G^T W

Here z is the jump of the correction :math:`\delta`, L the dynamic stiffness of each harmonic and D the exact derivative
of the contact law. GMRES needs about ten products with F. Of a structure with few modes and many points, such as a coil
in the span of its path, the equations of all modes are solved directly, :math:`(L + G^T W D G)\, \delta = -r`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.aft.matrix import apply_blocks, single_precision
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.numerics.krylov import gmres
from wroll_fem.typing import FloatArray

DIRECT = 2000
"""Largest number of unknowns (modes times Fourier coefficients) of a direct solution."""

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
    mode, which its negative damping compensates. ``tolerance`` is the relative residual of GMRES. A correction that is
    not finite counts as infinitely large and has no shapes.
    """
    model, every = balance.model, balance.contact.every_mode
    at = _Motion(balance, coefficients, frequency)
    residual = at.residual(damping)
    delta = _direct(at, residual) if _has_few_modes(balance) else _by_jumps(at, residual, tolerance)
    scaled = at.energetic(delta)
    if along is not None:
        directions = np.column_stack([at.energetic(every.split(model.vectors @ one.T)) for one in along])
        directions = la.qr(directions, mode="economic", check_finite=False)[0]
        scaled -= directions @ (directions.T @ scaled)
    ends = np.cumsum([0, *(part.size for part in delta)])
    delta = [
        scaled[first:last].reshape(part.shape) / r
        for first, last, part, r in zip(ends[:-1], ends[1:], delta, at.root, strict=True)
    ]
    found = every.joined(delta)
    if not np.isfinite(found).all():
        nothing = np.zeros_like(found)
        return Correction(nothing, nothing, np.inf, np.inf)
    norm = float(np.linalg.norm(at.energetic(at.modal)))
    return Correction(
        found,
        found / norm,
        float(np.linalg.norm(scaled)) / norm,
        float(np.linalg.norm(model.condensation.tip @ found[:, 1:3]) / np.linalg.norm(coefficients[1:3] @ model.tip)),
    )


def _by_jumps(at: _Motion, residual: list[FloatArray], tolerance: float) -> list[FloatArray]:
    """Solution of the linearised equations for the jump, by GMRES, then for the modes."""
    direct = [-part * force for part, force in zip(at.inverse, residual, strict=True)]
    tangent = _Tangent(at)
    jump = at.every.motion(direct)
    size = float(np.abs(jump).max(initial=0.0)) or 1.0  # m; squares of smaller numbers vanish in single precision
    start = (jump / size).astype(np.float32)
    z = gmres(tangent.product, start, tolerance=tolerance, iterations=KRYLOV, plus_identity=True).solution
    after = tangent.forces(size * z.astype(float))
    return [part - share * force for part, share, force in zip(direct, at.inverse, after, strict=True)]


def _has_few_modes(balance: HarmonicBalance) -> bool:
    """Whether the equations of all modes are fewer than those of the jumps, and few enough to be solved directly."""
    contact, modes = balance.contact, len(balance.model.condensation.eigenvalues)
    return contact.symmetry is None and modes < contact.n and modes * len(balance.orders) <= DIRECT


def _direct(at: _Motion, residual: list[FloatArray]) -> list[FloatArray]:
    """Solution of the linearised equations of all modes by their factors."""
    ((_, r, count),) = (part.shape for part in residual)
    matrix = at.balance.contact.with_all_modes.jacobian(at.state, threshold=0.0)[0].astype(float)
    matrix += np.diag((1.0 / at.inverse[0])[0].T.ravel())  # unknowns: harmonic by harmonic
    found = la.solve(matrix, -residual[0][0].T.ravel(), check_finite=False)
    return [found.reshape(count, r).T[None]]


def _inverse_stiffness(values: FloatArray, squares: FloatArray) -> FloatArray:
    """(b, d, c) inverse dynamic stiffness of modes with eigenvalues (b, d), kept away from a resonance.

    ``squares`` (c,) are squared frequencies. See `NEAR_RESONANCE`.
    """
    stiffness = values[:, :, None] - squares
    least = NEAR_RESONANCE * np.maximum(values[:, :, None], squares)
    near = np.abs(stiffness) < least
    if near.any():
        stiffness[near] = np.where(stiffness[near] < 0.0, -least[near], least[near])
    return np.asarray(1.0 / stiffness)


class _Motion:
    """Motion of a reduced model in all modes, by groups of `EveryMode`.

    Attributes
    ----------
    state : contact during a period
    modal : modal coordinates of the motion, one array per group
    stiffness, inverse : dynamic stiffness L, and its inverse with L kept away from 0 (`NEAR_RESONANCE`)
    root : square roots of the energy of unit coordinates
    """

    def __init__(self, balance: HarmonicBalance, coefficients: FloatArray, frequency: float):
        contact, every = balance.contact, balance.contact.every_mode
        self.balance, self.coefficients, self.frequency, self.every = balance, coefficients, frequency, every
        self.state = contact.evaluate(contact.motion(coefficients), frequency)
        self.modal = every.split(balance.model.vectors @ coefficients.T)
        self.stiffness: list[FloatArray] = []
        self.inverse: list[FloatArray] = []
        self.root: list[FloatArray] = []
        for group, values in zip(every.groups, every.eigenvalues, strict=True):
            squares = (balance.orders[group.columns] * frequency) ** 2
            self.stiffness.append(values[:, :, None] - squares)
            self.inverse.append(_inverse_stiffness(values, squares))
            self.root.append(np.sqrt(np.maximum(values, 0.0) + frequency**2)[:, :, None])

    def residual(self, damping: float) -> list[FloatArray]:
        """Residual of the harmonic balance in all modes; for ``damping`` see `correction`."""
        balance, every, c = self.balance, self.every, self.balance.model.condensation
        weights = balance.contact.laws.area[every.points][:, None, None]
        residual = every.force(weights * self.state.coefficients[every.dofs])
        for group, stiffness, motion, force in zip(every.groups, self.stiffness, self.modal, residual, strict=True):
            force += stiffness * motion
            force[:, :, group.columns == 1] += balance.acceleration * group.of_modes(c.base)[:, :, None]
        if c.forces:
            for force, part in zip(residual, every.split(balance.further_load().T), strict=True):
                force -= part
        if c.damping or damping:
            speed = balance.velocity(self.coefficients, self.frequency) @ balance.model.vectors.T  # (R, r)
            viscous = -2.0 * damping * self.frequency * speed
            if c.damping:
                viscous += c.viscous_force(speed.T).T
            for force, part in zip(residual, every.split(viscous.T), strict=True):
                force += part
        return residual

    def energetic(self, parts: list[FloatArray]) -> FloatArray:
        """Modal coordinates in one vector whose norm is the square root of their energy."""
        return np.concatenate([(root * part).ravel() for root, part in zip(self.root, parts, strict=True)])


class _Tangent:
    """Maps F D and D of the jump equation at a motion; see the module for the symbols."""

    def __init__(self, at: _Motion):
        contact, every = at.balance.contact, at.every
        points, blocks, _ = contact.point_blocks(at.state, threshold=0.0)
        place = np.zeros(contact.n, np.int64)
        place[every.points] = np.arange(contact.n)
        size = 3 * len(at.balance.orders)
        self.every, self.own, self.area = every, place[points], contact.laws.area[points][:, None, None]
        self.square = blocks.reshape(len(points), size, size)
        self.short_square = single_precision(blocks, contact.laws.area[points])
        squares = (at.balance.orders * at.frequency) ** 2
        self.residual_maps, values = every.with_residual_modes(float(squares.max()))
        self.short_inverse = [
            _inverse_stiffness(part, squares[group.columns]).astype(np.float32)
            for part, group in zip(values, self.residual_maps.groups, strict=True)
        ]

    def forces(self, z: FloatArray) -> list[FloatArray]:
        """Modal forces G^T W D z due to the tractions that a jump z (n, 3, R) causes."""
        forces, (count, size, _) = np.zeros_like(z), self.square.shape
        moved = self.square @ z[self.own].reshape(count, size, 1)
        forces[self.own] = (self.area * moved).reshape(count, 3, size // 3)
        return self.every.force(forces)

    def product(self, z: FloatArray) -> FloatArray:
        """F D z for z (n, 3, R) in single precision, with residual modes."""
        forces = np.empty_like(z)
        apply_blocks(self.short_square, self.own, z.reshape(len(z), -1), forces.reshape(len(z), -1))
        acting = self.residual_maps.force(forces)
        answer = [part * force for part, force in zip(self.short_inverse, acting, strict=True)]
        return self.residual_maps.motion(answer)
