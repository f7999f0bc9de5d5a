"""Claim group: claims that are judged from the same runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from reproduction.evidence import Evidence
from reproduction.verdict import Verdict

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Judge = Callable[[Evidence], Verdict]
Drawing = Callable[[Evidence], "Axes"]


@dataclass(frozen=True)
class ClaimGroup:
    """Claims judged from the same runs, with the figures and tables of these runs.

    Attributes
    ----------
    judges
        Id of each claim -> function that computes the value and the verdict.
    figures
        Name of each figure (without suffix) -> caption and function that draws it.
    tables
        Name of each table -> function that returns it as Markdown; tables follow the figures on the page.
    studies
        Studies that the judges use and that must be complete, in the order of their use.
    partial_studies
        Studies in which some cases may fail.
    """

    judges: Mapping[str, Judge]
    figures: Mapping[str, tuple[str, Drawing]] = field(default_factory=dict)
    tables: Mapping[str, Callable[[Evidence], str]] = field(default_factory=dict)
    studies: tuple[str, ...] = ()
    partial_studies: tuple[str, ...] = ()


def study_figure(study: str, figure: str = "") -> Drawing:
    """Function that draws a figure of a study; `figure` names it in `plotting.series.FIGURES`, by default `study`."""

    def draw(evidence: Evidence) -> Axes:
        from wroll_fem.plotting.series import FIGURES

        return FIGURES[figure or study](evidence.study(study))

    return draw
