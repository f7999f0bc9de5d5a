"""Types of the entries of a summary.json that was read from a file."""

from __future__ import annotations

from typing import Any

from wroll_fem.results.summary import SUMMARY


def well_typed(name: str, value: Any) -> bool:
    """Whether an entry with a unit, a share or a number holds numbers (null, lists and dicts included)."""
    entry = SUMMARY.get(name)
    numeric = entry is not None and (entry.unit != "" or entry.style != "si")
    return not numeric or _numbers(value)


def _numbers(value: Any) -> bool:
    if isinstance(value, list):
        return all(map(_numbers, value))
    if isinstance(value, dict):
        return all(map(_numbers, value.values()))
    return value is None or isinstance(value, int | float)
