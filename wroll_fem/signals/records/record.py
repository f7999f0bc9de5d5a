"""Records of a base acceleration at equal time steps, with their unit and time checked."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.signals.records.columns import Columns, read_columns
from wroll_fem.typing import FloatArray

UNITS = {"m/s^2": 1.0, "m/s2": 1.0, "m/s²": 1.0, "g": 9.80665, "mm/s^2": 1e-3}
"""Unit of an acceleration in a file -> m/s^2."""

FEWEST_SAMPLES = 16
"""Samples that a record has at least."""

JITTER = 0.1
"""Largest deviation of a sample from equal time steps, relative to a step; written times are rounded."""

CLIPPED = 4
"""Equal samples in a row, at the largest or at the smallest value, from which a record is said to be clipped."""


@dataclass(frozen=True, eq=False)
class Record:
    """Base acceleration at equal time steps.

    Attributes
    ----------
    acceleration
        (n,) samples, m/s^2.
    dt
        Time step, s.
    source
        File and column, for messages.
    remarks
        Doubts about the record, one sentence each.
    """

    acceleration: FloatArray
    dt: float
    source: str = "record"
    remarks: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return self.dt * (len(self.acceleration) - 1)


def read_record(
    path: str | Path,
    *,
    unit: str,
    column: str | int | None = None,
    time: str | int | None = None,
    sampling_rate: float | None = None,
    rows: int | None = None,
    length: float | None = None,
) -> Record:
    """Read the record of an acceleration from a file.

    Parameters
    ----------
    path
        File (`wroll_fem.signals.records.columns.read_columns`).
    unit
        Unit of the column: m/s^2, g (9.80665 m/s^2) or mm/s^2.
    column
        Name of the column, or its place counted from 1; needed if the file has several besides the time.
    time
        Column of the time, s; by default the one called time or t.
    sampling_rate
        Samples per second, in place of a column of the time.
    rows, length
        Number of samples, and time from the first to the last one (s), that a complete record has: a text that is cut
        off at the end of a row is found by them alone.

    Returns
    -------
    Record
        Samples in m/s^2.

    Raises
    ------
    InputError
        If file, column, unit or time is wrong, a value is not finite, or the record is shorter or longer than given.
    """
    if unit not in UNITS:
        raise InputError(
            f"unknown unit {unit!r} of the record", key="excitation.unit", file=str(path),
            remedy=f"use one of: {', '.join(UNITS)}",
        )  # fmt: skip
    columns = read_columns(path)
    clock = time_column(columns, time, sampling_rate)
    name = _record_column(columns, column, clock)
    values = columns.series[name]
    source = f"{columns.file}, column {name}"
    if rows is not None and len(values) != rows:
        raise InputError(
            f"{len(values)} samples in place of {rows}: the file is cut off, or of another record", file=source,
            key="excitation.rows", remedy="write the file again, or correct the number",
        )  # fmt: skip
    if len(values) < FEWEST_SAMPLES:
        raise InputError(
            f"{len(values)} samples", file=source, remedy=f"give a record of {FEWEST_SAMPLES} samples or more"
        )
    require_finite(values, source)
    if clock is None:
        dt = 1.0 / float(sampling_rate or 0.0)
    else:
        dt = time_step(columns.series[clock], len(values), f"{columns.file}, column {clock}")
    lasts = dt * (len(values) - 1)
    if length is not None and abs(lasts - length) > 0.5 * dt:
        raise InputError(
            f"the record lasts {lasts:.7g} s in place of {length:.7g} s: the file is cut off, or of another record",
            file=source, key="excitation.length", remedy="write the file again, or correct the length",
        )  # fmt: skip
    if not np.abs(values).max() > 0.0:
        raise InputError("all samples are zero", file=source, remedy="give the column of the base acceleration")
    clipped = clipping(values)
    return Record(UNITS[unit] * values, dt, source, (clipped,) if clipped else ())


def time_column(
    columns: Columns, time: str | int | None, rate: float | None, section: str = "excitation."
) -> str | None:
    """Name of the column of the time; None if the sampling rate is given. Messages name keys of ``section``."""
    if rate is not None:
        if time is not None:
            raise InputError(
                "time and sampling_rate are both given", key=f"{section}sampling_rate", remedy="give one of them"
            )
        if not 0.0 < rate < inf:
            raise InputError(
                f"sampling_rate = {rate:g}", key=f"{section}sampling_rate", remedy="give samples per second"
            )
        return None
    if time is not None:
        return columns.chosen(time, f"{section}time")
    found = [name for name in columns.series if re.fullmatch(r"(time|t)\b.*|time_s|t_s", name.strip().casefold())]
    if not found:
        raise InputError(
            "no column is called time or t", file=columns.file, key=f"{section}time",
            remedy=f"name it, or give {section}sampling_rate; the file has: {', '.join(list(columns.series)[:12])}",
        )  # fmt: skip
    return found[0]


def _record_column(columns: Columns, column: str | int | None, clock: str | None) -> str:
    if column is not None:
        name = columns.chosen(column, "excitation.column")
        if name == clock:
            raise InputError(
                f"column {name!r} is the time", file=columns.file, key="excitation.column", remedy="give another column"
            )
        return name
    others = [name for name in columns.series if name != clock]
    if len(others) != 1:
        listed = ", ".join(others[:12]) if others else "the time alone"
        raise InputError(
            f"{len(others)} columns besides the time", file=columns.file, key="excitation.column",
            remedy=f"name the column of the base acceleration; the file has: {listed}",
        )  # fmt: skip
    return others[0]


def require_finite(values: FloatArray, source: str) -> None:
    """Refuse samples that are not finite, or absurdly large."""
    wrong = np.flatnonzero(~np.isfinite(values))
    if wrong.size:
        raise InputError(
            f"sample {wrong[0] + 1} is {values[wrong[0]]} ({wrong.size} such)", file=source,
            remedy="repair the record, or cut it",
        )  # fmt: skip
    if np.abs(values).max() > 1e12:
        raise InputError(
            f"the largest sample is {np.abs(values).max():.3g}", file=source, remedy="check unit and column"
        )


def time_step(time: FloatArray, count: int, source: str, section: str = "excitation.") -> float:
    """Time step of a column of times, s; refuses times that do not rise, gaps, and unequal steps."""
    if len(time) != count:
        raise InputError(f"{len(time)} times for {count} samples", file=source, remedy="give one time per sample")
    require_finite(time, source)
    steps = np.diff(time)
    falls = np.flatnonzero(steps <= 0.0)
    if falls.size:
        k = int(falls[0])
        raise InputError(
            f"time does not rise: sample {k + 2} is at {time[k + 1]:g} s, the one before at {time[k]:g} s",
            file=source, remedy=f"sort the record, write the time with more digits, or give {section}sampling_rate",
        )  # fmt: skip
    usual = float(np.median(steps))
    longest = int(np.argmax(steps))
    if steps[longest] > 1.5 * usual:
        raise InputError(
            f"gap of {steps[longest]:.4g} s after {time[longest]:.6g} s, the step is {usual:.4g} s", file=source,
            remedy="fill the gap, or cut the record there",
        )  # fmt: skip
    dt = float(time[-1] - time[0]) / (count - 1)
    off = np.abs(time - time[0] - dt * np.arange(count))
    if not (dt > 0.0 and off.max() <= JITTER * dt):
        k = int(np.argmax(off))
        raise InputError(
            f"unequal time steps: sample {k + 1} at {time[k]:.6g} s is {off[k] / dt:.2g} steps off", file=source,
            remedy="resample the record to equal steps",
        )  # fmt: skip
    return dt


def clipping(values: FloatArray) -> str:
    """Remark about a clipped record; empty for another."""
    for level in (values.max(), values.min()):
        if level == 0.0:
            continue
        edges = np.diff(np.concatenate([[0], values == level, [0]]).astype(int))
        runs = np.flatnonzero(edges < 0) - np.flatnonzero(edges > 0)
        if runs.max() >= CLIPPED:
            return (
                f"{runs.max()} samples in a row have the extreme value {level:.4g}: the record may be clipped, and its "
                "peaks cut off"
            )
    return ""
