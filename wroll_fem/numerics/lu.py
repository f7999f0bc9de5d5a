"""LU factors of dense matrices in compiled loops: LAPACK's getrf, which numba's linear algebra is built on.

numba offers an inverse and a solution, but no factors that can be kept. An inverse takes four times as long as factors.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import numpy.typing as npt
from numba.core import types

GETRF: Any = types.ExternalFunction(
    "numba_xxgetrf",
    types.intc(
        types.char, types.intp, types.intp, types.CPointer(types.float32), types.intp, types.CPointer(types.intc)
    ),
)
"""LAPACK's getrf(precision, rows, columns, matrix, leading dimension, pivots); returns info."""

SINGLE = ord("s")
"""Letter with which numba's LAPACK functions are told that the precision is single."""


@numba.njit(cache=True)
def factor(matrix: npt.NDArray[np.float32]) -> npt.NDArray[np.int32]:
    """Replace ``matrix`` (m, m), single precision, C order, by its LU factors; returns the pivots (m,).

    LAPACK reads the array as the transpose, so the factors are those of the transpose. A singular matrix gives factors
    whose solutions are not finite.
    """
    m = matrix.shape[0]
    pivots = np.empty(m, np.int32)
    if m > 0:
        GETRF(SINGLE, m, m, matrix.ctypes, m, pivots.ctypes)
    return pivots


@numba.njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def solve(factors: npt.NDArray[np.float32], pivots: npt.NDArray[np.int32], x: npt.NDArray[np.float32]) -> None:
    """Overwrite the right-hand side ``x`` (m,) with the solution; ``factors`` and ``pivots`` are those of `factor`.

    The sums are loops: one slice and one `np.dot` for each row would take three times as long, because of the counts of
    references. Unsigned limits let them be vectorised.
    """
    m = x.shape[0]
    for i in range(m):
        row, total = factors[i], np.float32(0.0)
        for j in range(np.uint64(i)):
            total += row[j] * x[j]
        x[i] = (x[i] - total) / row[i]
    for i in range(m - 1, -1, -1):
        row, total = factors[i], np.float32(0.0)
        for j in range(np.uint64(i + 1), np.uint64(m)):
            total += row[j] * x[j]
        x[i] -= total
    for i in range(m - 1, -1, -1):
        j = pivots[i] - 1
        held = x[i]
        x[i] = x[j]
        x[j] = held
