"""Result of a laboratory evaluation: summary, Dataset and figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from wroll_fem.errors import InputError
from wroll_fem.lab.figure import Figure
from wroll_fem.lab.settings import LabSettings

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class LabResult:
    """Result of an evaluation.

    Attributes
    ----------
    summary
        Entries of summary.json: flat, in SI, with units in the names; `warnings` is a list of sentences.
    data
        Dataset with `units` and `long_name` on every variable.
    texts
        Name of a further file of the result folder -> its text.
    kind
        Kind of the evaluation; filled in by `evaluate`, like the next ones.
    settings
        Complete settings.
    inputs
        Path, size and SHA-256 of each input (`lab.inputs.described`).
    drawings
        Figures of the kind.
    texts
        Further files of the folder: name -> content.
    """

    summary: dict[str, Any]
    data: xr.Dataset
    texts: Mapping[str, str] = field(default_factory=dict)
    kind: str = ""
    settings: LabSettings | None = None
    inputs: tuple[dict[str, Any], ...] = ()
    drawings: Mapping[str, Figure] = field(default_factory=dict)

    @property
    def warnings(self) -> list[str]:
        """Warnings of the evaluation, each with its remedy."""
        return list(self.summary.get("warnings", ()))

    @property
    def figures(self) -> list[str]:
        """Names of the figures that `plot` can draw."""
        return [name for name, one in self.drawings.items() if not one.needs or one.needs in self.data]

    def plot(self, figure: str = "", *, ax: Axes | None = None) -> Axes:
        """Draw a figure of the kind, by default the first.

        Raises
        ------
        InputError
            If the kind has no such figure, or the data lack what it needs.
        """
        names = self.figures
        name = figure or next(iter(names), "")
        if name not in names:
            remedy = f"use one of: {', '.join(names)}" if names else "this evaluation has no figure"
            raise InputError(f"no figure {name!r} of {self.kind}", remedy=remedy)
        return self.drawings[name].draw(self.data, ax)

    def write_figures(self, folder: Path) -> list[Path]:
        """Draw all figures into a folder; return the files."""
        from wroll_fem.plotting.style import save_figure

        return [save_figure(self.plot(name), folder / f"{name}.png") for name in self.figures]
