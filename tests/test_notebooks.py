"""Notebooks run from top to bottom without a display, and equal the scripts that they are paired with."""

from __future__ import annotations

from pathlib import Path

import jupytext
import nbclient
import nbformat
import pytest

NAMES = sorted(path.stem for path in (Path(__file__).parent.parent / "notebooks").glob("*.ipynb"))


def sources(notebook):
    return [(cell.cell_type, cell.source) for cell in notebook.cells]


@pytest.mark.parametrize("name", NAMES)
def test_notebook_equals_its_script_and_holds_no_outputs(root, name):
    notebook = nbformat.read(root / "notebooks" / f"{name}.ipynb", as_version=4)
    script = jupytext.read(root / "notebooks" / f"{name}.py")
    assert sources(notebook) == sources(script), "run: .venv/bin/jupytext --sync notebooks/*.ipynb"
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in notebook.cells)


@pytest.mark.parametrize("name", NAMES)
def test_notebook_runs_headless(root, name, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")
    monkeypatch.delenv("MPLBACKEND", raising=False)  # the kernel draws in the notebook
    monkeypatch.delenv("DISPLAY", raising=False)
    notebook = nbformat.read(root / "notebooks" / f"{name}.ipynb", as_version=4)
    # sliders wait for a browser, now and then until the cell's time is up: take the way without ipywidgets
    notebook.cells.insert(0, nbformat.v4.new_code_cell("import sys; sys.modules['ipywidgets'] = None"))
    resources = {"metadata": {"path": str(root / "notebooks")}}
    nbclient.NotebookClient(notebook, timeout=110, kernel_name="python3", resources=resources).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    printed = "".join(output.get("text", "") for output in outputs if output.output_type == "stream")
    assert "slip starts above" in printed or name != "slip_contours"
