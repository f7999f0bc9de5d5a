"""mu(V): models, knots, scatter between tests, and the table for the case file."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.contact.rate_coulomb import RateCoulomb, coefficient
from wroll_fem.errors import InputError
from wroll_fem.lab.friction.rate_law import default_knots, fit_rate_laws, hats
from wroll_fem.lab.shear.rates import RatePoint
from wroll_fem.numerics.inference import Estimate

RATES = np.array([1e-6, 1e-5, 1e-4, 1e-3, 8e-3])


def points(values: np.ndarray, rates: np.ndarray = RATES, trials: int = 3, between: float = 0.0) -> list[RatePoint]:
    rng = np.random.default_rng(1)
    return [
        RatePoint(float(rate), Estimate(float(mu + between * rng.standard_normal()), 1e-5, 50.0), "constant")
        for rate, mu in zip(rates, values, strict=True)
        for _ in range(trials)
    ]


def test_table_interpolates_as_the_contact_law_does() -> None:
    found = fit_rate_laws(points(np.array([0.2, 0.22, 0.25, 0.24, 0.3])))
    assert found.best == "table"
    section = found.fits["table"].section(1e-6)
    table = section["rate_table"]
    assert isinstance(table, dict)
    law = RateCoulomb(table["mu"][0], 1e-6, tuple(table["slip_rate"]), tuple(table["mu"]))
    tables = np.array([[law.rates, law.coefficients]])
    for speed in (0.0, 3e-7, 4e-6, 5e-4, 5e-3, 1.0):
        value = float(hats(np.array([speed]), RATES)[:, 0] @ [0.2, 0.22, 0.25, 0.24, 0.3])
        assert coefficient(speed, 0, tables)[0] == pytest.approx(value, abs=1e-6), speed


def test_logarithm_is_found_with_its_slope() -> None:
    found = fit_rate_laws(points(0.25 + 0.005 * np.log(RATES / 1e-4), between=0.002))
    law = found.fits["logarithmic"]
    assert found.best == "logarithmic"
    low, high = law.fit["slope"].interval()
    assert low < 0.005 < high
    assert len(law.rates) == 17
    assert law.rates[0] == 0.0


def test_constant_wins_if_nothing_depends_on_the_rate() -> None:
    found = fit_rate_laws(points(np.full(5, 0.25), between=0.004))
    assert found.best == "constant"
    assert found.fits["constant"].section(2e-6) == {
        "law": "penalty_coulomb", "mu": pytest.approx(0.25, abs=0.004), "elastic_slip": 2e-6
    }  # fmt: skip


def test_scatter_between_mountings_is_found() -> None:
    many = np.geomspace(1e-6, 1e-2, 8)
    found = fit_rate_laws(points(np.full(8, 0.25), many, trials=20, between=0.004)).fits["constant"]
    assert found.between == pytest.approx(0.004, rel=0.2)  # 159 degrees of freedom: 6 % standard error
    assert found.fit["mu"].error == pytest.approx(0.004 / np.sqrt(160), rel=0.2)


def test_single_tests_choose_the_knots_that_they_need() -> None:
    rates = np.geomspace(1e-6, 1e-1, 25)
    values = 0.25 + 2.0 * np.clip(rates - 1e-3, 0.0, 0.02)
    rng = np.random.default_rng(2)
    knots = default_knots(rates, values + 1e-4 * rng.standard_normal(25), np.full(25, 1e-4))
    assert 3 <= len(knots) <= 9
    fitted = hats(rates, knots).T @ np.linalg.lstsq(hats(rates, knots).T, values, rcond=None)[0]
    np.testing.assert_allclose(fitted, values, atol=1.5e-3)  # of 0.04: no tested rate is exactly a corner


def test_too_little_is_refused() -> None:
    with pytest.raises(InputError, match="1 point of slip rate and coefficient"):
        fit_rate_laws(points(np.array([0.25]), RATES[:1], trials=1))
    with pytest.raises(InputError, match=r"knots: no test near the rate 1 m/s"):
        fit_rate_laws(points(np.full(5, 0.25)), knots=[1e-6, 1.0])
    with pytest.raises(InputError, match="knots: the rates must rise from above 0"):
        fit_rate_laws(points(np.full(5, 0.25)), knots=[1e-3, 1e-6])
    found = fit_rate_laws(points(np.array([-0.1, -0.1, 0.2, 0.2, 0.2])))
    with pytest.raises(InputError, match="the fitted table is not admissible: mu must be 0 or more"):
        found.fits["table"].section(1e-6)
