"""Sparse direct solves: right answers, and factors that are freed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from wroll_fem.numerics.linear import SMALL, factorise


def membrane(n: int) -> sp.csr_matrix:
    """Five-point Laplacian on n x n nodes, shifted to be regular; unsymmetric by a little."""
    line = sp.diags([-1.0, 2.1, -0.9], [-1, 0, 1], shape=(n, n))
    return sp.csr_matrix(sp.kron(sp.eye(n), line) + sp.kron(line, sp.eye(n)))


@pytest.mark.parametrize("n", [8, 40])
def test_one_or_several_right_hand_sides_are_solved(n: int) -> None:
    matrix = membrane(n)
    assert (matrix.shape[0] > SMALL) == (n > 8)
    rhs = np.random.default_rng(0).standard_normal((n * n, 3))
    factor = factorise(matrix)
    np.testing.assert_allclose(matrix @ factor.solve(rhs), rhs, atol=1e-12)
    np.testing.assert_allclose(matrix @ factor.solve(rhs[:, 0]), rhs[:, 0], atol=1e-12)


@pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="reads the resident memory from /proc")
def test_factors_are_freed() -> None:
    """Forty factorisations, one after the other, hold no more memory than one: each has 2 MB."""

    def resident() -> float:
        (line,) = [entry for entry in Path("/proc/self/status").read_text().splitlines() if entry.startswith("VmRSS")]
        return float(line.split()[1]) / 1024

    matrix, rhs = membrane(60), np.ones((3600, 1))
    factorise(matrix).solve(rhs)
    before = resident()
    for _ in range(40):
        factorise(matrix).solve(rhs)
    assert resident() - before < 20.0
