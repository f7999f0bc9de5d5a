r"""Sweep of the base from its record: phase and frequency of a measured sine whose frequency rises or falls.

The phase is that of the analytic signal (Hilbert transform) of the record, smoothed by a least-squares spline with
knots some `KNOT_CYCLES` cycles apart. Base and tip are demodulated with the same phase, so that a slow error of it
cancels in their ratio.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, CubicSpline, make_lsq_spline
from scipy.signal import hilbert

from wroll_fem.errors import InputError
from wroll_fem.signals.base_motion import TWO_PI
from wroll_fem.signals.sweeps import Profile, Sweep
from wroll_fem.typing import FloatArray

KNOT_CYCLES = 40.0
"""Cycles between the knots of the smoothed phase."""

MOST_KNOTS = 60
"""Largest number of knots of the smoothed phase."""

QUIET = 0.02
"""Envelope, relative to its 95th percentile, below which the base counts as at rest."""

EDGE_CYCLES = 2.0
"""Cycles at each end of the moving part that are left out, because the analytic signal is wrong there."""

NO_PROFILE = Profile()

LARGEST_SLIP = 0.5
"""Largest distance of the measured phase from the smoothed one, cycles. Beyond it the base is no single sine."""


@dataclass(frozen=True, eq=False)
class MeasuredSweep(Sweep):
    """Sine motion of the base whose frequency runs from f_start to f_end, from its samples.

    Attributes
    ----------
    time
        (n,) times of the samples, s, from 0.
    samples_of_base
        (n,) samples, in the unit of the record.
    smooth
        Spline of the phase over the time, rad.

    See `Sweep` for the others; `amplitude` is the largest value of the envelope.
    """

    amplitude: float
    f_start: float
    f_end: float
    time: FloatArray
    samples_of_base: FloatArray
    smooth: BSpline
    ramp_cycles: float = 0.0
    profile: Profile = NO_PROFILE

    @property
    def duration(self) -> float:
        """Time of the last sample, s."""
        return float(self.time[-1])

    @cached_property
    def _phase(self) -> FloatArray:
        return np.asarray(self.smooth(self.time))

    @cached_property
    def _frequency(self) -> FloatArray:
        return np.asarray(self.smooth.derivative()(self.time)) / TWO_PI

    @property
    def growth(self) -> float:
        """Largest change of the frequency per cycle, Hz; negative for a downward sweep."""
        change = np.gradient(self._frequency, self.time) / self._frequency
        return float(change[np.argmax(np.abs(change))])

    def frequency(self, time: npt.ArrayLike) -> FloatArray:
        """Instantaneous frequency at `time` (s), Hz."""
        return np.asarray(np.interp(np.asarray(time, dtype=np.float64), self.time, self._frequency))

    def phase(self, time: npt.ArrayLike) -> FloatArray:
        """Phase at `time` (s), rad; zero at the first sample."""
        return np.asarray(self.smooth(np.asarray(time, dtype=np.float64)))

    def time_of_phase(self, phase: npt.ArrayLike) -> FloatArray:
        """Time at which a phase (rad) is reached, s."""
        return np.asarray(CubicSpline(self._phase, self.time)(np.asarray(phase, dtype=np.float64)))

    def time_of_frequency(self, frequency: npt.ArrayLike) -> FloatArray:
        """Time at which the sweep passes a frequency (Hz), s."""
        order, wanted = -1 if self.downward else 1, np.asarray(frequency, dtype=np.float64)
        return np.asarray(np.interp(wanted, self._frequency[::order], self.time[::order]))

    def rate_at(self, frequency: float) -> float:
        """Sweep rate at a frequency (Hz), octaves per minute; positive for a downward sweep too."""
        slope = np.gradient(np.log2(self._frequency), self.time)
        return 60.0 * abs(float(np.interp(float(self.time_of_frequency(frequency)), self.time, slope)))

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Samples at `time` (s), in the unit of the record."""
        return np.asarray(CubicSpline(self.time, self.samples_of_base)(np.asarray(time, dtype=np.float64)))


def measured_sweep(samples: npt.ArrayLike, dt: float, band: tuple[float, float] | None = None) -> tuple[Sweep, slice]:
    """Sweep of a record, and the part of the record in which it runs.

    Parameters
    ----------
    samples
        (n,) record of the base.
    dt
        Time step, s.
    band
        Lowest and highest frequency of the part, Hz; the whole sweep if None.

    Returns
    -------
    tuple
        The sweep, whose time starts at the first sample of the part, and the part as slice of the record.

    Raises
    ------
    InputError
        If the record is no sweep: too short, not a single sine at each time, or its frequency turns.
    """
    x = np.asarray(samples, dtype=np.float64)
    analytic = hilbert(x - x.mean())
    size = np.abs(analytic)
    loud = size > QUIET * float(np.quantile(size, 0.95))
    first, last = _longest(loud, round(0.02 * len(x)) + 1)
    phase = np.unwrap(np.angle(analytic[first:last])) + 0.5 * np.pi  # of the sine
    time = dt * np.arange(last - first)
    cycles = abs(phase[-1] - phase[0]) / TWO_PI
    if cycles < 4.0 * EDGE_CYCLES + 10.0:
        raise InputError(f"{cycles:.3g} cycles are too few for a sweep", key="method", remedy="give a longer record")
    cut = np.searchsorted(phase, [phase[0] + TWO_PI * EDGE_CYCLES, phase[-1] - TWO_PI * EDGE_CYCLES])
    cut[0], cut[1] = max(0, cut[0]), min(len(phase), max(cut[1], cut[0] + 16))
    smooth = _smoothed(time[cut[0] : cut[1]], phase[cut[0] : cut[1]])
    time, start = time[cut[0] : cut[1]], first + int(cut[0])
    frequency = np.asarray(smooth.derivative()(time)) / TWO_PI
    low, high = _monotonic(frequency, time)
    if band is not None:
        inside = np.flatnonzero((frequency[low:high] >= band[0]) & (frequency[low:high] <= band[1]))
        if inside.size < 16:
            raise InputError(
                f"the sweep from {frequency[low]:.4g} to {frequency[high - 1]:.4g} Hz does not pass the band of "
                f"{band[0]:g} to {band[1]:g} Hz", key="band", remedy="give a band inside the sweep",
            )  # fmt: skip
        low, high = low + int(inside[0]), low + int(inside[-1]) + 1
    part = slice(start + low, start + high)
    return _sweep_of(x[part], dt, phase[int(cut[0]) + low : int(cut[0]) + high]), part


def _sweep_of(samples: FloatArray, dt: float, phase: FloatArray) -> MeasuredSweep:
    """Sweep of the samples of one monotonic part, with their measured phase."""
    time = dt * np.arange(len(samples))
    smooth = _smoothed(time, phase - phase[0])
    smooth = BSpline(smooth.t, smooth.c - smooth(0.0), smooth.k)  # phase zero at time zero
    ends = np.asarray(smooth.derivative()(time[[0, -1]])) / TWO_PI
    slips = np.abs(smooth(time) - (phase - phase[0])) / TWO_PI
    if np.quantile(slips, 0.99) > LARGEST_SLIP:
        raise InputError(
            "the base does not move as one sine at each time", key="method",
            remedy="set method: random for a random motion, or give the band of the sweep",
        )  # fmt: skip
    return MeasuredSweep(float(np.abs(samples).max()), float(ends[0]), float(ends[1]), time, samples, smooth)


def _longest(flags: npt.NDArray[np.bool_], gap: int) -> tuple[int, int]:
    """First index, and last index plus one, of the longest run of true values; gaps shorter than ``gap`` are closed."""
    at = np.flatnonzero(flags)
    breaks = np.flatnonzero(np.diff(at) > gap)
    starts, ends = at[np.r_[0, breaks + 1]], at[np.r_[breaks, at.size - 1]]
    k = int(np.argmax(ends - starts))
    return int(starts[k]), int(ends[k]) + 1


def _smoothed(time: FloatArray, phase: FloatArray) -> BSpline:
    """Least-squares cubic spline of a phase (rad) over the time (s)."""
    cycles = abs(phase[-1] - phase[0]) / TWO_PI
    pieces = int(np.clip(cycles / KNOT_CYCLES, 2, MOST_KNOTS))
    share = np.linspace(phase[0], phase[-1], pieces + 1)[1:-1]
    inner = np.interp(share, np.maximum.accumulate(phase), time)
    inner = np.unique(np.clip(inner, time[4], time[-5]))
    knots = np.r_[[time[0]] * 4, inner, [time[-1]] * 4]
    return make_lsq_spline(time, phase, knots, k=3)


def _monotonic(frequency: FloatArray, time: FloatArray) -> tuple[int, int]:
    """Part of a sweep in which its frequency does not turn; refuses a sweep that turns in its middle."""
    rising = frequency[-1] > frequency[0]
    turning = np.flatnonzero(np.diff(frequency) <= 0.0 if rising else np.diff(frequency) >= 0.0)
    edge = len(frequency) // 20
    inside = turning[(turning > edge) & (turning < len(frequency) - edge)]
    if inside.size or not frequency.min() > 0.0:
        at = time[inside[0]] if inside.size else 0.0
        raise InputError(
            f"the frequency of the base turns or stands still (first at {at:.4g} s of its motion)", key="method",
            remedy="give one sweep per file, upward or downward, or set method: random",
        )  # fmt: skip
    low = int(turning[turning <= edge].max(initial=-1)) + 1
    high = int(turning[turning >= len(frequency) - edge].min(initial=len(frequency) - 1)) + 1
    return low, high
