"""Strict YAML: duplicate keys are refused; an error is reported in one line with its position."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import yaml

from wroll_fem.errors import InputError


class _StrictLoader(yaml.SafeLoader):
    """YAML loader that refuses duplicate keys."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            if isinstance(key_node, yaml.ScalarNode) and key_node.tag != "tag:yaml.org,2002:merge":
                if key_node.value in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"key {key_node.value!r} occurs twice", key_node.start_mark
                    )
                seen.add(key_node.value)
        return super().construct_mapping(node, deep)


def parse_yaml(text: str, where: str) -> Any:
    """Parse a YAML text; ``where`` names the origin of the text in error messages.

    Raises
    ------
    InputError
        If the text is not valid YAML.
    """
    try:
        return yaml.load(text, Loader=_StrictLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        spot = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = f"is not valid YAML{spot}: {error.problem}"
    except yaml.YAMLError as error:
        problem = f"is not valid YAML: {' '.join(str(error).split())}"
    raise InputError(problem, remedy="check indentation, colons and brackets", file=where)


def key_lines(text: str) -> dict[str, int]:
    """Line of each dotted key of a valid YAML text, counted from 1; entries of lists are numbered from 0."""
    found: dict[str, int] = {}

    def visit(node: yaml.Node | None, path: tuple[str, ...]) -> None:
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                inner = (*path, str(key.value))
                found[".".join(inner)] = key.start_mark.line + 1
                visit(value, inner)
        elif isinstance(node, yaml.SequenceNode):
            for number, value in enumerate(node.value):
                inner = (*path, str(number))
                found[".".join(inner)] = value.start_mark.line + 1
                visit(value, inner)

    visit(yaml.compose(text, Loader=_StrictLoader), ())
    return found
