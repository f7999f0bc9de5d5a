r"""Classical shock pulses of the base: half-sine, terminal-peak sawtooth, trapezoid.

A pulse of the amplitude A (m/s^2, 0-peak) and the length T (s) starts after the pause `before` and is followed by the
time `after`, with no base acceleration. The velocity of the base changes by the area of the pulse: 2 A T / pi, A T / 2,
and A (flat + (rise + fall) / 2).

References
----------
.. [1] IEC 60068-2-27:2008, Environmental testing, Part 2-27: Tests, Test Ea and guidance: Shock.
.. [2] MIL-STD-810H, Method 516.8, Shock.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import inf, pi

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

ENERGY_SHARE = 0.99
"""Share of the energy of a motion (integral of the squared acceleration) below its highest frequency with energy."""


def require_number(name: str, value: float, *, positive: bool, remedy: str) -> None:
    """Raise an `InputError` for ``excitation.name`` unless a value is finite, and positive or not negative."""
    if not (0.0 < value < inf or (value == 0.0 and not positive)):
        raise InputError(f"{name} = {value:g}", key=f"excitation.{name}", remedy=remedy)


@dataclass(frozen=True)
class Pulse(ABC):
    """One-sided shock pulse.

    Attributes
    ----------
    amplitude
        Largest base acceleration, m/s^2.
    length
        Length of the pulse T, s.
    before, after
        Time without base acceleration before and after the pulse, s.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    amplitude: float
    length: float
    before: float = 0.0
    after: float = 0.0

    def __post_init__(self) -> None:
        require_number("amplitude", self.amplitude, positive=True, remedy="give the peak base acceleration in m/s^2")
        require_number("duration", self.length, positive=True, remedy="give the length of the pulse in s")
        require_number("before", self.before, positive=False, remedy="give a time in s, 0 for none")
        require_number("after", self.after, positive=False, remedy="give a time in s, 0 for none")

    @property
    def duration(self) -> float:
        """Duration of the motion, s: pulse and the times before and after it."""
        return self.before + self.length + self.after

    @property
    def end(self) -> float:
        """Time at which the pulse ends, s."""
        return self.before + self.length

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2; at a jump the mean of both sides."""
        s = (np.asarray(time, dtype=np.float64) - self.before) / self.length
        for end in (0.0, 1.0):  # a time on a grid misses the end by a rounding error
            s = np.where(np.abs(s - end) < 1e-9, end, s)
        return np.where((s < 0.0) | (s > 1.0), 0.0, self.amplitude * self._shape(s))

    @property
    @abstractmethod
    def velocity_change(self) -> float:
        """Area of the pulse, m/s."""

    @property
    @abstractmethod
    def highest_frequency_hz(self) -> float:
        """Frequency below which 99 % of the energy of the pulse lies, Hz."""

    @abstractmethod
    def _shape(self, s: FloatArray) -> FloatArray:
        """Pulse of unit amplitude over its length, 0 <= s <= 1."""


@dataclass(frozen=True)
class HalfSine(Pulse):
    """Half a period of a sine: a(t) = A sin(pi t / T)."""

    @property
    def velocity_change(self) -> float:
        """Area of the pulse, m/s."""
        return 2.0 * self.amplitude * self.length / pi

    @property
    def highest_frequency_hz(self) -> float:
        """Frequency below which 99 % of the energy of the pulse lies, Hz."""
        return 1.18 / self.length

    def _shape(self, s: FloatArray) -> FloatArray:
        return np.sin(pi * s)


@dataclass(frozen=True)
class Sawtooth(Pulse):
    """Terminal-peak sawtooth: a(t) = A t / T, which drops to zero at T."""

    @property
    def velocity_change(self) -> float:
        """Area of the pulse, m/s."""
        return 0.5 * self.amplitude * self.length

    @property
    def highest_frequency_hz(self) -> float:
        """Frequency below which 99 % of the energy of the pulse lies, Hz."""
        return 14.4 / self.length

    def _shape(self, s: FloatArray) -> FloatArray:
        return np.where(s == 1.0, 0.5, s)


@dataclass(frozen=True)
class Trapezoid(Pulse):
    """Trapezoid: straight rise, flat top, straight fall.

    Attributes
    ----------
    rise, fall
        Share of the length of the pulse for rise and fall; together 1 at most (IEC 60068-2-27: 0.1 each).
    """

    rise: float = 0.1
    fall: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("rise", "fall"):
            remedy = "give a share of the duration, 0 for a jump"
            require_number(name, getattr(self, name), positive=False, remedy=remedy)
        if self.rise + self.fall > 1.0 + 1e-12:
            raise InputError(
                f"rise and fall take {self.rise + self.fall:g} times the duration", key="excitation.rise",
                remedy="give shares of the duration that add up to 1 at most",
            )  # fmt: skip

    @property
    def velocity_change(self) -> float:
        """Area of the pulse, m/s."""
        return self.amplitude * self.length * (1.0 - 0.5 * (self.rise + self.fall))

    @property
    def highest_frequency_hz(self) -> float:
        """Frequency below which 99 % of the energy of the pulse lies, Hz."""
        return _band(self)

    def _shape(self, s: FloatArray) -> FloatArray:
        edge = 0.5 if self.rise == 0.0 else 0.0
        up = np.where(s == 0.0, edge, 1.0) if self.rise == 0.0 else np.minimum(s / self.rise, 1.0)
        edge = 0.5 if self.fall == 0.0 else 0.0
        down = np.where(s == 1.0, edge, 1.0) if self.fall == 0.0 else np.minimum((1.0 - s) / self.fall, 1.0)
        return np.minimum(up, down)


def _band(pulse: Pulse, points: int = 8192, lengths: int = 16) -> float:
    """Frequency below which `ENERGY_SHARE` of the energy of a pulse lies, Hz, from its samples."""
    step = pulse.length / points
    time = pulse.before + step * np.arange(points + 1)
    return band_of_record(pulse.acceleration(time), step, pad=lengths)


def band_of_record(acceleration: FloatArray, dt: float, *, share: float = ENERGY_SHARE, pad: int = 1) -> float:
    """Frequency below which a share of the energy of a record lies, Hz; 0 for a record of zeros.

    Parameters
    ----------
    acceleration
        (n,) samples; zero outside.
    dt
        Time between two samples, s.
    share
        Share of the integral of the squared acceleration.
    pad
        Length of the Fourier transform in lengths of the record.
    """
    power = np.abs(np.fft.rfft(acceleration, pad * len(acceleration))) ** 2
    below = np.cumsum(power)
    if not below[-1] > 0.0:
        return 0.0
    k = int(np.searchsorted(below, share * below[-1]))
    return k / (pad * len(acceleration) * dt)
