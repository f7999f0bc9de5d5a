"""Notebooks run from top to bottom without a display, and equal the scripts that they are paired with."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest


def test_notebooks_equal_their_scripts_and_hold_no_outputs(root):
    done = subprocess.run(
        [sys.executable, root / "tools" / "pair_notebooks.py", "--check"], capture_output=True, text=True
    )
    assert done.returncode == 0, f"{done.stdout}: run tools/pair_notebooks.py"
    for path in (root / "notebooks").glob("*.ipynb"):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in cells)


@pytest.mark.parametrize("name", ["slip_contours"])
def test_notebook_runs_headless(root, name):
    script = root / "notebooks" / f"{name}.py"
    environment = {**os.environ, "MPLBACKEND": "Agg", "OMP_NUM_THREADS": "1"}
    options = ["-W", "error::UserWarning", "-W", "error::RuntimeWarning"]
    done = subprocess.run(
        [sys.executable, *options, script],
        capture_output=True,
        text=True,
        cwd=script.parent,
        env=environment,
        timeout=110,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert "slip starts above" in done.stdout
