"""Rate-and-state friction: closed forms against the differential equations, steady sliding, jumps, regularised form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from wroll_fem.errors import InputError
from wroll_fem.tribology import RateAndState, VelocitySteps, shear_history
from wroll_fem.tribology.rate_and_state import LAWS, StateLaw, sine_history

MODEL = RateAndState()
BOTH = pytest.mark.parametrize("law", LAWS)


def integrated(model: RateAndState, state: float, rate: float, time: float) -> float:
    """ln theta after a time at a constant rate, by an implicit Runge-Kutta method on the equations as printed."""

    def slope(_: float, log: np.ndarray) -> np.ndarray:
        u = rate * np.exp(log) / model.distance
        change = 1.0 - u if model.law == "ageing" else -u * np.log(u)
        return np.asarray(change / np.exp(log))

    return float(solve_ivp(slope, (0.0, time), [np.log(state)], "Radau", rtol=1e-11, atol=1e-12).y[0, -1])


@BOTH
@pytest.mark.parametrize("off", [1e-3, 0.3, 7.0, 1e4])
def test_closed_forms_are_those_of_the_evolution_laws(law: StateLaw, off: float) -> None:
    model, rate = replace(MODEL, law=law), 3.0e-6
    state = off * float(model.steady_state(rate))
    for share in (0.01, 1.0, 8.0):
        time = share * model.distance / rate
        found = float(np.log(model.state_after(state, rate, time)))
        assert found == pytest.approx(integrated(model, state, rate, time), abs=2e-8)


@BOTH
def test_a_stretch_is_the_same_in_one_part_and_in_many(law: StateLaw) -> None:
    model, state = replace(MODEL, law=law), 0.4
    for _ in range(50):
        state = float(model.state_after(state, 2e-6, 0.3))
    assert state == pytest.approx(float(model.state_after(0.4, 2e-6, 15.0)), rel=1e-13)


def test_at_rest_the_ageing_state_grows_with_time_and_the_slip_state_stays() -> None:
    assert float(MODEL.state_after(2.0, 0.0, 5.0)) == 7.0
    assert float(replace(MODEL, law="slip").state_after(2.0, 0.0, 5.0)) == 2.0


@BOTH
def test_steady_sliding_and_direct_jumps(law: StateLaw) -> None:
    """To 1e-8 after 25 renewals of the state; the state term is -b ln(V/V_R), zero at V_R alone."""
    model = replace(MODEL, law=law)
    rates, durations = VelocitySteps(2.0e-6, 2.0e-5).history(points=40)
    data = shear_history(model, rates, durations)
    mu, states = data["friction_coefficient"].values, data["state_variable"].values
    ends = np.flatnonzero(np.diff(rates))
    assert len(ends) == 5
    steady = model.mu + (model.a - model.b) * np.log(rates[ends] / model.rate)
    np.testing.assert_allclose(mu[ends], steady, atol=1e-8)
    jump = model.coefficient(rates[ends + 1], states[ends]) - mu[ends]
    np.testing.assert_allclose(jump, model.a * np.log(rates[ends + 1] / rates[ends]), atol=1e-8)
    third = model.b * np.log(model.rate * states[ends] / model.distance)
    np.testing.assert_allclose(third, -model.b * np.log(rates[ends] / model.rate), atol=1e-8)
    assert float(data["slip_distance"][-1]) == pytest.approx(3.0e-3, rel=1e-12)


def test_one_constant_at_a_time() -> None:
    rates, durations = VelocitySteps(1.0e-6, 1.0e-5).history(points=20)
    up = int(np.flatnonzero(np.diff(rates))[0])
    alone = {name: shear_history(replace(MODEL, **{name: 0.0}), rates, durations) for name in ("a", "b")}
    direct, state = (alone[name]["friction_coefficient"].values for name in ("b", "a"))
    np.testing.assert_allclose(direct, MODEL.mu + MODEL.a * np.log(rates / MODEL.rate), atol=1e-12)
    assert abs(state[up + 1] - state[up]) < MODEL.b * np.log(10.0)
    assert state[-1] == pytest.approx(MODEL.mu - MODEL.b * np.log(10.0), abs=1e-8)
    coulomb = shear_history(replace(MODEL, a=0.0, b=0.0), rates, durations)["friction_coefficient"].values
    np.testing.assert_array_equal(coulomb, MODEL.mu)


def test_regularised_form_is_odd_and_equals_the_logarithm_away_from_rest() -> None:
    rates, state = np.array([1e-9, 1e-6, 1e-3]), 3.0
    np.testing.assert_allclose(MODEL.regularised(rates, state), MODEL.coefficient(rates, state), rtol=1e-12)
    np.testing.assert_allclose(MODEL.regularised(-rates, state), -MODEL.coefficient(rates, state), rtol=1e-12)
    assert float(MODEL.regularised(0.0, state)) == 0.0
    at = (MODEL.mu + MODEL.b * np.log(MODEL.rate * state / MODEL.distance)) / MODEL.a
    tiny = 1e-3 * np.exp(-at) * 2.0 * MODEL.rate
    assert float(MODEL.regularised(tiny, state)) == pytest.approx(MODEL.a * np.arcsinh(1e-3), rel=1e-9)


def test_sine_history_opposes_the_motion_and_dissipates() -> None:
    rates, durations = sine_history(0.1e-3, 25.0, cycles=2, points=800)
    assert np.abs(rates).max() == pytest.approx(2.0 * np.pi * 25.0 * 0.1e-3, rel=1e-4)
    data = shear_history(MODEL, rates, durations)
    mu = data["friction_coefficient"].values
    assert np.all(mu * rates >= 0.0)
    np.testing.assert_allclose(data["slip_distance"].values[[799, -1]], 0.0, atol=1e-12)
    work = float(np.sum(mu * rates * durations)[()]) / 2.0  # per cycle and unit normal force
    assert work == pytest.approx(4.0 * 0.1e-3 * float(np.mean(np.abs(mu))), rel=0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [({"mu": 0.0}, r"mu: mu = 0\.0; give a positive"),
     ({"a": -0.1}, r"a: must not be negative, got -0\.1; give 0 or more"),
     ({"law": "other"}, r"law: unknown state law 'other'; use ageing or slip")],
)  # fmt: skip
def test_values_without_a_meaning_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(MODEL, **change)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="rate: must be positive"):
        MODEL.coefficient(0.0, 1.0)
