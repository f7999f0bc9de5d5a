"""The run folder, with fake analyses: what a run leaves, what it refuses, how it stops and goes on."""

from __future__ import annotations

import contextlib
import json
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from filelock import FileLock
from support.fake_analyses import CONFIGS, TINY, FakeAnalyses, failure, tree
from typer.testing import Result

from wroll_fem import example_case, load_case
from wroll_fem.jobs.folder import RunFolder, Status
from wroll_fem.jobs.run import run_case
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset

# ---- run ----------------------------------------------------------------------------------------


def test_a_run_leaves_the_documented_files(wroll: Callable[..., Result], tmp_path: Path) -> None:
    done = wroll("run", TINY, "--set", "contact.friction.mu=0.5")
    assert done.exit_code == 0, done.output
    out = tmp_path / "runs" / "tiny"
    names = {
        "case.yaml",
        "summary.json",
        "results.nc",
        "run.log",
        ".lock",
        "provenance.json",
        "fields/slip_map.vtu",
        "figures/tip.png",
    }
    assert set(tree(out)) == names
    case = load_case(out / "case.yaml")
    assert case == load_case(TINY, ["contact.friction.mu=0.5"])
    provenance = json.loads((out / "provenance.json").read_text())
    assert provenance["status"] == "complete"
    assert provenance["case_hash"] == case.hash()
    assert provenance["command"] == f"wroll run {TINY} --out runs/tiny --set contact.friction.mu=0.5"
    assert provenance["seeds"] == {"seed": 3}
    assert provenance["wall_time_s"] > 0
    assert {"versions", "git", "machine"} <= set(provenance)
    log = (out / "run.log").read_text()
    assert "warning: the mesh is coarse" in log
    assert "fake analysis: done in" in log


def test_the_run_ends_with_a_table_and_the_paths(wroll: Callable[..., Result]) -> None:
    text = wroll("run", TINY, "--out", "here").stdout
    for line in (
        r"resonance frequency f_n +150\.25 Hz",
        r"damping ratio zeta +0\.0213",
        r"energy balance error +0\.12%",
        r"energy dissipated by friction +0\.0015 J",
        r"mean interface pressure +5e\+04 Pa",
        r"degrees of freedom +1200",
        r"run folder +here",
        r"figure +here/figures/tip\.png",
    ):
        assert re.search(line, text), line
    assert "peak transmissibility" not in text  # not a number here


def test_the_summary_is_strict_json_with_plain_values(wroll: Callable[..., Result], tmp_path: Path) -> None:
    wroll("run", TINY, "--out", "here")
    text = (tmp_path / "here" / "summary.json").read_text()
    assert "NaN" not in text
    summary = json.loads(text)
    assert next(iter(summary)) == "analysis"
    assert (summary["analysis"], summary["f_n_hz"], summary["interface_pressure_mean_pa"]) == ("dwell", 150.25, [5e4])
    assert summary["peak_transmissibility"] is None
    assert summary["wall_time_s"] > 0


def test_the_results_carry_their_case_and_origin(wroll: Callable[..., Result], tmp_path: Path) -> None:
    wroll("run", TINY, "--out", "here")
    dataset = load_dataset(tmp_path / "here" / "results.nc")
    assert dataset["tip_displacement"].attrs["units"] == "m"
    assert yaml.safe_load(dataset.attrs["case_yaml"]) == load_case(TINY).resolved()
    assert dataset.attrs["case_hash"] == load_case(TINY).hash()
    assert dataset.attrs["complete"] is True
    assert dataset.attrs["flag"] is True
    assert dataset.attrs["provenance"]["versions"]["numpy"] == np.__version__


def test_output_can_be_switched_off(wroll: Callable[..., Result], tmp_path: Path) -> None:
    wroll("run", TINY, "--out", "here", "--set", "output={fields: none, figures: false}")
    assert not (tmp_path / "here" / "fields").exists()
    assert not (tmp_path / "here" / "figures").exists()


def test_a_done_case_is_not_computed_again(
    wroll: Callable[..., Result], analyses: FakeAnalyses, tmp_path: Path
) -> None:
    wroll("run", TINY, "--out", "here")
    before = tree(tmp_path / "here")
    again = wroll("run", TINY, "--out", "here")
    assert again.exit_code == 0
    assert "here: this case is already complete; delete the folder to run it again" in again.stdout
    assert "150.25 Hz" in again.stdout
    assert "figure      here/figures/tip.png" in again.stdout
    assert len(analyses.calls) == 1
    assert tree(tmp_path / "here") == before


@pytest.mark.parametrize("without", [None, "provenance.json"])
def test_results_of_another_case_are_never_written_over(
    wroll: Callable[..., Result], analyses: FakeAnalyses, tmp_path: Path, without: str | None
) -> None:
    wroll("run", TINY, "--out", "here")
    if without is not None:
        (tmp_path / "here" / without).unlink()
    before = tree(tmp_path / "here")
    other = wroll("run", TINY, "--out", "here", "--set", "contact.friction.mu=0.5", "--resume")
    assert other.exit_code == 2
    assert re.fullmatch(
        r"here: contains results of another case \(hash \w{12}, this case has \w{12}\); choose another --out, "
        "or delete "
        r"the folder\n",
        other.stderr,
    )
    assert tree(tmp_path / "here") == before
    assert len(analyses.calls) == 1


def test_foreign_folders_and_files_are_left_alone(wroll: Callable[..., Result], tmp_path: Path) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.txt").write_text("mine")
    foreign = wroll("run", TINY, "--out", "thesis")
    assert (foreign.exit_code, foreign.stderr) == (
        2, "thesis: is not empty and not a run folder; choose another --out or an empty folder\n",
    )  # fmt: skip
    file = wroll("run", TINY, "--out", "thesis/chapter.txt")
    assert (file.exit_code, file.stderr) == (2, "thesis/chapter.txt: is a file, not a folder; choose another --out\n")
    assert tree(tmp_path) == {"thesis/chapter.txt": b"mine"}


def test_a_folder_where_another_process_works_is_refused(wroll: Callable[..., Result], tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    with FileLock(tmp_path / "here" / ".lock"):
        (tmp_path / "here" / "case.yaml").write_text(load_case(TINY).resolved_yaml())
        done = wroll("run", TINY, "--out", "here")
    assert done.exit_code == 2
    assert "here: is in use by another process" in done.stderr


def test_a_bad_case_leaves_nothing_behind(wroll: Callable[..., Result], tmp_path: Path) -> None:
    done = wroll("run", TINY, "--set", "geometry.lenght=1")
    assert done.exit_code == 2
    assert done.stderr == f"{TINY}: --set geometry.lenght: unknown key, got 1; did you mean length?\n"
    assert done.stdout == ""
    assert tree(tmp_path) == {}


def test_dry_run_says_how_large_and_writes_nothing(
    wroll: Callable[..., Result], analyses: FakeAnalyses, tmp_path: Path
) -> None:
    done = wroll("run", TINY, "--dry-run")
    assert done.exit_code == 0
    assert re.search(r"dofs +1200\ninterface points +60\nsteps +160\nestimated seconds +1\.25\n", done.stdout)
    assert "warning: the mesh is coarse" in done.stdout
    assert analyses.calls == []
    assert tree(tmp_path) == {}


# ---- failure, interruption, resuming ------------------------------------------------------------


def test_a_step_that_does_not_converge_exits_3_and_keeps_what_was_computed(
    wroll: Callable[..., Result], analyses: FakeAnalyses, tmp_path: Path
) -> None:
    analyses.fails, analyses.leaves_checkpoint = failure(analyses.dataset()), True
    done = wroll("run", TINY, "--out", "here")
    assert done.exit_code == 3
    assert done.stderr.count("\n") == 1
    assert "step did not converge at t = 0.01 s after 30 iterations" in done.stderr
    assert "use smaller steps" in done.stderr
    assert "results up to this point are in here/results.nc" in done.stdout
    assert load_dataset(tmp_path / "here" / "results.nc").attrs["complete"] is False
    assert RunFolder(tmp_path / "here").status() == "not_converged"
    assert not (tmp_path / "here" / "summary.json").exists()
    assert "Traceback" not in done.output


def test_a_preload_that_does_not_converge_exits_3_without_results(
    wroll: Callable[..., Result], analyses: FakeAnalyses, tmp_path: Path
) -> None:
    analyses.fails = failure(None)
    assert wroll("run", TINY, "--out", "here").exit_code == 3
    assert not (tmp_path / "here" / "results.nc").exists()


def test_a_failed_run_does_not_block_the_folder_for_the_mended_case(
    wroll: Callable[..., Result], analyses: FakeAnalyses
) -> None:
    analyses.fails = failure(None)
    wroll("run", TINY, "--out", "here")
    analyses.fails = None
    assert wroll("run", TINY, "--out", "here", "--set", "integrator.steps_per_cycle=80").exit_code == 0


def test_an_interrupted_run_exits_130_and_resumes(
    wroll: Callable[..., Result], analyses: FakeAnalyses, tmp_path: Path
) -> None:
    analyses.fails, analyses.leaves_checkpoint = KeyboardInterrupt(), True
    stopped = wroll("run", TINY, "--out", "here")
    assert stopped.exit_code == 130
    assert stopped.stderr == f"interrupted; continue with: wroll run {TINY} --out here --resume\n"
    assert RunFolder(tmp_path / "here").status() == "interrupted"
    analyses.fails, analyses.leaves_checkpoint = None, False
    before = tree(tmp_path / "here")
    careless = wroll("run", TINY, "--out", "here")
    assert (careless.exit_code, tree(tmp_path / "here")) == (2, before)
    assert "contains an unfinished run of this case; add --resume, or delete the folder" in careless.stderr
    assert wroll("run", TINY, "--out", "here", "--resume").exit_code == 0
    assert [call["resume"] for call in analyses.calls] == [False, True]
    assert analyses.calls[1]["checkpoint"] == Path("here/checkpoint.npz")
    assert not (tmp_path / "here" / "checkpoint.npz").exists()
    provenance = RunFolder(tmp_path / "here").provenance()
    assert (provenance["status"], provenance["resumed"]) == ("complete", True)


def test_interrupted_before_a_checkpoint_says_so(wroll: Callable[..., Result], analyses: FakeAnalyses) -> None:
    analyses.fails = KeyboardInterrupt()
    stopped = wroll("run", TINY)
    assert stopped.exit_code == 130
    assert "before the first checkpoint" in stopped.stderr


def test_interrupted_analysis_without_checkpoints_promises_none(
    wroll: Callable[..., Result], analyses: FakeAnalyses
) -> None:
    analyses.fails = KeyboardInterrupt()
    stopped = wroll("run", TINY.parent / "lab_modal.yaml")
    assert stopped.exit_code == 130, stopped.stderr
    assert stopped.stderr == "interrupted; this analysis has no checkpoints: run the same command again\n"


def test_an_interrupt_while_the_end_is_recorded_leaves_the_record(
    wroll: Callable[..., Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record, ends = RunFolder.record, []

    def interrupted_once(folder: RunFolder, status: Status, **entries: object) -> None:
        if status != "running" and not ends:
            ends.append(status)
            raise KeyboardInterrupt
        record(folder, status, **entries)

    monkeypatch.setattr(RunFolder, "record", interrupted_once)
    assert wroll("run", TINY, "--out", "here").exit_code == 130
    assert ends == ["complete"]
    assert RunFolder(tmp_path / "here").status() == "complete"
    assert "already" in wroll("run", TINY, "--out", "here").stdout


def test_resume_without_a_checkpoint_starts_from_the_beginning(
    wroll: Callable[..., Result], analyses: FakeAnalyses
) -> None:
    done = wroll("run", TINY, "--out", "here", "--resume")
    assert done.exit_code == 0
    assert "here: no checkpoint to resume from, starting from the beginning" in done.stdout
    assert analyses.calls[0]["resume"] is False


def test_a_defect_of_the_program_is_not_hidden(
    wroll: Callable[..., Result], analyses: FakeAnalyses, tmp_path: Path
) -> None:
    analyses.fails = ZeroDivisionError("defect")
    done = wroll("run", TINY, "--out", "here")
    assert isinstance(done.exception, ZeroDivisionError)
    assert RunFolder(tmp_path / "here").status() == "failed"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_that_ends_in_an_error_of_native_code_is_no_failure(
    number: signal.Signals, wroll: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """An interrupted import of an extension module ends with ImportError; a batch must run such a case again."""

    def stopped_while_importing(self: FakeAnalyses, case: object, **keywords: object) -> None:
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(number)
        raise ImportError("initialization failed")

    outer = signal.signal(signal.SIGINT, signal.default_int_handler)  # tests in the background ignore Ctrl-C
    try:
        before = [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)]
        monkeypatch.setattr(FakeAnalyses, "run_analysis", stopped_while_importing)
        done = wroll("run", TINY, "--out", "here")
        assert done.exit_code == 130, done.output
        assert RunFolder(tmp_path / "here").status() == "interrupted"
        assert [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)] == before
    finally:
        signal.signal(signal.SIGINT, outer)


def test_a_terminated_job_stops_like_an_interrupted_one(tmp_path: Path) -> None:
    code = (
        "import sys, time; sys.path.insert(0, 'tests'); from support.fake_analyses import FakeAnalyses\n"
        "class Slow(FakeAnalyses):\n"
        "    def run_analysis(self, case, **keywords):\n"
        "        print('started', flush=True); time.sleep(3600)\n"
        "sys.modules['wroll_fem.analyses'] = Slow()\n"
        "import wroll_fem.cli; wroll_fem.cli.main()\n"
    )
    words = [sys.executable, "-c", code, "run", str(TINY), "--out", str(tmp_path / "here")]
    job = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=CONFIGS.parent)
    assert job.stdout is not None
    while "started" not in job.stdout.readline():
        assert job.poll() is None
    job.send_signal(signal.SIGTERM)
    _, errors = job.communicate(timeout=600)
    assert job.returncode == 130
    assert "interrupted" in errors
    assert "Traceback" not in errors


# ---- from Python --------------------------------------------------------------------------------


def test_run_case_is_the_same_from_python(analyses: FakeAnalyses, tmp_path: Path) -> None:
    report = SilentProgress()
    done = run_case(example_case(), tmp_path / "run", progress=report)
    assert done.summary["f_n_hz"] == 150.25
    assert done.figures == [tmp_path / "run" / "figures" / "tip.png"]
    assert report.warnings == ["the mesh is coarse; use mesh.axial >= 20"]
    assert report.stages == ["fake analysis", "figures"]
    assert run_case(example_case(), tmp_path / "run").already_done
