"""JSON schema of the case file, for completion and checks in an editor."""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import models_json_schema

from wroll_fem.case.case import case_kinds


def schema_text() -> str:
    """JSON schema of the case file, generated from the models (docs/wroll-case.schema.json is a copy).

    One schema per analysis, and where an analysis takes a roll or matrices from a file one for each; `analysis` and
    `structure` decide which one holds.
    """
    kinds = case_kinds()
    _, schema = models_json_schema([(kind, "validation") for kind in kinds.values()])
    analyses = list(dict.fromkeys(analysis for analysis, _ in kinds))
    schema |= {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "wroll_fem case",
        "type": "object",
        "properties": {"analysis": {"description": "what to compute", "enum": analyses}},
        "required": ["analysis"],
        "allOf": [
            {
                "if": {"properties": {"analysis": {"const": analysis}}, "required": ["analysis"]},
                "then": _of(analysis, kinds),
            }
            for analysis in analyses
        ],
    }
    return json.dumps(schema, indent=2, sort_keys=True) + "\n"


def _of(analysis: str, kinds: dict[tuple[str, bool], Any]) -> dict[str, Any]:
    """Schema of an analysis: on a roll, or on matrices from a file."""
    on_roll, on_structure = kinds[analysis, False], kinds.get((analysis, True))
    roll = {"$ref": f"#/$defs/{on_roll.__name__}"}
    if on_structure is None:
        return roll
    structure = {"$ref": f"#/$defs/{on_structure.__name__}"}
    return {"if": {"required": ["structure"]}, "then": structure, "else": roll}
