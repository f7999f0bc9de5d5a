"""Former names of keys: accepted in case files and with `--set`; a warning names the new key."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wroll_fem.errors import InputError

KEYS = {"design_map.loosest": "design_map.softest"}
"""Former dotted key "section.key" -> current dotted key in the same section."""


def current_key(key: str) -> str:
    """Current name of a dotted key."""
    return KEYS.get(key, key)


def with_current_keys(data: Mapping[Any, Any]) -> tuple[dict[Any, Any], tuple[str, ...]]:
    """Content of a case with its keys under their current names, and the former names that it contained.

    Raises
    ------
    InputError
        When both names of a key are given.
    """
    current, found = dict(data), []
    for former, present in KEYS.items():
        section, _, old = former.partition(".")
        new = present.partition(".")[2]
        content = current.get(section)
        if not isinstance(content, Mapping) or old not in content:
            continue
        if new in content:
            raise InputError(
                f"is the former name of {present}, which the case also contains", key=former, remedy="leave it out"
            )
        current[section] = {new if key == old else key: value for key, value in content.items()}
        found.append(former)
    return current, tuple(found)


def with_former_keys(data: Mapping[str, Any]) -> dict[str, Any]:
    """Content of a case with its keys under their former names; renaming a key then leaves the hash unchanged."""
    former_data = dict(data)
    for former, present in KEYS.items():
        section, _, old = former.partition(".")
        new = present.partition(".")[2]
        if new in former_data.get(section, {}):
            former_data[section] = {old if key == new else key: value for key, value in former_data[section].items()}
    return former_data
