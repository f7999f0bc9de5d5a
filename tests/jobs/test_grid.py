"""Names of the folders of a grid; a grid file is read without what draws its figures."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from support.paths import CONFIGS

from wroll_fem.jobs.grid import MOST_BYTES, load_grid
from wroll_fem.jobs.study_figures import STUDY_FIGURES
from wroll_fem.plotting.series import FIGURES


def test_the_figures_of_grid_files_are_those_that_can_be_drawn() -> None:
    assert tuple(FIGURES) == STUDY_FIGURES


def test_reading_a_grid_file_loads_no_library_for_figures() -> None:
    grid = CONFIGS / "studies" / "preload.yaml"
    code = f"import sys, wroll_fem as wf; wf.load_grid({str(grid)!r}); assert 'matplotlib' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_folder_has_a_name_that_every_file_system_takes(tmp_path: Path) -> None:
    """Long names keep their beginning and get a hash, so that two of them differ."""
    (tmp_path / f"{'é' * 110}.yaml").write_text((CONFIGS / "tiny.yaml").read_text())
    (tmp_path / "=-x.yaml").write_text((CONFIGS / "tiny.yaml").read_text())
    text = f"cases: [{'é' * 110}.yaml, '=-x.yaml']\ngrid: {{mesh.axial: [4, 6], mesh.grading: [1.23456789, 2]}}\n"
    (tmp_path / "grid.yaml").write_text(text)
    names = [member.name for member in load_grid(tmp_path / "grid.yaml").members]
    assert len(set(names)) == 8
    assert max(len(name.encode()) for name in names) <= MOST_BYTES < 255 - len(".partial")
    assert all(name.startswith(("é" * 90, "x_")) for name in names)
