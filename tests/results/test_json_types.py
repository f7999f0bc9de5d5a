"""Conversion of values to JSON types."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from wroll_fem.results.json_types import json_types


def test_numpy_paths_and_odd_numbers_become_types_of_json() -> None:
    value = {
        "a": np.float32(1.5),
        "b": np.array([[1, 2]]),
        "c": (np.inf, -np.inf, np.nan),
        "d": Path("x"),
        3: np.bool_(True),
    }
    assert json_types(value) == {"a": 1.5, "b": [[1, 2]], "c": [None, None, None], "d": "x", "3": True}


def test_numbers_that_are_not_finite_are_kept_on_request() -> None:
    kept = json_types({"x": np.array([1.0, np.nan, -np.inf])}, keep_non_finite=True)["x"]
    assert kept[0] == 1.0
    assert math.isnan(kept[1])
    assert kept[2] == -math.inf
