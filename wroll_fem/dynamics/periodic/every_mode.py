"""All modes of a structure in harmonics: motion of its contact points, and forces on its modes, group by group.

With half-period symmetry a mode has odd harmonics alone, or the others; modes of one kind and their harmonics are a
`Group`. Only those pairs are stored and computed, and only the points that are evaluated: their images add the same to
a mode. Without symmetry there is one group of everything.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.periodic.half_period import HalfPeriod
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.typing import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Group:
    """Circumferential blocks whose modes have the same harmonics.

    Attributes
    ----------
    columns : (c,) Fourier coefficients that these modes have
    modes : (b, d) modes of each block; short blocks are filled up by the number of all modes, r
    filled : (b, d) True where there is a mode
    around : (3, b, n_theta) profiles at the points evaluated
    jump : (b, d, 3 n_rows) jump of every mode in each row of points, zero where there is no mode
    """

    columns: IntArray
    modes: IntArray
    filled: BoolArray
    around: FloatArray
    jump: FloatArray

    def of_modes(self, values: FloatArray, *, fill: float = 0.0) -> FloatArray:
        """(b, d, ...) part of an array (r, ...); ``fill`` where there is no mode."""
        return np.concatenate([values, np.full((1, *values.shape[1:]), fill)])[self.modes]


class EveryMode:
    """Maps between the coefficients (n, 3, R) at n points evaluated and those of all modes, one array per group.

    Attributes
    ----------
    groups : `Group` by group
    dofs : (n, 3) contact degrees of freedom of the points in the order used here: angle after angle
    points : (n,) their numbers

    Parameters
    ----------
    condensation
        Modes.
    symmetry
        Half-period symmetry of the motions.
    orders
        (R,) harmonic number of each coefficient.
    """

    def __init__(self, condensation: Condensation, symmetry: HalfPeriod | None, orders: FloatArray):
        c = condensation
        self.size, self.coefficients = len(c.eigenvalues), len(orders)
        theta = np.arange(c.n_theta) if symmetry is None else symmetry.first[symmetry.first < c.n_theta]
        self.rows, self.n_theta = len(c.jump[0]) // 3, len(theta)
        order = np.arange(self.rows * self.n_theta).reshape(self.rows, self.n_theta).T
        self.points = order.ravel()
        self.dofs = contact_dofs(len(self.points))[self.points]
        kinds = [(np.arange(len(c.jump)), np.arange(len(orders)))]
        if symmetry is not None:
            reverses = symmetry.odd[c.blocks[:-1]]
            odd = orders % 2 == 1
            kinds = [(np.flatnonzero(reverses == kind), np.flatnonzero(odd == kind)) for kind in (True, False)]
        self.groups = [self._group(c, theta, blocks, columns) for blocks, columns in kinds if len(blocks)]

    def _group(self, c: Condensation, theta: IntArray, blocks: IntArray, columns: IntArray) -> Group:
        counts = np.diff(c.blocks)[blocks]
        filled = np.arange(counts.max()) < counts[:, None]
        modes = np.where(filled, c.blocks[blocks][:, None] + np.arange(counts.max()), self.size)
        jump = np.zeros((*modes.shape, 3 * self.rows))
        for place, block in enumerate(blocks):
            jump[place, : counts[place]] = c.jump[block].T
        around = np.ascontiguousarray(c.profiles[blocks][:, :, theta].transpose(1, 0, 2))
        return Group(columns, modes, filled, around, jump)

    def split(self, values: FloatArray) -> list[FloatArray]:
        """(b, d, c) per group: the coefficients that the modes have, of all coefficients (r, R)."""
        return [group.of_modes(values[:, group.columns]) for group in self.groups]

    def joined(self, parts: Sequence[FloatArray]) -> FloatArray:
        """(r, R) coefficients of all modes from the arrays (b, d, c) of the groups; zero where a mode has none."""
        out = np.zeros((self.size, self.coefficients))
        for group, part in zip(self.groups, parts, strict=True):
            out[group.modes[group.filled][:, None], group.columns] = part[group.filled]
        return out

    def force(self, traction: FloatArray) -> list[FloatArray]:
        """(b, d, c) per group: modal forces G^T f of point forces (n, 3, R), N."""
        out = []
        for group in self.groups:
            blocks, count = len(group.modes), len(group.columns)
            forces = traction[:, :, group.columns].reshape(self.n_theta, self.rows, 3, count).transpose(2, 0, 1, 3)
            around = group.around @ forces.reshape(3, self.n_theta, self.rows * count)
            amplitudes = around.reshape(3, blocks, self.rows, count).transpose(1, 0, 2, 3)
            out.append(group.jump @ amplitudes.reshape(blocks, 3 * self.rows, count))
        return out

    def motion(self, parts: Sequence[FloatArray]) -> FloatArray:
        """(n, 3, R) relative displacement of the points for modal coefficients (b, d, c) per group."""
        out = np.zeros((len(self.points), 3, self.coefficients))
        for group, part in zip(self.groups, parts, strict=True):
            blocks, count = len(group.modes), len(group.columns)
            amplitudes = group.jump.transpose(0, 2, 1) @ part
            around = amplitudes.reshape(blocks, 3, self.rows, count).transpose(1, 0, 2, 3)
            moved = group.around.transpose(0, 2, 1) @ around.reshape(3, blocks, self.rows * count)
            out[:, :, group.columns] = (
                moved.reshape(3, self.n_theta, self.rows, count).transpose(1, 2, 0, 3).reshape(-1, 3, count)
            )
        return out
