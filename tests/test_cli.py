"""The commands that check, mesh, draw and tell, with fake analyses."""

from __future__ import annotations

import json
import re
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from support.fake_analyses import CONFIGS, TINY
from typer.testing import Result

from wroll_fem import __version__
from wroll_fem.case import schema_text
from wroll_fem.jobs.grid import grid_schema_text


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


def test_validate_reads_grid_files_and_tells_all_their_errors(wroll: Callable[..., Result], tmp_path: Path) -> None:
    """One error of many cases is told once, in the line of the grid file."""
    lines = [f"base: {TINY}", "grid:", "  contact.friction.mu: [-0.1, 0.2 m]", "  mesh.axail: [2, 3]", ""]
    (tmp_path / "bad.yaml").write_text("\n".join(lines), encoding="utf-8")
    bad = wroll("validate", tmp_path / "bad.yaml")
    assert bad.exit_code == 2
    told = [line.removeprefix(f"{tmp_path}/bad.yaml:") for line in bad.stderr.splitlines()]
    assert [line.split(";")[0] for line in told] == [
        "3: grid.contact.friction.mu: must be 0 or more, got -0.1",
        "3: grid.contact.friction.mu: must be a pure number, not a length, got '0.2 m'",
        "4: grid.mesh.axail: unknown key, got 2",
        "4: grid.mesh.axail: unknown key, got 3",
    ]
    (tmp_path / "good.yaml").write_text(f"base: {TINY}\ngrid: {{preload.pressure: [10 kPa, 2.0e+4]}}\n")
    good = wroll("validate", tmp_path / "good.yaml")
    assert good.stdout.splitlines() == [
        f"{tmp_path}/good.yaml: OK", f"{tmp_path}/good.yaml: warning: the mesh is coarse; use mesh.axial >= 20",
    ]  # fmt: skip


def test_dry_run_of_a_batch_names_its_cases_and_writes_nothing(wroll: Callable[..., Result], tmp_path: Path) -> None:
    grid = tmp_path / "grid.yaml"
    grid.write_text(f"base: {TINY}\ngrid: {{preload.pressure: [10 kPa, 2.0e+4]}}\n", encoding="utf-8")
    done = wroll("batch", grid, "--dry-run", "--workers", 2)
    assert done.exit_code == 0
    assert [line.split()[0] for line in done.stdout.splitlines()[:2]] == ["pressure_10000", "pressure_20000"]
    assert re.fullmatch(r"2 cases, .* s with 2 workers", done.stdout.splitlines()[-1].split(", 2 cases")[0])
    assert sorted(tmp_path.iterdir()) == [grid]


def test_schema_goes_to_the_screen_or_to_a_file(wroll: Callable[..., Result], tmp_path: Path) -> None:
    assert wroll("schema").stdout == schema_text()
    assert wroll("schema", "--out", tmp_path / "new" / "schema.json").exit_code == 0
    assert (tmp_path / "new" / "schema.json").read_text() == schema_text()
    assert wroll("schema", "--grid").stdout == grid_schema_text()
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
    from wroll_fem.jobs import environment

    def broken() -> str:
        raise ImportError("no such library")

    parts = {name: (lambda: "1.2") for name in environment._PARTS}
    monkeypatch.setattr(environment, "_PARTS", {**parts, "pyvista": broken})
    optional = wroll("info")
    assert optional.exit_code == 0
    names = [
        "python",
        "dolfinx",
        "petsc",
        "slepc",
        "numpy",
        "scipy",
        "blas",
        "gmsh",
        "numba",
        "xarray",
        "pyvista",
        "h5py",
    ]
    assert [line.split()[0] for line in optional.stdout.splitlines()] == ["wroll_fem", *names]
    assert re.search(r"pyvista +- +DOES NOT WORK: ImportError: no such library", optional.stdout)
    told = json.loads(wroll("info", "--json").stdout)
    assert told["wroll_fem"] == __version__
    assert told["libraries"]["gmsh"] == {"version": "1.2", "problem": None}
    assert told["libraries"]["pyvista"]["problem"] == "ImportError: no such library"
    monkeypatch.setattr(environment, "_PARTS", {**parts, "dolfinx": broken})
    assert wroll("info").exit_code == 1


def test_unknown_options_and_missing_arguments_exit_2(wroll: Callable[..., Result]) -> None:
    assert wroll("run").exit_code == 2
    assert wroll("run", TINY, "--nonsense").exit_code == 2
    assert wroll("--version").stdout == f"wroll_fem {__version__}\n"


def test_the_installed_command_answers_a_bad_case_fast_and_in_one_line() -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [sys.executable, "-m", "wroll_fem.cli", "run", str(TINY), "--set", "mandrel.material.nu=0.7"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith(f"{TINY}: --set mandrel.material.nu: must be less than 0.5, got 0.7; ")
    assert done.stderr.count("\n") == 1
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime < 5.0  # s of CPU; about 0.5
