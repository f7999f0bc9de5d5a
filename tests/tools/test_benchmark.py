"""The benchmark's table: what is measured, what is extrapolated, and what is compared with what."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from support.paths import ROOT

from wroll_fem.analyses import run_analysis
from wroll_fem.case import load_case


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import run

    return run


def report(**values: float) -> dict[str, float]:
    cost = {"set_up_cpu_s": 2.0, "loop_cpu_s": 8.0, "total_cpu_s": 10.0, "peak_memory_mb": 400.0}
    return cost | {"interface_points": 176.0, "steps": 48000.0, "f_n_hz": 150.0, "zeta": 0.02} | values


def rows(text: str, label: str) -> list[list[str]]:
    return [
        [cell.strip() for cell in line.strip("| ").split("|")] for line in text.splitlines() if f"| {label}" in line
    ]


def test_full_is_the_measured_step_times_the_steps_of_the_chirp(bench: ModuleType, tmp_path: Path) -> None:
    """440 steps in 88 s are 0.2 s each; 48 000 of them and the set-up are 9602 s, 960 times the 10 s of condensed."""
    reports = {
        "window-full": report(steps=440.0, loop_cpu_s=88.0),
        "chirp-condensed": report(),
        "chirp-reduced": report(loop_cpu_s=2.0, total_cpu_s=4.0, f_n_hz=150.15, zeta=0.0201),
    }
    text = bench.tables(reports, tmp_path)
    assert "440 steps of a dwell at resonance were measured, 200 ms each" in text
    (full,) = rows(text, "`full`")
    assert full[2:5] == ["*2.7 h*", "*2.7 h*", "5.0"]
    condensed, reduced = rows(text, "`condensed`")[0], rows(text, "`reduced`")[0]
    assert condensed[4:] == ["6,000", "400 MB", "960", "18,000 to 36,000"]
    assert reduced[6] == "2,400"
    assert rows(text, "`reduced`")[1][5:] == ["0.1 %", "–", "0.5 %"]


def test_histories_are_compared_by_their_largest_difference(bench: ModuleType, tmp_path: Path) -> None:
    tip = np.array([0.0, 2.0, -4.0])
    np.savez(tmp_path / "a.npz", tip=tip, friction=np.array([0.0, 1.0]))
    np.savez(tmp_path / "b.npz", tip=tip + np.array([0.0, 0.04, 0.0]), friction=np.array([0.0, 1.02]))
    assert bench.history_errors(tmp_path, "b", "a") == pytest.approx((0.01, 0.02))
    assert bench.history_errors(tmp_path, "a", "a") == bench.history_errors(tmp_path, "c", "a") == (None, None)


def test_the_clock_of_a_job_takes_what_every_analysis_reports(monkeypatch: pytest.MonkeyPatch) -> None:
    """Histories, and curves, which know no remaining time."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import job

    clock = job.StageClock()
    case = load_case(ROOT / "configs" / "lab_harmonic.yaml", ["mesh={circumferential: 8, axial: 3, grading: 1}"])
    run_analysis(case, progress=clock)
    assert {"preload", "stress"} <= set(clock.seconds)


@pytest.mark.slow
def test_a_job_reports_seconds_memory_and_readings(tmp_path: Path) -> None:
    words = ["solver.method=condensed", "analysis=dwell", "mesh={circumferential: 8, axial: 2, grading: 1}"]
    words.append("excitation={kind: dwell, amplitude: 5.0, frequency: 150, cycles: 2, ramp_cycles: 1}")
    job, case = ROOT / "benchmarks" / "job.py", ROOT / "configs" / "lab_sweep.yaml"
    subprocess.run([sys.executable, str(job), str(case), str(tmp_path / "x"), *words], check=True)
    found = json.loads((tmp_path / "x.json").read_text())
    assert found["steps"] == 80
    assert found["total_cpu_s"] == pytest.approx(found["set_up_cpu_s"] + found["loop_cpu_s"])
    assert 0.0 < found["loop_cpu_s"] < found["total_cpu_s"]
    assert 50.0 < found["peak_memory_mb"] < 1500.0
    assert len(np.load(tmp_path / "x.npz")["tip"]) == 81


LOAD_A_BLAS = ("numpy", "scipy", "xarray", "numba", "matplotlib", "petsc4py")


@pytest.mark.parametrize("room", ["benchmarks", "tools"])
def test_scripts_import_the_package_before_a_blas_is_loaded(room: str) -> None:
    """OpenBLAS reads the names of its kernels once: after numpy, a processor it does not know computes without AVX."""
    late = []
    for file in sorted((ROOT / room).glob("*.py")):
        rooms = imported(ast.parse(file.read_text(encoding="utf-8")))
        blas = [k for k, name in enumerate(rooms) if name in LOAD_A_BLAS]
        if "wroll_fem" in rooms and blas and rooms.index("wroll_fem") > blas[0]:
            late.append(file.name)
    assert not late


def imported(module: ast.Module) -> list[str]:
    """First parts of the names that a module imports at its top level, in order."""
    found: list[str] = []
    for statement in module.body:
        if isinstance(statement, ast.Import):
            found += [alias.name.split(".")[0] for alias in statement.names]
        elif isinstance(statement, ast.ImportFrom) and statement.module:
            found.append(statement.module.split(".")[0])
    return found
