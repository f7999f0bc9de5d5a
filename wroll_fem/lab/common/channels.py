"""Channels of a record: columns of a file, in SI units, checked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from wroll_fem.case.units import KINDS, WrongQuantity, in_si
from wroll_fem.errors import InputError
from wroll_fem.signals.records.columns import read_columns
from wroll_fem.signals.records.record import clipping
from wroll_fem.typing import FloatArray

LARGEST, SMALLEST = 1e12, 1e-15
"""Limits of the largest value of a channel, SI: beyond them, squares and products lose their digits."""


GAP = 10.0
"""Time step, relative to both neighbours, from which samples are missing."""


class Channel(NamedTuple):
    """Wanted channel: its key in the settings, the column (name, or place counted from 1), and its units.

    Attributes
    ----------
    key
        Name of the channel in the sections `columns` and `units`.
    column
        Name of the column in the file, or its place.
    unit
        Unit in the file.
    si
        Unit wanted, a key of `case.units.KINDS`.
    """

    key: str
    column: str | int
    unit: str
    si: str

    @property
    def factor(self) -> float:
        """Factor from the unit of the file to SI.

        Raises
        ------
        InputError
            If the unit is unknown or of another kind.
        """
        found = in_si(f"1 {self.unit}", self.si)
        if isinstance(found, WrongQuantity):
            raise InputError(found.problem, key=f"units.{self.key}", remedy=found.remedy)
        if isinstance(found, str):
            raise InputError(
                f"unknown unit {self.unit!r}", key=f"units.{self.key}",
                remedy=f"give a unit of {KINDS[self.si].name}, such as {KINDS[self.si].unit}",
            )  # fmt: skip
        return found


def read_channels(path: Path, channels: Sequence[Channel]) -> dict[str, FloatArray]:
    """Read channels of a file.

    Returns
    -------
    dict
        Key of each channel -> (n,) values, SI.

    Raises
    ------
    InputError
        If a column is missing (with the nearest name), a unit is unknown, a value is not finite, all values are
        absurdly large or small, the lengths differ, or the column `time` has a gap.
    """
    factors = [channel.factor for channel in channels]
    columns = read_columns(path)
    found: dict[str, FloatArray] = {}
    for channel, factor in zip(channels, factors, strict=True):
        name = columns.chosen(channel.column, f"columns.{channel.key}")
        values = columns.series[name]
        wrong = np.flatnonzero(~np.isfinite(values))
        if wrong.size:
            raise InputError(
                f"sample {wrong[0] + 1} is {values[wrong[0]]} ({wrong.size} such)", file=f"{path}, column {name}",
                remedy="repair the record, or cut it",
            )  # fmt: skip
        values = factor * values
        largest = float(np.abs(values).max()) if values.size else 0.0
        if largest > LARGEST or 0.0 < largest < SMALLEST:
            raise InputError(
                f"the largest value is {largest:.3g} {channel.si}", file=f"{path}, column {name}",
                key=f"units.{channel.key}", remedy="check unit and column",
            )  # fmt: skip
        found[channel.key] = values
    lengths = {key: len(values) for key, values in found.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{key} {length}" for key, length in lengths.items())
        raise InputError(f"columns of different length: {listed}", file=str(path), remedy="give one value per sample")
    if "time" in found:
        _refuse_gap(found["time"], str(path))
    return found


def _refuse_gap(time: FloatArray, source: str) -> None:
    """Refuse a time step much longer than its neighbours; the sampling rate itself may change with the rate of a test.

    Raises
    ------
    InputError
        If samples are missing.
    """
    steps = np.diff(time)
    if len(steps) < 3 or not (steps > 0.0).all():
        return  # a time that does not rise has its own message
    beside = np.maximum(np.r_[steps[1], steps[:-1]], np.r_[steps[1:], steps[-2]])
    gaps = np.flatnonzero(steps > GAP * beside)
    if gaps.size:
        k = int(gaps[0])
        raise InputError(
            f"gap of {steps[k]:.4g} s after {time[k]:.6g} s, the steps beside it are at most {beside[k]:.4g} s",
            file=source, remedy="fill the gap, or cut the record there",
        )  # fmt: skip


def clipped(values: FloatArray, path: Path, key: str) -> list[str]:
    """Doubt about a channel whose largest or smallest samples are equal, as where a sensor is at its limit."""
    text = clipping(values)
    return [f"{path}, {key}: {text}"] if text else []


def per_file(value: float | Sequence[float] | None, count: int, key: str) -> list[float] | None:
    """One value for each of ``count`` files, from one number or a list; None stays None.

    Raises
    ------
    InputError
        If the list has another length.
    """
    if value is None:
        return None
    if isinstance(value, int | float):
        return [float(value)] * count
    if len(value) != count:
        raise InputError(
            f"{len(value)} values for {count} files", key=key, remedy="give one number, or one per file in their order"
        )
    return [float(one) for one in value]
