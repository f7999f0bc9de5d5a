"""GMRES in parts for compiled loops, which cannot call a function that they are given as an argument.

The loop alternates between its own products and `extend`::

    start(space, b)
    left = 1.0                               # residual, relative to b
    for k in range(most):
        space.directions[k] = P b_k          # b_k = space.vectors[k], P approximates the inverse of A
        space.vectors[k + 1] = A space.directions[k]
        left *= extend(space, k)
    combine(space, k + 1, x)

The directions are kept, so that the preconditioner may change from one iteration to the next.

References
----------
Saad (1993), SIAM J. Sci. Comput. 14, 461, doi:10.1137/0914028 (flexible GMRES).
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.typing import FloatArray


class KrylovSpace(NamedTuple):
    """Work arrays of up to k iterations with n unknowns.

    Attributes
    ----------
    vectors : (k + 1, n) orthonormal basis
    directions : (k, n) vectors of which the solution is a combination
    triangle : (k, k) upper triangular matrix of the least-squares problem
    turns : (k, 2) cosine and sine of the rotations that led to it
    target : (k + 1,) right-hand side of the least-squares problem; its last entry is the residual
    """

    vectors: FloatArray
    directions: FloatArray
    triangle: FloatArray
    turns: FloatArray
    target: FloatArray


@numba.njit(cache=True)
def krylov_space(n, most):
    """`KrylovSpace` for ``most`` iterations with ``n`` unknowns."""
    return KrylovSpace(
        np.zeros((most + 1, n)), np.zeros((most, n)), np.zeros((most, most)), np.zeros((most, 2)), np.zeros(most + 1)
    )


@numba.njit(cache=True)
def start(space, b):
    """Start with the right-hand side ``b`` (n,), which is not zero."""
    size = np.sqrt(np.dot(b, b))
    for i in range(b.shape[0]):
        space.vectors[0, i] = b[i] / size
    space.target[0] = size


@numba.njit(cache=True, error_model="numpy")
def extend(space, k):
    """Orthogonalise vector k + 1; returns the residual after iteration ``k``, relative to that after iteration k - 1.

    The iteration has broken down if the result is 0 or not finite: 0 means that the solution is reached.
    """
    vectors, triangle, turns, target = space.vectors, space.triangle, space.turns, space.target
    w = vectors[k + 1]
    for j in range(k + 1):
        part = np.dot(vectors[j], w)
        triangle[j, k] = part
        for i in range(w.shape[0]):
            w[i] -= part * vectors[j, i]
    rest = np.sqrt(np.dot(w, w))
    for j in range(k):
        c, s = turns[j]
        upper, lower = triangle[j, k], triangle[j + 1, k]
        triangle[j, k] = c * upper + s * lower
        triangle[j + 1, k] = c * lower - s * upper
    length = np.sqrt(triangle[k, k] ** 2 + rest**2)
    turns[k, 0], turns[k, 1] = triangle[k, k] / length, rest / length
    triangle[k, k] = length
    target[k + 1] = -turns[k, 1] * target[k]
    target[k] = turns[k, 0] * target[k]
    for i in range(w.shape[0]):
        w[i] /= rest
    return turns[k, 1]


@numba.njit(cache=True, error_model="numpy")
def combine(space, count, x):
    """Fill ``x`` (n,) with the solution after ``count`` iterations."""
    triangle, weights = space.triangle, np.zeros(count)
    for i in range(count - 1, -1, -1):
        weights[i] = space.target[i]
        for j in range(i + 1, count):
            weights[i] -= triangle[i, j] * weights[j]
        weights[i] /= triangle[i, i]
    x[:] = 0.0
    for k in range(count):
        for i in range(x.shape[0]):
            x[i] += weights[k] * space.directions[k, i]
