"""Measurement of which damaged copies are made."""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

Damaged = tuple[list[Path], dict[str, Any]]
"""Files and settings."""

CELLS = (
    "nan", "inf", "-inf", "1e308", "-1e308", "1e400", "5e-324", "", "x", "1,5", "0", "-0", "1e-320", "１", "0x1", "1_0",
    "=1", "1;2", "\x00", '"', "1" * 400, "1e-300", "1e30", "NULL", "--",
)  # fmt: skip


class Original(ABC):
    """Measurement, from which damaged copies are made.

    Attributes
    ----------
    kind
        Kind of the evaluation.
    """

    kind: str

    @abstractmethod
    def damaged(self, place: Path, chance: random.Random) -> Damaged:
        """Damaged copy in a folder: files and settings."""

    def read_alone(self, files: list[Path], settings: dict[str, Any]) -> bool:
        """Read the damaged file alone, where the evaluation takes much longer; False if it has to be evaluated."""
        return False
