"""Rows of a PSD table: what is wrong with them. Without numpy, so that a case is read quickly."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import isfinite


def table_problem(frequency: Sequence[float], density: Sequence[float]) -> tuple[str, str, str] | None:
    """First error of a PSD table as (key, problem, remedy); None if there is none."""
    if len(frequency) < 2:
        return "frequency", f"a PSD needs two or more rows, got {len(frequency)}", "give for example [20, 300]"
    if len(density) != len(frequency):
        return (
            "g2_per_hz", f"{len(density)} densities for {len(frequency)} frequencies",
            "give one density per frequency",
        )  # fmt: skip
    if not frequency[0] > 0.0 or not all(isfinite(f) for f in frequency):
        return "frequency", f"the first frequency must be above zero, got {frequency[0]:g}", "give frequencies in Hz"
    for low, high in pairwise(frequency):
        if not high > low:
            return "frequency", f"the frequencies must rise, but {high:g} Hz follows {low:g} Hz", "sort the rows"
    for f, value in zip(frequency, density, strict=True):
        if not (isfinite(value) and value > 0.0):
            return (
                "g2_per_hz", f"the density at {f:g} Hz must be above zero, got {value:g} g^2/Hz",
                "give densities in g^2/Hz; a log-log line has no zero: let the band end there",
            )  # fmt: skip
    return None
