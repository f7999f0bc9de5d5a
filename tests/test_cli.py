"""The command line and the run folder, with a stand-in for the analyses."""

from __future__ import annotations

import fcntl
import io
import json
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import xarray as xr
import yaml
from typer.testing import CliRunner, Result

import wroll_fem
from wroll_fem import __version__, cli, example_case, load_case, progress
from wroll_fem.case import schema_text
from wroll_fem.errors import ConvergenceError
from wroll_fem.progress import SilentProgress, TerminalProgress
from wroll_fem.results import load_dataset
from wroll_fem.run_folder import RunFolder, plain
from wroll_fem.runner import run_case

CONFIGS = Path(__file__).resolve().parent.parent / "configs"
TINY = CONFIGS / "tiny.yaml"


class StandIn(ModuleType):
    """What `wroll_fem.analyses` offers, without finite elements."""

    def __init__(self) -> None:
        super().__init__("wroll_fem.analyses")
        self.calls: list[dict[str, Any]] = []
        self.fails: BaseException | None = None
        self.leaves_checkpoint = False

    def run_analysis(
        self, case: Any, *, progress: Any, checkpoint: Path | None = None, resume: bool = False
    ) -> xr.Dataset:
        self.calls.append({"case": case, "checkpoint": checkpoint, "resume": resume})
        with progress.stage("stand-in", 2, "steps") as stage:
            stage.update(1, "half")
            if self.leaves_checkpoint and checkpoint is not None:
                np.savez(checkpoint, step=1)
            if self.fails is not None:
                raise self.fails
            stage.update(2)
        return self.dataset()

    def dataset(self) -> xr.Dataset:
        attrs = {"seed": 3, "flag": True, "nothing": None, "list": [1.0, 2.0]}
        return xr.Dataset({"tip_displacement": ("time", [0.0, 1e-5])}, {"time": [0.0, 1e-4]}, attrs)

    def summarise(self, dataset: xr.Dataset, case: Any) -> dict[str, Any]:
        return {
            "f_n_hz": np.float64(150.25), "zeta": 0.0213, "peak_transmissibility": float("nan"), "dofs": 1200,
            "energy_balance_error": 0.0012, "friction_energy_j": 1.5e-3, "interface_pressure_mean_pa": np.array([5e4]),
        }  # fmt: skip

    def estimate(self, case: Any) -> dict[str, Any]:
        return {"dofs": 1200, "interface_points": 60, "steps": 160, "estimated_seconds": 1.25}

    def case_warnings(self, case: Any) -> list[str]:
        return ["the mesh is coarse; use mesh.axial >= 20"] if case.mesh.axial < 5 else []

    def write_fields(self, dataset: xr.Dataset, case: Any, folder: Path) -> None:
        (folder / "slip_map.vtu").write_text("fields")

    def write_figures(self, dataset: xr.Dataset, case: Any, folder: Path) -> list[Path]:
        path = folder / "tip.png"
        path.write_bytes(b"picture")
        return [path]


@pytest.fixture
def analyses(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    module = StandIn()
    monkeypatch.setitem(sys.modules, "wroll_fem.analyses", module)
    monkeypatch.setattr(wroll_fem, "analyses", module, raising=False)
    return module


@pytest.fixture
def wroll(analyses: StandIn, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()

    def call(*words: object) -> Result:
        return runner.invoke(cli.app, [str(word) for word in words])

    return call


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def failure(partial: xr.Dataset | None) -> ConvergenceError:
    error = ConvergenceError(
        "step did not converge", time_s=0.01, iterations=30, residual_history=[1.0, 0.5], advice="use smaller steps"
    )
    error.partial = partial  # type: ignore[attr-defined]
    return error


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
    assert "stand-in: done in" in log


def test_the_run_ends_with_a_table_and_the_paths(wroll: Callable[..., Result]) -> None:
    text = wroll("run", TINY, "--out", "here").stdout
    for line in (
        r"resonance f_n +150\.25 Hz",
        r"damping ratio zeta +0\.0213",
        r"energy balance error +0\.12%",
        r"friction energy +0\.0015 J",
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


def test_a_done_case_is_not_computed_again(wroll: Callable[..., Result], analyses: StandIn, tmp_path: Path) -> None:
    wroll("run", TINY, "--out", "here")
    before = tree(tmp_path / "here")
    again = wroll("run", TINY, "--out", "here")
    assert again.exit_code == 0
    assert "here: this case is already done; delete the folder to run it again" in again.stdout
    assert "150.25 Hz" in again.stdout
    assert "figure      here/figures/tip.png" in again.stdout
    assert len(analyses.calls) == 1
    assert tree(tmp_path / "here") == before


@pytest.mark.parametrize("without", [None, "provenance.json"])
def test_results_of_another_case_are_never_written_over(
    wroll: Callable[..., Result], analyses: StandIn, tmp_path: Path, without: str | None
) -> None:
    wroll("run", TINY, "--out", "here")
    if without is not None:
        (tmp_path / "here" / without).unlink()
    before = tree(tmp_path / "here")
    other = wroll("run", TINY, "--out", "here", "--set", "contact.friction.mu=0.5", "--resume")
    assert other.exit_code == 2
    assert re.fullmatch(
        r"here: holds results of another case \(hash \w{12}, this case has \w{12}\); choose another --out, or delete "
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
    with (tmp_path / "here" / "run.log").open("a") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
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
    wroll: Callable[..., Result], analyses: StandIn, tmp_path: Path
) -> None:
    done = wroll("run", TINY, "--dry-run")
    assert done.exit_code == 0
    assert re.search(r"dofs +1200\ninterface points +60\nsteps +160\nestimated seconds +1\.25\n", done.stdout)
    assert "warning: the mesh is coarse" in done.stdout
    assert analyses.calls == []
    assert tree(tmp_path) == {}


# ---- failure, interruption, resuming ------------------------------------------------------------


def test_a_step_that_does_not_converge_exits_3_and_keeps_what_was_computed(
    wroll: Callable[..., Result], analyses: StandIn, tmp_path: Path
) -> None:
    analyses.fails, analyses.leaves_checkpoint = failure(analyses.dataset()), True
    done = wroll("run", TINY, "--out", "here")
    assert done.exit_code == 3
    assert done.stderr.count("\n") == 1
    assert "step did not converge at t = 0.01 s after 30 iterations" in done.stderr
    assert "use smaller steps" in done.stderr
    assert "what was computed until then is in here/results.nc" in done.stdout
    assert load_dataset(tmp_path / "here" / "results.nc").attrs["complete"] is False
    assert RunFolder(tmp_path / "here").status() == "not_converged"
    assert not (tmp_path / "here" / "summary.json").exists()
    assert "Traceback" not in done.output


def test_a_preload_that_does_not_converge_exits_3_without_results(
    wroll: Callable[..., Result], analyses: StandIn, tmp_path: Path
) -> None:
    analyses.fails = failure(None)
    assert wroll("run", TINY, "--out", "here").exit_code == 3
    assert not (tmp_path / "here" / "results.nc").exists()


def test_a_failed_run_does_not_block_the_folder_for_the_mended_case(
    wroll: Callable[..., Result], analyses: StandIn
) -> None:
    analyses.fails = failure(None)
    wroll("run", TINY, "--out", "here")
    analyses.fails = None
    assert wroll("run", TINY, "--out", "here", "--set", "integrator.steps_per_cycle=80").exit_code == 0


def test_an_interrupted_run_exits_130_and_resumes(
    wroll: Callable[..., Result], analyses: StandIn, tmp_path: Path
) -> None:
    analyses.fails, analyses.leaves_checkpoint = KeyboardInterrupt(), True
    stopped = wroll("run", TINY, "--out", "here")
    assert stopped.exit_code == 130
    assert stopped.stderr == f"interrupted; go on with: wroll run {TINY} --out here --resume\n"
    assert RunFolder(tmp_path / "here").status() == "interrupted"
    analyses.fails, analyses.leaves_checkpoint = None, False
    before = tree(tmp_path / "here")
    careless = wroll("run", TINY, "--out", "here")
    assert (careless.exit_code, tree(tmp_path / "here")) == (2, before)
    assert "holds an unfinished run of this case; add --resume to go on, or delete the folder" in careless.stderr
    assert wroll("run", TINY, "--out", "here", "--resume").exit_code == 0
    assert [call["resume"] for call in analyses.calls] == [False, True]
    assert analyses.calls[1]["checkpoint"] == Path("here/checkpoint.npz")
    assert not (tmp_path / "here" / "checkpoint.npz").exists()
    provenance = RunFolder(tmp_path / "here").provenance()
    assert (provenance["status"], provenance["resumed"]) == ("complete", True)


def test_interrupted_before_a_checkpoint_says_so(wroll: Callable[..., Result], analyses: StandIn) -> None:
    analyses.fails = KeyboardInterrupt()
    stopped = wroll("run", TINY)
    assert stopped.exit_code == 130
    assert "before the first checkpoint" in stopped.stderr


def test_interrupted_analysis_without_checkpoints_promises_none(
    wroll: Callable[..., Result], analyses: StandIn
) -> None:
    analyses.fails = KeyboardInterrupt()
    stopped = wroll("run", TINY.parent / "lab_modal.yaml")
    assert stopped.exit_code == 130, stopped.stderr
    assert stopped.stderr == "interrupted; this analysis has no checkpoints: run the same command again\n"


def test_resume_without_a_checkpoint_starts_from_the_beginning(wroll: Callable[..., Result], analyses: StandIn) -> None:
    done = wroll("run", TINY, "--out", "here", "--resume")
    assert done.exit_code == 0
    assert "here: no checkpoint to resume from, starting from the beginning" in done.stdout
    assert analyses.calls[0]["resume"] is False


def test_a_defect_of_the_program_is_not_hidden(wroll: Callable[..., Result], analyses: StandIn, tmp_path: Path) -> None:
    analyses.fails = ZeroDivisionError("defect")
    done = wroll("run", TINY, "--out", "here")
    assert isinstance(done.exception, ZeroDivisionError)
    assert RunFolder(tmp_path / "here").status() == "failed"


def test_a_terminated_job_stops_like_an_interrupted_one(tmp_path: Path) -> None:
    code = (
        "import sys, time; from tests.test_cli import StandIn\n"
        "class Slow(StandIn):\n"
        "    def run_analysis(self, case, **keywords):\n"
        "        print('started', flush=True); time.sleep(60)\n"
        "sys.modules['wroll_fem.analyses'] = Slow()\n"
        "import wroll_fem.cli; wroll_fem.cli.main()\n"
    )
    words = [sys.executable, "-c", code, "run", str(TINY), "--out", str(tmp_path / "here")]
    job = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=CONFIGS.parent)
    assert job.stdout is not None
    while "started" not in job.stdout.readline():
        assert job.poll() is None
    job.send_signal(signal.SIGTERM)
    _, errors = job.communicate(timeout=20)
    assert job.returncode == 130
    assert "interrupted" in errors
    assert "Traceback" not in errors


# ---- validate, schema, mesh, plot, info ---------------------------------------------------------


def test_validate_checks_every_file_and_tells_warnings(wroll: Callable[..., Result], tmp_path: Path) -> None:
    good = wroll("validate", TINY, CONFIGS / "lab_sweep.yaml")
    assert good.exit_code == 0
    assert good.stdout.splitlines() == [
        f"{TINY}: OK",
        f"{TINY}: warning: the mesh is coarse; use mesh.axial >= 20",
        f"{CONFIGS / 'lab_sweep.yaml'}: OK",
    ]
    mixed = wroll("validate", tmp_path / "none.yaml", TINY)
    assert mixed.exit_code == 2
    assert mixed.stderr.startswith(f"{tmp_path / 'none.yaml'}: file not found; ")
    assert f"{TINY}: OK" in mixed.stdout


def test_schema_goes_to_the_screen_or_to_a_file(wroll: Callable[..., Result], tmp_path: Path) -> None:
    assert wroll("schema").stdout == schema_text()
    assert wroll("schema", "--out", tmp_path / "new" / "schema.json").exit_code == 0
    assert (tmp_path / "new" / "schema.json").read_text() == schema_text()
    blocked = wroll("schema", "--out", tmp_path)
    assert blocked.exit_code == 2
    assert "cannot be written" in blocked.stderr


def test_mesh_writes_gmsh_and_vtk_files(wroll: Callable[..., Result], tmp_path: Path) -> None:
    done = wroll("mesh", TINY, "--out", "mesh", "--set", "mesh.axial=2")
    assert done.exit_code == 0, done.output
    assert done.stdout.splitlines() == ["mesh/mesh.msh", "mesh/mesh.vtu"]
    assert '"layer_01_base"' in (tmp_path / "mesh" / "mesh.msh").read_text(errors="replace")
    (tmp_path / "file").write_text("mine")
    refused = wroll("mesh", TINY, "--out", "file")
    assert (refused.exit_code, refused.stderr) == (2, "file: is a file, not a folder; choose another --out\n")


def test_plot_draws_the_figures_again(wroll: Callable[..., Result], tmp_path: Path) -> None:
    wroll("run", TINY, "--out", "here")
    shutil.rmtree(tmp_path / "here" / "figures")
    done = wroll("plot", "here")
    assert (done.exit_code, done.stdout) == (0, "here/figures/tip.png\n")
    assert (tmp_path / "here" / "figures" / "tip.png").is_file()


def test_plot_of_something_else_is_refused(wroll: Callable[..., Result], tmp_path: Path) -> None:
    nothing = wroll("plot", "nowhere")
    assert nothing.exit_code == 2
    assert nothing.stderr.startswith("nowhere: is not a run folder (no case.yaml); ")
    wroll("run", TINY, "--out", "here")
    (tmp_path / "here" / "results.nc").unlink()
    assert wroll("plot", "here").exit_code == 2


def test_info_names_every_library_and_a_broken_one(
    wroll: Callable[..., Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    from wroll_fem import environment

    def broken() -> str:
        raise ImportError("no such library")

    parts = {name: (lambda: "1.2") for name in environment._PARTS}
    monkeypatch.setattr(environment, "_PARTS", {**parts, "pyvista": broken})
    optional = wroll("info")
    assert optional.exit_code == 0
    names = ["python", "dolfinx", "petsc", "slepc", "numpy", "scipy", "gmsh", "numba", "xarray", "pyvista", "h5py"]
    assert [line.split()[0] for line in optional.stdout.splitlines()] == ["wroll_fem", *names]
    assert re.search(r"pyvista +- +DOES NOT WORK: ImportError: no such library", optional.stdout)
    monkeypatch.setattr(environment, "_PARTS", {**parts, "dolfinx": broken})
    assert wroll("info").exit_code == 1


def test_unknown_options_and_missing_arguments_exit_2(wroll: Callable[..., Result]) -> None:
    assert wroll("run").exit_code == 2
    assert wroll("run", TINY, "--nonsense").exit_code == 2
    assert wroll("--version").stdout == f"wroll_fem {__version__}\n"


def test_the_installed_command_answers_a_bad_case_fast_and_in_one_line() -> None:
    started = time.monotonic()
    words = [sys.executable, "-m", "wroll_fem.cli", "run", str(TINY), "--set", "mandrel.material.nu=0.7"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith(f"{TINY}: --set mandrel.material.nu: must be less than 0.5, got 0.7; ")
    assert done.stderr.count("\n") == 1
    assert time.monotonic() - started < 5  # about 0.5 s on an idle machine


# ---- progress, plain values, Python interface ---------------------------------------------------


def test_progress_without_a_terminal_is_sparse_plain_lines(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    clock = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    stream = io.StringIO()
    with TerminalProgress(stream) as report:
        report.log_to(tmp_path / "run.log")
        with report.stage("sweep", 1000, "steps") as stage:
            for step in range(1, 1001):
                clock[0] += 0.1
                stage.update(step, "125 Hz")
        report.warning("coarse")
    lines = stream.getvalue().splitlines()
    assert lines[0] == "sweep (1000 steps) ..."
    assert re.fullmatch(r"sweep: 10% \((99|100) of 1000 steps\), 1 min 30 s left, 125 Hz", lines[1])
    assert lines[-2:] == ["sweep: done in 1 min 40 s", "warning: coarse"]
    assert len(lines) == 12
    log = (tmp_path / "run.log").read_text().splitlines()
    assert log[0].endswith(" sweep (1000 steps): start")
    assert all(re.match(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", line) for line in log)
    assert log[-1].endswith(" warning: coarse")


def test_progress_on_a_terminal_is_a_bar_and_nested_stages_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")  # a dumb one gets no bar
    stream = io.StringIO()
    with TerminalProgress(stream, terminal=True) as report:
        with report.stage("outer", 2) as outer, report.stage("inner", 3, "points") as inner:
            inner.update(3)
            report.info("between [brackets]")
            outer.update(1)
        report.info("after")
    text = stream.getvalue()
    assert "━" in text
    assert "between [brackets]" in text
    assert "inner: done in" in text
    assert text.rstrip().endswith("after")


def test_a_stopped_stage_is_logged_as_stopped() -> None:
    stream = io.StringIO()
    report = TerminalProgress(stream)
    with pytest.raises(ZeroDivisionError), report.stage("sweep", 0):
        raise ZeroDivisionError
    assert "sweep: stopped in" in stream.getvalue()


def test_plain_turns_numpy_and_odd_numbers_into_json() -> None:
    value = {
        "a": np.float32(1.5),
        "b": np.array([[1, 2]]),
        "c": (np.inf, -np.inf, np.nan),
        "d": Path("x"),
        3: np.bool_(True),
    }
    assert plain(value) == {"a": 1.5, "b": [[1, 2]], "c": [None, None, None], "d": "x", "3": True}


def test_run_case_is_the_same_from_python(analyses: StandIn, tmp_path: Path) -> None:
    report = SilentProgress()
    done = run_case(example_case(), tmp_path / "run", progress=report)
    assert done.summary["f_n_hz"] == 150.25
    assert done.figures == [tmp_path / "run" / "figures" / "tip.png"]
    assert report.warnings == ["the mesh is coarse; use mesh.axial >= 20"]
    assert report.stages == ["stand-in", "figures"]
    assert run_case(example_case(), tmp_path / "run").already_done
