"""Linear equations of a continuation: the Jacobian of a curve, bordered by one more row.

With few unknowns the matrix is formed and factored. With many unknowns its LU factors are kept along the curve and
precondition GMRES at later points, where the Jacobian is multiplied by vectors without being formed. Neighbouring
points differ mainly where contact points change their state, so some ten iterations are enough.

References
----------
Kelley (1995), Iterative Methods for Linear and Nonlinear Equations, chapters 3 and 6, doi:10.1137/1.9781611970944.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
import scipy.linalg as la

from wroll_fem.numerics.krylov import Solved, gmres
from wroll_fem.typing import FloatArray

FEWEST = 600
"""Number of unknowns from which kept factors precondition GMRES. Below it, a factorisation is cheaper."""

UNKNOWNS_PER_ITERATION = 60
"""Number of unknowns divided by the largest number of GMRES iterations. More iterations would take longer than new
factors; the factors are renewed if the residual is still too large."""

NEWTON, TANGENT = 0.05, 1e-4
"""Relative residuals of a Newton step and of a tangent from GMRES."""


class CurveProblem(Protocol):
    """Equations F(z) = 0 of a curve of solutions z (n + 1,); the last entry of z is the curve parameter."""

    @property
    def zero(self) -> float:
        """Curve parameter at which the physical parameter (a frequency) is zero; infinite if there is none."""
        ...

    def residual(self, z: FloatArray) -> FloatArray:
        """Residual F (n,)."""
        ...

    def jacobian(self, z: FloatArray) -> np.ndarray:
        """Jacobian dF/dz (n, n + 1), in single precision if this is enough for Newton's method."""
        ...

    def derivative(self, z: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """Function that multiplies the Jacobian at ``z`` by a vector (n + 1,)."""
        ...

    def describe(self, z: FloatArray) -> str:
        """Text that names the position ``z`` on the curve, for messages."""
        ...


class Bordered:
    """LU factors of the square matrix that consists of the Jacobian and one additional row."""

    def __init__(self, jacobian: np.ndarray, row: FloatArray):
        # the transpose is the column-major array that LAPACK works on in place
        matrix = np.vstack([jacobian, row.astype(jacobian.dtype)])
        getrf, self._getrs = la.get_lapack_funcs(("getrf", "getrs"), (matrix,))
        lu, pivots, _ = getrf(matrix.T, overwrite_a=True)  # a singular matrix shows in steps that are not finite
        self.factor = lu, pivots

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution in double precision; its error is that of the factors, which may be single."""
        return np.asarray(self._solve(rhs.astype(self.factor[0].dtype)), dtype=float)

    def _solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solution in the precision of the factors and of ``rhs``."""
        return np.asarray(self._getrs(*self.factor, rhs, trans=1)[0])

    @property
    def bytes(self) -> int:
        """Memory of the factors."""
        return int(self.factor[0].nbytes)

    @property
    def sign(self) -> float:
        """Sign of the determinant."""
        lu, pivots = self.factor
        swaps = np.count_nonzero(pivots != np.arange(len(pivots)))
        return float(np.prod(np.sign(np.diag(lu))) * (-1.0) ** swaps)

    def _preconditioned(
        self, problem: CurveProblem, z: FloatArray, row: FloatArray, rhs: FloatArray, tolerance: float
    ) -> Solved:
        """Solution (n + 1,) of the bordered equations at ``z``, with its own ``row``, by GMRES with these factors.

        It iterates in the precision of the factors, whose memory traffic is most of its time.
        """
        applied, precision = problem.derivative(z), self.factor[0].dtype
        border, b = row.astype(precision), rhs.astype(precision)

        def product(y: np.ndarray) -> np.ndarray:
            v, out = self._solve(y), np.empty_like(b)
            out[:-1], out[-1] = applied(v), border @ v
            return out

        found = gmres(product, b, tolerance=tolerance, iterations=len(z) // UNKNOWNS_PER_ITERATION)
        return found._replace(solution=self.solve(found.solution))


def fill_scaled(out: np.ndarray, matrix: np.ndarray, scale: FloatArray) -> None:
    """Fill ``out`` (n, n) with a ``matrix`` (n, n) of the same precision, rows and columns multiplied by ``scale``."""
    own = scale.astype(matrix.dtype)  # numpy is slow where precisions differ
    np.multiply(matrix, own, out=out)
    out *= own[:, None]


def newton_step(
    problem: CurveProblem, z: FloatArray, row: FloatArray, residual: FloatArray, kept: Bordered | None
) -> tuple[FloatArray, Bordered, bool]:
    """Newton step (n + 1,) in the plane normal to ``row``.

    Parameters
    ----------
    problem, z, row
        Equations, point (n + 1,) and normal vector (n + 1,).
    residual
        (n,) residual at ``z``.
    kept
        Factors of an earlier point, which precondition GMRES; None without any.

    Returns
    -------
    step : (n + 1,)
    factors : ``kept``, or the factors at ``z`` if the step was solved with them
    renewed : whether the factors are those at ``z``
    """
    rhs = np.append(-residual, 0.0)
    if kept is not None and len(z) >= FEWEST and np.isfinite(rhs).all():
        found = kept._preconditioned(problem, z, row, rhs, NEWTON)
        if found.residual <= NEWTON:
            return found.solution, kept, False
    factors = Bordered(problem.jacobian(z), row)
    return factors.solve(rhs), factors, True


def tangent_at(
    problem: CurveProblem, z: FloatArray, before: FloatArray, kept: Bordered | None
) -> tuple[FloatArray, Bordered, float]:
    """Unit tangent (n + 1,) at ``z``, LU factors, and sign of the determinant of the Jacobian bordered by ``before``.

    The scalar product of the tangent and ``before`` (n + 1,) is positive. ``kept`` are factors of an earlier point;
    they are returned if the tangent was solved with them.
    """
    rhs = np.zeros(len(z))
    rhs[-1] = 1.0
    if kept is not None and len(z) >= FEWEST:
        found = kept._preconditioned(problem, z, before, rhs, TANGENT)
        if found.residual <= TANGENT and not _changes_sign(found.projected):
            return found.solution / np.linalg.norm(found.solution), kept, kept.sign
    factors = Bordered(problem.jacobian(z), before)
    tangent = factors.solve(rhs)
    return tangent / np.linalg.norm(tangent), factors, factors.sign


def _changes_sign(projected: FloatArray) -> bool:
    """Whether the determinant may have another sign than that of the kept factors.

    Its sign changes where a real eigenvalue of the preconditioned matrix becomes negative. ``projected`` (k, k) is this
    matrix in the Krylov space, see `gmres`. The space lacks directions that the right-hand side does not excite, such
    as those of another symmetry; a change of sign there is seen at the next factorisation.
    """
    values = np.linalg.eigvals(projected)
    return bool(((values.real < 0.0) & (values.imag == 0.0)).any())
