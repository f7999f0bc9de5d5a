"""A grid file is read without what draws its figures."""

from __future__ import annotations

import subprocess
import sys

from support.paths import CONFIGS

from wroll_fem.jobs.study_figures import STUDY_FIGURES
from wroll_fem.plotting.series import FIGURES


def test_the_figures_of_grid_files_are_those_that_can_be_drawn() -> None:
    assert tuple(FIGURES) == STUDY_FIGURES


def test_reading_a_grid_file_loads_no_library_for_figures() -> None:
    grid = CONFIGS / "studies" / "preload.yaml"
    code = f"import sys, wroll_fem as wf; wf.load_grid({str(grid)!r}); assert 'matplotlib' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
