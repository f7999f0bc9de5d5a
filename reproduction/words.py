"""Text formats and monotonicity checks shared by several claim groups."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from scipy.stats import spearmanr

from wroll_fem.plotting.study import PRESSURE, StudyCase

SLACK = 0.005
"""Tolerated violation of monotonicity due to numerical noise, relative to the range (note 10 of the checklist)."""


def exactly(error: float) -> str:
    """Relative error as text; "rounding" for an exact zero."""
    return f"{error:.0e}" if error > 0 else "rounding"


def numbers(values: Iterable[float], form: str, joined: str = ", ") -> str:
    """Numbers in one format, joined to a text."""
    return joined.join(f"{value:{form}}" for value in values)


def listed(members: Iterable[StudyCase], value: Callable[[StudyCase], float], form: str) -> str:
    """One value of every case of a study, as text."""
    return numbers((value(m) for m in members), form)


def kpa(member: StudyCase) -> str:
    """External pressure of a case as text, "17.8 kPa"."""
    return f"{member.values[PRESSURE] / 1e3:.3g} kPa"


def monotone(values: Sequence[float], sign: int) -> bool:
    """Whether a series increases (sign 1) or decreases (-1), within the tolerance of the checklist."""
    return bool(np.all(sign * np.diff(values) > -SLACK * np.ptp(values)))


def rank_correlation(a: Sequence[float], b: Sequence[float]) -> float:
    """Spearman's rank correlation."""
    return float(spearmanr(a, b).statistic)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Markdown table; bars and line breaks in cells are escaped."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(
        "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in line) + " |" for line in lines
    )
