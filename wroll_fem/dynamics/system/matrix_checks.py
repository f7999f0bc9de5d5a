"""Inexpensive checks of stiffness, mass and damping matrices from other programs."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from wroll_fem.typing import FloatArray

SYMMETRY = 1e-9
"""Largest difference between entries (i, j) and (j, i) of a symmetric matrix, relative to the largest entry."""

DEFINITENESS = 1e-8
"""Magnitude of a negative quotient x^T A x / x^T diag(A) x up to which it counts as rounding error."""

INERTIA_LIMIT = 3000
"""Largest number of DOFs for which the signs of all pivots are checked. Larger matrices are tested with random
motions."""


def symmetry_problem(matrix: sp.csr_matrix) -> tuple[str, str]:
    """Messages that say why a square matrix is not symmetric and what to do; both are empty if it is symmetric."""
    gap = abs(matrix - matrix.T)
    largest = float(abs(matrix).max()) if matrix.nnz else 0.0
    if gap.nnz == 0 or gap.max() <= SYMMETRY * largest:
        return "", ""
    if sp.triu(matrix, 1).count_nonzero() == 0 or sp.tril(matrix, -1).count_nonzero() == 0:
        return "holds one triangle only", "write the whole matrix: A + A.T, minus the diagonal of A"
    worst = gap.tocoo()
    k = int(np.argmax(worst.data))
    row, column = int(worst.row[k]), int(worst.col[k])
    entries = f"entries ({row}, {column}) and ({column}, {row}), counted from 0, differ by {worst.data[k]:.3g}"
    return f"is not symmetric: {entries}", "write a symmetric matrix, for example 0.5 (A + A.T) if it is rounding"


def negative_problem(matrix: sp.csr_matrix, *, pivots: bool = True) -> str:
    """Message that says why a symmetric matrix is not positive semi-definite; empty if no reason is found.

    The diagonal is checked; with ``pivots``, so are the signs of all pivots, or random motions of a large matrix.
    """
    diagonal = matrix.diagonal()
    if diagonal.size and diagonal.min() < 0.0:
        k = int(np.argmin(diagonal))
        return f"diagonal entry {k}, counted from 0, is {diagonal[k]:.3g}"
    loose = np.flatnonzero((diagonal == 0.0) & (np.asarray(abs(matrix).sum(axis=1)).ravel() > 0.0))
    if loose.size:
        return f"row {loose[0]}, counted from 0, has entries but a zero on its diagonal"
    stiff = np.flatnonzero(diagonal > 0.0)
    if pivots and stiff.size and _lowest_is_below(_unit_diagonal(matrix, diagonal, stiff), -DEFINITENESS):
        return "it has a negative eigenvalue"
    return ""


def massless_dofs(mass: sp.csr_matrix) -> int:
    """Number of DOFs that carry no mass."""
    return int(np.sum(mass.diagonal() == 0.0))


def is_singular(matrix: sp.csr_matrix) -> bool:
    """Whether a positive semi-definite matrix is singular; of a large matrix only the diagonal is checked."""
    diagonal = matrix.diagonal()
    if np.any(diagonal == 0.0):
        return True
    if matrix.shape[0] > INERTIA_LIMIT:
        return False
    return _lowest_is_below(_unit_diagonal(matrix, diagonal, np.arange(len(diagonal))), 1e-13)


def _unit_diagonal(matrix: sp.csr_matrix, diagonal: FloatArray, stiff: np.ndarray) -> sp.csc_matrix:
    """Submatrix of the DOFs ``stiff``, scaled to a unit diagonal so that DOFs of different units have equal weight."""
    scale = sp.diags(1.0 / np.sqrt(diagonal[stiff]))
    return sp.csc_matrix(scale @ matrix[stiff][:, stiff] @ scale)


def _lowest_is_below(scaled: sp.csc_matrix, limit: float) -> bool:
    """Whether the lowest eigenvalue of a symmetric matrix is below ``limit``, tested by pivots or by random motions."""
    n = scaled.shape[0]
    if n > INERTIA_LIMIT:
        motions = np.random.default_rng(0).standard_normal((n, 8))
        quotients = np.einsum("ij,ij->j", motions, scaled @ motions) / np.einsum("ij,ij->j", motions, motions)
        return bool(quotients.min() < limit)
    shifted = sp.csc_matrix(scaled - limit * sp.identity(n, format="csc"))
    try:
        # pivots stay on the diagonal, so that their signs are those of the eigenvalues (Sylvester)
        factor = spla.splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # exactly singular
        return limit > 0.0
    if not np.array_equal(factor.perm_r, factor.perm_c):  # a zero pivot: count them the slow way
        return bool(np.linalg.eigvalsh(shifted.toarray())[0] < 0.0)
    return bool(factor.U.diagonal().min() < 0.0)
