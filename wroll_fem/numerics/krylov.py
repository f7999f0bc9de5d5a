"""GMRES for linear maps between arrays of any shape."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from typing import NamedTuple

import numpy as np

from wroll_fem.typing import FloatArray

ENOUGH = 0.5
"""Norm of a vector after orthogonalisation, divided by its norm before. At or below this ratio the orthogonalisation is
repeated once."""


ROUNDING = 4.5
"""Norm of a vector after orthogonalisation, divided by its norm before and by the rounding unit, at or below which the
vector counts as a combination of the others."""


class Solved(NamedTuple):
    """Solution by GMRES, its residual relative to the right-hand side, and the map in the basis of the k iterations.

    The eigenvalues of ``projected`` (k, k) approximate those eigenvalues of the map that the solution depends on.
    """

    solution: np.ndarray
    residual: float
    projected: FloatArray


def gmres(
    apply: Callable[[np.ndarray], np.ndarray],
    b: np.ndarray,
    *,
    tolerance: float,
    iterations: int,
    plus_identity: bool = False,
) -> Solved:
    """Solve ``apply(z) = b``, or ``z + apply(z) = b``, by GMRES without restart.

    A Krylov vector is orthogonalised a second time if the first orthogonalisation removes most of it. The small problem
    is solved by least squares, so the residual does not grow if the map is nearly singular.

    Parameters
    ----------
    apply
        Linear map from arrays of the shape of ``b`` to arrays of the same shape.
    b
        Right-hand side, of any shape, in the precision in which to iterate.
    tolerance
        Norm of the residual, relative to the norm of ``b``, at or below which the iteration ends.
    iterations
        Largest number of iterations. The last iterate is returned whatever its residual; so is the one before an
        iteration that is not finite.
    plus_identity
        Whether the map is the identity plus ``apply``. Its Krylov space is that of ``apply``, whose vectors lose less
        in the orthogonalisation.

    References
    ----------
    Saad, Schultz (1986), SIAM J. Sci. Stat. Comput. 7, 856, doi:10.1137/0907058.
    """
    return gmres_together(
        lambda _, arrays: [apply(arrays[0])], [b], tolerance=tolerance, iterations=iterations,
        plus_identity=plus_identity,
    )[0]  # fmt: skip


def gmres_together(
    apply: Callable[[Sequence[int], Sequence[np.ndarray]], Sequence[np.ndarray]],
    sides: Sequence[np.ndarray],
    *,
    tolerance: float,
    iterations: int,
    plus_identity: bool = False,
) -> list[Solved]:
    """Solve several systems as `gmres` does, with one call of ``apply`` per iteration for all that are not solved yet.

    ``apply`` takes the numbers of the systems and one array for each; ``sides`` are the right-hand sides.
    """
    runs = [_iterations(b, tolerance, iterations, plus_identity) for b in sides]
    asked, found = dict[int, np.ndarray](), dict[int, Solved]()
    answers: dict[int, np.ndarray | None] = dict.fromkeys(range(len(runs)))
    while answers:
        asked.clear()
        for number, answer in answers.items():
            try:
                asked[number] = next(runs[number]) if answer is None else runs[number].send(answer)
            except StopIteration as end:
                found[number] = end.value
        answers = dict(zip(asked, apply(list(asked), list(asked.values())), strict=True)) if asked else {}
    return [found[number] for number in range(len(runs))]


def _iterations(
    b: np.ndarray, tolerance: float, iterations: int, plus_identity: bool
) -> Generator[np.ndarray, np.ndarray, Solved]:
    """Iterations of `gmres`: yields the arrays to which the map is applied, and receives the results."""
    size = float(np.linalg.norm(b))
    if size == 0.0:  # also for a structure without interfaces
        return Solved(np.zeros_like(b), 0.0, np.zeros((0, 0)))
    space = np.empty((iterations + 1, b.size), b.dtype)
    space[0] = b.ravel() / size
    matrix = np.zeros((iterations + 1, iterations))
    triangle = np.zeros(iterations)  # column of the rotated matrix
    turns: list[tuple[float, float]] = []
    left, count, rounding = size, 0, ROUNDING * float(np.finfo(b.dtype).eps)
    while count < iterations and left > tolerance * size:
        w = (yield space[count].reshape(b.shape)).ravel().copy()
        before, known = math.sqrt(w @ w), space[: count + 1]
        for _ in range(2):
            part = known @ w
            w -= part @ known
            matrix[: count + 1, count] += part
            rest = math.sqrt(w @ w)
            if rest > ENOUGH * before:
                break
        if not np.isfinite(rest):  # the solution so far is finite
            break
        matrix[count, count] += float(plus_identity)
        matrix[count + 1, count] = rest
        triangle[: count + 1] = matrix[: count + 1, count]
        for k, (c, s) in enumerate(turns):
            triangle[k], triangle[k + 1] = c * triangle[k] + s * triangle[k + 1], c * triangle[k + 1] - s * triangle[k]
        length = float(np.hypot(triangle[count], rest))
        count += 1
        if length == 0.0 or rest <= rounding * before:  # the space contains the solution, or cannot be extended
            break
        turns.append((triangle[count - 1] / length, rest / length))
        left *= rest / length
        space[count] = w / rest
    target = np.zeros(count + 1)
    target[0] = size
    weights = np.linalg.lstsq(matrix[: count + 1, :count], target, rcond=None)[0]
    solution = np.asarray(weights.astype(b.dtype) @ space[:count]).reshape(b.shape)
    return Solved(solution, left / size, matrix[:count, :count])
