"""Datasets of results: units and labels on all variables; reading, and writing with compression.

Units and labels come from `results.fields`. NetCDF files are read and written by h5netcdf (h5py or netCDF4 from PyPI
would load a second HDF5 library into the process of dolfinx).
"""

from __future__ import annotations

import json
import os
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from wroll_fem.errors import InputError
from wroll_fem.results.atomic import replacing
from wroll_fem.results.fields import AXES, FIELDS, Field, field, label
from wroll_fem.results.json_types import json_types
from wroll_fem.results.provenance import provenance

__all__ = ["FIELDS", "Field", "annotate", "field", "label", "load_dataset", "provenance", "save_dataset"]

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
        For an unknown name, a complex variable or an attribute that JSON cannot represent.
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
    target.parent.mkdir(parents=True, exist_ok=True)
    with replacing(target) as file:
        ready.to_netcdf(file, engine="h5netcdf", encoding=encoding)
    return target


def load_dataset(path: str | os.PathLike[str], *, lazy: bool = False) -> xr.Dataset:
    """Load a file written by `save_dataset` into memory, and close the file.

    Parameters
    ----------
    lazy
        Read each variable on first use; a figure of many runs needs only a few variables.

    Raises
    ------
    InputError
        If the file is missing or is not a results file.
    """
    source = Path(path)
    if not source.is_file():
        raise InputError("results file not found", file=str(source), remedy="run the case first: wroll run CASE.yaml")
    try:
        dataset = (xr.open_dataset if lazy else xr.load_dataset)(source, engine="h5netcdf")
    except (OSError, ValueError) as error:
        raise InputError(f"not a readable NetCDF file ({error})", file=str(source)) from error
    dataset.attrs = _decode_attrs(dataset.attrs)
    for name in dataset.variables:
        dataset[name].attrs = _decode_attrs(dataset[name].attrs)
    return dataset
