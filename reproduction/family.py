"""A family of claims: those that look at the same runs."""

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
class Family:
    """Claims judged from the same runs, and the figures of these.

    Attributes
    ----------
    judges
        Id of a claim -> function that computes our value and the verdict.
    figures
        Name of a figure (without suffix) -> (caption, function that draws it).
    tables
        Name of a table -> function that writes it as Markdown; they follow the figures on the page.
    """

    judges: Mapping[str, Judge]
    figures: Mapping[str, tuple[str, Drawing]] = field(default_factory=dict)
    tables: Mapping[str, Callable[[Evidence], str]] = field(default_factory=dict)


def study_figure(study: str, figure: str = "") -> Drawing:
    """Figure of a study by its name in `plotting.series.FIGURES`; that of the study without."""

    def draw(evidence: Evidence) -> Axes:
        from wroll_fem.plotting.series import FIGURES

        return FIGURES[figure or study](evidence.study(study))

    return draw
