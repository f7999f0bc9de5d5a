"""Elastic slip from the pre-slip slope over the preload, against the stacks of the program's shear test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.lab.friction.elastic_slip import fit_elastic_slip
from wroll_fem.numerics.inference import Estimate
from wroll_fem.tribology import ShearTest

FORCES = np.array([50.0, 100.0, 200.0, 400.0])


def exact(test: ShearTest, fixture: float = np.inf) -> tuple[list[Estimate], list[Estimate]]:
    own = [replace(test, normal_force=float(force)) for force in FORCES]
    slopes = [Estimate(1.0 / (1.0 / one.stiffness + 1.0 / fixture), 1e3, 50.0) for one in own]
    return slopes, [Estimate(one.capacity, 1e-2, 50.0) for one in own]


@pytest.mark.parametrize("interfaces", [1, 2, 51])
def test_elastic_slip_of_a_stack_is_found_beside_layers_and_fixture(interfaces: int) -> None:
    test = ShearTest(interfaces=interfaces, normal_force=100.0, elastic_slip=1.7e-6, mu=0.31)
    found = fit_elastic_slip(FORCES, *exact(test, fixture=2e7), interfaces=interfaces)
    assert found.elastic_slip.value == pytest.approx(1.7e-6, rel=1e-9)
    assert found.mu.value == pytest.approx(0.31, rel=1e-9)
    layers = test.layers * test.layer_thickness / (2.0 * test.layer_shear_modulus * test.area)
    assert found.series.value == pytest.approx(layers + 1.0 / 2e7, rel=1e-9)


def test_compliance_left_in_series_is_reported() -> None:
    test = ShearTest(interfaces=1, normal_force=100.0)
    assert not fit_elastic_slip(FORCES, *exact(test), series=0.0).doubts
    assert "in series beyond series_compliance" in fit_elastic_slip(FORCES, *exact(test, 2e7), series=0.0).doubts[0]
    assert "lies in series" in fit_elastic_slip(FORCES, *exact(test, 2e6)).doubts[0]


def test_capacity_that_misses_the_origin_is_reported() -> None:
    slopes, levels = exact(ShearTest(interfaces=1, normal_force=100.0))
    shifted = [Estimate(one.value + 5.0, one.error, one.freedom) for one in levels]
    assert "misses the origin by 5 N" in fit_elastic_slip(FORCES, slopes, shifted).doubts[0]


def test_too_few_preloads_and_a_wrong_order_are_refused() -> None:
    slopes, levels = exact(ShearTest(interfaces=1, normal_force=100.0))
    with pytest.raises(InputError, match=r"normal_force: 2 tests at 2 preloads; test at 3 preloads or more, 4 tests"):
        fit_elastic_slip(FORCES[:2], slopes[:2], levels[:2])
    with pytest.raises(InputError, match="the stiffness does not rise with the preload"):
        fit_elastic_slip(FORCES, slopes[::-1], levels)
