"""Conversion of values to JSON types."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def json_types(value: Any, *, keep_non_finite: bool = False) -> Any:
    """Convert a value to JSON types: numpy values to Python values, tuples to lists, paths to text.

    Parameters
    ----------
    value
        Scalar, array, path, or mappings and sequences of them; keys of mappings become text.
    keep_non_finite
        Keep nan and infinity, which Python's json can write and read; otherwise None replaces them.
    """
    if isinstance(value, Mapping):
        return {str(key): json_types(item, keep_non_finite=keep_non_finite) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_types(item, keep_non_finite=keep_non_finite) for item in value]
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return json_types(value.tolist(), keep_non_finite=keep_non_finite)
    if isinstance(value, float) and not math.isfinite(value) and not keep_non_finite:
        return None
    return value
