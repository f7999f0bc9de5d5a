"""`wroll batch --scheduler`: a real Dask scheduler with real workers on this machine, one of them killed at work."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import xarray as xr
from support.paths import ROOT
from typer.testing import CliRunner

from wroll_fem import cli
from wroll_fem.jobs.batch import run_grid
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.grid import load_grid

GRID = f"""
base: {ROOT / "configs" / "oscillator.yaml"}
grid:
  analysis: [dwell]
  excitation: [{{kind: dwell, amplitude: 6.0, frequency: 11.0, cycles: 800}}]
  integrator.alpha: [-0.05, -0.1]
  solver.checkpoint_seconds: [0.3]
  output.figures: [false]
  output.fields: [none]
"""


def until(found: Callable[[], object], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not found():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


def dask(part: str, *words: str) -> subprocess.Popen[bytes]:
    module = f"distributed.cli.dask_{part}"
    command = [sys.executable, "-m", module, *words, "--no-dashboard"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=ROOT)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Address of a scheduler, and its two workers of one thread each."""
    file = tmp_path / "scheduler.json"
    scheduler = dask("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
    workers: list[subprocess.Popen[bytes]] = []
    try:
        until(lambda: file.is_file() and file.read_text().strip().endswith("}"))
        address = json.loads(file.read_text())["address"]
        workers += [dask("worker", address, "--nthreads", "1", "--no-nanny", "--name", name) for name in ("a", "b")]
        yield address, workers
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


@pytest.mark.slow
def test_the_table_is_that_of_local_runs_although_a_worker_dies(
    cluster: tuple[str, list[subprocess.Popen[bytes]]], tmp_path: Path
) -> None:
    address, workers = cluster
    path = tmp_path / "grid.yaml"
    path.write_text(GRID)
    command = [sys.executable, "-m", "wroll_fem.cli", "batch", str(path), "--out", str(tmp_path / "there")]
    job = subprocess.Popen(
        [*command, "--scheduler", address], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    folders = [RunFolder(tmp_path / "there" / member.name) for member in load_grid(path).members]
    until(lambda: sum(folder.checkpoint_file.is_file() for folder in folders) == 2, 120.0)
    os.kill(workers[0].pid, signal.SIGKILL)
    _, errors = job.communicate(timeout=300)
    assert job.returncode == 0, errors
    assert any(folder.provenance().get("resumed") for folder in folders)  # the killed worker's case went on
    outcomes = run_grid(load_grid(path), tmp_path / "here", workers=2)
    assert {o.status for o in outcomes} == {"complete"}
    with contextlib.ExitStack() as stack:
        here, there = (
            stack.enter_context(xr.open_dataset(tmp_path / side / "batch.nc", engine="h5netcdf")).load()
            for side in ("here", "there")
        )
    timed = {name for name in here if str(name).endswith("_time_s")}
    assert set(here) == set(there)
    xr.testing.assert_identical(here.drop_vars(timed), there.drop_vars(timed))


def test_a_scheduler_that_does_not_answer_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wroll_fem.jobs.executors.CONNECT_SECONDS", 0.5)
    path = tmp_path / "grid.yaml"
    path.write_text(GRID)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        words = ["batch", str(path), "--out", str(tmp_path / "out"), "--scheduler", address]
        done = CliRunner().invoke(cli.app, words)
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "--scheduler" in done.stderr
    assert f"no answer from {address}" in done.stderr
    assert not (tmp_path / "out").exists()
