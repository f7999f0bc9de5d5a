"""Run folders on a storage that fails: killed at any file operation, disk full at any write, damaged files, links."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from filelock import FileLock
from support.fake_analyses import CONFIGS, TINY, FakeAnalyses, tree
from support.faults import KILLED, Fault, with_fault
from typer.testing import Result

from wroll_fem import cli, load_case
from wroll_fem.errors import InputError
from wroll_fem.jobs.batch import run_grid
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.grid import load_grid
from wroll_fem.results.dataset import load_dataset

Wroll = Callable[..., Result]


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without asking git for the revision, which takes most of the time of a run with fake analyses."""
    monkeypatch.setattr("wroll_fem.jobs.result_folder.provenance", dict)
    monkeypatch.setattr("wroll_fem.results.dataset.provenance", dict)


def run_tiny() -> None:
    cli.app(["run", str(TINY), "--out", "here", "--resume"], prog_name="wroll")


def consistent(folder: RunFolder) -> None:
    """A folder that counts as complete has its results; files have their name only when they are whole."""
    if folder.path.is_dir() and folder.case_file.is_file() and folder.check(load_case(TINY), resume=True) == "complete":
        assert folder.summary()["f_n_hz"] == 150.25
        assert load_dataset(folder.results_file).attrs["complete"] is True


@pytest.mark.parametrize("first", [1, pytest.param(0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("fault", "once"), [("kill", False), ("full", False), ("full", True)])
def test_a_run_survives_a_fault_at_every_file_operation(
    fault: Fault, once: bool, first: int, wroll: Wroll, analyses: FakeAnalyses, tmp_path: Path, quick: None
) -> None:
    """Every seventh operation here, so that each kind occurs; all of them in the slow test."""
    analyses.leaves_checkpoint = True
    codes = set()
    for number in range(1 + first, 200, 7 if first else 1):
        folder = RunFolder(tmp_path / "here")
        ended = with_fault(run_tiny, tmp_path / "here", fault, number, once=once)
        if not ended.reached:
            break
        codes.add(ended.code)
        consistent(folder)
        if fault == "full" and ended.code:
            assert ended.code == 4, (number, ended.errors)
            assert ended.errors.count("\n") == 1, ended.errors
            assert "No space left on device); free some room there, then run the same command again" in ended.errors
        again = wroll("run", TINY, "--out", "here", "--resume")
        assert again.exit_code == 0, (number, again.output)
        assert folder.status() == "complete"
        np.testing.assert_array_equal(load_dataset(folder.results_file)["tip_displacement"], [0.0, 1e-5])
        assert not any(name.endswith(".partial") for name in tree(folder.path))
        shutil.rmtree(folder.path)
    assert number > 20, "operations of a run"
    assert codes <= ({KILLED} if fault == "kill" else {0, 4})


def test_the_end_is_recorded_on_a_full_disk(wroll: Wroll, analyses: FakeAnalyses, tmp_path: Path, quick: None) -> None:
    """A disk that is full from one file on, with the reserve as the only room: provenance.json says what happened."""
    for number in range(1, 100, 4):  # results.nc takes four operations
        if "results.nc" in with_fault(run_tiny, tmp_path / "here", "full", number, freed_by=".reserve").errors:
            break
        shutil.rmtree(tmp_path / "here", ignore_errors=True)
    held = RunFolder(tmp_path / "here").provenance()
    assert (held["status"], held["exit_code"]) == ("failed", 4)
    assert "results.nc: cannot be written (No space left on device)" in held["error"]


@pytest.mark.skipif(os.geteuid() != 0, reason="mounting needs root")
@pytest.mark.slow
def test_a_disk_that_is_full_ends_a_run_with_one_line(tmp_path: Path) -> None:
    """HDF5 ended the process with a segmentation fault here (exit code 139)."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", str(disk)], check=False).returncode:
        pytest.skip("no tmpfs here")
    try:
        (disk / "fill").write_bytes(bytes(2**24 - 40 * 1024))
        words = [sys.executable, "-m", "wroll_fem.cli", "run", str(CONFIGS / "oscillator.yaml"), "--out"]
        ended = subprocess.run([*words, str(disk / "run")], capture_output=True, text=True, cwd=CONFIGS.parent)
        assert (ended.returncode, ended.stderr.count("\n")) == (4, 1), ended.stderr
        held = RunFolder(disk / "run").provenance()
        assert (held["status"], held["exit_code"]) == ("failed", 4)
        assert not list((disk / "run").glob("*.partial"))
        (disk / "fill").unlink()
        again = subprocess.run([*words, str(disk / "run"), "--resume"], capture_output=True, text=True, check=False)
        assert again.returncode == 0, again.stderr
        assert RunFolder(disk / "run").status() == "complete"
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def test_standard_output_may_be_full() -> None:
    words = [sys.executable, "-m", "wroll_fem.cli", "validate", str(TINY)]
    with open("/dev/full", "w") as full:
        ended = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 4
    assert ended.stderr.startswith("standard output: cannot be written (No space left on device); ")
    assert ended.stderr.count("\n") == 1


# ---- damaged files ------------------------------------------------------------------------------


def damaged(file: Path, how: str) -> None:
    content = file.read_bytes()
    middle = len(content) // 2
    changes = {
        "empty": b"", "cut": content[:middle], "without its last byte": content[:-1],
        "one bit": content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :], "other": b"{",
    }  # fmt: skip
    file.write_bytes(changes[how])


@pytest.mark.parametrize("how", ["empty", "cut", "without its last byte", "one bit"])
def test_a_damaged_checkpoint_is_refused_with_a_remedy_that_works(
    how: str, wroll: Wroll, analyses: FakeAnalyses, tmp_path: Path
) -> None:
    analyses.fails, analyses.leaves_checkpoint = KeyboardInterrupt(), True
    wroll("run", TINY, "--out", "here")
    analyses.fails, analyses.leaves_checkpoint = None, False
    checkpoint = tmp_path / "here" / "checkpoint.npz"
    damaged(checkpoint, how)
    before = tree(tmp_path / "here")
    for words in ((), ("--resume",)):
        done = wroll("run", TINY, "--out", "here", *words)
        assert (done.exit_code, tree(tmp_path / "here")) == (2, before)
        assert done.stderr.startswith("here/checkpoint.npz: the checkpoint ")
        assert done.stderr.endswith(
            "; delete this file and run the same command again, which starts from the beginning\n"
        )
        assert done.stderr.count("\n") == 1
    checkpoint.unlink()
    assert wroll("run", TINY, "--out", "here", "--resume").exit_code == 0


@pytest.mark.parametrize("how", ["empty", "cut", "without its last byte", "one bit"])
def test_damaged_results_are_not_complete(how: str, wroll: Wroll, analyses: FakeAnalyses, tmp_path: Path) -> None:
    wroll("run", TINY, "--out", "here")
    results = tmp_path / "here" / "results.nc"
    damaged(results, how)
    if how == "without its last byte":  # the content is whole; readers see that the checksum is missing
        with pytest.raises(InputError, match=r"its checksum is missing\); delete this file and run the case again"):
            load_dataset(results)
        return
    for words in (("run", TINY, "--out", "here"), ("plot", "here"), ("plot", "here/results.nc")):
        done = wroll(*words)
        assert (done.exit_code, done.stderr.count("\n")) == (2, 1), done.output
        assert re.match("here/results.nc: (is empty|is damaged|not a readable NetCDF file)", done.stderr)
        assert done.stderr.endswith("; delete this file and run the case again\n")
    results.unlink()
    assert wroll("run", TINY, "--out", "here").exit_code == 0
    assert load_dataset(results).attrs["complete"] is True


@pytest.mark.parametrize("how", ["empty", "cut", "other"])
@pytest.mark.parametrize("name", ["summary.json", "provenance.json"])
def test_a_damaged_record_is_refused_with_a_remedy_that_works(
    name: str, how: str, wroll: Wroll, analyses: FakeAnalyses, tmp_path: Path
) -> None:
    wroll("run", TINY, "--out", "here")
    file = tmp_path / "here" / name
    damaged(file, how)
    done = wroll("run", TINY, "--out", "here")
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert done.stderr.startswith(f"here/{name}: cannot be read (")
    assert done.stderr.endswith("; delete this file and run the case again\n")
    file.unlink()
    assert wroll("run", TINY, "--out", "here").exit_code == 0


@pytest.mark.parametrize("name", ["results.nc", "summary.json", "provenance.json", "case.yaml", "checkpoint.npz"])
def test_a_folder_in_place_of_a_file_is_no_traceback(
    name: str, wroll: Wroll, analyses: FakeAnalyses, tmp_path: Path
) -> None:
    if name == "checkpoint.npz":
        analyses.fails, analyses.leaves_checkpoint = KeyboardInterrupt(), True
    wroll("run", TINY, "--out", "here")
    (tmp_path / "here" / name).unlink()
    (tmp_path / "here" / name).mkdir()
    for words in ((), ("--resume",)):
        done = wroll("run", TINY, "--out", "here", *words)
        assert done.exception is None or isinstance(done.exception, SystemExit)
        assert done.exit_code == (0 if name == "case.yaml" else 2), done.output  # a new case.yaml needs no old one
        assert name == "case.yaml" or done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "entry",
    [
        '"modes_hz": "x"',
        '"modes_hz": 5',
        '"dofs": 1.5',
        '"f_n_hz": 1' + 400 * "0",
        '"zeta": "x"',
        '"f_n_hz": {"a": "b"}',
    ],
)
def test_a_summary_with_wrong_types_is_refused(entry: str, wroll: Wroll, tmp_path: Path) -> None:
    wroll("run", TINY, "--out", "here")
    file = tmp_path / "here" / "summary.json"
    file.write_text(f'{{"analysis": "dwell", {entry}}}')
    done = wroll("run", TINY, "--out", "here")
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1), done.exception
    assert re.search(r"summary.json: entry \w+ has a wrong type; delete this file and run the case again", done.stderr)


# ---- links, and two processes at once -----------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["run.log", ".lock", "figures", "fields", "case.yaml.partial", "results.nc.partial", "summary.json",
             ".reserve", "figures/tip.png", "figures/tip.png.partial"],
)  # fmt: skip
def test_nothing_is_written_through_a_link(name: str, wroll: Wroll, analyses: FakeAnalyses, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    victim = outside / "mine.txt"
    victim.write_text("mine")
    link = tmp_path / "here" / name
    link.parent.mkdir(parents=True)
    link.symlink_to(outside if name in ("figures", "fields") else victim)
    if name in ("summary.json", "figures/tip.png", "figures/tip.png.partial"):
        (tmp_path / "here" / "case.yaml").write_text(load_case(TINY).resolved_yaml())
    done = wroll("run", TINY, "--out", "here")
    assert tree(outside) == {"mine.txt": b"mine"}
    if name in ("run.log", ".lock", "figures", "fields"):
        assert done.exit_code == 2
        assert f"here/{name}: is a symbolic link; delete it: nothing is written through links" in done.stderr or (
            "is not empty and not a run folder" in done.stderr
        )
    else:
        assert done.exit_code == 0, done.output
        assert RunFolder(tmp_path / "here").status() == "complete"


def test_a_second_run_is_told_that_the_first_is_at_work(wroll: Wroll, analyses: FakeAnalyses, tmp_path: Path) -> None:
    """The checkpoint of a run at work is not that of an unfinished run, whose folder one may delete."""
    analyses.fails, analyses.leaves_checkpoint = KeyboardInterrupt(), True
    wroll("run", TINY, "--out", "here")
    before = tree(tmp_path / "here")
    with FileLock(tmp_path / "here" / ".lock"):
        for words in ((), ("--resume",)):
            done = wroll("run", TINY, "--out", "here", *words)
            assert (done.exit_code, done.stderr) == (
                2, "here: is in use by another process; wait for it, or choose another --out\n",
            )  # fmt: skip
    assert tree(tmp_path / "here") == before


def test_a_second_batch_is_told_that_the_first_is_at_work(tmp_path: Path) -> None:
    path, out = tmp_path / "grid.yaml", tmp_path / "out"
    path.write_text(f"base: {TINY}\ngrid: {{preload.pressure: [1.0e+5, 3.0e+4]}}\n")
    out.mkdir()
    with FileLock(out / ".lock"), pytest.raises(InputError, match="out: is in use by another process; wait for it"):
        run_grid(load_grid(path), out)
    assert tree(out) == {".lock": b""}


def test_a_case_that_a_full_disk_stopped_is_run_again_by_the_batch(tmp_path: Path) -> None:
    from wroll_fem.jobs.batch import unfinished_jobs

    path = tmp_path / "grid.yaml"
    path.write_text(f"base: {TINY}\ngrid: {{preload.pressure: [1.0e+5, 3.0e+4]}}\n")
    grid = load_grid(path)
    for member, code in zip(grid.members, (3, 4), strict=True):
        folder = RunFolder(tmp_path / "out" / member.name)
        folder.path.mkdir(parents=True)
        folder.record("running", case_hash=member.case.hash())
        folder.record("failed", error="x", exit_code=code)
    assert [job.folder.name for job in unfinished_jobs(grid, tmp_path / "out")] == [grid.members[1].name]
