"""Datasets of results: units and labels on all variables; reading, and writing with compression.

Units and labels come from `results.fields`. NetCDF files are read and written by h5netcdf (h5py or netCDF4 from PyPI
would load a second HDF5 library into the process of dolfinx).
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import xarray as xr
from xarray.backends.h5netcdf_ import H5NetCDFStore

from wroll_fem.errors import InputError
from wroll_fem.results.fields import AXES, FIELDS, Field, field, label
from wroll_fem.results.json_types import json_types
from wroll_fem.results.provenance import provenance
from wroll_fem.results.storage.atomic import make_folder
from wroll_fem.results.storage.guarded import trial_reading
from wroll_fem.results.storage.paths import check_path
from wroll_fem.results.storage.seal import seal_of, write_sealed

__all__ = [
    "FIELDS", "Field", "annotate", "check_results", "field", "label", "load_dataset", "netcdf_image", "provenance",
    "save_dataset",
]  # fmt: skip

FORMAT, OLD_FORMAT = 2, 1
"""Versions of the format of results files: that of this program, and that of version 0.1.0, which did not state it."""

FORMAT_ATTR = "results_format"

_UNREADABLE = (
    OSError, ValueError, KeyError, RuntimeError, TypeError, AttributeError, IndexError, OverflowError, MemoryError,
    NotImplementedError,
)  # fmt: skip
"""Errors that HDF5, h5netcdf and xarray raise for a damaged file without a checksum."""

JSON_ATTRS = "json_attrs"  # attribute that lists the attributes stored as JSON text


def annotate(dataset: xr.Dataset) -> xr.Dataset:
    """Dataset with `units` and `long_name` on every variable and coordinate.

    Returns
    -------
    xr.Dataset
        Shallow copy; data are shared.

    Raises
    ------
    InputError
        For a name that is not in `FIELDS`.
    """
    result = dataset.copy()
    for name in result.variables:
        axis = result[name].dims == (name,) and str(name) in AXES
        entry = AXES[str(name)] if axis else field(str(name))
        result[name].attrs.update(units=entry.units, long_name=entry.long_name)
    return result


def _encode_attrs(attrs: Mapping[Hashable, Any]) -> dict[str, Any]:
    """Attributes for NetCDF: text and numbers unchanged, all other values as JSON text."""
    encoded: dict[str, Any] = {}
    as_json: list[str] = []
    for key, raw in attrs.items():
        value = json_types(raw, keep_non_finite=True)
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            try:
                value = json.dumps(value)
            except TypeError as error:
                raise InputError(f"attribute {key!r} cannot be stored: {error}") from error
            as_json.append(str(key))
        encoded[str(key)] = value
    if as_json:
        encoded[JSON_ATTRS] = json.dumps(as_json)
    return encoded


def _decode_attrs(attrs: Mapping[Hashable, Any]) -> dict[str, Any]:
    decoded = {str(key): value.item() if isinstance(value, np.generic) else value for key, value in attrs.items()}
    for key in json.loads(decoded.pop(JSON_ATTRS, "[]")):
        decoded[key] = json.loads(decoded[key])
    return decoded


def save_dataset(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a Dataset as NetCDF (HDF5), with units and labels on every variable.

    Parameters
    ----------
    dataset
        Real, integer, bool and string variables, whose names are in `FIELDS`. Attributes that are dicts, lists, bools
        or None are stored as JSON text; `load_dataset` restores them.
    path
        Target; missing parent folders are created. An existing file is replaced only after the new one is complete.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For an unknown name, a complex variable, an attribute that JSON cannot represent, or a path that cannot be
        written.
    StorageError
        If the disk is full or fails.
    """
    target = Path(path)
    ready = annotate(dataset)
    for name, variable in ready.variables.items():
        if np.iscomplexobj(variable):
            raise InputError(f"variable {name!r} is complex", remedy="store real and imaginary part as two variables")
    ready.attrs = _encode_attrs(dataset.attrs)
    for name in ready.variables:
        ready[name].attrs = _encode_attrs(ready[name].attrs)
    encoding: dict[Hashable, dict[str, Any]] = {
        name: {"zlib": True, "complevel": 4, "shuffle": True}
        for name, variable in ready.variables.items()
        if variable.dtype.kind == "f" and variable.size > 1000
    }
    ready.attrs[FORMAT_ATTR] = FORMAT
    make_folder(target.parent)
    write_sealed(target, netcdf_image(ready, encoding))
    return target


def netcdf_image(dataset: xr.Dataset, encoding: Mapping[Hashable, Mapping[str, Any]] | None = None) -> bytes:
    """Content of a NetCDF file (HDF5) in memory.

    HDF5 does not write to the disk itself: where the disk is full it cannot close its file, and ends the process at
    exit with a segmentation fault.
    """
    image = io.BytesIO()
    with h5netcdf.File(image, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file), encoding=encoding)
    return image.getvalue()


def load_dataset(path: str | os.PathLike[str], *, lazy: bool = False) -> xr.Dataset:
    """Load a file written by `save_dataset` into memory, and close the file.

    Parameters
    ----------
    lazy
        Read each variable on first use; a figure of many runs needs only a few variables.

    Raises
    ------
    InputError
        If the file is missing, is not a results file, was cut or changed, or is of a newer version.
    """
    source = Path(path)
    check_path(source)
    if not source.is_file():
        raise InputError("results file not found", file=str(source), remedy="run the case first: wroll run CASE.yaml")
    sealed = _is_sealed(source)
    problem = "" if sealed else trial_reading(source)
    if problem:
        raise _unreadable(source, f"not a readable NetCDF file ({problem})")
    try:
        dataset = (xr.open_dataset if lazy else xr.load_dataset)(source, engine="h5netcdf")
        dataset.attrs = _decode_attrs(dataset.attrs)
        for name in dataset.variables:
            dataset[name].attrs = _decode_attrs(dataset[name].attrs)
    except _UNREADABLE as error:
        reason = " ".join(str(error).split())[:80]
        raise _unreadable(source, f"not a readable NetCDF file ({reason})") from None
    version = dataset.attrs.pop(FORMAT_ATTR, OLD_FORMAT)
    if version != OLD_FORMAT and not sealed:
        dataset.close()
        raise _unreadable(source, "was cut off or changed after it was written (its checksum is missing)")
    if version not in (OLD_FORMAT, FORMAT):
        dataset.close()
        problem = f"has format {version}; this version reads formats {OLD_FORMAT} and {FORMAT}"
        raise InputError(problem, file=str(source), remedy="read it with the version of wroll_fem that wrote it")
    return dataset


def check_results(path: str | os.PathLike[str]) -> None:
    """Check that a results file is as it was written; a file without checksum (version 0.1.0) is opened for it.

    Raises
    ------
    InputError
        As `load_dataset`.
    """
    if not _is_sealed(path):
        load_dataset(path, lazy=True).close()


def _is_sealed(path: str | os.PathLike[str]) -> bool:
    """Whether a results file has a checksum, which fits its content; files of version 0.1.0 have none."""
    try:
        seal = seal_of(path)
        empty = os.path.getsize(path) == 0
    except OSError as error:
        raise _unreadable(path, f"cannot be read ({error.strerror or error})") from None
    if empty:
        raise _unreadable(path, "is empty")
    if seal == "broken":
        raise _unreadable(path, "is damaged (its checksum does not fit its content)")
    return seal == "intact"


def _unreadable(path: str | os.PathLike[str], problem: str) -> InputError:
    return InputError(problem, file=str(path), remedy="delete this file and run the case again")
