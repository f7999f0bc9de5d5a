"""Comparison of transmissibility curves from runs, results files and measured tables (`wroll compare`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from wroll_fem.errors import InputError
from wroll_fem.results.resonance import Resonance, resonance

TABLES = (".csv", ".txt", ".dat")
"""Suffixes of files that are read as tables of numbers."""


def load_curves(paths: Sequence[Path]) -> dict[str, xr.Dataset]:
    """Curves to compare: short name of each path -> Dataset with its transmissibility and its resonance.

    Parameters
    ----------
    paths
        Run folders, results files (.nc), or tables with the columns frequency (Hz) and |T|, or frequency, real part and
        imaginary part. A table may have a line of column names; lines that start with # are ignored.

    Raises
    ------
    InputError
        If there are fewer than two paths, or one of them has no transmissibility.
    """
    if len(paths) < 2:
        raise InputError("there is nothing to compare", remedy="give at least two run folders, .nc or .csv files")
    names = [path.stem if path.is_file() else path.resolve().name for path in paths]
    if len(set(names)) < len(names):
        names = [str(path) for path in paths]
    if len(set(names)) < len(names):
        raise InputError("a file is given twice", remedy="give each file once")
    return {name: _curve(path) for name, path in zip(names, paths, strict=True)}


def comparison_lines(curves: Mapping[str, xr.Dataset]) -> Iterator[str]:
    """Table of the resonances; differences are relative to the first curve."""
    width = max(len(name) for name in curves)
    yield f"{'':<{width}}  {'f_n, Hz':>18}  {'zeta, %':>18}  {'peak T':>18}  method"
    first: list[float] = []
    for name, curve in curves.items():
        read = resonance(curve)
        values = [read.f_n, 100.0 * read.zeta if read.stated else np.nan, read.peak]
        first = first or values
        cells = [_cell(value, reference, same=values is first) for value, reference in zip(values, first, strict=True)]
        yield f"{name:<{width}}  " + "  ".join(f"{cell:>18}" for cell in cells) + f"  {read.method}{_remark(read)}"


def _remark(read: Resonance) -> str:
    return "" if read.quality in ("", "ok") else f", zeta {read.quality}"


def _cell(value: float, reference: float, *, same: bool) -> str:
    if not np.isfinite(value):
        return "none"
    change = "" if same or not np.isfinite(reference) else f" ({100.0 * (value / reference - 1.0):+.1f} %)"
    return f"{value:.5g}{change}"


def _curve(path: Path) -> xr.Dataset:
    from wroll_fem.jobs.folder import RunFolder
    from wroll_fem.results.dataset import load_dataset

    if path.is_file() and path.suffix.lower() in TABLES:
        return _measured(path)
    found = load_dataset(path) if path.is_file() else RunFolder(path).load()
    if "transmissibility_real" not in found or "frequency" not in found.variables:
        remedy = "compare runs of sweep or harmonic, or measured tables"
        raise InputError("has no transmissibility curve", file=str(path), remedy=remedy)
    return found


def _measured(path: Path) -> xr.Dataset:
    from wroll_fem.signals.estimators import estimate_damping

    remedy = "give the columns frequency (Hz) and |T|, or frequency, real part and imaginary part"
    try:
        table = pd.read_csv(path, sep=None, engine="python", comment="#", header=None)
    except (OSError, ValueError) as error:
        raise InputError(f"is not a table of numbers ({error})", file=str(path), remedy=remedy) from None
    numbers = table.apply(pd.to_numeric, errors="coerce").dropna(axis="columns", how="all")
    numbers = numbers.iloc[1:] if numbers.iloc[:1].isna().any(axis=None) else numbers  # column names
    if numbers.shape[1] not in (2, 3) or len(numbers) < 3 or numbers.isna().any(axis=None):
        raise InputError("is not a table of two or three columns of numbers", file=str(path), remedy=remedy)
    frequency, *parts = numbers.sort_values(numbers.columns[0]).to_numpy(float).T
    T = parts[0] + 1j * parts[1] if len(parts) == 2 else parts[0]
    attrs = estimate_damping(frequency, T).as_attrs("measured")
    curve = {"transmissibility_real": ("frequency", np.real(T)), "transmissibility_imag": ("frequency", np.imag(T))}
    return xr.Dataset(curve, {"frequency": frequency}, attrs)
