"""A trial of a shaker test: records of base and tip, with the quantity that each sensor measures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.signals.records.series import read_series
from wroll_fem.typing import ComplexArray, FloatArray

DISPLACEMENT, VELOCITY, ACCELERATION = 0, 1, 2
"""Order of the time derivative of the displacement."""

UNITS: dict[str, tuple[int, float]] = {
    "m/s^2": (ACCELERATION, 1.0), "m/s2": (ACCELERATION, 1.0), "m/s²": (ACCELERATION, 1.0),
    "g": (ACCELERATION, 9.80665), "mm/s^2": (ACCELERATION, 1e-3), "m/s": (VELOCITY, 1.0), "mm/s": (VELOCITY, 1e-3),
    "um/s": (VELOCITY, 1e-6), "m": (DISPLACEMENT, 1.0), "mm": (DISPLACEMENT, 1e-3), "um": (DISPLACEMENT, 1e-6),
    "µm": (DISPLACEMENT, 1e-6),
}  # fmt: skip
"""Unit of a column -> order of the derivative, and factor to SI."""


@dataclass(frozen=True, eq=False)
class Trial:
    """Records of base and tip at the same times.

    Attributes
    ----------
    path
        File.
    base, tip
        (n,) samples in SI units of their quantity.
    dt
        Time step, s.
    base_order, tip_order
        Quantity of the samples: 0 displacement, 1 velocity, 2 acceleration.
    relative
        Whether the tip is measured relative to the base.
    remarks
        Doubts about the records, one sentence each.
    """

    path: Path
    base: FloatArray
    tip: FloatArray
    dt: float
    base_order: int
    tip_order: int
    relative: bool = False
    remarks: tuple[str, ...] = ()

    @property
    def rate(self) -> float:
        """Samples per second, Hz."""
        return 1.0 / self.dt

    @property
    def duration(self) -> float:
        """Length of the record, s."""
        return self.dt * len(self.base)


def to_acceleration(frequency: FloatArray, order: int) -> ComplexArray:
    """(n,) factors that turn the spectrum of a quantity of this order into that of the acceleration."""
    return np.asarray((2j * np.pi * np.asarray(frequency)) ** (ACCELERATION - order))


def read_trial(
    path: Path,
    *,
    base: str | int,
    tip: str | int,
    base_unit: str,
    tip_unit: str,
    relative: bool = False,
    time: str | int | None = None,
    sampling_rate: float | None = None,
) -> Trial:
    """Read a trial.

    Parameters
    ----------
    path
        File (`wroll_fem.signals.records.columns.read_columns`).
    base, tip
        Columns, by name or by place.
    base_unit, tip_unit
        Units, keys of `UNITS`; they also tell the quantity.
    relative
        Whether the tip is measured relative to the base.
    time, sampling_rate
        Column of the time (s), or samples per second in its place.

    Raises
    ------
    InputError
        If file, column, unit or time is wrong.
    """
    for key, unit in (("base_unit", base_unit), ("tip_unit", tip_unit)):
        if unit not in UNITS:
            raise InputError(f"unknown unit {unit!r}", key=key, remedy=f"use one of: {', '.join(UNITS)}")
    found = read_series(path, {"base": base, "tip": tip}, time=time, sampling_rate=sampling_rate)
    (base_order, base_factor), (tip_order, tip_factor) = UNITS[base_unit], UNITS[tip_unit]
    return Trial(
        path, base_factor * found.values["base"], tip_factor * found.values["tip"], found.dt, base_order, tip_order,
        relative, found.remarks,
    )  # fmt: skip


def check_rate(trial: Trial, highest: float) -> None:
    """Refuse a record with fewer than 2.5 samples per cycle of the highest frequency (Hz) of the band.

    Raises
    ------
    InputError
        If the sampling rate is too low.
    """
    if trial.rate < 2.5 * highest:
        raise InputError(
            f"{trial.rate:.5g} samples per second are fewer than 2.5 times the highest frequency, {highest:.5g} Hz",
            file=str(trial.path), key="band", remedy="lower the band, or record faster",
        )  # fmt: skip
