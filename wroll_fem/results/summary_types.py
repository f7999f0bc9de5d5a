"""Types of the entries of a summary.json that was read from a file."""

from __future__ import annotations

from typing import Any

from wroll_fem.results.summary import SUMMARY

_MOST_BITS = 1023  # of an integer that a double can hold

_LISTS = ("warnings", "modes_hz", "mode_kinds", "mode_damping_ratios")


def well_typed(name: str, value: Any) -> bool:
    """Whether an entry has the type that console and report need.

    An entry with a unit, a share or a number holds numbers (null, lists and dicts included); one that the console
    shows fits its format there; entries per mode and warnings are lists.
    """
    entry = SUMMARY.get(name)
    if value is None or entry is None:
        return True
    if name in _LISTS and not isinstance(value, list):
        return False
    if entry.console and not _shown(entry.console, value):
        return False
    numeric = entry.unit != "" or entry.style != "si"
    return not numeric or _numbers(value)


def _shown(form: str, value: Any) -> bool:
    """Whether the format of the console fits a value, or every entry of a list."""
    try:
        for entry in value if isinstance(value, list) else [value]:
            if entry is not None:
                form.format(entry)
    except (TypeError, ValueError, OverflowError):
        return False
    return True


def _numbers(value: Any) -> bool:
    if isinstance(value, list):
        return all(map(_numbers, value))
    if isinstance(value, dict):
        return all(map(_numbers, value.values()))
    if isinstance(value, int):
        return value.bit_length() < _MOST_BITS
    return value is None or isinstance(value, float)
