"""Checkpoint files: named arrays (.npz) with a seal and the version of their format."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.results.storage.seal import seal_of, write_sealed

FORMAT = 2
"""Version of the format of checkpoints; those of version 0.1.0 have none. A change of the arrays raises it."""

_FORMAT_KEY = "checkpoint_format"
_REMEDY = "delete this file and run the same command again, which starts from the beginning"


def refused(path: str | os.PathLike[str], problem: str) -> InputError:
    """Error for a checkpoint from which no run can continue."""
    return InputError(problem, file=str(path), remedy=_REMEDY)


def write_checkpoint(path: str | os.PathLike[str], arrays: Mapping[str, Any]) -> None:
    """Write named arrays; an existing checkpoint is replaced once the new one is complete.

    Raises
    ------
    InputError, StorageError
        If the file cannot be written.
    """
    image = io.BytesIO()  # numpy leaves a half-open archive where a disk is full
    np.savez(image, **{_FORMAT_KEY: np.array(FORMAT)}, **arrays)
    write_sealed(path, image.getvalue())


def check_checkpoint(path: str | os.PathLike[str]) -> None:
    """Check that a checkpoint is as it was written.

    Raises
    ------
    InputError
        If the file cannot be read, was cut or changed, or is of version 0.1.0; the message names the remedy.
    """
    try:
        seal = seal_of(path)
    except OSError as error:
        raise refused(path, f"the checkpoint cannot be read ({error.strerror or error})") from None
    if seal == "missing":
        raise refused(path, "the checkpoint was cut off, or is of an older version")
    if seal == "broken":
        raise refused(path, "the checkpoint is damaged (its checksum does not fit its content)")


def read_checkpoint(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """Arrays of a checkpoint by name.

    Raises
    ------
    InputError
        As `check_checkpoint`, and if the format is of another version.
    """
    check_checkpoint(path)
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    version = int(arrays.pop(_FORMAT_KEY, 1))
    if version != FORMAT:
        raise refused(path, f"the checkpoint has format {version}; this version reads format {FORMAT}")
    return arrays
