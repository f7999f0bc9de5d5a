"""GMRES for linear maps between arrays of any shape, by scipy."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature

import scipy.sparse.linalg as spla

from wroll_fem.typing import FloatArray

_RELATIVE = "rtol" if "rtol" in signature(spla.gcrotmk).parameters else "tol"  # renamed in scipy 1.12


def gmres(apply: Callable[[FloatArray], FloatArray], b: FloatArray, *, tolerance: float, iterations: int) -> FloatArray:
    """Solve ``apply(z) = b`` by GMRES without restart.

    Parameters
    ----------
    apply
        Linear map from arrays of the shape of ``b`` to arrays of the same shape.
    b
        Right-hand side, of any shape.
    tolerance
        Norm of the residual, relative to the norm of ``b``, at which the iteration ends.
    iterations
        Largest number of iterations. The last iterate is returned whatever its residual.

    Returns
    -------
    numpy.ndarray
        Solution z, in the shape of ``b``.
    """
    if b.size == 0:  # a structure without interfaces
        return b
    # gcrotmk with nothing recycled is GMRES. It solves its small problem by least squares; spla.gmres does not, and its
    # residual may grow by orders of magnitude where the map is nearly singular (scipy 1.10).
    operator = spla.LinearOperator((b.size, b.size), lambda v: apply(v.reshape(b.shape)).ravel(), dtype=float)
    z, _ = spla.gcrotmk(operator, b.ravel(), m=iterations, k=0, maxiter=1, atol=0.0, **{_RELATIVE: tolerance})
    return z.reshape(b.shape)
