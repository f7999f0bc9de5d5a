"""Estimates with their intervals as variables of a Dataset and as entries of a summary."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wroll_fem.numerics.inference import Estimate


def variables(name: str, dim: str, estimates: Sequence[Estimate | None]) -> dict[str, tuple[str, Any]]:
    """Variables ``name``, ``name_low`` and ``name_high`` (95 % interval) over a dimension; NaN where there is none."""
    rows = np.array([_row(one) for one in estimates]).reshape(-1, 3)
    return {key: (dim, rows[:, k]) for k, key in enumerate((name, f"{name}_low", f"{name}_high"))}


def entries(name: str, unit: str, estimates: Sequence[Estimate | None] | Estimate) -> dict[str, Any]:
    """Entries ``name_unit`` and ``name_interval_unit`` of a summary: numbers, and pairs of the ends at 95 %."""
    end = f"_{unit}" if unit else ""
    if isinstance(estimates, Estimate):
        value, low, high = _row(estimates)
        return {f"{name}{end}": value, f"{name}_interval{end}": [low, high]}
    rows = [_row(one) for one in estimates]
    return {f"{name}{end}": [row[0] for row in rows], f"{name}_interval{end}": [[row[1], row[2]] for row in rows]}


def _row(estimate: Estimate | None) -> tuple[float, float, float]:
    if estimate is None:
        return float("nan"), float("nan"), float("nan")
    return estimate.value, *estimate.interval()
