"""Overrides of dotted keys for `--set` and `Case.replace`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from wroll_fem.case.renamed import current_key
from wroll_fem.case.strict_yaml import parse_yaml
from wroll_fem.errors import InputError
from wroll_fem.results.json_types import json_types
from wroll_fem.results.storage.paths import path_problem

WITH_FILE = ("mesh", "structure", "excitation")
"""Sections whose `file` is a path relative to the case file (or, with --set, to the working directory)."""


def override_texts(*overrides: str | Mapping[str, Any]) -> list[str]:
    """Convert overrides to "dotted.key=value" texts; a mapping gives one text per key.

    Raises
    ------
    InputError
        If an override is neither text nor mapping.
    """
    texts: list[str] = []
    for given in overrides:
        if isinstance(given, str):
            texts.append(given)
        elif not isinstance(given, Mapping):
            remedy = 'give "dotted.key=value", or a dict of dotted keys and values'
            raise InputError(f"cannot change a case with {given!r}", remedy=remedy)
        else:
            texts += [f"{key}={json.dumps(json_types(value))}" for key, value in given.items()]
    return texts


def overridden(
    data: Mapping[str, Any], overrides: Sequence[str], file: str | None = None
) -> tuple[dict[str, Any], tuple[list[str], tuple[str, ...]]]:
    """Copy of the content of a case, changed by "dotted.key=value" texts.

    Parameters
    ----------
    data
        Content of a case file.
    overrides
        "dotted.key=value" texts, with values in YAML, or "dotted.key=@file" with the value in a YAML file.
    file
        File of the data, for messages.

    Returns
    -------
    tuple
        The changed copy; a pair of the changed dotted keys (current names) and the former names that were used.

    Raises
    ------
    InputError
        If a text is not "dotted.key=value", its value is not YAML, its file cannot be read, or its key is not in a
        section.
    """
    merged = _copy(dict(data))
    keys, former = [], []
    for text in overrides:
        key, equals, value = text.partition("=")
        key = key.strip()
        if current_key(key) != key:
            former.append(key)
            key = current_key(key)
        parts = key.split(".")
        if not equals or not all(parts):
            remedy = "write --set dotted.key=value, for example --set contact.friction.mu=0.5"
            raise InputError(f"must look like key=value, got {text!r}", key=f"--set {key}", remedy=remedy, file=file)
        here = merged
        for depth, part in enumerate(parts[:-1]):
            if here.get(part) is None:
                here[part] = {}
            here = here[part]
            if not isinstance(here, dict):
                remedy = "set the whole key instead"
                problem = f"{'.'.join(parts[: depth + 1])} is not a section, so it has no key {parts[depth + 1]!r}"
                raise InputError(problem, key=f"--set {key}", remedy=remedy, file=file)
        parsed = _from_file(value[1:], key) if value.startswith("@") else parse_yaml(value, f"--set {key}")
        if key in (f"{name}.file" for name in WITH_FILE) and isinstance(parsed, str):
            parsed = absolute(parsed)
        here[parts[-1]] = parsed
        keys.append(key)
    return merged, (keys, tuple(former))


def _from_file(path: str, key: str) -> Any:
    """Value of a key from a YAML file; "@" cannot start a value in YAML, so no value is mistaken for a file."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "no UTF-8 text"
        raise InputError(
            f"cannot be read ({reason.lower()})", file=path, key=f"--set {key}", remedy="give the path of a YAML file"
        ) from None
    return parse_yaml(text, path)


def absolute(path: str | Path) -> str:
    """Absolute path without links; a path that no file can have is returned unchanged, for the section's own check."""
    return str(path) if path_problem(path) else str(Path(path).resolve())


def _copy(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _copy(value) for key, value in data.items()}
    return data
