"""Linear buckling (K + lambda K_g) x = 0 by Lanczos iterations with the operator -K^-1 K_g."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from wroll_fem.errors import WrollError
from wroll_fem.numerics.linear import factorise
from wroll_fem.typing import FloatArray

NOT_HELD = "the stiffness without preload is not positive definite: a part of the structure is not held"
_RESIDUAL_LIMIT = 1e-6


def load_factors(stiffness: sp.spmatrix, geometric: sp.spmatrix, count: int) -> tuple[FloatArray, FloatArray]:
    """Lowest positive load factors (buckling load divided by preload) and the buckling modes.

    Parameters
    ----------
    stiffness
        (n, n) symmetric positive definite, N/m.
    geometric
        (n, n) symmetric geometric stiffness of the preload, N/m.
    count
        Number of factors.

    Returns
    -------
    factors : (at most count,) ascending; fewer if the preload does not destabilise that many motions.
    vectors : (n, n_factors) buckling modes with x^T K x = 1.

    Raises
    ------
    WrollError
        If the stiffness is not positive definite, or a residual |K x + lambda K_g x| / |K x| exceeds 1e-6.
    """
    n = stiffness.shape[0]
    if geometric.nnz == 0 or not np.any(geometric.data):
        return np.zeros(0), np.zeros((n, 0))
    if stiffness.diagonal().min() <= 0.0:  # not every eigensolver notices
        raise WrollError(NOT_HELD)
    factor = factorise(stiffness)
    inverse = spla.LinearOperator((n, n), matvec=lambda b: factor.solve(np.ascontiguousarray(b).ravel()))
    start = np.random.default_rng(1).standard_normal(n)
    inverse_factors, vectors = spla.eigsh(
        -geometric.tocsr(), min(count, n - 1), M=stiffness.tocsr(), Minv=inverse, which="LA", v0=start, tol=1e-10
    )
    energies = np.einsum("ij,ij->j", vectors, stiffness @ vectors)
    if energies.min() <= 0.0:
        raise WrollError(NOT_HELD)
    destabilised = np.flatnonzero(inverse_factors > 1e-9 * np.abs(inverse_factors).max())[::-1]
    factors, vectors = 1.0 / inverse_factors[destabilised], vectors[:, destabilised] / np.sqrt(energies[destabilised])
    internal = stiffness @ vectors
    residuals = np.linalg.norm(internal + (geometric @ vectors) * factors, axis=0) / np.linalg.norm(internal, axis=0)
    if residuals.size and residuals.max() > _RESIDUAL_LIMIT:
        raise WrollError(
            f"buckling modes did not converge: largest relative residual {residuals.max():.1e} "
            f"(limit {_RESIDUAL_LIMIT:.0e}); request fewer modes"
        )
    return factors, vectors
