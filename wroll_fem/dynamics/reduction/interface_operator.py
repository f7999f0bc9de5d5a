"""Compiled maps between contact points, circumferential blocks and modes, and the compliance of the interfaces."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact.point import contact_dof
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray, IntArray

drop_stale_cache(__file__)


class Compliance(NamedTuple):
    """Compliance of the interfaces with given springs in them, in a step.

    Attributes
    ----------
    blocks : (n_blocks, n_waves 3 n_rows, n_waves 3 n_rows) amplitude of the jump per unit amplitude of the force, m/N,
        by circumferential block
    dense : (3 n, 3 n) jump per unit traction, m/Pa, in single precision, for Newton's matrix
    """

    blocks: FloatArray
    dense: np.ndarray


class InterfaceOperator(NamedTuple):
    """Matrices for the interface jump per unit modal coordinate and per unit traction, by circumferential block.

    Attributes
    ----------
    starts : (n_blocks + 1,) index of the first mode of each block, then the number of modes
    modal_jump : flat array in single or double precision; amplitude of the jump of every wave in each row of points per
        unit modal coordinate, block after block
    profiles : (3, n_blocks n_waves, n_theta) shape of the hoop, axial and normal components of each wave around a row
    sticking : compliance F with the springs of the preload state
    sliding : compliance without their tangential springs; empty until enough points have been open
    """

    starts: IntArray
    modal_jump: np.ndarray
    profiles: FloatArray
    sticking: Compliance
    sliding: Compliance


@numba.njit(cache=True)
def _gather(s, area, profiles, amplitudes):
    """Circumferential amplitudes (n_blocks, n_waves 3 n_rows) of the contact forces area * s, for tractions s (3 n,).

    They are sorted by wave, then by component (hoop, axial, normal), then by row. s is in Pa.
    """
    n, n_waves, n_theta = area.shape[0], profiles.shape[1], profiles.shape[2]
    rows = n // n_theta
    of_wave = amplitudes.reshape(n_waves, 3 * rows)  # a view
    force = np.empty((rows, n_theta))
    for c in range(3):
        for row in range(rows):
            for i in range(n_theta):
                k = row * n_theta + i
                force[row, i] = area[k] * s[contact_dof(k, c, n)]
        projected = np.dot(force, profiles[c].T)
        for b in range(n_waves):
            for row in range(rows):
                of_wave[b, c * rows + row] = projected[row, b]


@numba.njit(cache=True)
def _scatter(amplitudes, profiles, out):
    """Add to ``out`` the values (3 n,) at the contact points from their ``amplitudes`` (see `_gather`)."""
    n, n_waves, n_theta = out.shape[0] // 3, profiles.shape[1], profiles.shape[2]
    rows = n // n_theta
    of_wave = amplitudes.reshape(n_waves, 3 * rows)
    part = np.empty((rows, n_waves))
    for c in range(3):
        for b in range(n_waves):
            for row in range(rows):
                part[row, b] = of_wave[b, c * rows + row]
        values = np.dot(part, profiles[c])
        for row in range(rows):
            for i in range(n_theta):
                k = row * n_theta + i
                out[contact_dof(k, c, n)] += values[row, i]


@numba.njit(cache=True)
def add_response(s, area, profiles, blocks, amplitudes, out):
    """Add to ``out`` (3 n,) the jump in m due to tractions s (3 n,) in Pa; ``blocks`` as in `Compliance`.

    ``amplitudes`` (n_blocks, n_waves 3 n_rows) is a work array.
    """
    _gather(s, area, profiles, amplitudes)
    for b in range(blocks.shape[0]):
        amplitudes[b] = np.dot(blocks[b], amplitudes[b])
    _scatter(amplitudes, profiles, out)


@numba.njit(cache=True, fastmath={"reassoc", "contract"})
def _fill_product(block, x, out):
    """Fill ``out`` (n,) with the product of ``block`` (n, m), in single or double precision, and ``x`` (m,)."""
    for i in range(block.shape[0]):
        row, total = block[i], 0.0
        for j in range(np.uint64(x.shape[0])):
            total += row[j] * x[j]
        out[i] = total


@numba.njit(cache=True, fastmath={"reassoc", "contract"})
def _fill_transposed_product(block, x, out):
    """Fill ``out`` (m,) with the product of the transpose of ``block`` (n, m) and ``x`` (n,); see `_fill_product`."""
    out[:] = 0.0
    n, m = block.shape[0], np.uint64(block.shape[1])
    for i in range(0, n - n % 4, 4):  # four rows at once read and write ``out`` a quarter as often
        a, b, c, d = block[i], block[i + 1], block[i + 2], block[i + 3]
        x0, x1, x2, x3 = x[i], x[i + 1], x[i + 2], x[i + 3]
        for j in range(m):
            out[j] += a[j] * x0 + b[j] * x1 + c[j] * x2 + d[j] * x3
    for i in range(n - n % 4, n):
        row, factor = block[i], x[i]
        for j in range(m):
            out[j] += row[j] * factor


@numba.njit(cache=True)
def add_free_jump(q, interface, amplitudes, out):
    """Add to ``out`` (3 n,) the jump due to modal coordinates q (r,)."""
    size, starts = amplitudes.shape[1], interface.starts
    for b in range(amplitudes.shape[0]):
        first, last = starts[b], starts[b + 1]
        block = interface.modal_jump[size * first : size * last].reshape(size, last - first)
        _fill_product(block, q[first:last], amplitudes[b])
    _scatter(amplitudes, interface.profiles, out)


@numba.njit(cache=True)
def fill_modal_force(s, area, interface, amplitudes, force):
    """Fill ``force`` (r,) with the modal force of the traction correction s: G^T W s in modal coordinates."""
    _gather(s, area, interface.profiles, amplitudes)
    size, starts = amplitudes.shape[1], interface.starts
    for b in range(amplitudes.shape[0]):
        first, last = starts[b], starts[b + 1]
        block = interface.modal_jump[size * first : size * last].reshape(size, last - first)
        _fill_transposed_product(block, amplitudes[b], force[first:last])
