"""Double shear test: series stiffness, capacity, modulus and energy, exact up to the tolerance of Newton's method."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr

from wroll_fem.errors import InputError
from wroll_fem.tribology import ShearTest, modulus_of, run_shear_test, stiffness_of
from wroll_fem.tribology.shear_test import EDGE

AREA = ShearTest.area


@cache
def run(interfaces: int, pressure: float = 1.0e5, **others: float) -> tuple[ShearTest, xr.Dataset]:
    test = ShearTest(interfaces, pressure * AREA, **others)
    return test, run_shear_test(test)


def test_one_interface_is_one_jenkins_element_per_stack() -> None:
    """F = min(K y, 2 mu F_N) with K = 2 mu F_N / gamma*, and slip y - gamma*."""
    test, data = run(1)
    y = data["platen_displacement"].values
    expected = np.minimum(2.0 * test.mu * test.normal_force / test.elastic_slip * y, 2.0 * test.mu * test.normal_force)
    np.testing.assert_allclose(data["shear_force"].values, expected, rtol=1e-8, atol=1e-9 * test.capacity)
    slid = np.maximum(0.0, y - test.elastic_slip)
    np.testing.assert_allclose(data["platen_slip"].values, slid, atol=1e-8 * test.elastic_slip)


@pytest.mark.parametrize("interfaces", [2, 6, 21])
def test_interfaces_and_layers_are_springs_in_series(interfaces: int) -> None:
    test, data = run(interfaces, layer_shear_modulus=2.0e5)  # soft layers: half of the compliance is theirs
    stick = test.mu * test.normal_force / test.elastic_slip
    layer = 2.0e5 * AREA / test.layer_thickness
    compliance = interfaces / stick + (interfaces - 1) / layer
    assert data.attrs["shear_stiffness_n_m"] == pytest.approx(2.0 / compliance, rel=1e-8)
    assert test.stiffness == pytest.approx(2.0 / compliance, rel=1e-12)
    assert 0.3 < (interfaces - 1) / layer / compliance < 0.9


@pytest.mark.parametrize("pressure", [2.0e4, 3.0e5])
def test_capacity_is_that_of_the_weakest_interface_whatever_the_layers(pressure: float) -> None:
    for interfaces in (1, 5, 31):
        test, data = run(interfaces, pressure)
        assert data.attrs["shear_capacity_n"] == pytest.approx(2.0 * 0.25 * pressure * AREA, rel=1e-7)
        assert data["friction_coefficient"].values[-1] == pytest.approx(0.25, rel=1e-7)
        assert data.attrs["pressure_pa"] == pressure
        assert test.layers == interfaces - 1


def test_all_sliding_is_at_the_platen() -> None:
    """The others hold: the machine's way less what the elastic stack and the machine's spring keep is slip there."""
    test = ShearTest(4, 1.0e5 * AREA)
    system = test.system()
    assert [i.friction.mu for i in system.interfaces] == pytest.approx([0.25, 0.25 * (1.0 + EDGE)] * 2)
    data = run_shear_test(test)
    ends = data["platen_slip"].values
    kept = test.capacity / test.stiffness + test.capacity / test.machine_stiffness
    assert ends[-1] == pytest.approx(float(data["actuator_displacement"][-1]) - kept, rel=1e-6)


def test_modulus_of_a_block_needs_the_factor_of_two_stacks() -> None:
    """Friction far stiffer than the layers: n - 1 bonded layers, whose modulus the double shear test gives back."""
    own, layers = 2.0e5, 10
    _, data = run(layers + 1, elastic_slip=1.0e-12, layer_shear_modulus=own, machine_stiffness=1.0e12)
    found = data.attrs["shear_stiffness_n_m"]
    assert modulus_of(found, AREA, layers * ShearTest.layer_thickness) == pytest.approx(own, rel=1e-4)


def test_work_of_the_machine_is_what_sliding_and_springs_take() -> None:
    test, data = run(3)
    y, force = data["platen_displacement"].values, data["shear_force"].values
    work = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(y))
    slip = 2.0 * test.mu * test.normal_force * float(data["platen_slip"][-1])
    stored = 0.5 * test.capacity**2 / test.stiffness
    # one step of the path passes the corner: its trapezoid is off by at most half a step's triangle
    step = np.diff(y).max()
    assert work == pytest.approx(slip + stored, abs=0.5 * step * np.diff(force).max())


def test_stiffness_is_read_before_sliding() -> None:
    y = np.linspace(0.0, 2.0, 101)
    assert stiffness_of(y, np.minimum(3.0 * y, 3.0)) == pytest.approx(3.0, rel=1e-12)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0, 1.0), "interfaces: must be at least 1, got 0; give 1 or more"),
        ((3, -1.0), "normal_force: normal_force = -1.0; give"),
    ],
)
def test_values_without_a_meaning_are_refused(values: tuple[int, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ShearTest(*values)


def test_steps_that_would_leave_open_what_slides_are_refused() -> None:
    message = "steps: with 20 steps, interfaces other than those at the platen may slide; use more than 30"
    with pytest.raises(InputError, match=message):
        run_shear_test(ShearTest(3, 100.0), steps=20)
