"""Several columns of one file as samples at the same equal time steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.signals.records.columns import read_columns
from wroll_fem.signals.records.record import FEWEST_SAMPLES, clipping, require_finite, time_column, time_step
from wroll_fem.typing import FloatArray


@dataclass(frozen=True, eq=False)
class Series:
    """Samples of several quantities at the same equal time steps.

    Attributes
    ----------
    values
        Key -> (n,) samples, in the unit of the file.
    dt
        Time step, s.
    source
        File, for messages.
    remarks
        Doubts about the samples, one sentence each.
    """

    values: dict[str, FloatArray]
    dt: float
    source: str
    remarks: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """Number of samples times the time step, s."""
        return self.dt * len(next(iter(self.values.values())))


def read_series(
    path: str | Path,
    wanted: Mapping[str, str | int],
    *,
    time: str | int | None = None,
    sampling_rate: float | None = None,
) -> Series:
    """Read columns of a file (`wroll_fem.signals.records.columns.read_columns`).

    Parameters
    ----------
    path
        File.
    wanted
        Key of the settings -> name of the column, or its place, counted from 1.
    time
        Column of the time, s; by default the one called time or t.
    sampling_rate
        Samples per second, in place of a column of the time.

    Raises
    ------
    InputError
        If file, column or time is wrong, a value is not finite, or the columns differ in length or times.
    """
    columns = read_columns(path, None)
    names = {key: columns.chosen(column, key) for key, column in wanted.items()}
    clock = time_column(columns, time, sampling_rate, "")
    found: dict[str, FloatArray] = {}
    remarks = []
    for key, name in names.items():
        values, source = columns.series[name], f"{columns.file}, column {name}"
        if name == clock:
            raise InputError(f"column {name!r} is the time", file=columns.file, key=key, remedy="give another column")
        if len(values) < FEWEST_SAMPLES:
            raise InputError(
                f"{len(values)} samples", file=source, remedy=f"give a record of {FEWEST_SAMPLES} samples or more"
            )
        require_finite(values, source)
        if not np.ptp(values) > 0.0:
            raise InputError("all samples are equal", file=source, key=key, remedy="give another column")
        if text := clipping(values):
            remarks.append(f"{source}: {text}")
        if found and len(values) != len(next(iter(found.values()))):
            other = next(iter(found))
            problem = f"{len(values)} samples, and {len(found[other])} of {other}"
            raise InputError(problem, file=source, key=key, remedy="give columns of the same record")
        if f"time of {name}" in columns.series:
            raise InputError(
                "has times of its own", file=source, key=key, remedy="export the records with the same times"
            )
        found[key] = values
    count = len(next(iter(found.values())))
    if clock is None:
        dt = 1.0 / float(sampling_rate or 0.0)
    else:
        dt = time_step(columns.series[clock], count, f"{columns.file}, column {clock}", "")
    return Series(found, dt, columns.file, tuple(remarks))
