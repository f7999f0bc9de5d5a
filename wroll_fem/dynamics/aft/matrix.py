"""Newton's matrix of the contact forces: their harmonics per unit of every harmonic of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.typing import IntArray


class Unknowns(NamedTuple):
    """Order of the unknowns in Newton's matrix, and the maps between contact points and reduced coordinates.

    Attributes
    ----------
    jump : (3 n, m) relative displacement per unit coordinate, the coordinates of one group after the other
    force : (m, 3 n) reduced force per unit traction
    first, width : (R,) first coordinate of each Fourier coefficient, and number of its coordinates
    start : (R,) its first unknown
    """

    jump: np.ndarray
    force: np.ndarray
    first: IntArray
    width: IntArray
    start: IntArray

    @classmethod
    def of(cls, groups: Sequence[tuple[IntArray, IntArray]], jump: np.ndarray, force: np.ndarray) -> Unknowns:
        """Order of the ``groups`` (`HarmonicContact.groups`) with ``jump`` (3 n, m) and ``force`` (m, 3 n)."""
        size = sum(len(rows) for rows, _ in groups)
        first, width, start = np.zeros((3, size), np.int64)
        coordinate = unknown = 0
        for rows, columns in groups:
            first[rows], width[rows] = coordinate, len(columns)
            start[rows] = unknown + len(columns) * np.arange(len(rows))
            coordinate, unknown = coordinate + len(columns), unknown + len(rows) * len(columns)
        order = np.concatenate([columns for _, columns in groups])
        return cls(np.ascontiguousarray(jump[:, order]), np.ascontiguousarray(force[order]), first, width, start)


@numba.njit(cache=True, error_model="numpy")
def fill_matrix(dofs, blocks, unknowns, matrix):
    """Fill Newton's matrix (k, k) of the contact forces.

    Parameters
    ----------
    dofs : (a, 3) contact degrees of freedom of the points that take part
    blocks : (a, 3, R, 3, R) derivatives of their tractions, in the precision of ``matrix``
    unknowns : `Unknowns`
    """
    a, size, m = blocks.shape[0], blocks.shape[2], unknowns.jump.shape[1]
    forces, motions = np.empty((m, 3 * a), matrix.dtype), np.empty((a, 3 * m), matrix.dtype)
    for p in range(a):
        for c in range(3):
            for i in range(m):
                forces[i, 3 * p + c], motions[p, c * m + i] = (
                    unknowns.force[i, dofs[p, c]],
                    unknowns.jump[dofs[p, c], i],
                )
    tractions = np.empty((3 * a, matrix.shape[0]), matrix.dtype)
    for r in range(size):
        first, width, start = unknowns.first[r], unknowns.width[r], unknowns.start[r]
        if width > 0:
            _fill_tractions(blocks, r, motions, unknowns.first, unknowns.width, unknowns.start, tractions)
            np.dot(forces[first : first + width], tractions, out=matrix[start : start + width])


@numba.njit(cache=True, error_model="numpy")
def _fill_tractions(blocks, r, motions, first, width, start, out):
    """Fill ``out`` (3 a, k): coefficient ``r`` of the tractions of the points per unit of each unknown.

    ``motions`` (a, 3 m) are the relative displacements of the points per unit coordinate. The indices are unsigned: for
    signed ones numba tests whether they are negative, and the loop is not vectorised.
    """
    size = blocks.shape[2]
    for p in range(blocks.shape[0]):
        motion = motions[p]
        m = np.uint64(motion.shape[0] // 3)
        for c in range(3):
            row = out[3 * p + c]
            for q in range(size):
                hoop, axial, normal = blocks[p, c, r, 0, q], blocks[p, c, r, 1, q], blocks[p, c, r, 2, q]
                source, target = np.uint64(first[q]), np.uint64(start[q])
                for i in range(np.uint64(width[q])):
                    at = source + i
                    row[target + i] = hoop * motion[at] + axial * motion[m + at] + normal * motion[m + m + at]


@numba.njit(cache=True, fastmath=True)
def apply_blocks(blocks, areas, places, motion, out):
    """Fill ``out`` (n, 3 R) with the forces due to a ``motion`` (n, 3 R) of the contact points, in single precision.

    ``blocks`` (a, 3 R, 3 R) are derivatives of the tractions by the motions at the points ``places`` (a,) with the
    ``areas`` (a,); the other points have no force. The sums may take any order, which they need to be vectorised.
    """
    out[:] = 0.0
    for p in range(blocks.shape[0]):
        block, there, force, area = blocks[p], motion[places[p]], out[places[p]], areas[p]
        for i in range(block.shape[0]):
            row, total = block[i], np.float32(0.0)
            for j in range(row.shape[0]):
                total += row[j] * there[j]
            force[i] = area * total
