"""Rolls at the edge of the periodic solvers: no friction, many harmonics, weak pressure: an answer or a cause."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from support.paths import CONFIGS

from wroll_fem.analyses import history, run_analysis, summarise
from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.case import load_case
from wroll_fem.dynamics.system.io import save_system
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.progress import SilentProgress

COARSE = "mesh={circumferential: 8, axial: 4, grading: 3}"


def run(name: str, *overrides: str):
    case = load_case(CONFIGS / f"lab_{name}.yaml", overrides)
    progress = SilentProgress()
    return case, run_analysis(case, progress=progress), progress


@pytest.mark.parametrize("name", ["harmonic", "backbone", "sweep"])
def test_a_roll_without_friction_has_a_frequency_no_damping_and_no_energy_error(name: str) -> None:
    """Nothing dissipates: the balance is referred to what the motion stores, not to an input of rounding."""
    wide = [] if name == "backbone" else ["excitation.f_start=115", "excitation.f_end=145"]
    rate = ["excitation.rate_oct_per_min=20"] if name == "sweep" else []
    one = [] if name == "sweep" else ["harmonic={harmonics: 1, samples: 32}"]
    case, found, progress = run(name, COARSE, "contact.friction.mu=0", *wide, *rate, *one)
    summary = summarise(found)
    assert summary["energy_balance_error"] < 1e-5
    assert not [text for text in progress.warnings if "energy balance" in text]
    frequency = found.attrs["f_stuck_hz" if name == "backbone" else "f_n_hz"]
    if name == "sweep":  # it rings through the undamped resonance
        assert any("ISO 7626-2 limit" in text for text in progress.warnings)
    else:
        assert frequency == pytest.approx(beam_frequency(case, bonded=False), rel=0.06)
    if name == "harmonic":
        assert np.isnan([found.attrs["zeta"], found.attrs["peak_transmissibility"]]).all()
        assert any("its damping ratio due to friction is below" in text for text in progress.warnings)
    if name == "backbone":
        assert found.attrs["zeta_max"] < 1e-9
        assert any("friction dissipates no energy" in text for text in progress.warnings)
    assert summary.get("friction_energy_j", summary.get("friction_work_per_cycle_j")) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
def test_fifteen_harmonics_agree_with_five() -> None:
    five, fifteen = (run("harmonic", f"harmonic.harmonics={count}")[1].attrs for count in (5, 15))
    assert fifteen["harmonics"] == 15
    assert fifteen["f_n_hz"] == pytest.approx(five["f_n_hz"], rel=1e-3)
    assert fifteen["peak_transmissibility"] == pytest.approx(five["peak_transmissibility"], rel=0.02)


def test_a_roll_that_rattles_is_told_so_at_once() -> None:
    """At 1 kPa and 0.5 g most points open at the resonance; the cause is named after the first curve."""
    started = time.process_time()
    with pytest.raises(ConvergenceError, match=r"the surfaces open at \d+ % of the points within a period") as error:
        run("harmonic", COARSE, "preload.pressure=1e3")
    assert time.process_time() - started < 15.0
    if "no periodic motion found" not in str(error.value):  # with some BLAS not even the first point is found
        assert error.value.partial is not None


def test_a_roll_that_rattles_from_the_first_frequency_is_told_so() -> None:
    """With most BLAS no point of the curve is found: the opening is then that of the last iterate."""
    with pytest.raises(ConvergenceError, match=r"the surfaces open at \d+ % of the points"):
        run("harmonic", COARSE, "preload.pressure=1e3", "excitation.amplitude=20", "excitation.f_start=130")


@pytest.mark.parametrize(("pressure", "level"), [(30.0, 0.5), (1e3, 5.0), (3e3, 20.0)])
def test_the_error_of_reduced_is_below_its_estimate_where_points_open(pressure, level, monkeypatch) -> None:
    monkeypatch.setattr(history, "FALLBACK_SIZE", -1)  # without the fallback to condensed
    words = [f"preload.pressure={pressure}", f"excitation.amplitude={level}", "output.fields=none"]
    found = [
        run_analysis(load_case(CONFIGS / "tiny.yaml", [*words, f"solver.method={method}"]), progress=SilentProgress())
        for method in ("condensed", "reduced")
    ]
    assert 0.05 < float(found[0]["open_fraction"].max()) < 0.3
    tip, work = (np.array([dataset[name].values for dataset in found]) for name in ("tip_displacement", "input_work"))
    error = np.sqrt(np.mean((tip[1] - tip[0]) ** 2) / np.mean(tip[0] ** 2))
    spent = np.abs(work[1] - work[0]).max() / np.abs(work[0]).max()
    assert 1e-3 < max(error, spent) < found[1].attrs["reduction_error_estimate"]


def test_a_backbone_begins_where_the_preload_leaves_points_at_their_slip_limit() -> None:
    """At 1 MPa such points slip once, by about the amplitude: the mean motion is half of it, and the roll sticks on."""
    mesh = "mesh={circumferential: 8, axial: 6, grading: 9}"
    ends = "backbone={tip_smallest: 1.0e-6, tip_largest: 1.0e-4}"
    _, found, progress = run("backbone", mesh, ends, "preload.pressure=1.0e6", "harmonic.harmonics=1")
    assert float(found["tip_amplitude"][-1]) == pytest.approx(1e-4, rel=0.05)
    assert not [text for text in progress.warnings if "the backbone ends" in text]
    assert float(found["resonance_frequency"][0]) == pytest.approx(found.attrs["f_stuck_hz"], rel=2e-3)
    assert abs(float(found["modal_damping"][0])) < 1e-9


@pytest.mark.parametrize("name", ["harmonic", "backbone", "random_response"])
def test_a_layer_from_which_another_one_moves_away_is_refused(name: str) -> None:
    """The pressure on the inner layer opens the interface on which the outer one, nearly unpressed, would rest."""
    with pytest.raises(InputError, match=r"preload: an interface carries no pressure, and nothing else holds"):
        run(name, COARSE, "coil.layers=2", "preload.pressure=[1e5, 1.0]")


def test_matrices_with_a_layer_that_friction_does_not_hold_at_rest_are_refused(tmp_path: Path) -> None:
    """The mean displacement of the layer is undetermined: rounding would decide where the training ends."""
    smoothed = "contact.friction={law: smoothed_coulomb, mu: 0.25, reference_speed: 1e-4}"
    roll = load_case(CONFIGS / "lab_dwell.yaml", [COARSE, smoothed])
    system, state = prepare(roll, SilentProgress())
    save_system(system, tmp_path / "roll.npz", preload=state)
    (tmp_path / "case.yaml").write_text(
        "analysis: harmonic\nstructure: {file: roll.npz}\n"
        "excitation: {kind: chirp, amplitude: 5, f_start: 125, f_end: 175, rate_oct_per_min: 2}\n"
    )
    with pytest.raises(InputError, match="mean displacement is undetermined"):
        run_analysis(load_case(tmp_path / "case.yaml"), progress=SilentProgress())
