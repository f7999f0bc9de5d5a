"""Changes of a case by dotted keys, as `--set` and `Case.replace` take them; YAML texts."""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from wroll_fem.case.renamed import current_key
from wroll_fem.errors import InputError
from wroll_fem.results.json_types import json_types

WITH_FILE = ("mesh", "structure")
"""Sections whose `file` is a path relative to the case file (or, with --set, to the working directory)."""


class _StrictLoader(yaml.SafeLoader):
    """SafeLoader that refuses a key written twice instead of keeping the last one."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            if isinstance(key_node, yaml.ScalarNode) and key_node.tag != "tag:yaml.org,2002:merge":
                if key_node.value in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"key {key_node.value!r} is written twice", key_node.start_mark
                    )
                seen.add(key_node.value)
        return super().construct_mapping(node, deep)


def parse_yaml(text: str, where: str) -> Any:
    """Content of a YAML text; `where` it is from is named in errors."""
    try:
        return yaml.load(text, Loader=_StrictLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        spot = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = f"is not valid YAML{spot}: {error.problem}"
    except yaml.YAMLError as error:
        problem = f"is not valid YAML: {' '.join(str(error).split())}"
    raise InputError(problem, remedy="mind indentation, colons and brackets", file=where)


def override_texts(*overrides: str | Mapping[str, Any]) -> list[str]:
    """Overrides as `load_case` takes them; a mapping of dotted keys to values becomes one text per key."""
    texts: list[str] = []
    for given in overrides:
        if isinstance(given, str):
            texts.append(given)
        elif not isinstance(given, Mapping):
            remedy = 'give "dotted.key=value", or a dict of dotted keys and values'
            raise InputError(f"cannot change a case by {given!r}", remedy=remedy)
        else:
            texts += [f"{key}={json.dumps(json_types(value))}" for key, value in given.items()]
    return texts


def overridden(
    data: Mapping[str, Any], overrides: Sequence[str], file: str | None = None
) -> tuple[dict[str, Any], tuple[list[str], tuple[str, ...]]]:
    """Apply "dotted.key=value" pairs to a copy.

    Returns
    -------
    tuple
        The changed copy; the dotted keys, and those of them that were given by a former name.
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
        parsed = parse_yaml(value, f"--set {key}")
        if key in (f"{name}.file" for name in WITH_FILE) and isinstance(parsed, str):
            parsed = str(Path(parsed).resolve())
        here[parts[-1]] = parsed
        keys.append(key)
    return merged, (keys, tuple(former))


def _copy(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _copy(value) for key, value in data.items()}
    return data
