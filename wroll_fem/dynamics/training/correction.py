r"""Correction of a motion of a reduced model by the harmonic balance of the full model.

The harmonic balance of the full model (all modes of `condensation`) has a residual r at this motion. It is
linearised there as in Newton's method, with every contact point and every mode:

.. math:: (I + F D)\, z = -G L^{-1} r, \qquad \delta = -L^{-1} (r + G^T W D z), \qquad F = G L^{-1} G^T W

Here z is the jump of the correction :math:`\delta`, L the dynamic stiffness of each harmonic and D the exact derivative
of the contact law. GMRES needs about ten products with F. Of a structure with few modes and many points, such as a coil
in the span of its path, the equations of all modes are solved directly, :math:`(L + G^T W D G)\, \delta = -r`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from wroll_fem.dynamics.aft.every_mode import EveryMode
from wroll_fem.dynamics.aft.matrix import apply_blocks
from wroll_fem.dynamics.aft.periodic_contact import PeriodicContact
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.numerics.krylov import gmres_together
from wroll_fem.typing import FloatArray, IntArray

DIRECT = 2000
"""Largest number of unknowns (modes times Fourier coefficients) of a direct solution."""

NEAR_RESONANCE = 1e-3
"""Smallest magnitude of the dynamic stiffness of a mode, relative to the larger of its eigenvalue and the squared
frequency of the harmonic. Smaller magnitudes are raised to this limit."""

KRYLOV, KRYLOV_TOLERANCE, ROUGH_TOLERANCE = 150, 1e-5, 1e-4
"""Limits of GMRES: largest number of iterations, relative residual for an error estimate, and relative residual for
shapes that only enrich a basis. Near a resonance the solution is less accurate: with a relative residual of 1e-3, an
error estimate could not fall below 1e-3 there."""

TOGETHER, BYTES = 8, 1.5e8
"""Largest number of motions that are corrected at once, and largest memory of the derivatives of their tractions, or
of motions and tractions if only means are corrected. The maps of all modes, which take longer to read than to multiply,
are then read once for all of these motions."""


@dataclass(frozen=True)
class Correction:
    """Correction of a motion of a reduced model by the harmonic balance of the full model.

    Attributes
    ----------
    modal : (r, R) first-order correction in modal coordinates of the condensation
    shapes : (r, R) ``modal`` divided by the energy norm of the motion
    energy : energy norm of the correction divided by the energy norm of the motion
    moving : the same without the correction of the mean displacement
    tip : change of the fundamental of the tip displacement, relative to this fundamental
    """

    modal: FloatArray
    shapes: FloatArray
    energy: float
    moving: float
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
    """First-order correction of one motion; for the arguments see `corrections`."""
    directions = None if along is None else [along]
    return corrections(
        balance, coefficients[None], np.array([frequency]), directions, np.array([damping]), tolerance=tolerance
    )[0]


def corrections(
    balance: HarmonicBalance,
    coefficients: FloatArray,
    frequencies: FloatArray,
    along: Sequence[FloatArray] | None = None,
    damping: FloatArray | None = None,
    *,
    tolerance: float = KRYLOV_TOLERANCE,
) -> list[Correction]:
    """First-order corrections of motions (p, R, m) of a reduced model; see `modal_corrections`.

    ``along`` (k, R, m) are the directions of each motion, in the coordinates of the reduced model too.
    """
    vectors = balance.model.vectors.T
    directions = None if along is None else [one @ vectors for one in along]
    return modal_corrections(balance, coefficients @ vectors, frequencies, directions, damping, tolerance=tolerance)


def modal_corrections(
    balance: HarmonicBalance,
    motions: FloatArray,
    frequencies: FloatArray,
    along: Sequence[FloatArray] | None = None,
    damping: FloatArray | None = None,
    *,
    tolerance: float = KRYLOV_TOLERANCE,
) -> list[Correction]:
    """First-order corrections of ``motions`` (p, R, r) in all modes at ``frequencies`` (p,), rad/s.

    ``balance`` has the load and the contacts of the motions; its reduced model has no influence. ``along`` (k, R, r)
    are directions, for each motion, whose components are removed from its correction. One is the direction of the
    curve: on a steep flank, a small shift in frequency would look like a large error. For a nonlinear mode, the
    directions of amplitude and phase are added, as both are free. ``damping`` are the modal damping ratios of nonlinear
    modes, which their negative damping compensates. ``tolerance`` is the relative residual of GMRES. A correction that
    is not finite counts as infinitely large and has no shapes.
    """
    found = []
    count = _number_together(balance)
    for first in range(0, len(motions), count):
        part = slice(first, first + count)
        at = _Motions(balance, motions[part], frequencies[part])
        residual = at.residual(None if damping is None else damping[part])
        deltas = _direct(at, residual) if _has_few_modes(balance) else _by_jumps(at, residual, tolerance)
        for k in range(len(at)):
            found.append(_corrected(at, k, at.of(deltas, k), None if along is None else along[first + k]))
    return found


def corrected_means(
    balance: HarmonicBalance, motions: FloatArray, frequencies: FloatArray, *, tolerance: float = KRYLOV_TOLERANCE
) -> FloatArray:
    """(p, r) mean displacements of motions (p, R, r) after a correction of the mean alone; see `modal_corrections`.

    The mean displacement is static, and the history of slip determines it: it changes along a curve in smaller steps
    than the harmonics, and one correction costs a third of that of a motion.
    """
    out = motions[:, 0].copy()
    contact = balance.contact
    of_one = 8 * contact.sampling.samples * 9 * contact.n  # motion, traction and slip during a period
    count = max(1, min(TOGETHER * len(balance.orders), int(BYTES / max(of_one, 1))))
    for first in range(0, len(motions), count):
        part = slice(first, first + count)
        at = _Motions(balance, motions[part], frequencies[part], mean=True)
        out[part] += at.repeated.joined(_by_jumps(at, at.residual(None), tolerance)).T
    return out


def _corrected(at: _Motions, number: int, delta: list[FloatArray], along: FloatArray | None) -> Correction:
    """Correction from the change ``delta`` of the modes, without its components ``along`` given directions."""
    condensation, every = at.balance.model.condensation, at.every
    scaled = at.energetic(delta, number)
    if along is not None:
        directions = np.column_stack([at.energetic(every.split(one.T), number) for one in along])
        directions = la.qr(directions, mode="economic", check_finite=False)[0]
        scaled -= directions @ (directions.T @ scaled)
    ends = np.cumsum([0, *(part.size for part in delta)])
    delta = [
        scaled[first:last].reshape(part.shape) / r
        for first, last, part, r in zip(ends[:-1], ends[1:], delta, at.root(number), strict=True)
    ]
    found = every.joined(delta)
    if not np.isfinite(found).all():
        nothing = np.zeros_like(found)
        return Correction(nothing, nothing, np.inf, np.inf, np.inf)
    norm = float(np.linalg.norm(at.energetic(at.of(at.modal, number), number)))
    root = np.sqrt(np.maximum(condensation.eigenvalues, 0.0) + at.frequencies[number] ** 2)
    whole, mean = float(np.linalg.norm(scaled)), float(np.linalg.norm(root * found[:, 0]))
    fundamental = at.motions[number][1:3] @ condensation.tip
    return Correction(
        found,
        found / norm,
        whole / norm,
        float(np.sqrt(max(whole**2 - mean**2, 0.0))) / norm,
        float(np.linalg.norm(condensation.tip @ found[:, 1:3]) / np.linalg.norm(fundamental)),
    )


def _by_jumps(at: _Motions, residual: list[FloatArray], tolerance: float) -> list[FloatArray]:
    """Solution of the linearised equations for the jumps, by GMRES, then for the modes."""
    direct = [-part * force for part, force in zip(at.inverse, residual, strict=True)]
    tangent = _Tangents(at)
    jump = at.single.motion(direct)
    count = len(at)
    jumps = [np.ascontiguousarray(part) for part in np.split(jump, count, axis=2)]
    sizes = [float(np.abs(part).max(initial=0.0)) or 1.0 for part in jumps]
    # m; squares of smaller numbers vanish in single precision
    starts = [(part / size).astype(np.float32) for part, size in zip(jumps, sizes, strict=True)]
    solved = gmres_together(tangent.product, starts, tolerance=tolerance, iterations=KRYLOV, plus_identity=True)
    after = tangent.forces([size * one.solution.astype(float) for size, one in zip(sizes, solved, strict=True)])
    return [part - share * force for part, share, force in zip(direct, at.inverse, after, strict=True)]


def _number_together(balance: HarmonicBalance) -> int:
    """Largest number of motions that are corrected at once."""
    if _has_few_modes(balance):
        return 1
    of_one = 4 * balance.contact.n * (3 * len(balance.orders)) ** 2
    return max(1, min(TOGETHER, int(BYTES / max(of_one, 1))))


def _has_few_modes(balance: HarmonicBalance) -> bool:
    """Whether the equations of all modes are fewer than those of the jumps, and few enough to be solved directly."""
    contact, modes = balance.contact, len(balance.model.condensation.eigenvalues)
    return contact.symmetry is None and modes < contact.n and modes * len(balance.orders) <= DIRECT


def _direct(at: _Motions, residual: list[FloatArray]) -> list[FloatArray]:
    """Solution of the linearised equations of all modes of one motion by their factors."""
    ((_, r, count),) = (part.shape for part in residual)
    matrix = at.balance.contact.with_all_modes.jacobian(at.states[0], threshold=0.0)[0].astype(float)
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


class _Motions:
    """Motions in all modes, by groups of `EveryMode`: in each array one motion after the other.

    Parameters
    ----------
    balance, motions, frequencies
        See `modal_corrections`.
    mean
        Whether the equations are those of the mean displacement alone.

    Attributes
    ----------
    orders : (R,) harmonic numbers of the coefficients in the equations
    every, repeated, single : maps of one motion and of all of them, and the latter in single precision
    states : contacts during a period
    modal : modal coordinates of the motions, one array per group
    stiffness, inverse : dynamic stiffness L, and its inverse with L kept away from 0 (`NEAR_RESONANCE`)
    """

    def __init__(self, balance: HarmonicBalance, motions: FloatArray, frequencies: FloatArray, *, mean: bool = False):
        every = balance.contact.every_mode
        self.balance, self.motions, self.frequencies, self.mean = balance, motions, frequencies, mean
        whole = every.repeated(len(motions))
        self.modal = whole.split(np.concatenate(motions).T)
        self.states = self._states(whole.motion(self.modal), every)
        self.orders = balance.orders[:1] if mean else balance.orders
        self.every = every.of_mean() if mean else every
        self.repeated = self.every.repeated(len(motions))
        single = every.single.of_mean() if mean else every.single
        self.single = single.repeated(len(motions))
        if mean:
            self.modal = self.repeated.split(motions[:, 0].T)
        self.stiffness: list[FloatArray] = []
        self.inverse: list[FloatArray] = []
        for squares, values in zip(self.squares(self.every), self.every.eigenvalues, strict=True):
            self.stiffness.append(values[:, :, None] - squares)
            self.inverse.append(_inverse_stiffness(values, squares))

    def _states(self, jumps: FloatArray, every: EveryMode) -> list[PeriodicContact]:
        """Contact during a period of each motion, from their ``jumps`` (n, 3, R ...)."""
        contact, states = self.balance.contact, []
        for jump, frequency in zip(np.split(jumps, len(self), axis=2), self.frequencies, strict=True):
            coefficients = np.empty((3 * contact.n, jump.shape[2]))
            coefficients[every.dofs] = jump
            states.append(contact.evaluate(coefficients, float(frequency)))
        return states

    def __len__(self) -> int:
        return len(self.motions)

    def squares(self, maps: EveryMode) -> list[FloatArray]:
        """Squared frequencies of the coefficients of each group of ``maps``, which are those of one motion."""
        return [np.square(np.outer(self.frequencies, self.orders[group.columns]).ravel()) for group in maps.groups]

    def of(self, parts: Sequence[np.ndarray], number: int) -> list[np.ndarray]:
        """Part of the arrays ``parts`` that belongs to one motion."""
        return [part.reshape(*part.shape[:2], len(self), part.shape[2] // len(self))[:, :, number] for part in parts]

    def root(self, number: int) -> list[FloatArray]:
        """Square roots of the energy of unit coordinates in one motion, one array (b, d, 1) per group."""
        square = self.frequencies[number] ** 2
        return [np.sqrt(np.maximum(values, 0.0) + square)[:, :, None] for values in self.every.eigenvalues]

    def residual(self, damping: FloatArray | None) -> list[FloatArray]:
        """Residual of the harmonic balance in all modes; for ``damping`` see `modal_corrections`."""
        balance, every, c = self.balance, self.repeated, self.balance.model.condensation
        weights, size = balance.contact.laws.area[every.points][:, None, None], len(self.orders)
        tractions = np.concatenate([state.coefficients[every.dofs, :size] for state in self.states], axis=2)
        residual = every.force(weights * tractions)
        cosines = np.tile(np.arange(size) == 1, len(self))
        for group, stiffness, motion, force in zip(every.groups, self.stiffness, self.modal, residual, strict=True):
            force += stiffness * motion
            force[:, :, cosines[group.columns]] += balance.acceleration * group.of_modes(c.base)[:, :, None]
        if c.forces:
            further = np.tile(balance.further_load()[:size].T, len(self))
            for force, part in zip(residual, every.split(further), strict=True):
                force -= part
        if size > 1 and (c.damping or (damping is not None and damping.any())):
            ratios = np.zeros(len(self)) if damping is None else damping
            parts = []
            for motion, w, ratio in zip(self.motions, self.frequencies, ratios, strict=True):
                speed = balance.velocity(motion, w).T  # (r, R)
                parts.append(-2.0 * ratio * w * speed + (c.viscous_force(speed) if c.damping else 0.0))
            for force, part in zip(residual, every.split(np.column_stack(parts)), strict=True):
                force += part
        return residual

    def energetic(self, parts: Sequence[FloatArray], number: int) -> FloatArray:
        """Modal coordinates of one motion in one vector whose norm is the square root of their energy."""
        return np.concatenate([(root * part).ravel() for root, part in zip(self.root(number), parts, strict=True)])


class _Tangents:
    """Maps F D and D of the jump equation at several motions; see the module for the symbols."""

    def __init__(self, at: _Motions):
        contact, every = at.balance.contact, at.every
        place = np.zeros(contact.n, np.int64)
        place[every.points] = np.arange(contact.n)
        self.at, self.derivatives = at, list[tuple[np.ndarray, FloatArray, IntArray]]()
        for state in at.states:
            points, blocks, _ = contact.point_blocks(state, threshold=0.0, precision=np.float32, mean=at.mean)
            blocks = blocks.reshape(len(points), 3 * blocks.shape[2], 3 * blocks.shape[2])
            self.derivatives.append((blocks, contact.laws.area[points].astype(np.float32), place[points]))
        largest = float((at.balance.orders.max() * at.frequencies.max()) ** 2)
        maps, values = contact.every_mode.with_residual_modes(largest)
        self.residual_maps = maps.of_mean() if at.mean else maps
        self._inverse = [
            _inverse_stiffness(part, squares).astype(np.float32)
            for part, squares in zip(values, at.squares(self.residual_maps), strict=True)
        ]
        self._last: tuple[list[int], list[FloatArray]] = ([], [])

    def _tractions(self, numbers: Sequence[int], jumps: Sequence[np.ndarray]) -> np.ndarray:
        """(n, 3, R ...) forces W D z of the motions of the given numbers, in single precision."""
        forces = np.empty((len(numbers), len(jumps[0]), 3 * jumps[0].shape[2]), np.float32)
        for force, number, z in zip(forces, numbers, jumps, strict=True):
            apply_blocks(*self.derivatives[number], z.reshape(len(z), 3 * z.shape[2]), force)
        return np.concatenate([force.reshape(jumps[0].shape) for force in forces], axis=2)

    def forces(self, jumps: Sequence[FloatArray]) -> list[FloatArray]:
        """Modal forces G^T W D z due to the tractions that the jumps z (n, 3, R) of all motions cause."""
        tractions = self._tractions(range(len(jumps)), [z.astype(np.float32) for z in jumps])
        return self.at.single.force(tractions)

    def product(self, numbers: Sequence[int], jumps: Sequence[np.ndarray]) -> list[np.ndarray]:
        """F D z for z (n, 3, R), in single precision, of the motions of the given numbers, with residual modes."""
        maps = self.residual_maps.repeated(len(numbers))
        if self._last[0] != numbers:
            split = [self.at.of(self._inverse, number) for number in numbers]
            chosen = [np.concatenate(parts, axis=2) for parts in zip(*split, strict=True)]
            self._last = list(numbers), chosen
        answer = [
            part * force for part, force in zip(self._last[1], maps.force(self._tractions(numbers, jumps)), strict=True)
        ]
        return np.split(maps.motion(answer), len(numbers), axis=2)
