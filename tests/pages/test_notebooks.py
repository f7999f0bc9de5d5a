"""Notebooks run from top to bottom without display and warnings, and equal the scripts that they are paired with."""

from __future__ import annotations

import ast

import jupytext
import nbclient
import nbformat
import pytest
from support.paths import ROOT

FOLDER = ROOT / "notebooks"
NAMES = sorted(path.stem for path in FOLDER.glob("*.ipynb"))
QUICK = "WROLL_QUICK"
"""Environment variable with which a notebook takes fewer points."""
ALWAYS = ("01_first_roll",)
"""Notebooks that run in `make test`; the others take 15 to 35 s each."""
SHORTENED = [name for name in NAMES if QUICK in (FOLDER / f"{name}.py").read_text(encoding="utf-8")]


def sources(notebook):
    return [(cell.cell_type, cell.source) for cell in notebook.cells]


@pytest.mark.parametrize("name", NAMES)
def test_notebook_equals_its_script_and_holds_no_outputs(root, name):
    notebook = nbformat.read(root / "notebooks" / f"{name}.ipynb", as_version=4)
    script = jupytext.read(root / "notebooks" / f"{name}.py")
    assert sources(notebook) == sources(script), "run: .venv/bin/jupytext --sync notebooks/*.ipynb"
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in notebook.cells)


@pytest.mark.parametrize("name", NAMES)
def test_notebook_says_what_it_compares_with_and_uses_the_public_names_alone(root, name):
    script = (root / "notebooks" / f"{name}.py").read_text(encoding="utf-8")
    first = jupytext.reads(script, "py:percent").cells[0]
    assert first.cell_type == "markdown"
    assert "**What is solved**" in first.source
    assert "**Against what it is compared**" in first.source
    tree = ast.parse(script)
    modules = [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    modules += [str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    assert [module for module in modules if module.startswith("wroll_fem")] == ["wroll_fem"]
    assert sum(isinstance(node, ast.Assert) for node in ast.walk(tree)) >= 3
    assert max(map(len, script.splitlines())) <= 120


def run(root, name, monkeypatch, *, quick):
    """Outputs of all cells; any error or warning raises."""
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")
    for variable in ("MPLBACKEND", "DISPLAY", "WAYLAND_DISPLAY", QUICK):  # the kernel draws in the notebook
        monkeypatch.delenv(variable, raising=False)
    if quick:
        monkeypatch.setenv(QUICK, "1")
    notebook = nbformat.read(root / "notebooks" / f"{name}.ipynb", as_version=4)
    # sliders wait for a browser, now and then until the cell's time is up: take the way without ipywidgets
    notebook.cells.insert(0, nbformat.v4.new_code_cell("import sys; sys.modules['ipywidgets'] = None"))
    # what ipykernel says of itself when it shuts down is not the notebook's
    strict = (
        "import warnings; warnings.simplefilter('error'); warnings.simplefilter('ignore', PendingDeprecationWarning)"
    )
    notebook.cells.insert(1, nbformat.v4.new_code_cell(strict))
    resources = {"metadata": {"path": str(root / "notebooks")}}
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=resources).execute()
    return [output for cell in notebook.cells for output in cell.get("outputs", [])]


def figures(outputs):
    return sum("image/png" in output.get("data", {}) for output in outputs)


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in ALWAYS else pytest.mark.slow) for n in NAMES])
def test_notebook_runs_headless(root, name, monkeypatch):
    outputs = run(root, name, monkeypatch, quick=True)
    assert figures(outputs) >= 3
    told = "".join(output.get("text", "") for output in outputs if output.output_type == "stream")
    assert "slip starts above" in told or name != "slip_contours"


@pytest.mark.slow
@pytest.mark.parametrize("name", SHORTENED)
def test_notebook_runs_in_full(root, name, monkeypatch):
    assert figures(run(root, name, monkeypatch, quick=False)) >= 3
