"""Work for other processes; they import this module alone, so that they start in a moment."""

from __future__ import annotations

import os


def process_and_square(x: int) -> tuple[int, int]:
    """Number of the process, and a square."""
    return os.getpid(), x * x
