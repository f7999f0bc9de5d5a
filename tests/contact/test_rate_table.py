"""Slope of a table of the coefficient of friction over the slip rate."""

from __future__ import annotations

import pytest

from wroll_fem.contact.rate_table import weakening_slope


@pytest.mark.parametrize(
    ("rates", "coefficients", "slope"),
    [
        ([0.0, 1.0, 1.5], [0.5, 0.4, 0.1], 0.6),  # the steepest fall is away from rest
        ([0.0, 0.01, 0.03], [0.3, 0.2, 0.25], 10.0),  # and at rest
        ([0.0, 1.0, 2.0], [0.2, 0.3, 0.3], 0.0),
        ([0.0], [0.3], 0.0),
    ],
)
def test_weakening_is_the_steepest_fall_between_two_rows(
    rates: list[float], coefficients: list[float], slope: float
) -> None:
    assert weakening_slope(rates, coefficients) == pytest.approx(slope, rel=1e-12)
