"""Checkpoints of harmonic and backbone: resumed runs are those that were not interrupted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.paths import CONFIGS
from support.periodic import trained_roll

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.training_progress import Passes
from wroll_fem.case import Case, load_case
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.training import course, training
from wroll_fem.dynamics.training.training_state import TrainingFile, arrays_of, curve_of
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.jobs.run import run_case
from wroll_fem.progress import SilentProgress

SMALL = ["mesh={circumferential: 8, axial: 3, grading: 1}", "output.figures=false", "harmonic.harmonics=3"]
BAND = ["excitation.f_start=140", "excitation.f_end=165", "harmonic.harmonics=1"]


def interrupt_after(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    """Interrupt the run after the next pass that follows pass ``number``, at the first point of a curve."""
    report, at_point, seen = Passes.report, Passes.at_point, []

    def reported(self: Passes, count: int, *rest: object) -> None:
        seen.append(count)
        report(self, count, *rest)  # type: ignore[arg-type]

    def stopped(self: Passes, *rest: object) -> None:
        if seen and seen[-1] >= number:
            raise KeyboardInterrupt
        at_point(self, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(Passes, "report", reported)
    monkeypatch.setattr(Passes, "at_point", stopped)


def case_of(name: str) -> Case:
    return load_case(CONFIGS / f"{name}.yaml", [*SMALL, *(BAND if name == "lab_harmonic" else [])])


@pytest.mark.parametrize("name", ["lab_harmonic", pytest.param("lab_backbone", marks=pytest.mark.slow)])
def test_a_resumed_run_is_bitwise_the_uninterrupted_one(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = case_of(name)
    whole = run_case(case, tmp_path / "whole").summary
    assert not (tmp_path / "whole" / "checkpoint.npz").exists()
    with monkeypatch.context() as patch:
        interrupt_after(patch, 1)
        with pytest.raises(KeyboardInterrupt):
            run_case(case, tmp_path / "cut")
    assert (tmp_path / "cut" / "checkpoint.npz").is_file()
    resumed = run_case(case, tmp_path / "cut", resume=True).summary
    assert not (tmp_path / "cut" / "checkpoint.npz").exists()
    timed = {"solver_time_s", "wall_time_s"}
    assert {k: v for k, v in resumed.items() if k not in timed} == {k: v for k, v in whole.items() if k not in timed}


@pytest.mark.parametrize("sparse", [0.0, 10.0])
def test_every_state_of_a_training_continues_to_the_same_curve(
    sparse: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Curves that were moved to a larger basis, with all points or some, included: here every curve is."""
    monkeypatch.setattr(course, "SPARSE", sparse)
    monkeypatch.setattr(training, "COARSE", 1.0)
    monkeypatch.setattr(course, "MOVABLE", 1e9)
    case, path = load_case(CONFIGS / "lab_backbone.yaml", [*SMALL, "harmonic.reduction_tolerance=1e-4"]), tmp_path / "x"
    states: list[bytes] = []
    keep = TrainingFile.keep

    def kept(self: TrainingFile, *rest: object) -> None:
        keep(self, *rest)  # type: ignore[arg-type]
        self.write()
        states.append(self.path.read_bytes())

    with monkeypatch.context() as patch:
        patch.setattr(TrainingFile, "keep", kept)
        whole = run_analysis(case, progress=SilentProgress(), checkpoint=path)
    moved = 0
    for state in states:
        path.write_bytes(state)
        with np.load(path) as data:
            moved += any(key.startswith("curve_") for key in data.files)
        again = run_analysis(case, progress=SilentProgress(), checkpoint=path, resume=True)
        np.testing.assert_array_equal(again["modal_damping"], whole["modal_damping"])
        assert again.attrs["reduction_error_estimate"] == whole.attrs["reduction_error_estimate"]
    assert moved > 0


def test_a_response_curve_is_the_same_after_a_checkpoint() -> None:
    curve = trained_roll(8, 3).curve
    curve = replace(curve, gap=(900.0, 910.0), skipped=(950.0,))
    again = curve_of(curve.balance, arrays_of(curve))
    assert isinstance(again, HarmonicCurve)
    for name in ("frequencies", "coefficients", "tangents", "iterations", "stable", "gap", "skipped"):
        np.testing.assert_array_equal(getattr(again, name), getattr(curve, name))
    assert (again.problem.band, again.problem.size) == (curve.problem.band, curve.problem.size)
    np.testing.assert_array_equal(again.direction(3), curve.direction(3))


def test_a_checkpoint_of_another_run_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "state.npz"
    with monkeypatch.context() as patch:
        interrupt_after(patch, 1)
        with pytest.raises(KeyboardInterrupt):
            run_analysis(case_of("lab_harmonic"), progress=SilentProgress(), checkpoint=path)
    other = load_case(CONFIGS / "lab_harmonic.yaml", [*SMALL, *BAND, "coil.material.E=3e9"])
    with pytest.raises(InputError, match="belongs to another run"):
        run_analysis(other, progress=SilentProgress(), checkpoint=path, resume=True)
    path.write_bytes(b"nothing")
    with pytest.raises(InputError, match="was cut off"):
        run_analysis(other, progress=SilentProgress(), checkpoint=path, resume=True)


def test_a_curve_that_cannot_be_followed_leaves_no_checkpoint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "state.npz"

    def stopped(self: TrainingFile, *rest: object) -> None:
        self.path.write_bytes(b"state")
        raise ConvergenceError("no", time_s=None, iterations=1, residual_history=[1.0], advice="none")

    monkeypatch.setattr(TrainingFile, "keep", stopped)
    with pytest.raises(ConvergenceError):
        run_analysis(case_of("lab_harmonic"), progress=SilentProgress(), checkpoint=path)
    assert not path.exists()
