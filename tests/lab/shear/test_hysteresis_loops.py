"""Hysteresis loops: energy against the closed form of elastic slip, cycles, and what the fixture does not change."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.loops import crossings, loops
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.lab.shear.simulated import ramp, sine_loops
from wroll_fem.tribology import ShearTest


def constant(speed: np.ndarray) -> np.ndarray:
    return 0.25 + 0.0 * speed


@pytest.mark.parametrize("amplitude", [5e-6, 2e-5, 1e-4])
def test_energy_of_an_ideal_loop(amplitude: float) -> None:
    found = loops(sine_loops(constant, amplitude=amplitude, points=4000))
    exact = 4.0 * 100.0 * (amplitude - 2e-6)  # 4 F_c (X - F_c/K), F_c = 2 mu F_N = 100 N, F_c/K = 2 um
    # the polygon cuts the corners of the loop: four triangles of one sample each
    np.testing.assert_allclose(found.energy, exact, rtol=3e-5)
    np.testing.assert_allclose(found.displacement, amplitude, rtol=1e-5)
    np.testing.assert_allclose(found.force, 100.0, rtol=1e-9)
    np.testing.assert_allclose(found.duration, 0.2, rtol=1e-9)
    assert len(found.energy) == 6  # eight cycles from the middle: seven passages upwards within the record


def test_loop_without_full_slip_dissipates_nothing() -> None:
    found = loops(sine_loops(constant, amplitude=1.5e-6, noise=0.0))
    assert np.abs(found.energy).max() < 1e-12


def test_elastic_fixture_changes_the_loop_but_not_its_energy() -> None:
    stiff, soft = (loops(sine_loops(constant, points=4000, fixture=k)) for k in (np.inf, 1e7))
    np.testing.assert_allclose(soft.energy, stiff.energy, rtol=1e-6)
    assert soft.displacement[0] > 1.05 * stiff.displacement[0]


def test_noise_does_not_bias_the_energy() -> None:
    rng = np.random.default_rng(1)
    found = loops(sine_loops(constant, rng, cycles=60, noise=5.0))
    mean = found.after(1).means[0]
    low, high = mean.interval()
    assert low < 4.0 * 100.0 * 98e-6 < high


def test_noise_at_the_middle_makes_no_further_cycles() -> None:
    rng = np.random.default_rng(2)
    time = np.linspace(0.0, 10.0, 4001)
    x = np.sin(2.0 * np.pi * time) + 0.15 * rng.standard_normal(4001)
    assert len(crossings(x)) == 9  # those at start and end are not within the record


def test_ramp_has_no_cycle_and_backward_loops_are_reported() -> None:
    with pytest.raises(InputError, match="no complete cycle of the displacement"):
        loops(ramp(ShearTest(interfaces=1, normal_force=100.0)))
    record = sine_loops(constant)
    back = ShearRecord(record.time, record.displacement, -record.force, 200.0)
    assert "runs backwards" in loops(back).doubts[0]
    coarse = ShearRecord(record.time[::20], record.displacement[::20], record.force[::20], 200.0)
    assert "samples per cycle" in loops(coarse).doubts[0]
