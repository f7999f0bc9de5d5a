"""`wroll batch` stopped at any point: nothing that is finished is lost or run again, what was begun goes on."""

from __future__ import annotations

import csv
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from filelock import FileLock
from support.here_pool import HerePool
from support.paths import ROOT

from wroll_fem.errors import ConvergenceError
from wroll_fem.jobs import batch
from wroll_fem.jobs.batch import run_grid
from wroll_fem.jobs.executors import Ended, Job, LocalPool
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.grid import load_grid
from wroll_fem.jobs.run import run_case
from wroll_fem.progress import SilentProgress

CONFIGS = ROOT / "configs"
LONG = f"""
base: {CONFIGS / "oscillator.yaml"}
grid:
  analysis: [dwell]
  excitation: [{{kind: dwell, amplitude: 6.0, frequency: 11.0, cycles: 400}}]
  contact.friction: [{{law: penalty_coulomb, mu: 0.3, elastic_slip: 1.0e-5}}]
  integrator.steps_per_cycle: [60, 20]
  solver.checkpoint_seconds: [0.1]
  output.figures: [false]
"""
QUICK = f"""
base: {CONFIGS / "two_dof.yaml"}
grid:
  two_dof.friction_capacity: [[3], [5], [10]]
  two_dof.omega.points: [20]
  output.figures: [false]
"""
TINY = f"base: {CONFIGS / 'tiny.yaml'}\ngrid: {{preload.pressure: [1.0e+5, 3.0e+4], output.figures: [false]}}\n"


def grid_file(folder: Path, text: str) -> Path:
    path = folder / "grid.yaml"
    path.write_text(text)
    return path


def started(path: Path, out: Path, *words: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "wroll_fem.cli", "batch", str(path), "--out", str(out), *words]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT, preexec_fn=_hear_sigint
    )


def _hear_sigint() -> None:
    """Ctrl-C as in a terminal, also where pytest itself was started with `&` and ignores it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


HANGS = 600.0
"""s: no test waits for this long unless what it waits for never happens."""


def until(found: Callable[[], object]) -> None:
    end = time.monotonic() + HANGS
    while not found():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def rows(out: Path) -> list[dict[str, str]]:
    with (out / "batch.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


def finished(out: Path) -> dict[str, tuple[int, int]]:
    """Name -> (time of writing, inode) of the summary of every case that is complete."""
    held = [RunFolder(path) for path in sorted(out.glob("*/"))]
    files = {f.path.name: f.summary_file.stat() for f in held if f.status() == "complete"}
    return {name: (stat.st_mtime_ns, stat.st_ino) for name, stat in files.items()}


@pytest.mark.parametrize("kill", [signal.SIGINT, pytest.param(signal.SIGKILL, marks=pytest.mark.slow)])
def test_a_stopped_batch_goes_on_from_the_checkpoint(
    kill: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, out = grid_file(tmp_path, LONG), tmp_path / "out"
    job = started(path, out)
    members = load_grid(path).members
    first, second = (RunFolder(out / member.name) for member in members)
    until(lambda: first.checkpoint_file.is_file() or job.poll() is not None)
    assert job.poll() is None
    job.send_signal(kill)
    _, errors = job.communicate(timeout=HANGS)
    if kill == signal.SIGKILL:  # its case follows: it saves itself, then it releases its folder
        FileLock(first.lock_file).acquire(timeout=HANGS).lock.release()
    else:
        assert (job.returncode, errors) == (130, "interrupted; run the same command again to continue\n")
        assert rows(out) == []
    assert first.status() == "interrupted"
    assert first.checkpoint_file.is_file()
    assert not second.path.exists()
    if kill == signal.SIGKILL:
        job = started(path, out)
        _, errors = job.communicate(timeout=HANGS)
        assert job.returncode == 0, errors
    else:  # what the command does, without the seconds in which processes load their libraries
        monkeypatch.setattr(batch, "LocalPool", HerePool)
        run_grid(load_grid(path), out)
    assert [row["status"] for row in rows(out)] == ["complete", "complete"]
    assert [folder.provenance()["resumed"] for folder in (first, second)] == [True, False]
    whole = run_case(members[0].case, tmp_path / "whole").summary
    assert first.summary()["friction_energy_j"] == whole["friction_energy_j"]  # as if nothing had happened


@pytest.mark.slow
def test_a_batch_killed_at_random_loses_and_repeats_nothing(tmp_path: Path) -> None:
    path, out = grid_file(tmp_path, QUICK), tmp_path / "out"
    chance = random.Random(5)
    kept: dict[str, tuple[int, int]] = {}
    for kill in (signal.SIGTERM, signal.SIGKILL, None):
        job = started(path, out, "--workers", "2")
        if kill is not None:
            time.sleep(chance.uniform(2.0, 6.0))
            job.send_signal(kill)
        _, errors = job.communicate(timeout=HANGS)
        assert "Traceback" not in errors
        assert job.returncode in (
            {None: (0,), signal.SIGTERM: (0, 130, -signal.SIGTERM)}.get(kill, (0, -signal.SIGKILL))
        )
        now = finished(out)
        assert kept.items() <= now.items()  # still there, and not written again
        kept = now
    assert len(kept) == 3
    assert [row["status"] for row in rows(out)] == ["complete"] * 3


@pytest.mark.parametrize("left", [["run.log"], [".lock", "run.log", "case.yaml.partial"]])
def test_a_run_killed_while_it_opens_its_folder_blocks_nothing(left: list[str], tmp_path: Path) -> None:
    grid = load_grid(grid_file(tmp_path, TINY))
    folder = RunFolder(tmp_path / "out" / grid.members[0].name)
    folder.path.mkdir(parents=True)
    for name in left:
        (folder.path / name).write_text("")
    assert folder.check(grid.members[0].case) == "new"


def test_an_orphan_still_at_work_is_waited_for(tmp_path: Path) -> None:
    """A process that outlives its batch holds the folder; the next batch waits for it in place of failing."""
    grid = load_grid(grid_file(tmp_path, QUICK.replace("[[3], [5], [10]]", "[[3]]")))
    folder = RunFolder(tmp_path / "out" / grid.members[0].name)
    folder.path.mkdir(parents=True)
    hold = f"lock = FileLock({str(folder.lock_file)!r}); lock.acquire(); print('held', flush=True)"
    code = f"import time; from filelock import FileLock; {hold}; time.sleep(2)"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as orphan:
        assert orphan.stdout is not None
        assert orphan.stdout.readline() == "held\n"
        [outcome] = run_grid(grid, tmp_path / "out")
    assert outcome.status == "complete"


class Busy(HerePool):
    """Pool with cases of another batch, and with cases that have ended a moment ago."""

    def submit(self, jobs: Sequence[Job]) -> list[Future[Ended]]:
        self.names = [job.folder.name for job in jobs]
        return super().submit(jobs)

    def at_work(self) -> dict[str, float]:
        return dict.fromkeys(("of another batch", *self.names), 0.0)  # since 1970


class Told(SilentProgress):
    """Keeps what the display of a batch shows."""

    def __init__(self) -> None:
        super().__init__()
        self.shown: list[tuple[str, float | None]] = []

    @contextmanager
    def stage(self, name: str, total: int, unit: str = "") -> Iterator[Any]:
        told = self.shown
        yield SimpleNamespace(update=lambda _, note="", left=None: told.append((note, left)))


def test_the_display_counts_the_cases_of_its_own_batch_that_have_not_ended(tmp_path: Path) -> None:
    told = Told()
    run_grid(load_grid(grid_file(tmp_path, QUICK)), tmp_path / "out", pool=Busy(1), progress=told)
    assert told.shown == [("", 0.0)]  # all have ended


# ---- failed cases ----------------------------------------------------------------------------------


@pytest.fixture
def pool(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the cases that a stand-in for processes was asked to run; each ends as its folder says."""
    asked: list[str] = []

    def run(self: LocalPool, job: Job) -> Ended:
        asked.append(job.folder.name)
        return Ended(3, "stand-in")

    monkeypatch.setattr(LocalPool, "_run", run)
    return asked


def ended(folder: RunFolder, case: object, status: str, **entries: object) -> None:
    """Folder of a run that came to an end without results."""
    folder.path.mkdir(parents=True)
    folder.case_file.write_text(case.resolved_yaml())  # type: ignore[attr-defined]
    folder.record("running", case_hash=case.hash())  # type: ignore[attr-defined]
    folder.record(status, **entries)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("status", "again"), [("not_converged", False), ("failed", False), ("interrupted", True), ("running", True)]
)
def test_what_failed_stays_so_until_a_retry_and_what_was_stopped_goes_on(
    status: str, again: bool, pool: list[str], tmp_path: Path
) -> None:
    grid = load_grid(grid_file(tmp_path, TINY))
    one, other = (member.name for member in grid.members)
    ended(RunFolder(tmp_path / one), grid.members[0].case, status, error="no luck\nat all", exit_code=3)
    progress = SilentProgress()
    outcomes = run_grid(grid, tmp_path, progress=progress)
    assert pool == ([one, other] if again else [other])
    if not again:
        assert (outcomes[0].status, outcomes[0].error, outcomes[0].exit_code) == ("failed", "no luck", 3)
        assert progress.infos[0] == f"1 of 2  {one}: FAILED before: no luck"
    assert [outcome.tried for outcome in outcomes] == [again, True]
    assert [row["status"] for row in rows(tmp_path)] == ["failed", "failed"]
    pool.clear()
    assert all(outcome.tried for outcome in run_grid(grid, tmp_path, retry=True))
    assert sorted(pool) == sorted([one, other])


def test_a_failure_of_another_case_or_an_older_program_is_no_obstacle(pool: list[str], tmp_path: Path) -> None:
    grid = load_grid(grid_file(tmp_path, TINY))
    one, other = grid.members
    ended(RunFolder(tmp_path / one.name), other.case, "failed", error="of another case")
    ended(RunFolder(tmp_path / other.name), other.case, "not_converged")  # without its message
    outcomes = run_grid(grid, tmp_path)
    assert pool == [one.name]
    assert (outcomes[1].error, outcomes[1].exit_code) == ("see its run.log", ConvergenceError.exit_code)


def test_why_a_run_failed_stands_in_its_folder(tmp_path: Path) -> None:
    case = load_grid(grid_file(tmp_path, LONG)).members[0].case
    stuck = case.changed("solver.max_iterations=1", "solver.max_cuts=1")
    with pytest.raises(ConvergenceError) as caught:
        run_case(stuck, tmp_path / "run")
    held = RunFolder(tmp_path / "run").provenance()
    assert (held["status"], held["error"], held["exit_code"]) == ("not_converged", str(caught.value), 3)


def test_a_batch_of_nothing_new_starts_no_stage(pool: list[str], tmp_path: Path) -> None:
    grid = load_grid(grid_file(tmp_path, TINY))
    for member in grid.members:
        ended(RunFolder(tmp_path / member.name), member.case, "failed", error="x", exit_code=1)
    progress = SilentProgress()
    run_grid(grid, tmp_path, progress=progress)
    assert progress.stages == []
    run_grid(batch.Grid(grid.source, grid.members, []), tmp_path, retry=True, progress=progress)
    assert progress.stages == ["batch"]
