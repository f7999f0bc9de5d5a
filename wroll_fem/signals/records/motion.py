r"""Base motion from a record: low-pass filter, baseline, ends, and values between the samples.

The content above the limit of the low-pass filter is removed by a symmetric (linear-phase) filter, whose delay is taken
out. The same filter interpolates the record to a step fine enough for a cubic spline. The record is zero before and
after; so the response of a roll may be followed beyond its end.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline
from scipy.signal import firwin, upfirdn

from wroll_fem.errors import InputError
from wroll_fem.signals.records.record import Record
from wroll_fem.signals.shock.pulses import band_of_record, require_number
from wroll_fem.typing import FloatArray

Baseline = Literal["none", "velocity", "displacement"]

BANDS = 8.0
"""Default limit of the low-pass filter, relative to the frequency below which 99 % of the energy lies. Time steps of 20
per cycle of this frequency and more then meet no content above half their rate."""

SAMPLES = 10
"""Samples per cycle of the limit, to which the record is interpolated before the spline."""

TRANSITION = 0.25
"""Width of the transition of the low-pass filter, relative to its limit."""

JUMP = 0.05
"""Value at an end of the record, relative to its largest, from which a remark is given."""


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """Base motion from a record.

    Attributes
    ----------
    record
        Samples.
    baseline
        "none"; "velocity": a constant is subtracted, so that the velocity of the base ends at zero; "displacement": a
        straight line is subtracted, so that velocity and displacement end at zero.
    taper
        Length of the cosine taper at each end, relative to the record; 0 for none. It comes before the baseline.
    low_pass
        Limit of the low-pass filter, Hz; None takes 8 times the frequency below which 99 % of the energy lies, or none
        if that is above 0.4 times the sampling rate.
    scale
        Factor of the samples.
    before, after
        Time without base acceleration before and after the record, s.
    """

    record: Record
    baseline: Baseline = "none"
    taper: float = 0.0
    low_pass: float | None = None
    scale: float = 1.0
    before: float = 0.0
    after: float = 0.0

    def __post_init__(self) -> None:
        if self.baseline not in get_args(Baseline):
            raise InputError(
                f"baseline = {self.baseline!r}", key="excitation.baseline",
                remedy=f"use one of: {', '.join(get_args(Baseline))}",
            )  # fmt: skip
        if not 0.0 <= self.taper <= 0.5:
            raise InputError(
                f"taper = {self.taper:g}", key="excitation.taper", remedy="give a share of the record, 0 to 0.5"
            )
        for name in ("before", "after"):
            require_number(name, getattr(self, name), positive=False, remedy="give a time in s, 0 for none")
        if self.low_pass is not None:
            half = 0.5 / self.record.dt
            if not 0.0 < self.low_pass < half:
                raise InputError(
                    f"low_pass = {self.low_pass:g} Hz", key="excitation.low_pass",
                    remedy=f"give a frequency below half the sampling rate, {half:.4g} Hz",
                )  # fmt: skip

    @property
    def duration(self) -> float:
        """Duration of the motion, s."""
        return self.before + self.record.duration + self.after

    @property
    def end(self) -> float:
        """Time at which the record ends, s."""
        return self.before + self.record.duration

    @cached_property
    def amplitude(self) -> float:
        """Largest base acceleration of the samples, m/s^2."""
        return float(np.abs(self._fine[1]).max())

    @cached_property
    def highest_frequency_hz(self) -> float:
        """Frequency below which 99 % of the energy of the motion lies, Hz."""
        step, fine = self._fine
        return max(band_of_record(fine, step), 1.0 / max(self.record.duration, step))

    @property
    def velocity_change(self) -> float:
        """Change of the velocity of the base, m/s."""
        step, fine = self._fine
        return float(step * (fine.sum() - 0.5 * (fine[0] + fine[-1])))

    @property
    def limit(self) -> float:
        """Limit of the low-pass filter, Hz; half the sampling rate if there is none."""
        half = 0.5 / self.record.dt
        if self.low_pass is not None:
            return self.low_pass
        wanted = BANDS * band_of_record(self.record.acceleration, self.record.dt)
        return half if wanted > 0.8 * half or wanted == 0.0 else wanted

    @property
    def remarks(self) -> tuple[str, ...]:
        """Doubts about the motion, one sentence each."""
        found = list(self.record.remarks)
        values, band = self.record.acceleration, 1.0 / self.record.dt
        ends = max(abs(values[0]), abs(values[-1])) / np.abs(values).max()
        if ends > JUMP and self.taper == 0.0:
            found.append(
                f"the record starts or ends at {100 * ends:.0f} % of its largest value, from which the base jumps to "
                "zero; set excitation.taper, or record longer"
            )
        if 2.5 * self.highest_frequency_hz > band:
            found.append(
                f"the record has {band:.4g} samples per second, fewer than 2.5 times the frequency below which 99 % of "
                f"its energy lies, {self.highest_frequency_hz:.4g} Hz: it may be aliased"
            )
        return tuple(found)

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2; zero before and after the record."""
        t = np.asarray(time, dtype=np.float64) - self.before
        end = self.record.duration
        t = np.where(np.abs(t - end) < 1e-9 * end, end, t)
        inside = (t >= -1e-12 * end) & (t <= end)
        return np.where(inside, self._spline(np.clip(t, 0.0, end)), 0.0)

    @cached_property
    def _spline(self) -> CubicSpline:
        step, fine = self._fine
        return CubicSpline(step * np.arange(len(fine)), fine)

    @cached_property
    def _fine(self) -> tuple[float, FloatArray]:
        """Step (s) and samples (m/s^2) of the filtered and conditioned record."""
        record, half = self.record, 0.5 / self.record.dt
        limit = self.limit
        factor = max(1, ceil(SAMPLES * limit * record.dt))
        edge = min(limit, 0.95 * half)
        values = record.acceleration
        if limit < half or factor > 1:
            width = TRANSITION * edge if limit < half else 2.0 * (half - edge)
            values = _filtered(values, record.dt, factor, edge, width)
        values = self.scale * values * _taper(len(values), self.taper)
        return record.dt / factor, _levelled(values, self.baseline)


def _filtered(values: FloatArray, dt: float, factor: int, edge: float, width: float) -> FloatArray:
    """Record filtered at ``edge`` (Hz) with a transition of ``width`` (Hz), and interpolated by ``factor``.

    Before and after the record its odd reflection at the end point continues it, so that no step is filtered.
    """
    rate = factor / dt
    reach = min(ceil(4.0 / (width * dt)), len(values) - 1)  # samples of the record on each side
    before = 2.0 * values[0] - values[reach:0:-1]
    after = 2.0 * values[-1] - values[-2 : -reach - 2 : -1]
    taps = factor * firwin(2 * reach * factor + 1, edge, window=("kaiser", 8.0), fs=rate)
    found = upfirdn(taps, np.concatenate([before, values, after]), up=factor)
    start = 2 * reach * factor
    return np.asarray(found[start : start + factor * (len(values) - 1) + 1])


def _taper(count: int, share: float) -> FloatArray:
    ends = round(share * (count - 1))
    window = np.ones(count)
    if ends > 0:
        rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(ends) / ends)
        window[:ends], window[count - ends :] = rise, rise[::-1]
    return window


def _levelled(values: FloatArray, baseline: Baseline) -> FloatArray:
    """Samples without the line that leaves a velocity, or velocity and displacement, at the end."""
    if baseline == "none":
        return values
    s = np.linspace(0.0, 1.0, len(values))
    weight = np.full(len(values), 1.0)
    weight[[0, -1]] = 0.5  # trapezoidal rule
    if baseline == "velocity":
        return np.asarray(values - (weight @ values) / weight.sum())
    moments = np.array([weight, weight * (1.0 - s)])  # velocity, displacement at the end
    line = np.array([np.ones_like(s), s])
    return np.asarray(values - np.linalg.solve(moments @ line.T, moments @ values) @ line)
