"""The site shows every notebook with its outputs, made from the cells that the notebook has now."""

from __future__ import annotations

import re

import nbformat
import pytest
from support.paths import ROOT

from tools import notebook_pages

NAMES = sorted(path.stem for path in (ROOT / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("name", NAMES)
def test_the_page_of_a_notebook_is_current(name: str) -> None:
    assert notebook_pages.is_current(name), "run: .venv/bin/python tools/notebook_pages.py, and commit docs/notebooks"


@pytest.mark.parametrize("name", NAMES)
def test_the_page_holds_the_cells_and_the_figures(name: str) -> None:
    page = (ROOT / "docs" / "notebooks" / f"{name}.md").read_text(encoding="utf-8")
    for cell in nbformat.read(ROOT / "notebooks" / f"{name}.ipynb", as_version=4).cells:
        assert cell.cell_type != "code" or cell.source in page
    figures = re.findall(r"\]\((figures/\w+\.png)\)", page)
    assert len(figures) >= 3
    assert all((ROOT / "docs" / "notebooks" / figure).stat().st_size > 5000 for figure in figures)
    assert page.count("```text") >= 2
    assert "Traceback" not in page


def test_a_changed_cell_makes_the_page_old(monkeypatch: pytest.MonkeyPatch) -> None:
    read = nbformat.read

    def changed(path: object, as_version: int) -> nbformat.NotebookNode:
        notebook = read(path, as_version=as_version)
        notebook.cells[-1].source += "\n"
        return notebook

    monkeypatch.setattr(nbformat, "read", changed)
    assert not notebook_pages.is_current(NAMES[0])
