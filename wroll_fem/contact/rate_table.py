"""Table of the coefficient of friction versus slip rate: its checks and its velocity-weakening slope."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple


class TableProblem(NamedTuple):
    """Problem of a table: the column concerned (slip_rate or mu), what is wrong, and the remedy."""

    column: str
    problem: str
    remedy: str


def table_problem(rates: Sequence[float], coefficients: Sequence[float]) -> TableProblem | None:
    """First problem of a table of ``coefficients`` versus slip ``rates`` (m/s); None if the table is valid."""
    if not rates:
        return TableProblem("slip_rate", "is empty", "give at least the slip rate 0, m/s, and its mu")
    if len(rates) != len(coefficients):
        return TableProblem(
            "mu", f"has {len(coefficients)} values for {len(rates)} slip rates", "give one mu for each slip_rate"
        )
    if rates[0] != 0.0:
        return TableProblem("slip_rate", "must start at 0 m/s", "start with 0 and the coefficient at rest")
    if not all(b > a for a, b in pairwise(rates)):
        return TableProblem("slip_rate", "must rise", "sort the slip rates, each larger than the one before")
    if not all(value >= 0.0 for value in coefficients):
        return TableProblem("mu", "must be 0 or more", "give coefficients of friction, dimensionless")
    if coefficients[0] == 0.0 and any(coefficients):
        return TableProblem(
            "mu", "must not start at 0", "give a positive mu at rest: the stick stiffness is mu p / elastic_slip"
        )
    return None


def weakening_slope(rates: Sequence[float], coefficients: Sequence[float]) -> float:
    """Velocity-weakening slope of a table: largest -d mu / dV, s/m; 0 if mu never decreases."""
    slopes = [(d - c) / (b - a) for (a, b), (c, d) in zip(pairwise(rates), pairwise(coefficients), strict=True)]
    return max(0.0, -min(slopes, default=0.0))
