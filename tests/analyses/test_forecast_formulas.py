"""Formulas behind the words before a run, written out once more: shear lag, slip, sweeps, computing time."""

from __future__ import annotations

import math

import pytest
from support.paths import CONFIGS

from wroll_fem.analyses.forecasts import computing_time
from wroll_fem.analyses.forecasts.closed_forms import beam_frequency, shear_lag_length
from wroll_fem.analyses.forecasts.slip import slip_forecast
from wroll_fem.analyses.shared import resolution
from wroll_fem.analyses.shared.preflight import fast_sweeps
from wroll_fem.case import load_case


def test_the_shear_lag_is_that_of_two_bars_on_the_stick_stiffness() -> None:
    case = load_case(CONFIGS / "lab_sweep.yaml")
    bars = [
        case.mandrel.material.E * case.geometry.mandrel_thickness, case.coil.material.E * case.coil.total_thickness
    ]  # fmt: skip
    stick = case.friction.mu * 5e4 / case.friction.elastic_slip
    found = shear_lag_length(case, case.interface_laws[0], 5e4)
    assert found == pytest.approx(math.sqrt(bars[0] * bars[1] / sum(bars) / stick), rel=1e-12)


def test_slip_begins_at_the_second_interface_of_an_inner_edge() -> None:
    """Bars inside and outside of the second of three layers; the third interface has a higher pressure."""
    pressures = "[1 kPa, 2 kPa, 100 kPa]"
    words = [
        "coil.layers=3",
        "coil.base=inner_edge",
        "preload.kind=interface_pressure",
        f"preload.pressure={pressures}",
    ]
    case = load_case(CONFIGS / "lab_sweep.yaml", words)
    found = slip_forecast(case)
    g, layer = case.geometry, case.coil.material.E * case.coil.total_thickness / 3.0
    inside, outside = case.mandrel.material.E * g.mandrel_thickness + layer, 2.0 * layer
    limit = case.friction.mu * 2e3
    lag = math.sqrt(inside * outside / (inside + outside) * case.friction.elastic_slip / limit)
    radius = 0.5 * g.mandrel_outer_diameter + case.coil.total_thickness / 3.0
    per_tip = outside * radius * 3.0 / g.length**2
    assert found is not None
    assert found[0] == pytest.approx(limit * lag / math.tanh(g.length / lag) / per_tip, rel=1e-9)


def test_a_fast_sweep_is_judged_at_the_resonance_without_friction() -> None:
    case = load_case(CONFIGS / "lab_sweep.yaml", ["excitation.rate_oct_per_min=2000", "excitation.f_start=50"])
    (line,) = fast_sweeps(case)
    assert f"a resonance at {beam_frequency(case, bonded=False):.0f} Hz" in line
    assert f"{beam_frequency(case, bonded=False):.0f}" != f"{beam_frequency(case, bonded=True):.0f}"


def test_modes_of_a_whole_roll_take_the_seconds_of_all_their_dofs() -> None:
    case = load_case(CONFIGS / "lab_sweep.yaml", ["analysis=modal"])
    found = computing_time.estimate_modes(case)
    assert found["estimated_seconds"] > computing_time.SECONDS_PER_DOF_OF_MODES * found["dofs"]


def test_the_mesh_of_a_fourier_roll_is_compared_with_twice_as_many_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[dict[str, float]] = []
    real = resolution.finer
    monkeypatch.setattr(resolution, "finer", lambda roll, least: asked.append(dict(least)) or real(roll, least))
    words = ["mesh.discretisation=fourier", "mesh.radial=2", "mesh.axial=3", "mesh.grading=1"]
    assert resolution.fourier_remark(load_case(CONFIGS / "case_study.yaml", words)) == ""
    assert asked == [{"axial": 6, "radial": 4}]


def test_a_curve_takes_the_seconds_of_its_contact_points_on_top_of_the_roll() -> None:
    case = load_case(CONFIGS / "lab_harmonic.yaml")
    roll, curve = computing_time.estimate_roll(case), computing_time.estimate_curve(case)
    more = computing_time.SECONDS_PER_CURVE_POINT * roll["interface_points"]
    assert curve["estimated_seconds"] == pytest.approx(roll["estimated_seconds"] + more, rel=1e-12)


def test_a_coil_on_springs_has_no_forecast_of_slip_and_a_guided_one_has() -> None:
    guided = load_case(CONFIGS / "lab_sweep.yaml", ["coil.base=guided"])
    sprung = load_case(CONFIGS / "lab_sweep.yaml", ["coil.base=guided", "coil.base_stiffness=1e6"])
    assert slip_forecast(guided) is not None
    assert slip_forecast(sprung) is None
