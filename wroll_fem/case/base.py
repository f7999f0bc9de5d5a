"""Base classes (strict, immutable models) and number types of the case sections."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    GetJsonSchemaHandler,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError

from wroll_fem.case.descriptions import unit_of
from wroll_fem.case.strict_yaml import NUMBER
from wroll_fem.case.units import KINDS, QUANTITY_PATTERN, WrongQuantity, in_si

OF_ENCLOSING_KEY = "as the enclosing key"
"""Words in the description of a key whose unit is that of the section around it."""


class Section(BaseModel):
    """Immutable case section in SI units; unknown keys are refused.

    A key whose description contains a unit also takes a text with another unit, such as "1200 mm"; see `units.in_si`.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, validate_default=False,
        defer_build=True,  # the commands that read no case start faster
    )  # fmt: skip

    @model_validator(mode="before")
    @classmethod
    def _in_si(cls, data: Any) -> Any:
        """Convert texts with units to numbers in SI; mark numbers beyond the range of their unit."""
        if not isinstance(data, Mapping):
            return data
        units = {
            key: cls.unit_of(key)
            for key, value in data.items()
            if key in cls.model_fields and isinstance(value, str | int | float | list | tuple)
        }
        return {**data, **{key: _converted(data[key], unit) for key, unit in units.items()}}

    @classmethod
    def unit_of(cls, key: str) -> str:
        """Unit of a key, as its description spells it; "" if the key has no unit of its own."""
        description = cls.model_fields[key].description or ""
        return "" if OF_ENCLOSING_KEY in description else unit_of(description)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """JSON schema in which a number with a unit may also be a text, such as "1200 mm"."""
        schema = handler.resolve_ref_schema(handler(core))
        keys = schema.get("properties", {})
        for key in keys:
            if key in cls.model_fields and cls.unit_of(key) in KINDS:
                keys[key] = _or_quantity(keys[key])
        return schema


class TaggedSection(Section):
    """Case section that has several kinds; the key `kind` or `law` selects one and is required in case files."""

    TAGS: ClassVar[tuple[str, ...]] = ("kind", "law")

    def model_post_init(self, context: Any) -> None:
        """Mark the tag, `kind` or `law`, as set, so that it is always serialised."""
        self.model_fields_set.update(tag for tag in self.TAGS if tag in type(self).model_fields)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """JSON schema in which the tag is required."""
        schema = super().__get_pydantic_json_schema__(core, handler)
        tags = [tag for tag in cls.TAGS if tag in cls.model_fields]
        schema["required"] = [*tags, *(key for key in schema.get("required", []) if key not in tags)]
        return schema


class SparseSection(Section):
    """Case section that is serialised without the keys that have no value (None)."""

    @model_serializer(mode="wrap")
    def _without_empty_keys(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in dict(dump(self)).items() if value is not None}


def validation_error(
    problem: str, *, remedy: str, key: str = "", value: Any = None, show_value: bool = True
) -> PydanticCustomError:
    """Return the validation error of a check that cannot be written as a bound on a field.

    Parameters
    ----------
    problem
        What is wrong; without the value, unless ``show_value`` is False.
    remedy
        What to do.
    key
        Dotted key relative to the model whose validator fails; empty for the validator of a single field.
    value
        The offending value, shown as "got VALUE".
    show_value
        False when there is no value to show (a missing section), or ``problem`` contains it.
    """
    context = {"problem": problem, "remedy": remedy, "key": key, "value": value, "show_value": show_value}
    return PydanticCustomError("wroll", "{problem}; {remedy}", context)


def _converted(value: Any, unit: str) -> Any:
    """Text with a unit, or a list with such texts, in the SI unit ``unit``; anything else is returned unchanged.

    A number beyond the range of its unit (`RANGES`) is returned as `WrongQuantity`.
    """
    if isinstance(value, list | tuple):
        return [_converted(entry, unit) for entry in value]
    number = in_si(value, unit) if isinstance(value, str) else value
    if unit in RANGES and isinstance(number, int | float) and _beyond(number, *RANGES[unit]):
        return WrongQuantity(str(value), BEYOND, _between(*RANGES[unit], f"in {unit}"))
    return number


_OF_THE_KEY = ("title", "description", "default", "examples", "deprecated")
"""Entries of a JSON schema that belong to the key, not to one of the types of its value."""


def _or_quantity(schema: JsonSchemaValue) -> JsonSchemaValue:
    """JSON schema of a number, or of a list of numbers, that also takes texts with units."""
    if schema.get("type") == "array":
        lists = {name: _or_quantity(schema[name]) for name in ("items",) if name in schema}
        pairs = {"prefixItems": [_or_quantity(entry) for entry in schema.get("prefixItems", [])]}
        return schema | lists | {name: entries for name, entries in pairs.items() if entries}
    text = {"type": "string", "pattern": QUANTITY_PATTERN}
    if "anyOf" in schema:
        options = [_or_quantity(option) if option.get("type") == "array" else option for option in schema["anyOf"]]
        return schema | {"anyOf": [*options, text] if any(o.get("type") == "number" for o in options) else options}
    if schema.get("type") != "number":
        return schema
    kept = {name: schema[name] for name in _OF_THE_KEY if name in schema}
    number = {name: value for name, value in schema.items() if name not in kept}
    return {"anyOf": [number, text]} | kept


SMALLEST, LARGEST = 1e-30, 1e30
"""Range of the numbers of a case, in SI units: products of several of them neither overflow nor vanish."""

RANGES = {"m": (1e-15, 1e6), "Pa": (1e-6, 1e18), "kg/m^3": (1e-15, 1e12)}
"""Unit -> range of the numbers with this unit. A roll of atoms or planets has no frequencies that can be computed."""

BEYOND = "is beyond all quantities of a roll"


def _beyond(value: float, smallest: float, largest: float) -> bool:
    return bool(value) and not smallest <= abs(value) <= largest and abs(value) < math.inf


def _between(smallest: float, largest: float, where: str) -> str:
    return f"write 0, or a number between {smallest:g} and {largest:g} {where}"


def _number(value: Any) -> Any:
    """Convert a number that PyYAML reads as text, such as '1e-3', to a float; refuse booleans and other text."""
    if isinstance(value, WrongQuantity):
        raise validation_error(value.problem, remedy=value.remedy, value=str(value))
    if isinstance(value, bool):
        raise validation_error("must be a number", remedy="write a number, not true or false", value=value)
    if isinstance(value, str):
        if NUMBER.fullmatch(value.strip()):
            return _number(float(value))
        remedy = "write a plain number in SI units, for example 1.5e-3"
        raise validation_error("must be a number", remedy=remedy, value=value)
    if isinstance(value, int | float) and _beyond(value, SMALLEST, LARGEST):
        raise validation_error(BEYOND, remedy=_between(SMALLEST, LARGEST, "in SI units"), value=value)
    return value


def _switch(value: Any) -> Any:
    if not isinstance(value, bool):
        raise validation_error("must be true or false", remedy="write true or false", value=value)
    return value


Real = Annotated[float, BeforeValidator(_number)]
Whole = Annotated[int, BeforeValidator(_number)]
Switch = Annotated[bool, BeforeValidator(_switch)]
