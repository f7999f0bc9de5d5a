"""Rate and state from velocity steps: exact recovery, preference of the law, and what the data do not determine."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.lab.friction.state_law import fit_state_laws, step_data
from wroll_fem.lab.shear.simulated import velocity_steps
from wroll_fem.tribology import RateAndState
from wroll_fem.tribology.rate_and_state import LAWS, StateLaw

SKIP = 0.5e-3


@pytest.mark.parametrize(("law", "seed"), list(zip(LAWS, (1, 2), strict=True)))
def test_constants_of_a_record_without_noise_are_recovered(law: StateLaw, seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = RateAndState(
        mu=rng.uniform(0.15, 0.4), a=rng.uniform(0.002, 0.02), b=rng.uniform(0.002, 0.02), rate=1e-6,
        distance=10.0 ** rng.uniform(-5.2, -4.4), law=law,
    )  # fmt: skip
    found = fit_state_laws([velocity_steps(truth)], skip=SKIP, rate=1e-6)
    assert found.preferred == law
    fitted = found.fits[law].friction
    for name in ("mu", "a", "b", "distance"):
        assert getattr(fitted, name) == pytest.approx(getattr(truth, name), rel=1e-5), name
    slope = found.fits[law].steady_slope
    assert slope.value == pytest.approx(truth.a - truth.b, abs=1e-7)


def test_transients_that_do_not_end_before_the_next_step_are_followed() -> None:
    truth = RateAndState(distance=3e-4)  # after 0.5 mm, exp(-5/3) of a transient is left
    fitted = fit_state_laws([velocity_steps(truth)], skip=SKIP, rate=1e-6).fits["ageing"].friction
    for name in ("mu", "a", "b", "distance"):
        assert getattr(fitted, name) == pytest.approx(getattr(truth, name), rel=1e-4), name


def test_the_reference_rate_moves_mu_alone() -> None:
    record = velocity_steps(RateAndState(), np.random.default_rng(1))
    low, high = (fit_state_laws([record], skip=SKIP, rate=rate).fits["ageing"] for rate in (1e-6, 1e-5))
    for name in ("a", "b", "distance"):
        assert high[name].value == pytest.approx(low[name].value, rel=1e-5)
    assert high["mu"].value - low["mu"].value == pytest.approx(low.steady_slope.value * np.log(10.0), rel=1e-4)


def test_several_records_are_fitted_together() -> None:
    rng = np.random.default_rng(2)
    law = RateAndState()
    pair = [velocity_steps(law, rng), velocity_steps(law, rng, rates=(1e-5, 1e-4) * 2)]
    both = fit_state_laws(pair, skip=SKIP, rate=1e-6).fits["ageing"]
    one = fit_state_laws(pair[:1], skip=SKIP, rate=1e-6).fits["ageing"]
    low, high = both["a"].interval()
    assert low < law.a < high
    assert both["a"].error < one["a"].error


def test_transients_shorter_than_a_sample_leave_the_distance_open() -> None:
    # D_R = 0.05 um, a sample every 1.7 um of slip
    found = fit_state_laws([velocity_steps(RateAndState(distance=5e-8), np.random.default_rng(3))], skip=SKIP)
    assert "distance" in found.fits[found.preferred].fit.unidentified
    assert any(text.startswith("distance is not identifiable") for text in found.doubts)
    low, high = found.fits[found.preferred]["distance"].interval()
    assert (low, high) == (0.0, np.inf)


def test_friction_without_state_leaves_b_at_zero() -> None:
    found = fit_state_laws([velocity_steps(RateAndState(b=0.0), np.random.default_rng(4))], skip=SKIP)
    own = found.fits[found.preferred]
    assert (
        "distance" in own.fit.unidentified
        or "b" in own.fit.unidentified
        or any("b does not differ from 0" in text or text.startswith("b =") for text in found.doubts)
    )
    assert any("fit equally well" in text for text in found.doubts)


def test_another_evolution_is_reported_by_its_residuals() -> None:
    # steps of the slip law fitted by the ageing law: the residuals after each step are far from noise
    found = fit_state_laws([velocity_steps(RateAndState(law="slip"), np.random.default_rng(5))], skip=SKIP)
    assert found.preferred == "slip"
    assert found.difference > 100.0
    assert found.fits["ageing"].scatter > 1.5 * found.fits["slip"].scatter


def test_soft_fixture_is_reported() -> None:
    record = velocity_steps(RateAndState(), np.random.default_rng(6))
    # 400 N x 0.015 ln 10 = 14 N at a step: 1.4 um at 1e7 N/m, 14 um at 1e6 N/m, D_R = 20 um
    assert not fit_state_laws([record], skip=SKIP, fixture_stiffness=1e7).doubts
    assert any("blurred" in text for text in fit_state_laws([record], skip=SKIP, fixture_stiffness=1e6).doubts)


def test_record_without_steps_is_refused() -> None:
    record = velocity_steps(RateAndState(), rates=(1e-5,) * 3)
    with pytest.raises(InputError, match=r"the rate does not change beyond the first 0.5 mm; lower skip"):
        step_data(record, skip=SKIP)
    with pytest.raises(InputError, match="the normal force is missing; add it"):
        fit_state_laws([type(record)(record.time, record.displacement, record.force)])
