"""Description of a case, from the content of its case.yaml and the descriptions in the case models.

Sections and keys that the models do not know (those of other versions) are shown as they are written.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from wroll_fem.analyses.registry import find_analysis
from wroll_fem.case.analyses import MODULES
from wroll_fem.case.case import case_sections
from wroll_fem.case.descriptions import meaning_of, name_of, sections, unit_of
from wroll_fem.report.values import quantity

Plain = Mapping[str, Any]

_SETTINGS = {"modal": ("modal",), "harmonic": ("harmonic", "backbone"), "backbone": ("backbone",)}
"""Case section with defaults -> analyses that use it; reports of other analyses omit the section."""

_WITHOUT_STEPS = ("modal", "modal_transient", "slip_damping", "winding", "design_map", "sizing", "two_dof")
"""Analyses without time integration and without load increments."""

NUMERICS = ("integrator", "solver", "mesh", "modal", "harmonic", "backbone")
"""Case sections of numerical settings."""

_NOT_PHYSICS = ("checkpoint_seconds", "allow_coarse")
"""Keys without influence on results."""

_TAGS = ("kind", "law", "model")
"""Keys that select the kind of a case section."""

_SHOWN = {
    "octaves per minute": "oct/min", "multiples of 9.80665 m/s^2": "g", "kg/m^3": "kg/m³", "m/s^2": "m/s²",
    "count": "", "dimensionless": "",
}  # fmt: skip
_WITH_PREFIX = ("Pa", "kg", "m", "s", "N")
_AS_AROUND = "as the enclosing key"
_MOST_VALUES = 12


class CaseRow(NamedTuple):
    """Row of the table of keys: case section, label, value with unit, dotted key."""

    section: str
    name: str
    value: str
    key: str


def analysis_words(data: Plain) -> str:
    """Name of the analysis, followed by its description if the program has an analysis of this name."""
    name = str(data.get("analysis", "unknown"))
    return f"{name}. {find_analysis(name).sentence}" if name in MODULES else f"{name}."


def case_rows(data: Plain) -> list[CaseRow]:
    """Keys of the case sections that the analysis uses, in the order of the case file."""
    analysis = data.get("analysis")
    rows: list[CaseRow] = []
    known = case_sections()
    for key, value in data.items():
        if key in ("analysis", "output") or value is None or analysis not in _SETTINGS.get(key, (analysis,)):
            continue
        if key in ("integrator", "solver") and analysis in _WITHOUT_STEPS:
            continue
        title = key.replace("_", " ").capitalize()
        rows += [CaseRow(title, *rest) for rest in _rows(known, key, value, key, "")]
    return rows


def setting_rows(fields: Mapping[str, FieldInfo], data: Plain) -> list[CaseRow]:
    """Settings of an evaluation of the laboratory, those without a section first.

    Parameters
    ----------
    fields
        Fields of the model of the settings.
    data
        Content of settings.yaml.
    """
    rows: list[CaseRow] = []
    for key, value in sorted(data.items(), key=lambda item: isinstance(item[1], Mapping)):
        if key == "figures" or value is None:
            continue
        title = str(key).replace("_", " ").capitalize() if isinstance(value, Mapping) else "Settings"
        rows += [CaseRow(title, *rest) for rest in _rows(fields, str(key), value, str(key), "")]
    return rows


def _rows(
    fields: Mapping[str, FieldInfo], name: str, value: Any, key: str, unit_around: str
) -> Iterator[tuple[str, str, str]]:
    """Table rows (label, value with unit, dotted key) of a single key, or of all keys in a case section.

    Keys without a value and keys without influence on results are omitted from a case section.
    """
    field = fields.get(name)
    words = (field.description or "") if field is not None else ""
    unit = unit_around if _AS_AROUND in words else unit_of(words)
    if isinstance(value, Mapping):
        model = _model(sections(field.annotation) if field is not None else [], value)
        inner = {} if model is None else model.model_fields
        for one in sorted(value, key=lambda name: name not in _TAGS):
            if value[one] is not None and one not in _NOT_PHYSICS:
                yield from _rows(inner, one, value[one], f"{key}.{one}", unit)
    elif isinstance(value, list) and value and all(isinstance(entry, Mapping) for entry in value):
        model = _model(sections(field.annotation) if field is not None else [], value[0])
        inner = {} if model is None else model.model_fields
        for number, entry in enumerate(value):
            parts = [_in_brief(inner, one, held) for one, held in entry.items() if held is not None]
            yield f"{name.replace('_', ' ')} {number + 1}", ", ".join(parts), f"{key}.{number}"
    elif isinstance(value, bool):
        meaning = "" if value else meaning_of(words, "false")
        yield _name(name, words), f"{'yes' if value else 'no'}{f': {meaning}' if meaning else ''}", key
    elif isinstance(value, str):
        meaning = meaning_of(words, value)
        label = _name(name, "" if meaning or ("; " in words and not unit) else words)
        yield label, f"{value}: {meaning}" if meaning else value, key
    else:
        yield _name(name, words), _value(value, unit), key


def _in_brief(fields: Mapping[str, FieldInfo], name: str, value: Any) -> str:
    """Name and value of a key of a list entry; of a section within the entry its kind alone."""
    if isinstance(value, Mapping):
        return str(value.get("kind", name))
    field = fields.get(name)
    unit = unit_of(field.description or "") if field is not None else ""
    return f"{name.replace('_', ' ')} {_value(value, unit)}"


def _name(name: str, words: str) -> str:
    return (name_of(words) if words else "") or name.replace("_", " ")


def _model(models: list[type[BaseModel]], value: Plain) -> type[BaseModel] | None:
    """First class of ``models`` that has all keys of ``value`` and allows its kind; if none fits, the first class."""
    for model in models:
        if not set(value) <= set(model.model_fields):
            continue
        tags = [tag for tag in _TAGS if tag in value and len(models) > 1]
        if all(str(value[tag]) in str(model.model_fields[tag].annotation) for tag in tags):
            return model
    return models[0] if models else None


def _value(value: Any, unit: str) -> str:
    """Number, or list of numbers, with its unit."""
    if isinstance(value, list):
        if len(value) > _MOST_VALUES:
            return f"{len(value)} values from {_value(value[0], unit)} to {_value(value[-1], unit)}"
        return ", ".join(_value(item, unit) for item in value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    if unit in _WITH_PREFIX:
        return quantity(float(value), unit)
    if unit == "m/s":
        return f"{quantity(float(value), 'm')}/s"
    return f"{value:.6g} {_SHOWN.get(unit, unit)}".rstrip()
