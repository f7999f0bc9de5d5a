"""Grouping of coordinates that are equal but for rounding."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.bodies.levels import levels


@pytest.mark.parametrize("scale", [1e-3, 0.3, 50.0])
def test_rounding_does_not_split_a_level_and_a_fine_mesh_is_not_merged(scale: float) -> None:
    rng = np.random.default_rng(1)
    heights = scale * np.cumsum(np.geomspace(1e-4, 1.0, 12))  # graded: the first cell is 1e-4 of the last
    values = np.repeat(heights, 7) * (1.0 + 1e-8 * rng.uniform(-1.0, 1.0, 84))
    order = rng.permutation(84)
    means, group = levels(values[order])
    np.testing.assert_allclose(means, heights, rtol=1e-7)
    np.testing.assert_array_equal(group, np.repeat(np.arange(12), 7)[order])


def test_equal_values_are_one_level() -> None:
    means, group = levels(np.full(4, 0.2))
    assert means == pytest.approx([0.2])
    np.testing.assert_array_equal(group, 0)
