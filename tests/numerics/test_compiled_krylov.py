"""GMRES in parts for compiled loops, against numpy's solver."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.numerics.compiled_krylov import combine, extend, krylov_space, start


def solve(matrix: np.ndarray, b: np.ndarray, preconditioners: list[np.ndarray]) -> tuple[np.ndarray, float]:
    """Solution with one preconditioner for each iteration, and its residual as GMRES knows it."""
    space, left, x = krylov_space(len(b), len(preconditioners)), 1.0, np.empty(len(b))
    start(space, b)
    for k, inverse in enumerate(preconditioners):
        space.directions[k] = inverse @ space.vectors[k]
        space.vectors[k + 1] = matrix @ space.directions[k]
        left *= extend(space, k)
    combine(space, len(preconditioners), x)
    return x, left


@pytest.mark.parametrize("changing", [False, True])
def test_residual_is_known_and_smallest(changing: bool) -> None:
    """The residual is that of the solution, and no combination of the directions has a smaller one."""
    rng = np.random.default_rng(1)
    matrix, b = rng.standard_normal((40, 40)) + 8.0 * np.eye(40), rng.standard_normal(40)
    exact = np.linalg.inv(matrix)
    noise = [0.003 * rng.standard_normal((40, 40)) for _ in range(6)]
    inverses = [exact + (noise[k] if changing else noise[0]) for k in range(6)]
    x, left = solve(matrix, b, inverses)
    residual = np.linalg.norm(b - matrix @ x)
    assert residual == pytest.approx(left * np.linalg.norm(b), rel=1e-9)
    assert 1e-8 < left < 0.1
    space = np.empty((40, 6))
    vector = b
    for k in range(6):  # the same directions by numpy
        space[:, k] = inverses[k] @ vector
        images = np.linalg.qr(np.column_stack([b, matrix @ space[:, : k + 1]]))[0]
        vector = images[:, -1]
    best = np.linalg.lstsq(matrix @ space, b, rcond=None)[0]
    assert residual == pytest.approx(np.linalg.norm(b - matrix @ space @ best), rel=1e-6)


def test_as_many_iterations_as_unknowns_solve() -> None:
    rng = np.random.default_rng(2)
    matrix, b = rng.standard_normal((7, 7)), rng.standard_normal(7)
    x, left = solve(matrix, b, [np.eye(7)] * 7)
    np.testing.assert_allclose(x, np.linalg.solve(matrix, b), rtol=1e-9)
    assert left < 1e-12


def test_exact_preconditioner_takes_one_iteration() -> None:
    matrix = np.array([[2.0, 1.0], [0.5, 3.0]])
    x, left = solve(matrix, np.array([1.0, -2.0]), [np.linalg.inv(matrix)])
    np.testing.assert_allclose(x, np.linalg.solve(matrix, [1.0, -2.0]), rtol=1e-12)
    assert left < 1e-12
