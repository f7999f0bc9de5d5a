"""Seal of a file: the SHA-256 of its content, as a last line that readers of NetCDF (HDF5) and .npz files ignore.

A sealed file that was cut or changed is recognised before any library parses it.
"""

from __future__ import annotations

import hashlib
import os
from typing import Literal

from wroll_fem.results.storage.atomic import replacing

Seal = Literal["intact", "broken", "missing"]

_START = b"\nwroll sha256 "
_SIZE = len(_START) + 64 + 1  # with the hexadecimal digits and the end of the line
_BLOCK = 1 << 20


def write_sealed(path: str | os.PathLike[str], content: bytes) -> None:
    """Write ``content`` and its seal; an existing file is replaced once the new one is complete.

    Raises
    ------
    InputError, StorageError
        If the file cannot be written.
    """
    with replacing(path) as file, file.open("wb") as stream:
        stream.write(content)
        stream.write(_START + hashlib.sha256(content).hexdigest().encode() + b"\n")


def seal_of(path: str | os.PathLike[str]) -> Seal:
    """State of the seal of a file: "intact", "broken" (the content differs from it), or "missing".

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    digest = hashlib.sha256()
    with open(path, "rb") as stream:
        left = stream.seek(0, os.SEEK_END) - _SIZE
        if left < 0:
            return "missing"
        stream.seek(left)
        seal = stream.read()
        if not (seal.startswith(_START) and seal.endswith(b"\n")):
            return "missing"
        stream.seek(0)
        while left > 0:
            block = stream.read(min(_BLOCK, left))
            if not block:
                return "broken"  # cut meanwhile
            digest.update(block)
            left -= len(block)
    return "intact" if seal[len(_START) : -1] == digest.hexdigest().encode() else "broken"
