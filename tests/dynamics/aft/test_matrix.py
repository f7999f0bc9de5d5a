"""Newton's matrix of the contact forces, and products with the derivatives at the points, against plain sums."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.aft.matrix import Unknowns, apply_blocks, fill_matrix

N, M, R = 9, 12, 7
ODD, EVEN = np.array([1, 2, 5, 6]), np.array([0, 3, 4])
GROUPS = {
    "one": [(np.arange(R), np.arange(M))],
    "two": [(ODD, np.array([0, 3, 4, 7, 11])), (EVEN, np.array([1, 2, 5, 6, 8, 9, 10]))],
    "one without coordinates": [(ODD, np.arange(M)), (EVEN, np.arange(0))],
}


@pytest.mark.parametrize("groups", GROUPS)
@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_the_matrix_is_the_sum_over_the_points(groups: str, precision: type) -> None:
    rng, chosen = np.random.default_rng(1), GROUPS[groups]
    jump, force = rng.standard_normal((3 * N, M)), rng.standard_normal((M, 3 * N))
    points = np.array([0, 2, 3, 8])
    blocks = rng.standard_normal((len(points), 3, R, 3, R))
    unknowns = Unknowns.of(chosen, jump.astype(precision), force.astype(precision))
    count = sum(len(rows) * len(columns) for rows, columns in chosen)
    found, dofs = np.zeros((count, count), precision), contact_dofs(N)[points]
    fill_matrix(dofs, blocks.astype(precision), unknowns, found)
    full = np.einsum("ipc,pcrdq,pdj->riqj", force[:, dofs], blocks, jump[dofs]).reshape(R * M, R * M)
    order = np.concatenate([(rows[:, None] * M + columns).ravel() for rows, columns in chosen])
    np.testing.assert_allclose(found, full[np.ix_(order, order)], atol=1e3 * np.finfo(precision).eps)


def test_products_with_the_derivatives_are_those_of_the_points() -> None:
    rng = np.random.default_rng(2)
    places, areas = np.array([4, 0, 7]), rng.uniform(1.0, 2.0, 3).astype(np.float32)
    blocks, motion = (rng.standard_normal(shape).astype(np.float32) for shape in ((3, 3, R, 3, R), (N, 3, R)))
    found = np.full((N, 3 * R), np.nan, np.float32)
    apply_blocks(blocks.reshape(3, 3 * R, 3 * R), areas, places, motion.reshape(N, -1), found)
    expected = np.zeros((N, 3, R))
    expected[places] = areas[:, None, None] * np.einsum("pcrdq,pdq->pcr", blocks, motion[places])
    np.testing.assert_allclose(found.reshape(N, 3, R), expected, atol=1e-4)
