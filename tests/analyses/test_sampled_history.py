"""`solver.hyper_reduction` of sweeps and dwells: readings, what the run says, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.analyses import run_analysis, sampled_history, summarise
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress

LAB = CONFIGS / "lab_sweep.yaml"
COARSE = ("mesh={circumferential: 12, axial: 6, grading: 10}", "solver.hyper_reduction=true")
DWELL = ("excitation={kind: dwell, frequency: 100, amplitude: 10, cycles: 20}",)
QUICK = ("excitation.rate_oct_per_min=40", "excitation.f_start=140", "excitation.f_end=165")


class Told(SilentProgress):
    """Progress that keeps messages."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []

    def info(self, text: str) -> None:
        self.lines.append(text)


def run(*overrides: str, file: str = "lab_sweep.yaml") -> tuple[dict[str, Any], Told]:
    case, told = load_case(CONFIGS / file, list(overrides)), Told()
    found = run_analysis(case, progress=told)
    read = summarise(found, case) | {key: float(found[key][-1]) for key in ("friction_energy", "input_work")}
    return read | {"largest_tip": float(np.abs(found["tip_displacement"]).max())}, told


@pytest.mark.parametrize(
    "scheme", ["{scheme: hht, alpha: -0.05, steps_per_cycle: 40}", "{scheme: trigonometric, steps_per_cycle: 40}"]
)
def test_a_sweep_on_a_subset_reads_as_one_on_all_points(scheme: str) -> None:
    options = (*QUICK, f"integrator={scheme}")
    found, told = run(*COARSE, *options)
    right, _ = run(COARSE[0], *options)
    assert any("friction at" in line for line in told.lines)
    assert found["sampled_points"] < 0.5 * found["interface_points"]
    assert found["f_n_hz"] == pytest.approx(right["f_n_hz"], rel=2e-4)
    assert found["peak_transmissibility"] == pytest.approx(right["peak_transmissibility"], rel=4e-3)
    assert found["friction_energy"] == pytest.approx(right["friction_energy"], rel=5e-3)
    assert found["sampling_work_error"] < 1e-2
    assert not [text for text in told.warnings if "subset" in text]


@pytest.mark.slow
@pytest.mark.parametrize("amplitude", [0.5, 30.0])
def test_a_dwell_on_a_subset_reads_as_one_on_all_points(amplitude: float) -> None:
    """From hardly any slip to slip nearly everywhere."""
    options = (f"excitation.amplitude={amplitude}", "excitation.frequency=150", "excitation.cycles=40")
    found, _ = run(*COARSE, *options, file="lab_dwell.yaml")
    right, _ = run(COARSE[0], *options, file="lab_dwell.yaml")
    assert found["largest_tip"] == pytest.approx(right["largest_tip"], rel=5e-3)


@pytest.mark.parametrize("scheme", [pytest.param("hht, alpha: -0.05", marks=pytest.mark.slow), "trigonometric"])
def test_the_beginning_of_a_sweep_does_not_stop_it(scheme: str) -> None:
    """In the ramp, the trained basis lacks 1.5 % of a motion that is a thousandth of the later one."""
    words = ("mesh={circumferential: 32, axial: 16, grading: 40}", "solver.hyper_reduction=true")
    found, told = run(
        *words, f"integrator={{scheme: {scheme}, steps_per_cycle: 40}}", "excitation.rate_oct_per_min=60",
    )  # fmt: skip
    assert found["sampled_points"] < 0.4 * found["interface_points"]
    assert found["reduction_error_estimate"] < 3e-3
    assert not [text for text in told.warnings if "falls back" in text]


@pytest.mark.parametrize("change", ["contact.friction.mu=0", "preload.pressure=0", "contact.friction.elastic_slip=1"])
def test_without_slip_all_points_are_used_and_the_run_says_so(change: str) -> None:
    found, told = run(*COARSE, *QUICK, "excitation.rate_oct_per_min=90", "excitation.ramp_cycles=2", change)
    assert "sampled_points" not in found
    assert any("no subset" in line for line in (*told.lines, *told.warnings))


def test_a_structure_without_contact_needs_no_subset() -> None:
    found, told = run(*COARSE, *QUICK, "coil.model=bonded")
    assert "sampled_points" not in found
    assert not any("subset" in line for line in (*told.lines, *told.warnings))


def test_a_training_that_stops_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A profile, since its largest factor counts for the amplitude of the training."""
    from wroll_fem.dynamics.training import history_points

    monkeypatch.setattr(history_points, "MOST_POINTS", 5)
    profile = "excitation.profile={frequency: [140, 165], factor: [1, 0.5]}"
    found, told = run(*COARSE, *QUICK, profile)
    assert "sampled_points" not in found
    assert any("more than 5 points" in text for text in told.warnings)


def test_large_errors_of_the_subset_are_told() -> None:
    assert sampled_history.subset_remark({}) == ""
    assert sampled_history.subset_remark({"sampling_work_error": 0.009, "sampling_motion_error": 0.0}) == ""
    text = sampled_history.subset_remark({"sampling_work_error": 0.02, "sampling_motion_error": 0.001})
    assert "2 %" in text
    assert "solver.hyper_reduction: false" in text


@pytest.mark.parametrize(
    ("file", "overrides", "problem"),
    [
        ("lab_sweep.yaml", ["solver.method=condensed"], "at all contact points"),
        ("lab_random.yaml", [], "periodic motions"),
        ("lab_shock.yaml", [], "periodic motions"),
    ],
)
def test_what_cannot_be_trained_is_refused(file: str, overrides: list[str], problem: str) -> None:
    with pytest.raises(InputError, match=r"solver\.hyper_reduction") as stop:
        load_case(CONFIGS / file, ["solver.hyper_reduction=true", *overrides])
    assert problem in str(stop.value)
    assert "\n" not in str(stop.value)


def test_a_coil_whose_wraps_slide_is_refused() -> None:
    with pytest.raises(InputError, match=r"coil\.inside: slipping"):
        load_case(CONFIGS / "slipping_harmonic.yaml", ["analysis=dwell", *DWELL, "solver.hyper_reduction=true"])
