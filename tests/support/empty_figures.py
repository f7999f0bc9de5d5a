"""Figures that are drawn and not written: most of the time of a figure is spent on its pixels."""

from __future__ import annotations

from pathlib import Path

import pytest

from wroll_fem.plotting import style


def touched(figure: object, path: Path) -> Path:
    """Empty file in place of a figure."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    return path


def empty_figures(patch: pytest.MonkeyPatch) -> None:
    """From now on the files of figures are empty."""
    patch.setattr(style, "write_figure", touched)
