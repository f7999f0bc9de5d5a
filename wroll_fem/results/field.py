"""Unit and label of a variable of a result."""

from __future__ import annotations

from typing import NamedTuple


class Field(NamedTuple):
    """Unit (SI, "1" if dimensionless) and label of a variable or coordinate."""

    units: str
    long_name: str
