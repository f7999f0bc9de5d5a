"""Least squares with confidence: intervals hold the truth as often as they promise, under correlated noise too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from support.coverage import holds, misses

from wroll_fem.errors import InputError
from wroll_fem.numerics.inference import Estimate, fit, linear_fit, mean_estimate, noise_model
from wroll_fem.typing import FloatArray

TIME = np.linspace(0.0, 1.0, 300)


def noise(rng: np.random.Generator, phi: tuple[float, ...], count: int = 300) -> FloatArray:
    """Autoregressive noise after its start-up, standard deviation of its driving noise 0.1."""
    return np.asarray(lfilter([1.0], np.concatenate([[1.0], -np.array(phi)]), 0.1 * rng.standard_normal(count + 500)))[
        500:
    ]


@pytest.mark.parametrize("phi", [(), (0.8,), (1.2, -0.5)])
def test_interval_of_a_slope_holds_the_truth_in_95_of_100_records(phi: tuple[float, ...]) -> None:
    rng = np.random.default_rng(5)
    columns = {"offset": np.ones_like(TIME), "slope": TIME}
    found = [holds(linear_fit(columns, 1.0 + 2.0 * TIME + noise(rng, phi))["slope"], 2.0) for _ in range(200)]
    assert not misses(found)


def test_independent_errors_are_far_too_small_under_correlated_noise() -> None:
    rng = np.random.default_rng(6)
    columns = {"offset": np.ones_like(TIME), "slope": TIME}
    records = [2.0 * TIME + noise(rng, (0.9,)) for _ in range(60)]
    found = [holds(linear_fit(columns, record, correlated=False)["slope"], 2.0) for record in records]
    assert np.mean(found) < 0.6  # why the noise model exists


def test_interval_of_a_decay_constant_holds_the_truth() -> None:
    rng = np.random.default_rng(7)

    def model(x: FloatArray) -> FloatArray:
        return x[0] * np.exp(-TIME / x[1])

    start, truth = {"size": 1.0, "time": 1.0}, model(np.array([3.0, 0.2]))
    records = [truth + noise(rng, (0.5,)) for _ in range(60)]
    found = [holds(fit(model, record, start, positive=["time"])["time"], 0.2) for record in records]
    assert not misses(found)


def test_coefficients_of_the_noise_are_found() -> None:
    rng = np.random.default_rng(8)
    long = noise(rng, (1.2, -0.5), 20000)
    # their standard error is about sqrt((1 - 0.25)/20000) = 0.006
    found = np.array(noise_model(long, [20000]).coefficients)
    np.testing.assert_allclose(found[:2], (1.2, -0.5), atol=0.025)
    assert np.all(np.abs(found[2:]) < 0.025)
    # of independent noise: their standard error is sqrt(1/5000) = 0.014
    assert np.all(np.abs(noise_model(rng.standard_normal(5000), [5000]).coefficients) < 0.05)


def test_parameters_that_the_data_do_not_determine_are_named() -> None:
    data = np.sin(9.0 * TIME)
    found = fit(lambda x: x[0] * x[1] * np.ones_like(TIME), data, {"a": 1.0, "b": 2.0})
    assert set(found.unidentified) == {"a", "b"}
    assert not np.isfinite(found["a"].interval()[1])
    flat = fit(lambda x: x[0] + 0.0 * x[1], data, {"a": 1.0, "b": 2.0})
    assert flat.unidentified == ("b",)


def test_correlation_that_the_noise_model_lacks_is_reported() -> None:
    # a missing term of the model, not noise: a step in each of ten series
    wave = np.sign(np.sin(2.0 * np.pi * 9.5 * TIME))
    columns = {"offset": np.ones_like(TIME)}
    rng = np.random.default_rng(9)
    assert linear_fit(columns, wave + 0.01 * rng.standard_normal(300)).correlated
    assert not linear_fit(columns, rng.standard_normal(300)).correlated


def test_weights_are_reciprocal_standard_deviations() -> None:
    rng = np.random.default_rng(10)
    size = np.where(TIME < 0.5, 0.01, 1.0)
    columns = {"offset": np.ones_like(TIME)}
    found = [
        linear_fit(columns, 3.0 + size * rng.standard_normal(300), weights=1.0 / size, correlated=False)["offset"]
        for _ in range(100)
    ]
    assert not misses([holds(one, 3.0) for one in found])
    assert found[0].standard_error == pytest.approx(0.01 / np.sqrt(150.0), rel=0.15)


def test_interval_follows_the_t_distribution() -> None:
    low, high = mean_estimate(np.array([1.0, 2.0, 3.0])).interval()
    reach = 4.302653 / np.sqrt(3.0)  # t of 0.975 and two degrees of freedom, standard deviation 1
    assert (low, high) == (pytest.approx(2.0 - reach, rel=1e-6), pytest.approx(2.0 + reach, rel=1e-6))
    assert mean_estimate(np.array([1.0])).interval() == (-np.inf, np.inf)
    low, high = Estimate(2.0, 0.1, 1e9, logarithmic=True).interval()
    assert np.log([low, high]) == pytest.approx(np.log(2.0) + 0.1 * 1.959964 * np.array([-1.0, 1.0]), rel=1e-6)


def test_more_parameters_than_values_are_refused() -> None:
    with pytest.raises(InputError, match="2 values do not determine 2 parameters"):
        linear_fit({"a": np.ones(2), "b": np.arange(2.0)}, np.zeros(2))
