"""The command `wroll`: a module per group of commands.

Heavy libraries are imported inside the commands that need them, so that `wroll --help` and error messages are instant.
"""

from __future__ import annotations

import os
import sys

# One thread per process: the matrices of the solvers are small, and more threads only slow the computation down.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from wroll_fem.cli import runs  # isort: skip
from wroll_fem.cli import cases  # isort: skip
from wroll_fem.cli import results  # isort: skip
from wroll_fem.cli import lab  # isort: skip
from wroll_fem.cli import project  # isort: skip
from wroll_fem.cli.app import app

__all__ = [
    "app",
    "cases",
    "lab",
    "main",
    "project",
    "results",
    "runs",
]  # the order of imports is that of `wroll --help`


def main() -> None:
    """Entry point of the command `wroll`."""
    try:
        app()
    except BrokenPipeError:  # the reader (head, less) has ended: nothing more can be printed
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
