"""Input files of laboratory evaluations: existence and SHA-256."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from wroll_fem.errors import InputError

_BLOCK = 1 << 20


def checked_inputs(files: Sequence[str | Path], *, folders: bool = False) -> tuple[Path, ...]:
    """Paths of existing inputs.

    Parameters
    ----------
    files
        Paths of files, and of folders if ``folders``.
    folders
        Whether folders are allowed.

    Raises
    ------
    InputError
        If there is no file, one is missing or given twice, or one is a folder where this is not allowed.
    """
    paths = tuple(Path(file) for file in ([files] if isinstance(files, str | Path) else files))
    if not paths:
        raise InputError("no file is given", remedy="give one file or more")
    seen: set[Path] = set()
    for path in paths:
        if not path.exists():
            raise InputError("file not found", file=str(path), remedy="give the path of a measurement")
        if path.is_dir() and not folders:
            raise InputError("is a folder, not a file", file=str(path), remedy="give the files inside it")
        if path.resolve() in seen:
            raise InputError("is given twice", file=str(path), remedy="give each file once")
        seen.add(path.resolve())
    return paths


def described(path: Path) -> dict[str, Any]:
    """Path, number of bytes and SHA-256 of an input; of a folder, those of its files in the order of their names.

    Raises
    ------
    InputError
        If a file cannot be read.
    """
    try:
        if not path.is_dir():
            return {"path": str(path), "bytes": path.stat().st_size, "sha256": _digest(path)}
        files = sorted(file for file in path.iterdir() if file.is_file())
        whole = hashlib.sha256()
        for file in files:
            whole.update(f"{file.name} {_digest(file)}\n".encode())
        size = sum(file.stat().st_size for file in files)
        return {"path": str(path), "bytes": size, "sha256": whole.hexdigest(), "files": len(files)}
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"cannot be read ({reason})", file=str(path), remedy="give a readable file") from None


def _digest(path: Path) -> str:
    found = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            found.update(block)
    return found.hexdigest()
