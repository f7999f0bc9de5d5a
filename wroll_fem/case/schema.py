"""JSON schema of the case file, for completion and checks in an editor."""

from __future__ import annotations

import json

from wroll_fem.case.case import Case


def schema_text() -> str:
    """JSON schema of the case file, generated from the models (docs/wroll-case.schema.json is a copy)."""
    schema = Case.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "wroll_fem case"
    return json.dumps(schema, indent=2, sort_keys=True) + "\n"
