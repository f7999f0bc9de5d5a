"""Doubts about finished results, and where the warnings of a run stand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import minimize_scalar
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.backbone import range_remark
from wroll_fem.analyses.shared import small_displacement
from wroll_fem.analyses.shared.doubts import doubts
from wroll_fem.analyses.shared.small_displacement import flattening, largest_tip
from wroll_fem.analyses.shared.time_step import dwell_step_error, steps_per_cycle, time_step
from wroll_fem.case import OnRoll
from wroll_fem.case.kinds_history import RollDwellCase
from wroll_fem.jobs.console import summary_lines
from wroll_fem.jobs.run import run_case
from wroll_fem.progress import KeptWarnings, SilentProgress
from wroll_fem.signals.motions import base_motion

OSCILLATOR = CONFIGS / "oscillator.yaml"
FAST = ["excitation.rate_oct_per_min=20", "integrator.steps_per_cycle=20", "output.figures=false"]


def test_warnings_of_a_run_stand_in_the_summary_in_the_results_and_at_the_end(tmp_path: Path) -> None:
    progress = SilentProgress()
    case = wf.load_case(OSCILLATOR, [*FAST, "integrator.scheme=moderate_dissipation", "integrator.alpha=-0.41421"])
    run_case(case, tmp_path / "run", progress=progress)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["warnings"] == list(dict.fromkeys(progress.warnings))
    assert any("numerically" in text for text in summary["warnings"])  # before the run
    assert any("oct/min" in text for text in summary["warnings"])  # during the run
    assert wf.summarise(wf.load_result(tmp_path / "run"))["warnings"] == summary["warnings"]
    assert summary_lines(summary)[-len(summary["warnings"]) :] == [f"warning: {text}" for text in summary["warnings"]]


def test_a_run_without_warnings_has_an_empty_list() -> None:
    case = wf.load_case(CONFIGS / "winding_lab.yaml")
    assert wf.summarise(wf.run(case, progress=SilentProgress()))["warnings"] == []


def test_a_warning_is_passed_on_once() -> None:
    inner = SilentProgress()
    kept = KeptWarnings(inner)
    for text in ("a", "b", "a"):
        kept.warning(text)
    with kept.stage("stage", 1.0):
        kept.info("information")
    assert kept.warnings == inner.warnings == ["a", "b"]
    assert (inner.stages, inner.infos) == (["stage"], ["information"])


@pytest.mark.parametrize(
    ("file", "remedy"),
    [("oscillator", "steps_per_cycle"), ("lab_harmonic", "harmonic.samples"), ("two_dof", "two_dof.method: time")],
)
def test_an_open_energy_balance_is_a_doubt(file: str, remedy: str) -> None:
    case = wf.load_case(CONFIGS / f"{file}.yaml")
    assert doubts(xr.Dataset(), {"energy_balance_error": 0.0049}, case) == []
    [text] = doubts(xr.Dataset(), {"energy_balance_error": 0.0051}, case)
    assert "energy balance error is 0.51 %" in text
    assert remedy in text


def test_a_dwell_that_is_not_steady_is_marked() -> None:
    words = ["solver.method=condensed", "mesh={circumferential: 8, axial: 2, grading: 1}", "output.figures=false"]
    progress = SilentProgress()
    case = wf.load_case(CONFIGS / "tiny.yaml", words)
    summary = wf.summarise(wf.run(case, progress=progress))
    assert summary["steady_drift"] > 0.02
    assert "steady_drift" in summary["steady_doubt"]
    assert any("steady_magnitude is doubtful" in text for text in summary["warnings"])


@pytest.mark.parametrize(("noise", "told"), [(0.0, False), (2.0, True)])
def test_an_error_by_the_time_step_that_cannot_be_estimated_is_told(noise: float, told: bool) -> None:
    """The motion of one oscillator, with and without a noise that no oscillator follows."""
    case = wf.load_case(CONFIGS / "lab_dwell.yaml").expect(RollDwellCase)
    time = np.arange(2000) * time_step(case)
    motion = base_motion(case.excitation)
    tip = -motion.acceleration(time) / (2.0 * np.pi * 500.0) ** 2  # far below the resonance
    tip += noise * np.abs(tip).max() * np.random.default_rng(3).standard_normal(len(tip))
    error, text = dwell_step_error(case, xr.Dataset({"tip_displacement": ("time", tip)}))
    assert np.isnan(error) == told
    assert text.startswith("the error by the time step is unknown") == told
    assert not told or text.endswith(f"integrator.steps_per_cycle: {2 * steps_per_cycle(case)}")


def test_a_sweep_that_misses_the_resonance_gives_none() -> None:
    progress = SilentProgress()
    case = wf.load_case(OSCILLATOR, [*FAST, "excitation.f_start=20"])
    summary = wf.summarise(wf.run(case, progress=progress))
    assert np.isnan([summary["f_n_hz"], summary["zeta"], summary["peak_transmissibility"]]).all()
    assert "no resonance inside" in summary["half_power_reason"]
    assert any("no resonance inside" in text for text in summary["warnings"])


def test_a_fast_sweep_without_a_half_power_point_is_told_its_rate_and_its_time_step() -> None:
    """The band ends just above the peak; the remarks about zeta stand although there is none."""
    coarse = ["integrator.steps_per_cycle=12", "solver.allow_coarse=true", "excitation.ramp_cycles=3"]
    progress = SilentProgress()
    found = wf.run(wf.load_case(OSCILLATOR, [*FAST, *coarse, "excitation.f_end=19.8"]), progress=progress).attrs
    assert 15.0 < found["f_n_hz"] < 18.0
    assert np.isnan([found["zeta"], found["zeta_apparent"], found["half_power_high_hz"]]).all()
    reasons = found["zeta_doubts"].split("\n")
    assert found["zeta_quality"] == "invalid"
    assert "no half-power point" in reasons[0]
    assert "ISO 7626-2 limit" in reasons[1]
    assert "the time step changes |T|" in reasons[2]
    assert set(reasons) <= set(progress.warnings)


def test_a_periodic_motion_far_from_resonance_has_a_balance_and_no_resonance() -> None:
    """Nothing slips there: friction work and input are rounding, and their ratio was 126 %."""
    words = [
        "mesh={circumferential: 8, axial: 2, grading: 1}", "harmonic={harmonics: 1, samples: 32}",
        "excitation.f_start=10", "excitation.f_end=20", "output.figures=false",
    ]  # fmt: skip
    summary = wf.summarise(wf.run(wf.load_case(CONFIGS / "lab_harmonic.yaml", words), progress=SilentProgress()))
    assert summary["energy_balance_error"] < 1e-4
    assert summary["work_quadrature_error"] < 1e-2
    assert np.isnan(summary["f_n_hz"])
    assert "upper end of the band" in summary["half_power_reason"]


def test_the_balance_of_a_period_is_the_identity_and_the_quadrature_has_its_own_name() -> None:
    case = wf.load_case(OSCILLATOR, ["analysis=harmonic", "excitation.amplitude=3", "output.figures=false"])
    errors = [wf.summarise(wf.run(case.changed(f"harmonic.samples={n}"), progress=SilentProgress())) for n in (64, 256)]
    assert all(found["energy_balance_error"] < 1e-5 for found in errors)
    assert errors[1]["work_quadrature_error"] < 0.2 * errors[0]["work_quadrature_error"]
    assert errors[0]["work_quadrature_error"] > 1e-5


def test_flattening_minimises_the_energy_of_a_bent_tube() -> None:
    """Section r = R (1 - zeta cos 2 phi), inextensible, with its exact second moment of area and hoop bending."""
    case = wf.load_case(CONFIGS / "lab_mandrel.yaml").expect(OnRoll)
    g, material = case.geometry, case.mandrel.material
    t, tip = g.mandrel_thickness, 2e-3
    radius, curvature = 0.5 * (g.mandrel_outer_diameter - t), 3.0 * tip / g.length**2
    phi = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]

    def inertia(zeta: float) -> float:
        y = radius * ((1.0 + zeta * np.cos(2.0 * phi)) * np.sin(phi) - 0.5 * zeta * np.sin(2.0 * phi) * np.cos(phi))
        return float(t * radius * np.mean(y**2) * 2.0 * np.pi)

    def energy(zeta: float) -> float:
        plate = material.E * t**3 / (12.0 * (1.0 - material.nu**2))
        hoop = 0.5 * plate * np.pi * radius * (3.0 * zeta / radius) ** 2
        return 0.5 * material.E * inertia(zeta) * curvature**2 + hoop

    found = minimize_scalar(energy, bounds=(0.0, 0.1), method="bounded", options={"xatol": 1e-12})
    assert inertia(0.0) == pytest.approx(np.pi * radius**3 * t)
    assert flattening(case, tip) == pytest.approx(1.0 - inertia(found.x) / inertia(0.0), rel=0.02)


@pytest.mark.parametrize(("tip", "slip", "words"), [(1e-3, 1e-4, []), (6e-3, 1e-4, ["tip"]), (1e-3, 1e-3, ["slide"])])
def test_motions_beyond_small_displacement_theory_are_told(tip: float, slip: float, words: list[str]) -> None:
    case = wf.load_case(CONFIGS / "lab_dwell.yaml")
    data = xr.Dataset({"tip_displacement": ("time", [0.0, -tip, 0.5 * tip])})
    told = doubts(data, {"max_relative_displacement_m": slip}, case)
    assert len(told) == len(words)
    assert all(word in text for word, text in zip(words, told, strict=True))


RANDOM = "excitation={kind: random, psd: {frequency: [120, 200], g2_per_hz: [1e-3, 1e-3]}, duration: 2}"
TINY = "mesh={circumferential: 8, axial: 3, grading: 3}"


@pytest.mark.parametrize(
    ("changed", "sigmas"),
    [
        (["analysis=random", RANDOM, "excitation.levels=[0.5, 1]", "output.damping=rational_fraction"], [True, False]),
        (["analysis=random_response", RANDOM, "backbone={tip_largest: 2e-4}", "damping.modal=0.01"], [True, True]),
        (["analysis=dwell", "excitation={kind: dwell, frequency: 150, amplitude: 5, cycles: 6}"], [False, False]),
        (["analysis=harmonic"], [False, False]),
    ],
)
def test_every_shaken_roll_is_judged_by_small_displacement_theory(
    changed: list[str], sigmas: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With limits that every motion exceeds, tip and slip are told in the warnings of a real run."""
    for name in ("STIFFNESS_ERROR", "SLIP_OF_RADIUS", "SLIP_OF_ELEMENT"):
        monkeypatch.setattr(small_displacement, name, 1e-12)
    case = wf.load_case(CONFIGS / "lab_harmonic.yaml", [*changed, TINY, "output.figures=false"])
    warnings = wf.run(case, progress=SilentProgress()).attrs["warnings"].split("\n")
    for words, random in zip(("the tip moves by", "layers slide by up to"), sigmas, strict=True):
        [text] = [text for text in warnings if text.startswith(words)]
        assert ("(three standard deviations)" in text) == random


def test_a_random_response_is_judged_at_three_standard_deviations_of_its_highest_level() -> None:
    """Its backbone may go further: what it could be is not what it is."""
    data = xr.Dataset(
        {"tip_displacement_rms_at_level": ("level_db", [1e-4, 2e-3])}, {"tip_amplitude": [1e-6, 1e-1]},
        {"tip_displacement_rms_m": 1e-4},
    )  # fmt: skip
    assert largest_tip(data)[0] == pytest.approx(6e-3)
    case = wf.load_case(CONFIGS / "lab_random_response.yaml")
    [text] = doubts(data, {"slip_rms_m": [1e-6]}, case)
    assert text.startswith("the tip moves by 6 mm (three standard deviations), beyond small-displacement theory")
    assert doubts(data.isel(level_db=[0]), {"slip_rms_m": [1e-6]}, case) == []


def test_a_level_that_opens_the_coil_widely_is_a_warning() -> None:
    """Two interfaces with areas 1, 2, 1 and a point that the preload leaves open; three levels."""
    opened = np.array([[[0, 0, 0], [0, 0, 0]], [[0.1, 0, 0], [0, 0, 1]], [[0.1, 0.2, 0], [0, 0, 1]]])
    area, pressure = [[1.0, 2.0, 1.0], [1.0, 2.0, 5.0]], [[1e4, 1e4, 1e4], [1e4, 1e4, 0.0]]
    fields = {"area": (("interface", "point"), area), "pressure": (("interface", "point"), pressure)}
    levels = xr.Dataset(
        fields | {"open_time_fraction": (("level", "interface", "point"), opened)}, {"level_db": ("level", [-6, 0, 6])}
    )
    case = wf.load_case(CONFIGS / "lab_random.yaml")
    [text] = doubts(levels, {}, case)
    assert "from 0 dB on interface 0 (0: innermost) opens over 25 % of its area" in text
    single = levels.isel(level=2).drop_vars("level_db")
    assert "interface 0 (0: innermost) opens over 75 % of its area" in doubts(single, {}, case)[0]
    assert doubts(levels.isel(level=[0]), {}, case) == []
    assert doubts(single, {}, wf.load_case(CONFIGS / "lab_harmonic.yaml")) == []


@pytest.mark.parametrize(("amplitude", "wide"), [(5.0, False), (3000.0, True)])
def test_a_shock_that_opens_the_coil_is_told(amplitude: float, wide: bool) -> None:
    words = [
        "analysis=shock", "mesh={circumferential: 8, axial: 2, grading: 1}", "output.figures=false",
        "solver.method=condensed", "preload.pressure=1e4",
        f"excitation={{kind: half_sine, amplitude: {amplitude}, duration: 2.0e-3, decay: 0.02}}",
    ]  # fmt: skip
    summary = wf.summarise(wf.run(wf.load_case(CONFIGS / "tiny.yaml", words), progress=SilentProgress()))
    assert any("opens over" in text for text in summary["warnings"]) == wide
    assert (max(summary["open_area_fraction"]) > 0.2) == wide


def test_a_damping_that_still_rises_at_the_end_of_the_range_is_told() -> None:
    rising, over = (
        xr.Dataset({"modal_damping": ("tip_amplitude", values)}, attrs={"tip_amplitude_at_zeta_max_m": 1e-4})
        for values in ([0.0, 0.01, 0.02], [0.0, 0.02, 0.01])
    )
    assert "raise backbone.tip_largest" in range_remark(rising)
    assert range_remark(over) == ""
    assert range_remark(0.0 * over) == ""  # sticks: no damping at all
