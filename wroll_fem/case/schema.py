"""JSON schema of the case file, for completion and checks in an editor."""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import models_json_schema

from wroll_fem.case.case import case_kinds


def schema_text() -> str:
    """JSON schema of the case file, generated from the models (docs/wroll-case.schema.json is a copy).

    There is one schema per analysis. An analysis that accepts a roll or matrices from a file has one schema for each.
    The keys `analysis` and `structure` decide which schema applies.
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
    """Schema of the cases of an analysis, for a roll and for matrices from a file."""
    on_roll, on_structure = kinds[analysis, False], kinds.get((analysis, True))
    roll = {"$ref": f"#/$defs/{on_roll.__name__}"}
    if on_structure is None:
        return roll
    structure = {"$ref": f"#/$defs/{on_structure.__name__}"}
    return {"if": {"required": ["structure"]}, "then": structure, "else": roll}
