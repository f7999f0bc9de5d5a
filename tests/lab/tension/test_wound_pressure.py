"""Pressure from a measured tension: the winding analysis, its slope, and linear errors against a sample."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.errors import InputError
from wroll_fem.lab.tension.pressure import WindingModel
from wroll_fem.numerics.inference import Estimate

LAB = CONFIGS / "winding_lab.yaml"
K2 = "winding.web.radial_modulus.K2"


def test_pressure_is_that_of_the_winding_analysis() -> None:
    summary = wf.summarise(wf.run(wf.load_case(LAB, ["winding.tension_newton=52"])))
    found = WindingModel(LAB).at(Estimate(52.0, 1.0, 4.0))
    assert found.mandrel.value == pytest.approx(summary["pressure_mandrel_pa"], rel=1e-12)
    assert 0.0 < found.mean.value < found.mandrel.value


def test_linear_error_agrees_with_a_sample_if_the_error_is_small() -> None:
    found = WindingModel(LAB).at(Estimate(40.0, 0.5, 5.0), draws=2000)
    np.testing.assert_allclose(found.mandrel.interval(), found.sample, rtol=2e-3)
    assert found.mandrel.error == pytest.approx(found.slope * 0.5)
    assert not found.nonlinear


def test_slope_is_the_difference_of_two_runs() -> None:
    model = WindingModel(LAB)
    up, down = (model.pressures(tension)[0] for tension in (40.5, 39.5))
    assert model.at(Estimate(40.0, 0.5, 5.0)).slope == pytest.approx(up - down, rel=1e-4)


def test_other_uncertain_keys_add_their_error() -> None:
    model = WindingModel(LAB, {K2: 0.05})
    alone, both = WindingModel(LAB).at(Estimate(40.0, 0.5, 5.0)), model.at(Estimate(40.0, 0.5, 5.0), draws=100)
    steps = [model.pressures(40.0, {K2: 40.0 + change})[0] for change in (2.0, -2.0)]
    extra = 0.5 * (steps[0] - steps[1])  # 5 % of K2
    assert both.mandrel.error == pytest.approx(np.hypot(alone.mandrel.error, extra), rel=1e-2)
    np.testing.assert_allclose(both.mandrel.interval(), both.sample, rtol=0.02)
    assert both.mandrel.freedom > 5.0


def test_large_error_of_a_tension_is_reported_as_nonlinear() -> None:
    model = WindingModel(LAB, {K2: 0.4})
    assert model.at(Estimate(40.0, 0.5, 20.0), draws=200).nonlinear


def test_wrong_cases_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"tiny.yaml: winding: required section is missing; add it"):
        WindingModel(CONFIGS / "tiny.yaml")
    text = LAB.read_text(encoding="utf-8").replace("tension_newton: 40", "tension_stress: 2.0e+6")
    file = tmp_path / "stress.yaml"
    file.write_text(text.replace("  web_width: 0.300 # m\n", ""), encoding="utf-8")
    with pytest.raises(InputError, match=r"winding.web_width: required key is missing; add it \(width of the web"):
        WindingModel(file)
    with pytest.raises(InputError, match=r"uncertain: winding.web.radial_modulus.law is no number of the case"):
        WindingModel(LAB, {"winding.web.radial_modulus.law": 0.1})
    with pytest.raises(InputError, match="a tension of -1 N winds no roll"):
        WindingModel(LAB).at(Estimate(-1.0, 0.1, 3.0))
