"""Example measurements with known truth, from which each kind can be tried and is tested."""

from __future__ import annotations

import shlex
from pathlib import Path

from wroll_fem.errors import InputError
from wroll_fem.lab.kinds import find_kind


def example_files(kind: str, out: str | Path) -> list[Path]:
    """Write the example of a kind into a new or empty folder; return the files to evaluate.

    Raises
    ------
    InputError
        If the folder is not empty or cannot be written, or the kind is unknown or has no example.
    """
    declared = find_kind(kind)
    if declared.example is None:
        raise InputError(f"{kind} has no example", remedy="see docs/laboratory.md")
    folder = Path(out)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError("is not an empty folder", file=str(folder), remedy="choose another --out")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return declared.example(folder)
    except OSError as error:
        raise InputError(
            f"cannot be written ({error.strerror})", file=str(folder), remedy="choose another --out"
        ) from None


def write_example(kind: str, out: str | Path) -> list[str]:
    """Write the example of a kind; return its files and the command that evaluates them, one per line."""
    files = example_files(kind, out)
    words = ["wroll", "lab", kind, *map(str, files)]
    settings = Path(out) / "settings.yaml"
    if settings.is_file():
        words += ["--settings", str(settings)]
    return [*map(str, files), f"try: {shlex.join([*words, '--out', f'{out}_result'])}"]
