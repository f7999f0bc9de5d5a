"""Polynomial of a nonlinear spring against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.contact.polynomial_spring import polynomial


def test_a_polynomial_spring_has_the_value_and_slope_of_its_polynomial() -> None:
    power = np.polynomial.Polynomial([0.0, 0.4, 0.3, 0.5])
    tables = np.zeros((2, 2, 5))
    tables[1, 0, :3] = (0.4, 0.3, 0.5)
    for x in (-1.7, 0.0, 0.6):
        assert polynomial(x, 1, tables) == pytest.approx((power(x), power.deriv()(x)), rel=1e-14, abs=1e-15)
