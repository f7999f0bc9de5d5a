"""Interpolation of a record to a higher sampling rate."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.signals.shock.upsampling import HALF_LENGTH, upsampled


@pytest.mark.parametrize("factor", [2, 3, 8])
@pytest.mark.parametrize("share", [0.05, 0.5, 0.9])
def test_a_sine_below_half_the_rate_is_interpolated_to_a_thousandth(share: float, factor: int) -> None:
    """``share`` of half the sampling rate; the first and last samples see the zeros outside of the record."""
    n = 6 * HALF_LENGTH
    phase = np.pi * share * np.arange(factor * (n - 1) + 1) / factor + 0.7
    found = upsampled(np.sin(phase[::factor]), factor)
    inner = slice(factor * HALF_LENGTH, -factor * HALF_LENGTH)
    assert found.shape == phase.shape
    np.testing.assert_allclose(found[inner], np.sin(phase)[inner], atol=1e-3)
    own = found[::factor]  # the filter is zero at the other samples of the record
    np.testing.assert_allclose(own, np.sin(phase[::factor]), atol=1e-3)


def test_the_same_rate_is_the_same_record() -> None:
    record = np.array([1.0, -2.0, 3.0])
    assert upsampled(record, 1) is record
