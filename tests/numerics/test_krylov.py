"""GMRES for arrays of any shape."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.numerics.krylov import gmres, gmres_together
from wroll_fem.typing import FloatArray


@pytest.fixture
def matrix() -> FloatArray:
    """Well-conditioned, not symmetric, (60, 60)."""
    return np.eye(60) + 0.04 * np.random.default_rng(0).normal(size=(60, 60))


def test_gmres_solves_for_arrays_to_its_tolerance(matrix: FloatArray) -> None:
    b = np.random.default_rng(1).normal(size=(20, 3))

    def apply(z: FloatArray) -> FloatArray:
        assert z.shape == b.shape
        return (matrix @ z.ravel()).reshape(z.shape)

    exact = np.linalg.solve(matrix, b.ravel()).reshape(b.shape)
    np.testing.assert_allclose(gmres(apply, b, tolerance=1e-12, iterations=60).solution, exact, rtol=0, atol=1e-10)
    loose = gmres(apply, b, tolerance=1e-2, iterations=60)
    left = np.linalg.norm(apply(loose.solution) - b) / np.linalg.norm(b)
    assert 1e-6 < left <= 1e-2
    assert loose.residual == pytest.approx(left, rel=1e-6)


def test_gmres_iterates_in_the_precision_of_the_right_side(matrix: FloatArray) -> None:
    b, short = np.random.default_rng(3).normal(size=60).astype(np.float32), matrix.astype(np.float32)
    found = gmres(lambda z: short @ z, b, tolerance=1e-5, iterations=60)
    assert found.solution.dtype == np.float32
    assert np.linalg.norm(matrix @ found.solution - b) < 2e-5 * np.linalg.norm(b)
    same = gmres(lambda z: 2.0 * z, b, tolerance=1e-12, iterations=60)  # the space ends with its first vector
    np.testing.assert_allclose(same.solution, 0.5 * b, rtol=1e-6)
    assert same.projected.shape == (1, 1)


def test_gmres_with_the_identity_apart_is_that_of_the_sum(matrix: FloatArray) -> None:
    b = np.random.default_rng(4).normal(size=60)
    rest = matrix - np.eye(60)
    together = gmres(lambda z: matrix @ z, b, tolerance=1e-6, iterations=60)
    apart = gmres(lambda z: rest @ z, b, tolerance=1e-6, iterations=60, plus_identity=True)
    np.testing.assert_allclose(apart.solution, together.solution, rtol=0, atol=1e-10)
    np.testing.assert_allclose(apart.projected, together.projected, rtol=0, atol=1e-9)
    nothing = gmres(lambda z: 0.0 * z, b, tolerance=1e-6, iterations=60, plus_identity=True)
    np.testing.assert_allclose(nothing.solution, b, rtol=1e-14)


def test_gmres_minimises_the_residual_over_the_krylov_space(matrix: FloatArray) -> None:
    b = np.random.default_rng(2).normal(size=60)
    space = np.column_stack([b, matrix @ b, matrix @ (matrix @ b)])
    best = space @ np.linalg.lstsq(matrix @ space, b, rcond=None)[0]
    found = gmres(lambda z: matrix @ z, b, tolerance=1e-14, iterations=3).solution
    np.testing.assert_allclose(found, best, rtol=0, atol=1e-12)


def test_gmres_of_a_zero_right_side_is_zero() -> None:
    found = gmres(lambda z: 2.0 * z, np.zeros((4, 2)), tolerance=1e-3, iterations=5)
    np.testing.assert_array_equal(found.solution, np.zeros((4, 2)))
    assert found.residual == 0.0


def test_the_projected_map_has_the_outlying_eigenvalue(matrix: FloatArray) -> None:
    shifted = matrix - 3.0 * np.outer(*np.eye(60)[[0, 0]])
    negative = np.linalg.eigvals(shifted).real.min()
    found = gmres(lambda z: shifted @ z, np.ones(60), tolerance=1e-6, iterations=40)
    assert negative < -1.0
    assert np.linalg.eigvals(found.projected).real.min() == pytest.approx(negative, rel=1e-4)


def test_gmres_ends_with_a_finite_solution_where_the_map_is_not(matrix: FloatArray) -> None:
    calls = []

    def apply(z: FloatArray) -> FloatArray:
        calls.append(1)
        return matrix @ z if len(calls) < 3 else np.full(60, np.nan)

    found = gmres(apply, np.ones(60), tolerance=1e-9, iterations=10)
    assert np.isfinite(found.solution).all()
    assert 1e-9 < found.residual < 1.0


def test_the_residual_never_grows_even_where_the_map_is_nearly_singular() -> None:
    """Identity with four directions 1e13 times larger: the loss of orthogonality must not spoil the solution."""
    rng = np.random.default_rng(1)
    matrix = np.eye(150) + 1e13 * rng.normal(size=(150, 4)) @ rng.normal(size=(4, 150))
    b = rng.normal(size=150)
    found = gmres(lambda z: matrix @ z, b, tolerance=1e-3, iterations=80).solution
    assert np.linalg.norm(matrix @ found - b) < np.linalg.norm(b)


def test_systems_solved_together_are_those_solved_one_by_one(matrix: FloatArray) -> None:
    """Systems of different sizes of the solution space: those that end early are asked for no more."""
    rng = np.random.default_rng(5)
    matrices = [matrix, 2.0 * np.eye(60), matrix + 0.1 * np.diag(rng.random(60)), matrix]
    sides = [rng.normal(size=60), rng.normal(size=60), rng.normal(size=60), np.zeros(60)]
    asked = []

    def apply(numbers: list[int], arrays: list[FloatArray]) -> list[FloatArray]:
        asked.append(list(numbers))
        return [matrices[number] @ z for number, z in zip(numbers, arrays, strict=True)]

    found = gmres_together(apply, sides, tolerance=1e-8, iterations=60)
    for number, one in enumerate(found):
        alone = gmres(lambda z, number=number: matrices[number] @ z, sides[number], tolerance=1e-8, iterations=60)
        np.testing.assert_array_equal(one.solution, alone.solution)
    assert asked[:2] == [[0, 1, 2], [0, 2]]
    assert gmres_together(apply, [], tolerance=1e-8, iterations=60) == []
