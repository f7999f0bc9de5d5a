"""The commands that check, mesh, draw and tell, with fake analyses."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from support.fake_analyses import CONFIGS, TINY
from typer.testing import Result

from wroll_fem import __version__
from wroll_fem.case import schema_text


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
    from wroll_fem.jobs import environment

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
