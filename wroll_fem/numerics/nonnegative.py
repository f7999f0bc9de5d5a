"""Sparse nonnegative least squares: few columns of a matrix whose positive combination gives a vector."""

from __future__ import annotations

import numpy as np

from wroll_fem.typing import FloatArray

RIDGE = 1e-13
"""Addition to the diagonal of the normal equations, relative to their mean diagonal entry. Dependent columns then have
finite factors; residuals down to some 1e-6 are not affected."""


def sparse_nonnegative(
    matrix: FloatArray, target: FloatArray, tolerance: float, limits: FloatArray | float = np.inf
) -> FloatArray:
    """Nonnegative factors x (n,), most of them zero, with ``matrix`` (k, n) x near ``target`` (k,).

    The algorithm of Lawson and Hanson adds one column at a time, that with the largest component along the residual,
    and drops columns whose factors would become negative. It ends early, as soon as the residual is small enough.

    Parameters
    ----------
    tolerance
        Norm of the residual, relative to the norm of the target, at which the algorithm ends. It also ends if no column
        reduces the residual.
    limits
        (k,) largest residual of each equation at which it ends; without limits the norm alone counts.

    References
    ----------
    Lawson, Hanson (1995), Solving Least Squares Problems, chapter 23, doi:10.1137/1.9781611971217.
    Chapman et al. (2017), Int. J. Numer. Methods Eng. 109, 1623, doi:10.1002/nme.5332 (early end).
    """
    count = matrix.shape[1]
    x, size = np.zeros(count), float(np.linalg.norm(target))
    chosen: list[int] = []
    residual = target
    for _ in range(3 * count):
        if np.linalg.norm(residual) <= tolerance * size and (np.abs(residual) <= limits).all():
            break
        gain = residual @ matrix
        gain[chosen] = -np.inf
        new = int(np.argmax(gain))
        if not gain[new] > 0.0:
            break
        chosen.append(new)
        chosen, x = _nonnegative_part(matrix, target, chosen, x)
        residual = target - matrix[:, chosen] @ x[chosen]
    return x


def _nonnegative_part(
    matrix: FloatArray, target: FloatArray, chosen: list[int], x: FloatArray
) -> tuple[list[int], FloatArray]:
    """Least-squares factors of the ``chosen`` columns, those that would be negative removed; they start from ``x``."""
    columns = matrix[:, chosen]
    normal, right = columns.T @ columns, target @ columns
    normal += RIDGE * np.trace(normal) / len(chosen) * np.eye(len(chosen))
    kept, now = np.arange(len(chosen)), x[chosen]
    while True:
        best = np.linalg.solve(normal[np.ix_(kept, kept)], right[kept])
        if best.min() > 0.0:
            break
        low = best <= 0.0
        part = float(np.min(now[low] / np.maximum(now[low] - best[low], 1e-300)))
        now = now + part * (best - now)
        stays = (now > 0.0) & ~(low & (now <= 1e-12 * now.max()))
        if stays.all():
            stays[np.argmin(np.where(low, now, np.inf))] = False
        kept, now = kept[stays], now[stays]
        if not len(kept):
            return [], np.zeros_like(x)
    out = np.zeros_like(x)
    left = [chosen[k] for k in kept]
    out[left] = best
    return left, out
