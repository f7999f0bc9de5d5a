"""File friction.yaml: the case section `contact.friction`, ready for `--set` and for a case file."""

from __future__ import annotations

from collections.abc import Sequence

import yaml
from pydantic import TypeAdapter, ValidationError

from wroll_fem.case.contact import Friction
from wroll_fem.errors import InputError


def law_text(section: dict[str, object], remarks: Sequence[str]) -> str:
    """YAML text of the section, with remarks as comments; it is the value of the key `contact.friction`.

    Raises
    ------
    InputError
        If the section is not one that a case accepts.
    """
    head = [
        "# Section contact.friction of a case file; run a case with it by",
        "#   wroll run CASE.yaml --set contact.friction=@friction.yaml",
        *(f"# {text}" for text in remarks),
    ]
    _check(section)
    return "\n".join([*head, yaml.safe_dump(section, sort_keys=False, default_flow_style=None, width=120)])


def _check(section: dict[str, object]) -> None:
    try:
        TypeAdapter(Friction).validate_python(section)
    except ValidationError as error:
        first = error.errors()[0]
        raise InputError(
            f"the fitted law is not admissible: {first['msg']}", key="rate_model",
            remedy="use rate_model: constant, or more records",
        ) from None  # fmt: skip
