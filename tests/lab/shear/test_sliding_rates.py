"""Coefficient over slip rate: parts of constant rate, steady averages, sines with offset and inertia."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.rates import at_constant_rates, in_sine
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.lab.shear.segments import constant_rates
from wroll_fem.lab.shear.simulated import sine_loops, velocity_steps
from wroll_fem.tribology import RateAndState


def constant(speed: np.ndarray) -> np.ndarray:
    return 0.25 + 0.0 * speed


@pytest.mark.parametrize("seed", range(4))
def test_changes_of_the_rate_are_found_to_a_fraction_of_a_sample(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rates = 10.0 ** rng.uniform(-6.0, -3.0, 5)
    while np.any(np.abs(np.diff(np.log(rates))) < np.log(1.5)):
        rates = 10.0 ** rng.uniform(-6.0, -3.0, 5)
    parts = constant_rates(velocity_steps(RateAndState(), rng, rates=rates.tolist()))
    assert len(parts) == 5
    np.testing.assert_allclose([part.rate for part in parts], rates, rtol=1e-4)
    ends = np.cumsum(0.5e-3 / rates)
    step = 0.5e-3 / 300 / rates
    for k, part in enumerate(parts[:-1]):
        assert abs(part.end - ends[k]) < 0.2 * max(step[k], step[k + 1])
        assert part.end == parts[k + 1].begin


def test_constant_rate_is_one_part_and_equal_neighbours_are_joined() -> None:
    rng = np.random.default_rng(7)
    assert len(constant_rates(velocity_steps(RateAndState(), rng, rates=(1e-5,) * 3))) == 1
    assert len(constant_rates(velocity_steps(RateAndState(), rng, rates=(1e-5, 1.1e-5)))) == 1


def test_steady_coefficients_of_velocity_steps_follow_the_law() -> None:
    law = RateAndState()
    found = at_constant_rates(velocity_steps(law), skip=0.5e-3)
    assert len(found.points) == 5  # of six stretches, the first is skipped
    for point in found.points:
        # the last half of 0.5 mm begins 12 D_R after the step: exp(-12) of the transient is left
        assert point.coefficient.value == pytest.approx(float(law.steady_coefficient(point.rate)), abs=2e-6)
    assert not found.doubts


def test_unsteady_stretches_are_reported() -> None:
    law = RateAndState(distance=4e-4)
    found = at_constant_rates(velocity_steps(law), skip=0.5e-3)
    assert any("still changes by" in text for text in found.doubts)


def test_sine_gives_the_law_in_spite_of_offset_and_inertia() -> None:
    def law(speed: np.ndarray) -> np.ndarray:
        return 0.25 + 2.0 * speed

    record = sine_loops(law, points=2000, frequency=20.0, mass=2.0, offset=5.0)
    for point in in_sine(record, moving_mass=2.0).points:
        assert point.profile == "sine"
        # a class spans half an octave; the mean of a linear law is the law at the mean rate
        assert point.coefficient.value == pytest.approx(float(law(np.array(point.rate))), rel=1e-3)


def test_sine_too_small_to_slide_is_refused() -> None:
    with pytest.raises(InputError, match="is too small: full slip takes"):
        in_sine(sine_loops(constant, amplitude=2.5e-6))
    with pytest.raises(InputError, match="1 complete cycles; record three cycles or more"):
        in_sine(sine_loops(constant, cycles=3))


def test_triangle_is_no_sine_and_is_reported() -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    x = 1e-4 * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * np.pi * 5.0 * time))
    record = ShearRecord(time, x, 100.0 * np.sign(np.gradient(x)), 200.0)
    assert any("depart from a sine" in text for text in in_sine(record).doubts)


def test_sliding_back_is_refused() -> None:
    record = velocity_steps(RateAndState())
    back = ShearRecord(record.time, -record.displacement, record.force, 200.0)
    with pytest.raises(InputError, match="ends where it started, or below"):
        at_constant_rates(back)
    with pytest.raises(InputError, match="no stretch of constant rate beyond the first 50 mm"):
        at_constant_rates(record, skip=0.05)
