"""Reference pages generated from the code: case models, typer commands, and the table of result fields."""

from __future__ import annotations

from pathlib import Path

from tools.reference.case import case_page
from tools.reference.commands import commands_page
from tools.reference.lab import lab_page
from tools.reference.results import results_page

__all__ = ["PAGES", "case_page", "commands_page", "lab_page", "results_page", "write_pages"]

PAGES = {"case.md": case_page, "commands.md": commands_page, "lab.md": lab_page, "results.md": results_page}
"""File in docs/reference -> function that returns its Markdown."""


def write_pages(folder: Path) -> list[Path]:
    """Write all reference pages to a folder; existing pages are overwritten."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, page in PAGES.items():
        path = folder / name
        path.write_text(page(), encoding="utf-8")
        written.append(path)
    return written
