"""Ramps: onset of slip, capacity, stiffness, modulus and fixture against the program's own shear test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.capacity import capacity
from wroll_fem.lab.shear.events import find_event
from wroll_fem.lab.shear.fixture import Fixture
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.lab.shear.simulated import ramp, rigid
from wroll_fem.lab.shear.stiffness import moduli, stiffness
from wroll_fem.numerics.inference import Estimate
from wroll_fem.tribology import ShearTest

TEST = ShearTest(interfaces=5, normal_force=200.0)


@pytest.mark.parametrize(("drop", "rule"), [(5.0, "force_drop"), (0.0, "displacement_jump")])
def test_capacity_without_noise_is_that_of_the_test(drop: float, rule: str) -> None:
    record = ramp(TEST, drop=drop)
    found = capacity(record, find_event(record))
    assert found.rule == rule
    # the record is sampled: the line is exact, and the drop lies anywhere between two samples of 0.17 N
    assert found.force.value == pytest.approx(TEST.capacity, abs=0.1 if drop else 1e-4)
    assert abs(found.onset - 600) <= 1  # sample 600 of 900 is the first beyond step 30 of 45


def test_largest_sample_is_above_the_capacity_and_the_estimate_is_not() -> None:
    rng = np.random.default_rng(3)
    found = []
    for _ in range(20):
        record = ramp(TEST, rng, force_noise=1.0)
        found.append((record.force.max(), capacity(record, find_event(record, rule="displacement_jump")).force.value))
    above, off = np.array(found).T - TEST.capacity
    assert above.min() > 1.5  # 300 samples on the plateau: nearly three standard deviations
    assert abs(off.mean()) < 4.0 * off.std() / np.sqrt(20)


def test_a_rule_can_be_chosen_and_thresholds_are_lengths_and_forces() -> None:
    record = ramp(TEST, drop=5.0)
    assert find_event(record, rule="displacement_jump").rule == "displacement_jump"
    with pytest.raises(InputError, match="no slip is reached: the force never falls by 8 N up to"):
        find_event(record, rule="force_drop", drop=8.0)
    smooth = ramp(TEST)
    # the elastic displacement at slip is 5 um; at the end of the record the platen is 7.5 um further than without slip
    near, far = (find_event(smooth, jump=value).onset for value in (0.5e-6, 1.5e-6))
    assert 600 < near < far


def test_record_without_slip_is_refused_in_one_line() -> None:
    record = ramp(TEST).part(0, 560)
    with pytest.raises(InputError, match="no slip is reached") as caught:
        find_event(record)
    assert "event_rule: none" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_stiffness_and_modulus_of_the_test_are_found() -> None:
    record = ramp(TEST)
    slope, curved = stiffness(record, TEST.capacity, 600)
    assert not curved
    assert slope.value == pytest.approx(TEST.stiffness, rel=1e-7)
    right, one_stack = moduli(slope, TEST.area, TEST.thickness)
    # claim C121: each stack carries half of the force, G = (F/2)/A divided by y/t
    strain = record.displacement[300] / TEST.thickness
    assert right.value == pytest.approx(0.5 * record.force[300] / TEST.area / strain, rel=1e-7)
    assert one_stack.value == pytest.approx(2.0 * right.value, rel=1e-12)


def test_noise_of_the_displacement_does_not_lower_the_stiffness() -> None:
    rng = np.random.default_rng(4)
    found, plain = [], []
    for _ in range(20):
        record = ramp(TEST, rng, length_noise=4e-7)  # a tenth of the range in the window
        found.append(stiffness(record, TEST.capacity, 600)[0].value / TEST.stiffness)
        plain.append(record.slope(60, 480) / TEST.stiffness)
    assert np.mean(plain) < 0.95  # what least squares of force over displacement gives
    assert abs(np.mean(found) - 1.0) < 4.0 * np.std(found) / np.sqrt(20)


def test_given_and_measured_fixture_are_removed_exactly() -> None:
    record = ramp(TEST, fixture=3e7)
    for fixture in (Fixture.given(3e7), Fixture.measured(rigid(3e7)), Fixture.measured(rigid(3e7), degree=2)):
        slope, _ = stiffness(record, TEST.capacity, 600, fixture=fixture)
        assert slope.value == pytest.approx(TEST.stiffness, rel=1e-6)
        own = fixture.corrected(record)
        np.testing.assert_allclose(own.displacement, ramp(TEST).displacement, atol=1e-13)
    both = 1.0 / (1.0 / TEST.stiffness + 1.0 / 3e7)
    assert stiffness(record, TEST.capacity, 600)[0].value == pytest.approx(both, rel=1e-6)


def test_error_of_the_fixture_enters_the_stiffness() -> None:
    slope, fixture = Estimate(1e7, 1e4, 50.0), Fixture.given(3e7, 3e5)
    removed = fixture.removed(slope, ramp(TEST))
    # 1/K = 1/K_m - 1/K_f, by hand
    value = 1.0 / (1e-7 - 1.0 / 3e7)
    error = value**2 * np.hypot(1e4 / 1e14, 3e5 / 9e14)
    assert (removed.value, removed.error) == (pytest.approx(value), pytest.approx(error))
    assert removed.error > value**2 * 1e4 / 1e14


def test_curved_fixture_is_reported_and_a_higher_degree_removes_it() -> None:
    rng = np.random.default_rng(5)
    force = np.linspace(0.0, 250.0, 500)
    bent = force / 3e7 + 2e-11 * force**2
    record = ShearRecord(np.linspace(0.0, 50.0, 500), bent + 1e-8 * rng.standard_normal(500), force)
    assert "raise rigid_degree" in Fixture.measured(record).doubts[0]
    assert not Fixture.measured(record, degree=2).doubts
    measured = ramp(TEST, rng)
    measured = replace(measured, displacement=measured.displacement + measured.force / 3e7 + 2e-11 * measured.force**2)
    slope, _ = stiffness(measured, TEST.capacity, 600, fixture=Fixture.measured(record, degree=2))
    low, high = slope.interval()
    assert low < TEST.stiffness < high


def test_forces_beyond_the_rigid_specimen_are_reported() -> None:
    fixture = Fixture.measured(rigid(3e7, span=(0.0, 60.0)))
    assert "exceed those of the rigid specimen" in fixture.exceeded(ramp(TEST))
    assert not Fixture.given(3e7).exceeded(ramp(TEST))


def test_fixture_that_is_softer_than_the_whole_is_refused() -> None:
    with pytest.raises(InputError, match="is not stiffer than specimen and fixture"):
        stiffness(ramp(TEST), TEST.capacity, 600, fixture=Fixture.given(1e7))
    with pytest.raises(InputError, match=r"fixture_stiffness: the stiffness is -1 N/m; give a number above 0"):
        Fixture.given(-1.0)


def test_force_that_creeps_upward_before_a_drop_is_extrapolated_as_a_parabola() -> None:
    rng = np.random.default_rng(6)
    time = np.linspace(0.0, 60.0, 900)
    force = 100.0 * np.sqrt(time / 50.0) - 20.0 * (time > 50.0) + 0.05 * rng.standard_normal(900)
    record = ShearRecord(time, 1e-6 * time, force)
    found = capacity(record, find_event(record, rule="force_drop"))
    assert any("curved" in text for text in found.doubts)
    assert found.force.value == pytest.approx(100.0, abs=0.15)
