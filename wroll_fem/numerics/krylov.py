"""GMRES of scipy for linear maps of arrays of any shape."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature

import scipy.sparse.linalg as spla

from wroll_fem.typing import FloatArray

_RELATIVE = "rtol" if "rtol" in signature(spla.gcrotmk).parameters else "tol"  # renamed in scipy 1.12


def gmres(apply: Callable[[FloatArray], FloatArray], b: FloatArray, *, tolerance: float, iterations: int) -> FloatArray:
    """Solution z of ``apply(z) = b`` by GMRES without restart.

    Parameters
    ----------
    apply
        Linear map of an array like ``b`` to another one.
    b
        Right side, of any shape.
    tolerance
        Norm of the residual, relative to that of ``b``, at which the iteration ends.
    iterations
        Maximum number of iterations. The iterate reached then is returned, whatever its residual.
    """
    # gcrotmk with nothing recycled is GMRES. It solves its small problem by least squares; spla.gmres does not, and its
    # residual may grow by orders of magnitude where the map is nearly singular (scipy 1.10).
    operator = spla.LinearOperator((b.size, b.size), lambda v: apply(v.reshape(b.shape)).ravel(), dtype=float)
    z, _ = spla.gcrotmk(operator, b.ravel(), m=iterations, k=0, maxiter=1, atol=0.0, **{_RELATIVE: tolerance})
    return z.reshape(b.shape)
