"""Maps between all modes of a structure and its contact points, for the Fourier coefficients of periodic motions.

With half-period symmetry, a mode has either the odd harmonics alone, or the mean and the even harmonics alone. The
modes of one kind and their harmonics form a `Group`. Only these pairs of mode and harmonic are stored and computed, and
only the contact points that are evaluated: the mirrored points contribute the same modal force. Without symmetry, one
group holds all modes and all harmonics.

Modes far above the harmonics of a motion respond to a force at the contact points almost as springs. In each block,
residual modes replace them: orthogonal combinations, at most as many as the block has amplitudes of the jump. Their
compliance is exact in the first two terms of its series in the squared frequency.

References
----------
Rubin (1975), AIAA J. 13, 995, doi:10.2514/3.60497 (residual modes; here with their inertia).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg as la

from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.aft.half_period import HalfPeriod
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.typing import BoolArray, FloatArray, IntArray

FAR = 100.0
"""Eigenvalue of a mode, relative to the largest squared frequency of a motion, from which the mode counts as far above
it. The compliance of residual modes is off by at most the inverse of its square, 1e-4, and by 1e-7 as a rule."""

CLASSES = 16.0
"""Limits between near and far modes are powers of this number, so that the motions of a curve share few of them."""


@dataclass(frozen=True)
class Group:
    """Circumferential blocks of modes whose nonzero Fourier coefficients belong to the same harmonics.

    Attributes
    ----------
    columns : (c,) indices of the Fourier coefficients that these modes have
    modes : (b, d) indices of the modes of each block; rows of shorter blocks are padded with r, the number of all modes
    filled : (b, d) True for a mode, False for padding
    around : (3, b n_waves, n_theta) circumferential profiles at the evaluated contact points
    jump : (b, d, n_waves 3 n_rows) amplitude of the jump of every mode in each row of contact points; zero for padding
    """

    columns: IntArray
    modes: IntArray
    filled: BoolArray
    around: FloatArray
    jump: FloatArray

    def of_modes(self, values: FloatArray, *, fill: float = 0.0) -> FloatArray:
        """(b, d, ...) values for the modes of the group, from ``values`` (r, ...) of all r modes; padding is ``fill``.

        The group has b circumferential blocks of at most d modes.
        """
        out = values.take(self.modes, axis=0, mode="clip")
        out[~self.filled] = fill
        return np.asarray(out)

    def in_single_precision(self) -> Group:
        """The same group with maps of single precision."""
        return replace(self, around=self.around.astype(np.float32), jump=self.jump.astype(np.float32))

    def with_residual_modes(self, eigenvalues: FloatArray, limit: float) -> tuple[Group, FloatArray]:
        """Group with residual modes in place of the modes above an eigenvalue ``limit``, and its eigenvalues (b, d).

        The rows of blocks with fewer modes are padded by modes without a jump. ``eigenvalues`` are those of all modes.
        """
        blocks, amplitudes = len(self.modes), self.jump.shape[2]
        values = self.of_modes(eigenvalues, fill=np.inf)
        near = values < limit
        far = self.filled & ~near
        sizes = near.sum(axis=1) + np.minimum(far.sum(axis=1), amplitudes)
        if sizes.max() >= self.modes.shape[1]:  # nothing is gained
            return self, self.of_modes(eigenvalues, fill=1.0)
        jump, found = np.zeros((blocks, sizes.max(), amplitudes)), np.full((blocks, sizes.max()), limit)
        for k in range(blocks):
            count, size = near[k].sum(), sizes[k]
            jump[k, :count], found[k, :count] = self.jump[k, near[k]], values[k, near[k]]
            if size > count:
                jump[k, count:size], found[k, count:size] = _residual(self.jump[k, far[k]], values[k, far[k]])
        return replace(self, jump=jump), found


def _residual(jump: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Jump (k, n) and eigenvalues (k,) of residual modes, from those of m modes, (m, n) and (m,); k = min(m, n).

    With J^T (L - s)^{-1} J = J^T L^{-1} J + s J^T L^{-2} J + ..., both terms are those of the m modes.
    """
    shapes, triangle = la.qr(jump / np.sqrt(values)[:, None], mode="economic", check_finite=False)
    inverse, turn = la.eigh(shapes.T @ (shapes / values[:, None]), check_finite=False)
    return (turn.T @ triangle) / np.sqrt(inverse)[:, None], 1.0 / inverse


class EveryMode:
    """Maps between Fourier coefficients (n, 3, R) at the n evaluated contact points and those of all modes.

    Modal coefficients are lists with one array (b, d, c) per group: b circumferential blocks of at most d modes, with c
    Fourier coefficients each.

    Attributes
    ----------
    groups : list of `Group`
    eigenvalues : eigenvalues (b, d) of the modes of each group; padding is 1
    dofs : (n, 3) contact degrees of freedom of the points in the order used here: all rows of one angle, then the next
    points : (n,) indices of the points in this order

    Parameters
    ----------
    condensation
        Modes of the structure.
    symmetry
        Half-period symmetry of the motions; None without symmetry.
    orders
        (R,) harmonic number of each coefficient.
    """

    def __init__(self, condensation: Condensation, symmetry: HalfPeriod | None, orders: FloatArray):
        c = condensation
        self.size, self.coefficients = len(c.eigenvalues), len(orders)
        theta = np.arange(c.n_theta) if symmetry is None else symmetry.first[symmetry.first < c.n_theta]
        self.rows, self.n_theta = len(c.jump[0]) // (3 * c.profiles.shape[1]), len(theta)
        order = np.arange(self.rows * self.n_theta).reshape(self.rows, self.n_theta).T
        self.points = order.ravel()
        self.dofs = contact_dofs(len(self.points))[self.points]
        self._residual: dict[float, tuple[EveryMode, list[FloatArray]]] = {}
        self._repeated: dict[int, EveryMode] = {1: self}
        self._mean: EveryMode | None = None
        kinds = [(np.arange(len(c.jump)), np.arange(len(orders)))]
        if symmetry is not None:
            reverses = symmetry.odd[c.blocks[:-1]]
            odd = orders % 2 == 1
            kinds = [(np.flatnonzero(reverses == kind), np.flatnonzero(odd == kind)) for kind in (True, False)]
        self.groups = [self._group(c, theta, blocks, columns) for blocks, columns in kinds if len(blocks)]
        self._all = c.eigenvalues
        self.eigenvalues = [group.of_modes(self._all, fill=1.0) for group in self.groups]

    def _group(self, c: Condensation, theta: IntArray, blocks: IntArray, columns: IntArray) -> Group:
        counts = np.diff(c.blocks)[blocks]
        filled = np.arange(counts.max()) < counts[:, None]
        modes = np.where(filled, c.blocks[blocks][:, None] + np.arange(counts.max()), self.size)
        jump = np.zeros((*modes.shape, len(c.jump[0])))
        for place, block in enumerate(blocks):
            jump[place, : counts[place]] = c.jump[block].T
        profiles = c.profiles[blocks].reshape(-1, 3, c.n_theta)  # of each wave
        around = np.ascontiguousarray(profiles[:, :, theta].transpose(1, 0, 2))
        return Group(columns, modes, filled, around, jump)

    def with_residual_modes(self, square: float) -> tuple[EveryMode, list[FloatArray]]:
        """The same maps with residual modes, for arrays of single precision, and eigenvalues (b, d) per group.

        ``square`` is the largest squared frequency (rad^2/s^2) of the motions. Only `force` and `motion` have a meaning
        for residual modes.
        """
        limit = CLASSES ** float(np.ceil(np.log(FAR * square) / np.log(CLASSES)))
        if limit not in self._residual:
            out = copy(self)
            out._repeated, out._mean = {1: out}, None
            found = [group.with_residual_modes(self._all, limit) for group in self.groups]
            out.groups = [group.in_single_precision() for group, _ in found]
            self._residual[limit] = out, [values for _, values in found]
        return self._residual[limit]

    @cached_property
    def single(self) -> EveryMode:
        """The same maps in single precision."""
        out = copy(self)
        out._repeated, out._mean = {1: out}, None
        out.groups = [group.in_single_precision() for group in self.groups]
        return out

    def repeated(self, count: int) -> EveryMode:
        """The same maps for ``count`` motions at once: R coefficients of the first one, then those of the next ones.

        The coefficients of a group are those of its first motion, then those of the next ones.
        """
        if count not in self._repeated:
            out = copy(self)
            out.coefficients = count * self.coefficients
            first = self.coefficients * np.arange(count)[:, None]
            out.groups = [replace(group, columns=(first + group.columns).ravel()) for group in self.groups]
            self._repeated[count] = out
        return self._repeated[count]

    def of_mean(self) -> EveryMode:
        """The same maps for the mean alone, the first of the coefficients; groups without it have no columns."""
        if self._mean is None:
            out = copy(self)
            out.coefficients, out._mean, out._repeated = 1, out, {1: out}
            out.groups = [replace(group, columns=group.columns[group.columns == 0]) for group in self.groups]
            self._mean = out
        return self._mean

    def split(self, values: FloatArray) -> list[FloatArray]:
        """Fourier coefficients of each group, one array (b, d, c) per group, from the array (r, R) of all r modes."""
        return [group.of_modes(values).take(group.columns, axis=2) for group in self.groups]

    def joined(self, parts: Sequence[FloatArray]) -> FloatArray:
        """(r, R) Fourier coefficients of all r modes, from one array (b, d, c) per group.

        Coefficients that belong to no group are zero.
        """
        out = np.zeros((self.size, self.coefficients))
        for group, part in zip(self.groups, parts, strict=True):
            out[group.modes[group.filled][:, None], group.columns] = part[group.filled]
        return out

    def force(self, traction: FloatArray) -> list[FloatArray]:
        """Modal forces G^T f due to the forces f (n, 3, R), N, at the contact points; one array (b, d, c) per group.

        They have the precision of the maps.
        """
        out, traction = [], traction.astype(self.groups[0].jump.dtype, copy=False)
        for group in self.groups:
            blocks, waves, count = len(group.modes), group.around.shape[1], len(group.columns)
            forces = traction[:, :, group.columns].reshape(self.n_theta, self.rows, 3, count).transpose(2, 0, 1, 3)
            around = group.around @ forces.reshape(3, self.n_theta, self.rows * count)
            amplitudes = around.reshape(3, waves, self.rows, count).transpose(1, 0, 2, 3)
            out.append(group.jump @ amplitudes.reshape(blocks, group.jump.shape[2], count))
        return out

    def motion(self, parts: Sequence[FloatArray]) -> FloatArray:
        """(n, 3, R) relative displacement of the contact points from modal coefficients (b, d, c) per group.

        It has the precision of the maps.
        """
        out = np.zeros((len(self.points), 3, self.coefficients), self.groups[0].jump.dtype)
        for group, part in zip(self.groups, parts, strict=True):
            waves, count = group.around.shape[1], len(group.columns)
            amplitudes = group.jump.transpose(0, 2, 1) @ part.astype(out.dtype, copy=False)
            around = amplitudes.reshape(waves, 3, self.rows, count).transpose(1, 0, 2, 3)
            moved = group.around.transpose(0, 2, 1) @ around.reshape(3, waves, self.rows * count)
            out[:, :, group.columns] = (
                moved.reshape(3, self.n_theta, self.rows, count).transpose(1, 2, 0, 3).reshape(len(out), 3, count)
            )
        return out


class ModeMaps:
    """`EveryMode` of one structure for any harmonics; those of the same harmonics are built once.

    Parameters are those of `EveryMode`, without the harmonics.
    """

    def __init__(self, condensation: Condensation, symmetry: HalfPeriod | None):
        self._condensation, self._symmetry = condensation, symmetry
        self._built: dict[bytes, EveryMode] = {}

    def of(self, orders: FloatArray) -> EveryMode:
        """Maps for Fourier coefficients of the harmonic numbers ``orders`` (R,)."""
        key = orders.tobytes()
        if key not in self._built:
            self._built[key] = EveryMode(self._condensation, self._symmetry, orders)
        return self._built[key]
