r"""Base motions: prescribed accelerations of the base. Dwells are here, sweeps in `signals.sweeps`.

Both are sine motions of the form

.. math:: a_g(t) = A\, w(t) \sin\varphi(t), \qquad \varphi(t) = 2\pi \int_0^t f\, dt,

with the amplitude A (0-peak, m/s^2), the phase in closed form and a start ramp w(t) = (1 - cos(pi t / t_r)) / 2 over
the first t_r = ramp_cycles / f(0) seconds (w = 1 afterwards, and from the start if ramp_cycles = 0). They are zero for
t < 0. The formula is continued beyond `duration`, so that there is no jump on a time grid that ends a rounding error
later.

References
----------
.. [1] ISO 7626-2:2015, Experimental determination of mechanical mobility, Part 2, sine sweep rates.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, pi
from typing import Protocol

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

TWO_PI = 2.0 * pi


class BaseMotion(Protocol):
    """Properties and methods of every base motion, as used by time integration."""

    @property
    def duration(self) -> float:
        """Duration of the motion, s."""
        ...

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2; zero before the motion starts."""
        ...


class SineMotion(BaseMotion, Protocol):
    """Base motion with an instantaneous frequency, as used by demodulation."""

    @property
    def amplitude(self) -> float:
        """Amplitude of the base acceleration, 0-peak, m/s^2."""
        ...

    @property
    def ramp_cycles(self) -> float:
        """Duration of the start ramp, cycles."""
        ...

    def frequency(self, time: npt.ArrayLike) -> FloatArray:
        """Instantaneous frequency at `time` (s), Hz."""
        ...

    def phase(self, time: npt.ArrayLike) -> FloatArray:
        """Phase at `time` (s), rad."""
        ...


def require_positive(name: str, value: float, remedy: str) -> None:
    """Refuse a value of section `excitation` that is not a positive number."""
    if not (isfinite(value) and value > 0.0):
        raise InputError(f"{name} = {value:g} is not a positive number", key=f"excitation.{name}", remedy=remedy)


def require_ramp(ramp_cycles: float, start_frequency: float, duration: float) -> None:
    """Refuse a start ramp that is negative or longer than the motion; frequency in Hz, duration in s."""
    if not (isfinite(ramp_cycles) and ramp_cycles >= 0.0):
        raise InputError(
            f"ramp_cycles = {ramp_cycles:g} is negative or not finite",
            key="excitation.ramp_cycles",
            remedy="give the duration of the ramp in cycles of the start frequency, 0 for none",
        )
    if ramp_cycles / start_frequency > duration:
        raise InputError(
            f"the start ramp of {ramp_cycles:g} cycles is longer than the motion",
            key="excitation.ramp_cycles",
            remedy=f"use at most {start_frequency * duration:.4g} cycles",
        )


def ramp(time: FloatArray, ramp_time: float) -> FloatArray:
    """Cosine start ramp, (n,) values in [0, 1]; zero for t < 0."""
    if ramp_time == 0.0:
        return np.where(time < 0.0, 0.0, 1.0)
    return 0.5 - 0.5 * np.cos(pi * np.clip(time / ramp_time, 0.0, 1.0))


def samples_of(motion: BaseMotion, dt: float) -> tuple[FloatArray, FloatArray]:
    """Times 0, dt, ... (s) up to or just beyond the duration, and base accelerations (m/s^2) at these times, (n,).

    Raises
    ------
    InputError
        If `dt` is not positive.
    """
    if not (isfinite(dt) and dt > 0.0):
        raise InputError(f"time step dt = {dt:g} s is not a positive number", remedy="use for example 1 / (40 f_end)")
    steps = int(np.ceil(motion.duration / dt - 1e-9))
    time = dt * np.arange(steps + 1, dtype=np.float64)
    return time, motion.acceleration(time)


@dataclass(frozen=True, init=False)
class Dwell:
    """Sinusoidal base motion at one frequency; constructor: `Dwell(amplitude, frequency, cycles, ramp_cycles=5.0)`.

    Attributes
    ----------
    amplitude
        Base acceleration, 0-peak, m/s^2.
    frequency_hz
        Frequency, Hz (the argument `frequency`; `frequency(t)` is a method of every base motion).
    cycles
        Duration of the motion in cycles, ramp included.
    ramp_cycles
        Duration of the start ramp in cycles.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    amplitude: float
    frequency_hz: float
    cycles: float
    ramp_cycles: float

    def __init__(self, amplitude: float, frequency: float, cycles: float, ramp_cycles: float = 5.0) -> None:
        values = {"amplitude": amplitude, "frequency_hz": frequency, "cycles": cycles, "ramp_cycles": ramp_cycles}
        for name, value in values.items():
            object.__setattr__(self, name, value)
        require_positive("amplitude", self.amplitude, "give the 0-peak base acceleration in m/s^2")
        require_positive("frequency", self.frequency_hz, "give a frequency in Hz above zero")
        require_positive("cycles", self.cycles, "give the number of cycles")
        require_ramp(self.ramp_cycles, self.frequency_hz, self.duration)

    @property
    def duration(self) -> float:
        """Duration of the motion, s."""
        return self.cycles / self.frequency_hz

    def frequency(self, time: npt.ArrayLike) -> FloatArray:
        """Frequency, Hz, in the shape of `time`."""
        return np.full(np.shape(time), self.frequency_hz, dtype=np.float64)

    def phase(self, time: npt.ArrayLike) -> FloatArray:
        """Phase at `time` (s), rad, zero at t = 0."""
        return np.asarray(TWO_PI * self.frequency_hz * np.asarray(time, dtype=np.float64))

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2."""
        t = np.asarray(time, dtype=np.float64)
        return self.amplitude * ramp(t, self.ramp_cycles / self.frequency_hz) * np.sin(self.phase(t))

    def samples(self, dt: float) -> tuple[FloatArray, FloatArray]:
        """Times 0, dt, ... (s) up to or just beyond `duration`, and base accelerations (m/s^2) at these times, (n,).

        Raises
        ------
        InputError
            If `dt` is not positive.
        """
        return samples_of(self, dt)


def sweep_rate_limit(f_n: float, zeta: float) -> float:
    r"""Highest sweep rate (oct/min) that ISO 7626-2 allows for a resonance: 78 f_n / Q^2 with Q = 1 / (2 zeta).

    Parameters
    ----------
    f_n
        Natural frequency, Hz.
    zeta
        Damping ratio.

    Notes
    -----
    At a lower rate the envelope of the response of a single degree of freedom reaches at least about 95 % of the steady
    peak; see the table in `wroll_fem.signals.transmissibility`.
    """
    return 78.0 * f_n * (2.0 * zeta) ** 2
