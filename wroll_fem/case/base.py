"""Base classes (strict, immutable models) and number types of the case sections."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    GetJsonSchemaHandler,
    SerializerFunctionWrapHandler,
    model_serializer,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError


class Section(BaseModel):
    """Immutable case section in SI units; unknown keys are refused."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, validate_default=False,
        defer_build=True,  # the commands that read no case start faster
    )  # fmt: skip


class TaggedSection(Section):
    """Case section that has several kinds; the key `kind` or `law` selects one and is required in case files."""

    TAGS: ClassVar[tuple[str, ...]] = ("kind", "law")

    def model_post_init(self, context: Any) -> None:
        """Mark the tag, `kind` or `law`, as set, so that it is always serialised."""
        self.model_fields_set.update(tag for tag in self.TAGS if tag in type(self).model_fields)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """JSON schema in which the tag is required."""
        schema = handler.resolve_ref_schema(handler(core))
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
        What is wrong, without the value.
    remedy
        What to do.
    key
        Dotted key relative to the model whose validator fails; empty for the validator of a single field.
    value
        The offending value, shown as "got VALUE".
    show_value
        False when there is no value to show (a missing section).
    """
    context = {"problem": problem, "remedy": remedy, "key": key, "value": value, "show_value": show_value}
    return PydanticCustomError("wroll", "{problem}; {remedy}", context)


def _number(value: Any) -> Any:
    """Convert a number that PyYAML reads as text, such as '1e-3', to a float; refuse booleans and other text."""
    if isinstance(value, bool):
        raise validation_error("must be a number", remedy="write a number, not true or false", value=value)
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            remedy = "write a plain number in SI units, for example 1.5e-3"
            raise validation_error("must be a number", remedy=remedy, value=value) from None
    return value


def _switch(value: Any) -> Any:
    if not isinstance(value, bool):
        raise validation_error("must be true or false", remedy="write true or false", value=value)
    return value


Real = Annotated[float, BeforeValidator(_number)]
Whole = Annotated[int, BeforeValidator(_number)]
Switch = Annotated[bool, BeforeValidator(_switch)]
