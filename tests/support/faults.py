"""Faults of the storage in a child process: it is killed, or its disk is full, at the n-th file operation."""

from __future__ import annotations

import errno
import os
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

Fault = Literal["kill", "full"]

KILLED, PASSED = 137, 42
"""Exit codes of a child that was killed, and of one that ended before its n-th operation."""

_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


@dataclass(frozen=True)
class Ended:
    """End of a child: exit code, what it wrote to standard error, whether the fault happened."""

    code: int
    errors: str
    reached: bool


def with_fault(
    action: Callable[[], object], folder: Path, fault: Fault, number: int, *, once: bool = False, freed_by: str = ""
) -> Ended:
    """Run ``action`` in a child process with a fault at its n-th writing operation (from 1) below ``folder``.

    Operations are opening for writing, renaming, removing, making a folder, and synchronising. A killed child runs no
    handler. On a full disk this operation and all later ones fail, except removing; with ``once`` this one only, with
    ``freed_by`` until a file of this name is removed.
    """
    told, mark = folder.parent / f"{folder.name}.stderr", folder.parent / f"{folder.name}.reached"
    told.unlink(missing_ok=True)
    mark.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        _in_child(action, folder, fault, number, told, mark, once, freed_by)
    _, status = os.waitpid(child, 0)
    return Ended(os.waitstatus_to_exitcode(status), told.read_text(errors="replace"), mark.exists())


def _in_child(
    action: Callable[[], object], folder: Path, fault: Fault, number: int, told: Path, mark: Path, once: bool,
    freed_by: str,
) -> None:  # fmt: skip
    code = 1
    try:
        stream = os.open(told, os.O_WRONLY | os.O_CREAT)
        os.dup2(stream, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", closefd=False)  # noqa: SIM115
        reached = os.open(mark.parent, os.O_RDONLY)
        marked = lambda: os.close(os.open(mark.name, os.O_CREAT | os.O_WRONLY, dir_fd=reached))  # noqa: E731
        _break(folder, fault, number, marked, once, freed_by)
        action()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


def _break(folder: Path, fault: Fault, number: int, reached: Callable[[], None], once: bool, freed_by: str) -> None:
    """Let the n-th writing operation below ``folder`` fail in this process."""
    root, count = str(folder.resolve()), 0
    synchronise, quiet, freed = os.fsync, False, False

    def operation(*, frees: bool) -> None:
        nonlocal count, quiet
        count += 1
        if count == number:
            quiet = True
            reached()
            quiet = False
            if fault == "kill":
                os._exit(KILLED)
        if (count == number or (count > number and not once)) and not frees and not freed:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal freed
        if quiet or event not in ("open", "os.rename", "os.remove", "os.mkdir"):
            return
        place = arguments[0]
        if not isinstance(place, str | os.PathLike):
            return
        if event == "open" and not (arguments[2] or 0) & _WRITES:
            return
        if os.path.abspath(os.fspath(place)).startswith(root):
            operation(frees=event == "os.remove")
            if freed_by and event == "os.remove" and count > number and os.path.basename(os.fspath(place)) == freed_by:
                freed = True

    def fsync(descriptor: int) -> None:
        operation(frees=False)
        synchronise(descriptor)

    os.fsync = fsync
    sys.addaudithook(hook)
