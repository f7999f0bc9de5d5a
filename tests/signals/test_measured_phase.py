"""Smoothed phase of a measured sweep."""

from __future__ import annotations

import numpy as np

from wroll_fem.signals.measured_sweep import _smoothed
from wroll_fem.signals.records.columns import _listed


def test_a_short_sweep_is_smoothed_by_two_pieces() -> None:
    """One knot inside follows a phase whose second derivative changes; a single cubic is at least twice as far off."""
    time = np.linspace(0.0, 1.0, 2001)
    phase = 2.0 * np.pi * (5.0 * time + 2.0 * np.maximum(time - 0.52, 0.0) ** 3)
    spline = _smoothed(time, phase)
    assert len(spline.t) == 4 + 1 + 4
    assert np.abs(spline(time) - phase).max() < 0.02
    one = np.polynomial.Polynomial.fit(time, phase, 3)
    assert np.abs(one(time) - phase).max() > 2.0 * np.abs(spline(time) - phase).max()


def test_a_long_list_of_columns_ends_with_their_number() -> None:
    names = [f"channel {k}" for k in range(14)]
    assert _listed(names[:2]) == "channel 0, channel 1"
    assert _listed(names).endswith("channel 10, channel 11, and 2 more")
