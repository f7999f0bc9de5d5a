r"""Sine sweeps of the base: geometric or linear in time, upward or downward, with constant or varying amplitude.

A sweep is a sine motion (see `signals.base_motion`) whose frequency runs monotonically from f_start to f_end:

===========  ==========================  ==========================================  ==============================
law          f(t)                        phase phi(t)                                duration
===========  ==========================  ==========================================  ==============================
geometric    f_start exp(g t)            2 pi f_start (exp(g t) - 1) / g             ln(f_end / f_start) / g
linear       f_start + c t               2 pi (f_start t + c t^2 / 2)                (f_end - f_start) / c
===========  ==========================  ==========================================  ==============================

with g = R ln 2 / 60 for R octaves per minute, and c in Hz/s; both are negative for a downward sweep. The frequency of a
geometric sweep is a linear function of the phase, that of a linear sweep of its square root.

A steady response to a varying amplitude needs a constant amplitude within the half-power width of a resonance: it lags
behind the amplitude by some 1 / (2 pi zeta f_n). A factor that falls from 1 to 0.3 between 145 and 155 Hz makes the
peak of an oscillator with 150 Hz and zeta = 2 % too high by 1.8 % upward, too low by 2.2 % downward, at a tenth of the
ISO limit.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import log, log2
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.signals.base_motion import TWO_PI, ramp, require_positive, require_ramp, samples_of
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    import xarray as xr


DIRECTION, UP_DOWN = "sweep_direction", "up_down"
"""Attribute of results, and its value for a sweep up and down."""


@dataclass(frozen=True)
class Profile:
    """Factor of the amplitude of a sweep over its frequency, log-log between the rows.

    Attributes
    ----------
    frequency
        Ascending frequencies, Hz.
    factor
        Factors at these frequencies. The first and the last one hold below and above.
    """

    frequency: tuple[float, ...] = ()
    factor: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.frequency) != len(self.factor):
            raise InputError(
                f"{len(self.frequency)} frequencies and {len(self.factor)} factors", key="excitation.profile",
                remedy="give one factor per frequency",
            )  # fmt: skip
        rows = np.array([self.frequency, self.factor])
        if not (np.isfinite(rows).all() and (rows > 0.0).all() and (np.diff(rows[0]) > 0.0).all()):
            raise InputError(
                "frequencies have to rise, and all numbers have to be above zero", key="excitation.profile",
                remedy="sort the rows by frequency; give a small factor in place of zero",
            )  # fmt: skip

    def __call__(self, frequency: npt.ArrayLike) -> FloatArray | float:
        """Factor at frequencies in Hz; 1 without rows."""
        if not self.frequency:
            return 1.0
        at = np.log(np.asarray(frequency, dtype=np.float64))
        return np.asarray(np.exp(np.interp(at, np.log(self.frequency), np.log(self.factor))))


class Sweep(ABC):
    """Sine motion whose frequency runs from f_start to f_end.

    Attributes
    ----------
    amplitude
        Base acceleration, 0-peak, m/s^2.
    f_start, f_end
        First and last frequency, Hz; a downward sweep has f_end < f_start.
    ramp_cycles
        Duration of the start ramp in cycles of f_start.
    profile
        Factor of the amplitude over the frequency.
    start_phase
        Phase of the acceleration at t = 0, rad.
    """

    amplitude: float
    f_start: float
    f_end: float
    ramp_cycles: float
    profile: Profile
    start_phase: float

    @property
    @abstractmethod
    def growth(self) -> float:
        """Largest change of the frequency per cycle, Hz; negative for a downward sweep."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """Time from f_start to f_end, s."""

    @abstractmethod
    def frequency(self, time: npt.ArrayLike) -> FloatArray:
        """Instantaneous frequency at `time` (s), Hz."""

    @abstractmethod
    def phase(self, time: npt.ArrayLike) -> FloatArray:
        """Phase at `time` (s), rad: the exact integral of 2 pi f, zero at t = 0."""

    @abstractmethod
    def time_of_phase(self, phase: npt.ArrayLike) -> FloatArray:
        """Time at which a phase (rad) is reached, s."""

    @abstractmethod
    def time_of_frequency(self, frequency: npt.ArrayLike) -> FloatArray:
        """Time at which the sweep passes a frequency (Hz), s."""

    @abstractmethod
    def rate_at(self, frequency: float) -> float:
        """Sweep rate at a frequency (Hz), octaves per minute; positive for a downward sweep too."""

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency, Hz."""
        return min(self.f_start, self.f_end), max(self.f_start, self.f_end)

    @property
    def downward(self) -> bool:
        """Whether the frequency falls."""
        return self.f_end < self.f_start

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2."""
        t = np.asarray(time, dtype=np.float64)
        size = self.amplitude * self.profile(self.frequency(t))
        return np.asarray(size * ramp(t, self.ramp_cycles / self.f_start) * np.sin(self.start_phase + self.phase(t)))

    def samples(self, dt: float) -> tuple[FloatArray, FloatArray]:
        """Times 0, dt, ... (s) up to or just beyond `duration`, and base accelerations (m/s^2) at these times, (n,).

        Raises
        ------
        InputError
            If `dt` is not positive.
        """
        return samples_of(self, dt)

    def _check(self, rate: str) -> None:
        """Raise an InputError if a value is out of range; ``rate`` is the name of the rate."""
        require_positive("amplitude", self.amplitude, "give the 0-peak base acceleration in m/s^2")
        require_positive("f_start", self.f_start, "give a frequency in Hz above zero")
        require_positive("f_end", self.f_end, "give a frequency in Hz above zero")
        require_positive(rate, getattr(self, rate), "give a rate above zero, for a downward sweep too")
        if self.f_end == self.f_start:
            raise InputError(
                f"f_end = {self.f_end:g} Hz is f_start", key="excitation.f_end",
                remedy="give two different frequencies, or use a dwell",
            )  # fmt: skip
        require_ramp(self.ramp_cycles, self.f_start, self.duration)


@dataclass(frozen=True)
class Chirp(Sweep):
    """Geometric sweep: a constant rate in octaves per minute.

    Attributes
    ----------
    rate_oct_per_min
        Sweep rate R, octaves per minute, above zero.

    See `Sweep` for the others.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    amplitude: float
    f_start: float
    f_end: float
    rate_oct_per_min: float
    ramp_cycles: float = 0.0
    profile: Profile = Profile()
    start_phase: float = 0.0

    def __post_init__(self) -> None:
        self._check("rate_oct_per_min")

    @property
    def growth(self) -> float:
        """Relative growth rate g of the frequency, (df/dt) / f, 1/s; equal to its change per cycle, Hz."""
        size = self.rate_oct_per_min * log(2.0) / 60.0
        return -size if self.downward else size

    @property
    def duration(self) -> float:
        """Time from f_start to f_end, s."""
        return 60.0 * abs(log2(self.f_end / self.f_start)) / self.rate_oct_per_min

    @property
    def cycles(self) -> float:
        """Number of cycles from f_start to f_end."""
        return (self.f_end - self.f_start) / self.growth

    def frequency(self, time: npt.ArrayLike) -> FloatArray:
        """Instantaneous frequency at `time` (s), Hz."""
        return np.asarray(self.f_start * np.exp(self.growth * np.asarray(time, dtype=np.float64)))

    def phase(self, time: npt.ArrayLike) -> FloatArray:
        """Phase at `time` (s), rad: the exact integral of 2 pi f, zero at t = 0."""
        t = np.asarray(time, dtype=np.float64)
        return np.asarray(TWO_PI * self.f_start / self.growth * np.expm1(self.growth * t))

    def time_of_phase(self, phase: npt.ArrayLike) -> FloatArray:
        """Time at which a phase (rad) is reached, s."""
        p = np.asarray(phase, dtype=np.float64)
        return np.asarray(np.log1p(p * self.growth / (TWO_PI * self.f_start)) / self.growth)

    def time_of_frequency(self, frequency: npt.ArrayLike) -> FloatArray:
        """Time at which the sweep passes a frequency (Hz), s."""
        return np.asarray(np.log(np.asarray(frequency, dtype=np.float64) / self.f_start) / self.growth)

    def rate_at(self, frequency: float) -> float:
        """Sweep rate, octaves per minute, the same at all frequencies (Hz)."""
        return self.rate_oct_per_min


@dataclass(frozen=True)
class LinearSweep(Sweep):
    """Linear sweep: a constant rate in Hz/s.

    Attributes
    ----------
    rate_hz_per_s
        Sweep rate, Hz/s, above zero.

    See `Sweep` for the others.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    amplitude: float
    f_start: float
    f_end: float
    rate_hz_per_s: float
    ramp_cycles: float = 0.0
    profile: Profile = Profile()
    start_phase: float = 0.0

    def __post_init__(self) -> None:
        self._check("rate_hz_per_s")

    @property
    def slope(self) -> float:
        """Change of the frequency per time, Hz/s; negative for a downward sweep."""
        return -self.rate_hz_per_s if self.downward else self.rate_hz_per_s

    @property
    def growth(self) -> float:
        """Largest change of the frequency per cycle, Hz: that at the lowest frequency."""
        return self.slope / self.band[0]

    @property
    def duration(self) -> float:
        """Time from f_start to f_end, s."""
        return (self.f_end - self.f_start) / self.slope

    def frequency(self, time: npt.ArrayLike) -> FloatArray:
        """Instantaneous frequency at `time` (s), Hz."""
        return np.asarray(self.f_start + self.slope * np.asarray(time, dtype=np.float64))

    def phase(self, time: npt.ArrayLike) -> FloatArray:
        """Phase at `time` (s), rad: the exact integral of 2 pi f, zero at t = 0."""
        t = np.asarray(time, dtype=np.float64)
        return np.asarray(TWO_PI * t * (self.f_start + 0.5 * self.slope * t))

    def time_of_phase(self, phase: npt.ArrayLike) -> FloatArray:
        """Time at which a phase (rad) is reached, s."""
        cycles = np.asarray(phase, dtype=np.float64) / TWO_PI  # the root of the quadratic that is 0 at phase 0
        return np.asarray(2.0 * cycles / (self.f_start + np.sqrt(self.f_start**2 + 2.0 * self.slope * cycles)))

    def time_of_frequency(self, frequency: npt.ArrayLike) -> FloatArray:
        """Time at which the sweep passes a frequency (Hz), s."""
        return np.asarray((np.asarray(frequency, dtype=np.float64) - self.f_start) / self.slope)

    def rate_at(self, frequency: float) -> float:
        """Sweep rate at a frequency (Hz), octaves per minute; positive for a downward sweep too."""
        return 60.0 * self.rate_hz_per_s / (frequency * log(2.0))


def sweep_of(dataset: xr.Dataset) -> Sweep | None:
    """Sweep of a result, from its attributes; None for other motions and for a sweep up and down.

    The attributes are `f_start_hz`, `f_end_hz` and `rate_oct_per_min` or `rate_hz_per_s`. Without a rate, a geometric
    sweep is taken to reach `f_end_hz` at the last time.
    """
    attrs = dataset.attrs
    if attrs.get("excitation_kind") != "chirp" or "f_start_hz" not in attrs or attrs.get(DIRECTION) == UP_DOWN:
        return None
    amplitude, start = float(attrs.get("amplitude_m_s2", 1.0)), float(attrs["f_start_hz"])
    if "rate_hz_per_s" in attrs:
        return LinearSweep(amplitude, start, float(attrs["f_end_hz"]), float(attrs["rate_hz_per_s"]))
    if "f_end_hz" in attrs:
        end = float(attrs["f_end_hz"])
        octaves = abs(log2(end / start))
        return Chirp(
            amplitude, start, end, float(attrs.get("rate_oct_per_min", 60.0 * octaves / dataset["time"].values[-1]))
        )
    if "rate_oct_per_min" in attrs:
        rate = float(attrs["rate_oct_per_min"])
        end = start * 2.0 ** (rate * float(dataset["time"].values[-1]) / 60.0)
        return Chirp(amplitude, start, end, rate)
    return None
