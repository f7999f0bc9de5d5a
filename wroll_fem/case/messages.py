"""One-line messages from the validation errors of pydantic."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, get_args, get_origin

import yaml
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from wroll_fem.case.descriptions import sections
from wroll_fem.case.hints import meant
from wroll_fem.errors import InputError

Refusal = Callable[[str], tuple[str, str] | None]
"""Function of a top-level key: returns problem and remedy, or None for a key that no analysis uses."""

MOST_ERRORS = 40
"""Largest number of errors of a file that are reported."""

_TAGS = ("kind", "law")
_BOUNDS = {
    "greater_than": ("must be greater than {gt:g}"),
    "greater_than_equal": ("must be {ge:g} or more"),
    "less_than": ("must be less than {lt:g}"),
    "less_than_equal": ("must be {le:g} or less"),
    "too_short": ("must have {min_length} or more entries"),
}
_KINDS = {
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "finite_number": "must be a finite number",
    "int_type": "must be a whole number",
    "int_parsing": "must be a whole number",
    "int_from_float": "must be a whole number",
    "model_type": "must be a section (key: value pairs)",
    "model_attributes_type": "must be a section (key: value pairs)",
    "list_type": "must be a list",
    "dict_type": "must be a section (key: value pairs)",
}


def input_error(
    errors: Sequence[ErrorDetails], model: type[BaseModel], *, file: str | None = None, overrides: Sequence[str] = (),
    known: Sequence[str] = (), refusal: Refusal | None = None,
) -> InputError:  # fmt: skip
    """Turn validation errors into errors of one line each: file, dotted key, problem, value, remedy.

    Parameters
    ----------
    errors
        What pydantic found (`ValidationError.errors`); the message is about the first error, and `InputError.others`
        holds the rest.
    model
        Root model, to find descriptions and the nearest known key.
    file
        File the input came from.
    overrides
        Dotted keys given with `--set`; an error in one of them names `--set key`.
    known
        Top-level keys in the order in which a message lists them; if empty, the keys of the model.
    refusal
        Function of a top-level key that the model does not have; returns problem and remedy, or None for an
        unknown key.
    """
    details = [d for d in errors if d["type"] != "default_factory_not_called"]
    refused = {d["loc"]: refusal(str(d["loc"][0])) if refusal and len(d["loc"]) == 1 else None for d in details}
    details.sort(key=lambda d: d["type"] != "extra_forbidden" or refused[d["loc"]] is not None)
    details = details[:MOST_ERRORS]
    found: list[InputError] = []
    named: set[str] = set()
    for detail in details:
        reason = refused[detail["loc"]] if detail["type"] == "extra_forbidden" else None
        if detail["type"] == "missing" and ".".join(_walk(detail["loc"], model)[0]) in named:
            continue  # the key is there, misspelled
        key, problem, remedy, other = _refused(detail, *reason) if reason else _explain(detail, model, known)
        named.add(other)
        if any(key == given or key.startswith(f"{given}.") for given in overrides):
            key = f"--set {key}"
        one = InputError(problem, key=key or None, remedy=remedy, file=file)
        if str(one) not in map(str, found):
            found.append(one)
    found[0].others = tuple(found[1:])
    return found[0]


def _refused(detail: ErrorDetails, problem: str, remedy: str) -> tuple[str, str, str, str]:
    """Same values as `_explain`, for a top-level key for which the case class gives problem and remedy."""
    value = detail["input"]
    got = "" if isinstance(value, Mapping | BaseModel) else f", got {_show(value)}"
    return str(detail["loc"][0]), f"{problem}{got}", remedy, ""


def _explain(detail: ErrorDetails, model: type[BaseModel], known: Sequence[str]) -> tuple[str, str, str, str]:
    """Explain a validation error: (dotted key, problem with value, remedy, dotted key that was probably meant)."""
    kind, context, value = detail["type"], detail.get("ctx", {}), detail["input"]
    keys, parent = _walk(detail["loc"], model)
    key = ".".join(keys)
    got = f", got {_show(value)}"
    if kind == "wroll":
        key = ".".join(part for part in (key, context["key"]) if part)
        got = f", got {_show(context['value'])}" if context["show_value"] else ""
        return key, f"{context['problem']}{got}", str(context["remedy"]), ""
    if kind == "extra_forbidden":
        remedy, other = _unknown_key(keys, value, parent, model, known)
        return key, f"unknown key{got}", remedy, other
    field = parent.model_fields.get(keys[-1]) if keys and parent else None
    if field is None and len(keys) > 1 and keys[-1].isdigit():  # an entry of a list has the list's description
        field = _field_at(keys[:-1], model)
    what = field.description if field is not None and field.description else "see `wroll schema`"
    if kind == "missing":
        section = field is not None and _section_of(field.annotation) is not None
        return (
            key,
            f"required {'section' if section else 'key'} is missing",
            f"add it ({what}){_example(field, key)}",
            "",
        )
    if kind in ("literal_error", "union_tag_invalid"):
        options = str(context.get("expected") or context.get("expected_tags")).replace("'", "")
        if kind == "union_tag_invalid":
            tag = str(context["discriminator"]).strip("'")
            key, value = f"{key}.{tag}", value.get(tag)
        return key, f"is not one of the choices, got {_show(value)}", f"use {options.replace(' or ', ', ')}", ""
    if kind == "union_tag_not_found":
        found = [str(tag) for one in sections(field.annotation) for tag in _tags(one)] if field is not None else []
        kinds = "chirp, dwell or sine" if not found or keys[-1] == "excitation" else " or ".join(found)
        return f"{key}.kind", "required key is missing", f"add it ({what}): {kinds}", ""
    if kind in _BOUNDS:
        return key, f"{_BOUNDS[kind].format(**context)}{got}", f"give the {what}", ""
    if kind in _KINDS:
        remedy = f"give the {what}" if "section" not in _KINDS[kind] else "write its keys indented below it"
        return key, f"{_KINDS[kind]}{got}", remedy, ""
    return key, f"{detail['msg'][:1].lower()}{detail['msg'][1:]}{got}", f"give the {what}", ""


def _example(field: FieldInfo | None, key: str) -> str:
    """YAML example of a case section; empty if the field has none."""
    if field is None or not field.examples:
        return ""
    text = yaml.safe_dump(field.examples[0], default_flow_style=True, width=200).strip()
    return f", for example {key}: {text}"


def _walk(loc: tuple[int | str, ...], model: type[BaseModel]) -> tuple[list[str], type[BaseModel] | None]:
    """Keys on the path to an error, without pydantic's union tags, and the model that contains the last key."""
    keys: list[str] = []
    parent: type[BaseModel] | None = model
    here: Any = model
    for part in loc:
        named = _entries_of(here)
        if named is not None:
            keys.append(str(part))
            here = named
            continue
        options = sections(here)
        tagged = [m for m in options if len(options) > 1 and part in _tags(m)]
        if tagged:
            here = tagged[0]
            continue
        parent = options[0] if options else None
        keys.append(str(part))
        field = parent.model_fields.get(str(part)) if parent else None
        here = field.annotation if field is not None else None
    return keys, parent


def _entries_of(annotation: Any) -> Any:
    """Type of the entries of a case section whose keys are names chosen by the user; None for other annotations."""
    if get_origin(annotation) is dict:
        return get_args(annotation)[1]
    if isinstance(annotation, type):
        return None
    return next((found for argument in get_args(annotation) if (found := _entries_of(argument)) is not None), None)


def _field_at(keys: Sequence[str], model: type[BaseModel]) -> FieldInfo | None:
    """Field at the end of a path of keys, or None. If several kinds of a section have it, the first kind decides."""
    models, field = [model], None
    for key in keys:
        field = next((m.model_fields[key] for m in models if key in m.model_fields), None)
        if field is None:
            return None
        models = sections(field.annotation)
    return field


def _tags(model: type[BaseModel]) -> tuple[Any, ...]:
    """Values of the tag (`kind` or `law`) of a model; empty if it has no tag."""
    return next((get_args(model.model_fields[key].annotation) for key in _TAGS if key in model.model_fields), ())


def _section_of(annotation: Any) -> type[BaseModel] | None:
    found = sections(annotation)
    return found[0] if found else None


def _all_keys(model: type[BaseModel], prefix: str = "") -> Iterator[str]:
    for name, field in model.model_fields.items():
        yield f"{prefix}{name}"
        for section in sections(field.annotation):
            yield from _all_keys(section, f"{prefix}{name}.")


def _unknown_key(
    keys: list[str], value: Any, parent: type[BaseModel] | None, root: type[BaseModel], known: Sequence[str]
) -> tuple[str, str]:
    """Remedy for an unknown key, and the dotted key that was probably meant."""
    siblings = list(parent.model_fields) if parent else []
    if len(keys) == 1 and known:
        siblings = list(known)
    said, other = meant(keys, value, siblings)
    if said:
        return said, ".".join([*keys[:-1], other])
    near = difflib.get_close_matches(keys[-1], siblings, n=1)
    if near:
        return f"did you mean {near[0]}?", ".".join([*keys[:-1], near[0]])
    elsewhere = list(dict.fromkeys(k for k in _all_keys(root) if k.rsplit(".", 1)[-1] == keys[-1]))
    elsewhere = [k for k in elsewhere if k.startswith(f"{keys[0]}.")] or elsewhere  # the same section first
    elsewhere = [k for k in elsewhere if k.count(".") == min(other.count(".") for other in elsewhere)]
    if elsewhere and ".".join(keys) not in elsewhere:
        return f"did you mean {' or '.join(elsewhere)}?", elsewhere[0]
    return f"known keys: {', '.join(siblings)}", ""


def _show(value: Any) -> str:
    """Value as text of at most 60 characters; null, true and false as in YAML."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, int) and value.bit_length() > 1100:
        return f"a number of about {value.bit_length() * 0.30103:.0f} digits"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
