"""Writing and reading of named arrays in a .npz or .mat file (see `io`), with one-line errors.

In a .npz file, a sparse matrix ``K`` consists of the fields ``K_data``, ``K_indices``, ``K_indptr`` and ``K_shape``
(compressed rows, or compressed columns if ``K_format`` is "csc"). In a .mat file it is a MATLAB sparse matrix. Dense
matrices, integers, and vectors written as rows or columns are accepted everywhere. Pickles are not read or written.
"""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
import scipy.sparse as sp

from wroll_fem.errors import InputError
from wroll_fem.results.storage.atomic import replacing
from wroll_fem.typing import FloatArray

SUFFIXES = (".npz", ".mat")
_PARTS = ("data", "indices", "indptr", "shape", "format")
_V7 = "save it again with -v7: save -v7 FILE.mat K M ..."


def check_suffix(path: str | os.PathLike[str]) -> Path:
    """Path, checked to end in .npz or .mat.

    Raises
    ------
    InputError
        If the path has another ending.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError("is neither .npz nor .mat", file=str(path), remedy="give the file one of these endings")
    return path


def write_arrays(path: str | os.PathLike[str], fields: Mapping[str, Any]) -> Path:
    """Write numbers, texts, arrays and sparse matrices; an existing file is replaced once the new one is complete.

    Raises
    ------
    InputError
        If the path does not end in .npz or .mat, or cannot be written.
    StorageError
        If the disk is full or fails.
    """
    path = check_suffix(path)
    image = io.BytesIO()  # an archive that a full disk interrupts cannot be closed
    if path.suffix.lower() == ".npz":
        np.savez_compressed(image, **_flat(fields))
    else:
        ready = {name: sp.csc_matrix(v) if sp.issparse(v) else v for name, v in fields.items()}
        scipy.io.savemat(image, ready, do_compression=True, oned_as="column", long_field_names=True)
    with replacing(path, remedy="choose another file") as file:
        file.write_bytes(image.getvalue())
    return path


def _flat(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Fields in which each sparse matrix is replaced by its parts."""
    flat: dict[str, Any] = {}
    for name, value in fields.items():
        if not sp.issparse(value):
            flat[name] = value
            continue
        kept = value if value.format in ("csr", "csc") else value.tocsr()
        parts = (kept.data, kept.indices, kept.indptr, np.array(kept.shape), kept.format)
        flat |= {f"{name}_{part}": entry for part, entry in zip(_PARTS, parts, strict=True)}
    return flat


class ArrayFile:
    """Read access to the named arrays of one file; every error message names the file and, if possible, the field.

    Parameters
    ----------
    path
        .npz or .mat file; the whole file is read into memory.

    Raises
    ------
    InputError
        If the file is missing, damaged, pickled, or a MATLAB v7.3 (HDF5) file.
    """

    def __init__(self, path: str | os.PathLike[str]):
        self.path = check_suffix(path)
        if not self.path.is_file():
            raise self.error("file not found", remedy="give the path of a .npz or .mat file (see docs/matrices.md)")
        self._values = self._read_npz() if self.path.suffix.lower() == ".npz" else self._read_mat()

    def error(self, problem: str, *, key: str | None = None, remedy: str) -> InputError:
        """One-line error about this file."""
        return InputError(problem, key=key, remedy=remedy, file=str(self.path))

    def _read_npz(self) -> dict[str, Any]:
        try:
            with np.load(self.path, allow_pickle=False) as archive:
                values = {}
                for name in archive.files:
                    try:
                        values[name] = archive[name]
                    except ValueError as error:
                        if "Object arrays" not in str(error):
                            raise
                        remedy = f"save {name}_data, {name}_indices, {name}_indptr, {name}_shape, or {name}.toarray()"
                        raise self.error("is a pickled Python object", key=name, remedy=remedy) from None
        except InputError:
            raise
        except Exception as error:  # a damaged archive can raise almost anything
            reason = " ".join(str(error).split())[:80] or type(error).__name__
            raise self.error(f"is not a readable .npz file ({reason})", remedy="write it with numpy.savez") from None
        whole: dict[str, Any] = {}
        for name in values:
            stem, _, part = name.rpartition("_")
            if part in _PARTS and f"{stem}_indptr" in values:
                if stem not in whole:
                    whole[stem] = self._sparse(stem, {p: values.get(f"{stem}_{p}") for p in _PARTS})
            else:
                whole[name] = values[name]
        return whole

    def _sparse(self, name: str, parts: dict[str, Any]) -> sp.spmatrix:
        lacking = [f"{name}_{p}" for p in _PARTS[:4] if parts[p] is None]
        if lacking:
            raise self.error(f"{lacking[0]} is missing", key=name, remedy="save all four parts of the sparse matrix")
        kind = "csr" if parts["format"] is None else str(parts["format"])
        build = {"csr": sp.csr_matrix, "csc": sp.csc_matrix}.get(kind)
        if build is None:
            raise self.error(f"has the sparse format {kind!r}", key=name, remedy="use csr or csc")
        try:
            matrix = build((parts["data"], parts["indices"], parts["indptr"]), tuple(int(k) for k in parts["shape"]))
            matrix.check_format(full_check=True)
        except (ValueError, TypeError, IndexError) as error:
            reason = " ".join(str(error).split())[:80]
            raise self.error(f"its sparse parts do not fit together ({reason})", key=name,
                             remedy="save data, indices, indptr and shape of one scipy matrix") from None  # fmt: skip
        return matrix

    def _read_mat(self) -> dict[str, Any]:
        with self.path.open("rb") as file:
            start = file.read(128)
        if start.startswith((b"MATLAB 7.3", b"\x89HDF")):
            raise self.error("is a MATLAB v7.3 (HDF5) file, which is not read here", remedy=_V7)
        try:
            found = scipy.io.loadmat(self.path)
        except Exception as error:
            # any error that scipy raises for a damaged file (ValueError, TypeError, zlib.error, struct.error, ...)
            reason = " ".join(str(error).split())[:80] or type(error).__name__
            raise self.error(f"is not a readable .mat file ({reason})", remedy=_V7) from None
        return {name: value for name, value in found.items() if not name.startswith("__")}

    @property
    def names(self) -> list[str]:
        """Names of the fields of the file; the parts of a sparse matrix count as one field."""
        return list(self._values)

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def _value(self, name: str, meaning: str) -> Any:
        if name not in self._values:
            raise self.error("required field is missing", key=name, remedy=f"add it ({meaning})")
        return self._values[name]

    def _checked(self, name: str, data: Any) -> None:
        """Raise an error unless all values of a field are real finite numbers."""
        kind = np.asarray(data).dtype.kind
        if kind == "c":
            remedy = "write real matrices; structural damping (1 + i eta) K cannot be used: give viscous damping C"
            raise self.error("is complex", key=name, remedy=remedy)
        if kind not in "fiub":
            raise self.error("does not hold numbers", key=name, remedy="write real numbers")
        if not np.isfinite(data).all():
            raise self.error("holds NaN or infinite values", key=name, remedy="write finite numbers")

    def matrix(self, name: str, shape: tuple[int | None, int | None], meaning: str) -> sp.csr_matrix:
        """Field as a sparse float matrix; None in ``shape`` allows any size.

        The entries keep their order in the file, so that products repeat bit by bit.
        """
        value = self._value(name, meaning)
        if not sp.issparse(value):
            value = np.atleast_2d(np.asarray(value))
            if value.ndim != 2:
                raise self.error(f"has {value.ndim} dimensions", key=name, remedy="write a matrix")
        self._checked(name, value.data if sp.issparse(value) else value)
        if any(want is not None and want != have for want, have in zip(shape, value.shape, strict=True)):
            want = " x ".join("any" if k is None else str(k) for k in shape)
            have = " x ".join(map(str, value.shape))
            raise self.error(f"is {have}, not {want}", key=name, remedy=f"write the {meaning}")
        return sp.csr_matrix(value, dtype=float)

    def vector(self, name: str, size: int | None, meaning: str) -> FloatArray:
        """Field as a float array (size,), from a row, a column, a single number or a sparse vector."""
        value = self._value(name, meaning)
        value = value.toarray() if sp.issparse(value) else np.asarray(value)
        self._checked(name, value)
        if sum(k > 1 for k in value.shape) > 1 or (size is not None and value.size != size):
            have = " x ".join(map(str, value.shape))
            count = "a vector" if size is None else f"{size} value" + "s" * (size != 1)
            raise self.error(f"is {have}, not {count}", key=name, remedy=f"write the {meaning}")
        return value.astype(float).ravel()

    def table(self, name: str, shape: tuple[int, int], meaning: str) -> FloatArray:
        """Field as a dense float array of the given ``shape``."""
        return np.ascontiguousarray(self.matrix(name, shape, meaning).toarray())

    def number(self, name: str, meaning: str) -> float:
        """Field as a single float."""
        return float(self.vector(name, 1, meaning)[0])

    def text(self, name: str, meaning: str) -> str:
        """Field as a text."""
        value = np.asarray(self._value(name, meaning))
        if value.dtype.kind != "U" or value.size > 1:
            raise self.error("is not a text", key=name, remedy=f"write the {meaning} as a text")
        return str(value.ravel()[0]) if value.size else ""
