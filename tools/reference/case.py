"""Reference of the case file from the pydantic models: every case section and key."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from tools.reference.markdown import GENERATED, code, prose, table
from wroll_fem.analyses.registry import all_analyses
from wroll_fem.case.base import TaggedSection
from wroll_fem.case.case import case_sections
from wroll_fem.case.descriptions import sections, unit_of

_SHOWN = {"dimensionless": "1", "multiples of 9.80665 m/s^2": "g", "octaves per minute": "oct/min"}

_CONDITIONAL = {("Coil", "total_thickness"), ("Coil", "material")}
"""Required keys whose model has a placeholder as default; validators of the case section require them."""

_INTRO = """# Case file

This page lists every section and key of a case file (YAML). A case is one file, and no other setting changes a result.
Units are SI; numbers may be written as `1e-3`. An unknown key is refused, and the message names the nearest known key.
Any key can be changed on the command line by its dotted name, `--set contact.friction.mu=0.5`, and varied by
[wroll batch](../batch.md).

"required" keys have no default. A default that depends on other keys is explained in the description. Editors complete
and check the file with [wroll-case.schema.json](../wroll-case.schema.json); the first line of each file in `configs/`
points to it. Start from one of these files.
"""


_ANALYSES = """`contact` and `preload` are needed only with `coil.model: layers` (by `modal` only with
`modal.interface: stuck`). `structure` replaces geometry, mandrel, coil, mesh and preload; contact is then optional.
`preload.kind: winding_tension` needs `winding`. `design_map`, `two_dof`, `sizing` and `damping_ratio` belong to one
analysis; other sections may be in the file without use."""


def case_page() -> str:
    """Markdown of the reference of the case file."""
    parts = [GENERATED, _INTRO, "## Analyses", _analyses(), _ANALYSES, "## Sections", _overview()]
    told: dict[type[BaseModel], str] = {}
    for name, field in case_sections().items():
        models = sections(field.annotation)
        if len(models) > 1:
            parts += [f"## {code(name)}", prose(_sentence(field.description)) + "."]
        for model in models:
            parts += section_parts(name, model, told, tagged=len(models) > 1, level=3 if len(models) > 1 else 2)
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _overview() -> str:
    rows = []
    for name, field in case_sections().items():
        models = sections(field.annotation)
        shown = f"[{code(name)}](#{name})" if models else code(name)
        kind = "section" if models else type_name(field.annotation)
        rows.append((shown, kind, prose(field.description or "")))
    return table(("key", "type", "meaning"), rows)


def _analyses() -> str:
    rows = ((code(one.name), one.sentence, ", ".join(code(key) for key in one.sections)) for one in all_analyses())
    return table(("analysis", "computes", "needs"), rows)


def section_parts(
    path: str, model: type[BaseModel], told: dict[type[BaseModel], str], *, tagged: bool, level: int
) -> list[str]:
    """Heading, description and table of a case section and its nested sections; repeated sections are linked."""
    name = path
    if tagged:
        (value,) = get_args(model.model_fields[_tag(model)].annotation)
        name = f"{path}.{_tag(model)}: {value}"
    parts = [f"{'#' * level} {code(name)}"]
    if model in told:
        return [*parts, f"As {code(told[model])}."]
    told[model] = name
    parts.append(prose(_first_paragraph(model)))
    parts.append(table(("key", "type", "unit", "default", "bounds", "meaning"), _rows(model)))
    for key, field in model.model_fields.items():
        inner = sections(field.annotation)
        for one in inner:
            parts += section_parts(f"{path}.{key}", one, told, tagged=len(inner) > 1, level=3)
    return parts


def _tag(model: type[BaseModel]) -> str:
    """Discriminating key of a case section with several kinds; "" if there is only one kind."""
    return next((key for key in ("kind", "law") if key in model.model_fields), "")


def _rows(model: type[BaseModel]) -> Iterator[tuple[str, ...]]:
    fields = model.model_fields
    for name in sorted(fields, key=lambda key: key != _tag(model)):
        field = fields[name]
        words = field.description or ""
        unit = "as the enclosing key" if "as the enclosing key" in words else unit_of(words)
        yield (
            code(name), type_name(field.annotation), _SHOWN.get(unit, unit), default_of(model, name, field),
            bounds(field), prose(words),
        )  # fmt: skip


_NAMES: dict[Any, str] = {float: "number", int: "whole number", bool: "true, false", str: "text", Path: "path"}


def type_name(annotation: Any) -> str:
    """Type of a key, for the reader."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return type_name(arguments[0])
    if origin is Literal:
        return ", ".join(code(str(value)) for value in arguments)
    if origin is tuple:
        return "pair"
    if origin is list:
        return f"list of {type_name(arguments[0])}s"
    if origin is dict and not sections(annotation):
        return f"{type_name(arguments[1])} per key"
    if origin in (Union, UnionType):
        models = sections(annotation)
        if models:
            return "section"
        return " or ".join(dict.fromkeys(type_name(option) for option in arguments if option is not NoneType))
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return "section"
    return _NAMES[annotation]


def default_of(model: type[BaseModel], name: str, field: FieldInfo) -> str:
    """Default of a key, for the reader."""
    if (model.__name__, name) in _CONDITIONAL:
        return "required but for `model: none`"
    if field.is_required() or (issubclass(model, TaggedSection) and name in TaggedSection.TAGS):
        return "required"
    value = field.get_default(call_default_factory=True, validated_data={})
    if isinstance(value, BaseModel):
        return "its own defaults"
    if value is None:
        return "left out"
    if isinstance(value, float) and math.isnan(value):
        return "from others"
    if isinstance(value, bool):
        return code(str(value).lower())
    return code(f"{value:g}".replace("e-0", "e-") if isinstance(value, float) else str(value))


def bounds(field: FieldInfo) -> str:
    """Bounds of a number or of the length of a list."""
    found = []
    for item in field.metadata:
        if isinstance(item, Gt):
            found.append(f"> {item.gt:g}")
        elif isinstance(item, Ge):
            found.append(f"≥ {item.ge:g}")
        elif isinstance(item, Lt):
            found.append(f"< {item.lt:g}")
        elif isinstance(item, Le):
            found.append(f"≤ {item.le:g}")
        elif isinstance(item, MinLen):
            found.append(f"{item.min_length} or more entries")
    return ", ".join(found)


def _first_paragraph(model: type[BaseModel]) -> str:
    return " ".join((model.__doc__ or "").split("\n\n")[0].split())


def _sentence(text: str | None) -> str:
    words = (text or "").strip()
    return words[:1].upper() + words[1:]
