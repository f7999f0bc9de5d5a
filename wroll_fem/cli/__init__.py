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
from wroll_fem.errors import StorageError
from wroll_fem.results.storage.atomic import writing_error

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
        try:
            app()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:  # the reader (head, less) has ended: nothing more can be printed
        _drop_output()
        sys.exit(1)
    except OSError as error:  # of standard output, or of a library's cache
        found = writing_error(error, error.filename or "standard output")
        if not isinstance(found, StorageError):
            raise
        _drop_output()
        print(found, file=sys.stderr)  # noqa: T201
        sys.exit(found.exit_code)


def _drop_output() -> None:
    """Send what is still to be printed nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
