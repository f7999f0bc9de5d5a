"""Strict YAML: numbers of YAML 1.2, no duplicate keys, bounded size; an error is one line with its position.

PyYAML reads YAML 1.1, in which 0150 is 104, 2:30 is 150 and 2001-12-14 is a date. Here 0150 is 150, and the others are
texts, which no number accepts.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Hashable
from functools import lru_cache
from typing import Any

import yaml

from wroll_fem.errors import InputError

MOST_CHARACTERS = 500_000
MOST_NODES = 20_000
MOST_LEVELS = 40
"""Limits of a text: length, number of keys and values with every alias expanded, sections inside sections."""
KEPT_CHARACTERS = 20_000
"""Length up to which the content of a text is kept for the next time."""

_TAG = "tag:yaml.org,2002:"
_INT = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
"""Text of a decimal number."""
_FLOAT = re.compile(rf"{NUMBER.pattern}|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_MOST_DIGITS = 400  # of an integer; a double has at most 309
_UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff]")
_CHECK = "check indentation, colons and brackets"


class _Refused(yaml.constructor.ConstructorError):
    """YAML that is not accepted here, with its remedy."""

    def __init__(self, problem: str, mark: yaml.Mark, remedy: str) -> None:
        super().__init__(None, None, problem, mark)
        self.remedy = remedy


class _StrictLoader(yaml.SafeLoader):
    """YAML loader with the numbers of YAML 1.2, without dates, binary data and own tags, with limits."""

    yaml_constructors = {}  # noqa: RUF012  (of PyYAML: filled below)
    yaml_implicit_resolvers = {}  # noqa: RUF012

    def __init__(self, stream: str) -> None:
        super().__init__(stream)
        self._extents: dict[int, tuple[int, int]] = {}  # node -> number of nodes, levels; aliases expanded
        self._nodes: list[yaml.Node] = []  # they keep the keys of `_extents` unique

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose a node; refuse it where a limit is exceeded."""
        mark = self.peek_event().start_mark
        self._depth = getattr(self, "_depth", 0) + 1
        if self._depth > MOST_LEVELS:
            raise self._deep(mark)
        alias = self.check_event(yaml.AliasEvent)
        node = super().compose_node(parent, index)
        self._depth -= 1
        if node is None:
            return None
        if id(node) not in self._extents:
            if alias:
                raise _Refused("an alias refers to the section around it", mark, "write the value itself")
            self._nodes.append(node)
            self._extents[id(node)] = self._extent(node, mark)
        return node

    def _extent(self, node: yaml.Node, mark: yaml.Mark) -> tuple[int, int]:
        children: list[yaml.Node] = []
        if isinstance(node, yaml.SequenceNode):
            children = node.value
        elif isinstance(node, yaml.MappingNode):
            children = [part for pair in node.value for part in pair]
        elif _UNPRINTABLE.search(node.value):
            raise _Refused("a text contains a control character", mark, "write printable characters")
        parts = [self._extents[id(child)] for child in children]
        count, levels = 1 + sum(part[0] for part in parts), 1 + max((part[1] for part in parts), default=0)
        if count > MOST_NODES:
            problem = f"more than {MOST_NODES} keys and values, with every alias expanded"
            raise _Refused(problem, mark, "write less, or long tables into a file of their own")
        if levels > MOST_LEVELS:
            raise self._deep(mark)
        return count, levels

    @staticmethod
    def _deep(mark: yaml.Mark) -> _Refused:
        return _Refused(f"more than {MOST_LEVELS} levels of sections", mark, "close brackets, or indent less")

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """Mapping of a node; duplicate keys are refused."""
        seen: set[Any] = set()
        for key_node, _ in node.value:
            if isinstance(key_node, yaml.ScalarNode) and key_node.tag != f"{_TAG}merge":
                if key_node.value in seen:
                    raise _Refused(f"key {key_node.value!r} occurs twice", key_node.start_mark, "delete one")
                seen.add(key_node.value)
        return super().construct_mapping(node, deep)

    def construct_int(self, node: yaml.ScalarNode) -> int:
        """Decimal integer (also with zeros in front), 0o17 or 0x1f."""
        text = str(self.construct_scalar(node))
        if not _INT.fullmatch(text):
            raise _Refused("not a whole number", node.start_mark, "write decimal digits")
        if len(text) > _MOST_DIGITS:
            raise _Refused(f"a number of {len(text)} digits", node.start_mark, "write it as 1.5e+3")
        return int(text, 10 if text.lstrip("+-0")[:1] not in ("o", "x") else 0)

    def construct_float(self, node: yaml.ScalarNode) -> float:
        """Decimal number, .inf or .nan."""
        text = str(self.construct_scalar(node))
        if not _FLOAT.fullmatch(text):
            raise _Refused("not a number", node.start_mark, "write it as 1.5e+3")
        return float(text if NUMBER.fullmatch(text) else text.lower().replace(".", ""))

    def construct_switch(self, node: yaml.ScalarNode) -> bool:
        """Yes or no."""
        word = str(self.construct_scalar(node)).lower()
        if word not in self.bool_values:
            raise _Refused("neither true nor false", node.start_mark, "write true or false")
        return self.bool_values[word]

    def construct_undefined(self, node: yaml.Node) -> Any:
        """Refuse a tag."""
        tag = str(node.tag).replace(_TAG, "!!")[:40]
        raise _Refused(f"the tag {tag} is not used here", node.start_mark, "write the plain value")


for _name, _constructor in {
    "null": _StrictLoader.construct_yaml_null, "bool": _StrictLoader.construct_switch,
    "int": _StrictLoader.construct_int, "float": _StrictLoader.construct_float,
    "str": _StrictLoader.construct_yaml_str, "seq": _StrictLoader.construct_yaml_seq,
    "map": _StrictLoader.construct_yaml_map,
}.items():  # fmt: skip
    _StrictLoader.add_constructor(f"{_TAG}{_name}", _constructor)
_StrictLoader.add_constructor(None, _StrictLoader.construct_undefined)


class _Dumper(yaml.SafeDumper):
    """YAML writer that puts a text in quotes if `_StrictLoader` would read it as a number."""


for _target in (_StrictLoader, _Dumper):
    _target.add_implicit_resolver(f"{_TAG}int", re.compile(rf"(?:{_INT.pattern})\Z"), list("-+0123456789"))
    _target.add_implicit_resolver(f"{_TAG}float", re.compile(rf"(?:{_FLOAT.pattern})\Z"), list("-+0123456789."))
for _letter, _resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items():
    for _tag, _pattern in _resolvers:
        if _tag in (f"{_TAG}bool", f"{_TAG}null", f"{_TAG}merge"):
            _StrictLoader.yaml_implicit_resolvers.setdefault(_letter, []).append((_tag, _pattern))


@lru_cache(maxsize=256)
def _parsed(text: str) -> Any:
    """Content of a YAML text; the cases of a grid read one text hundreds of times. To be copied, not changed."""
    return yaml.load(text, Loader=_StrictLoader)


def parse_yaml(text: str, where: str) -> Any:
    """Parse a YAML text; ``where`` names the origin of the text in error messages.

    Raises
    ------
    InputError
        If the text is not valid YAML, or exceeds a limit.
    """
    if len(text) > MOST_CHARACTERS:
        problem = f"is too long ({len(text)} characters; at most {MOST_CHARACTERS})"
        raise InputError(problem, remedy="write long tables into a file of their own", file=where)
    remedy = _CHECK
    try:
        return copy.deepcopy(_parsed(text)) if len(text) <= KEPT_CHARACTERS else yaml.load(text, Loader=_StrictLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        spot = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = f"is not valid YAML{spot}: {error.problem}"
        remedy = error.remedy if isinstance(error, _Refused) else _CHECK
    except yaml.YAMLError as error:
        problem = f"is not valid YAML: {' '.join(str(error).split())}"
    raise InputError(problem, remedy=remedy, file=where)


def dump_yaml(data: Any, **options: Any) -> str:
    """YAML text of plain data, which `parse_yaml` reads as the same data; options as for `yaml.dump`."""
    return str(yaml.dump(data, Dumper=_Dumper, sort_keys=False, **options))


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
