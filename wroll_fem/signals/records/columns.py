"""Columns of numbers from files: CSV, .npz, .mat and UFF set 58, with their names."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.signals.records.csv_columns import csv_columns
from wroll_fem.signals.records.mat_columns import Hdf5Version, mat_matrices
from wroll_fem.signals.records.uff import uff_columns
from wroll_fem.typing import FloatArray

FORMATS = {
    ".csv": "csv", ".txt": "csv", ".dat": "csv", ".tsv": "csv", ".npz": "npz", ".mat": "mat", ".uff": "uff",
    ".unv": "uff",
}  # fmt: skip
"""Suffix of a file -> its format."""

LARGEST_FILE = 2**31
"""Largest file that is read, bytes."""


class Columns(NamedTuple):
    """Series of equal or different length, with their names in the order of the file.

    Attributes
    ----------
    file
        Path, for messages.
    series
        Name -> (n,) values.
    """

    file: str
    series: dict[str, FloatArray]

    def chosen(self, wanted: str | int, key: str) -> str:
        """Name of a column given by name, or by its place, counted from 1.

        Raises
        ------
        InputError
            If the file has no such column; the message has the nearest name.
        """
        names = list(self.series)
        if isinstance(wanted, int):
            if not 1 <= wanted <= len(names):
                raise InputError(
                    f"column {wanted} of {len(names)}", key=key, file=self.file,
                    remedy=f"count from 1, or give a name: {_listed(names)}",
                )  # fmt: skip
            return names[wanted - 1]
        folded = {name.casefold(): name for name in reversed(names)}
        if wanted in self.series or wanted.casefold() in folded:
            return wanted if wanted in self.series else folded[wanted.casefold()]
        near = get_close_matches(wanted.casefold(), folded, n=1, cutoff=0.5)
        hint = f"did you mean {folded[near[0]]!r}? " if near else ""
        raise InputError(
            f"no column {wanted!r}", key=key, file=self.file, remedy=f"{hint}the file has: {_listed(names)}"
        )


def read_columns(path: str | Path, key: str | None = "excitation.file") -> Columns:
    """Read all columns of a file; its suffix gives the format.

    Parameters
    ----------
    path
        .csv, .txt, .dat or .tsv: text with one row per sample. .npz, .mat (up to version 7.2): each vector is a column,
        and each column of a matrix with samples along its longer side. .uff or .unv: universal file, sets 58; needs
        pyuff (extra `lab`).
    key
        Key of the path, for messages.

    Raises
    ------
    InputError
        If the file is missing, damaged, cut off, or has no numbers.
    """
    path = Path(path)
    where = str(path)
    if path.suffix.lower() not in FORMATS:
        raise InputError(
            f"unknown format {path.suffix!r}", file=where, key=key,
            remedy=f"use one of: {', '.join(FORMATS)}",
        )  # fmt: skip
    if not path.is_file():
        raise InputError("file not found", file=where, key=key, remedy="give the path of a record")
    if path.stat().st_size > LARGEST_FILE:
        raise InputError("the file has more than 2 GiB", file=where, remedy="shorten the record or lower its rate")
    read = {"csv": csv_columns, "npz": _npz, "mat": _mat, "uff": uff_columns}[FORMATS[path.suffix.lower()]]
    series = read(path)
    if not series:
        raise InputError("the file contains no series of numbers", file=where, remedy="give a file with a record")
    return Columns(where, series)


def _npz(path: Path) -> dict[str, FloatArray]:
    try:
        with np.load(path, allow_pickle=False) as data:
            if not hasattr(data, "files"):
                raise ValueError("not a zip archive")
            return _vectors({name: data[name] for name in data.files})
    except Exception as error:  # a damaged archive can raise almost anything
        raise _damaged(path, error) from None


def _mat(path: Path) -> dict[str, FloatArray]:
    try:
        return _vectors(mat_matrices(path.read_bytes()))
    except Hdf5Version:
        raise InputError(
            "the .mat file has version 7.3 (HDF5)", file=str(path), remedy="save it with -v7 in MATLAB"
        ) from None
    except (ValueError, OSError) as error:
        raise _damaged(path, error) from None


def _damaged(path: Path, error: Exception) -> InputError:
    words = " ".join(str(error).split())[:120] or type(error).__name__
    problem = f"the file is damaged, cut off or of another format ({words})"
    return InputError(problem, file=str(path), remedy="write it again")


def _vectors(arrays: Mapping[str, np.ndarray]) -> dict[str, FloatArray]:
    """Columns of arrays of real numbers; scalars, texts and structures are left out."""
    found: dict[str, FloatArray] = {}
    for name, value in arrays.items():
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu" or value.ndim > 2 or value.size < 2:
            continue
        matrix = np.atleast_2d(value.astype(np.float64))
        matrix = matrix.T if matrix.shape[0] < matrix.shape[1] else matrix
        if matrix.shape[1] == 1:
            found[name] = matrix[:, 0]
        else:
            found |= {f"{name}[{k}]": column for k, column in enumerate(matrix.T, start=1)}
    return found


def _listed(names: list[str]) -> str:
    return ", ".join(names[:12]) + (f", and {len(names) - 12} more" if len(names) > 12 else "")
