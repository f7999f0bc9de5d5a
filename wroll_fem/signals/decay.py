r"""Frequency and damping of a free vibration versus its amplitude.

The motion is multiplied by :math:`\exp(-i\omega_0 t)` and smoothed by a symmetric window of a few periods: the analytic
signal of the band around :math:`\omega_0`, without its fast rotation. With the complex envelope z, the rate

.. math:: s = i\omega_0 + \frac{\dot z}{z} = \frac{\dot a}{a} + i\omega_d, \qquad \omega = |s|

is that of the motion at each moment, with the amplitude a. The damping ratio is that by energy, W / (4 pi E) of a
steady cycle with the work W and the largest kinetic energy E. It follows from the balance -U' da/dt = W omega / (2 pi),
where U(a) is the energy that the motion releases when its amplitude falls:

.. math:: \zeta = -\frac{\dot a}{a\,\omega}\,\frac{U'(a)}{k a}, \qquad k = m \omega^2, \qquad
          s = \frac{d\ln\omega}{d\ln a}

- Conservative springs: a^2 omega is the action, and U' / (k a) = 1 + s / 2.
- Slip with a memory (Masing's rule: each branch of the loop is the first loading f, doubled) [2]_: between two
  peaks a + d/2 and -(a - d/2) the work of the force along the branch is zero. With W = 8 int f - 4 a f(a) this gives
  d = W / (2 a f'(a)). A slipping structure releases U'(a) = a f'(a), less than k a, because the springs of the
  slipping points keep their energy. The frequency gives f': a first loading of the power a^(n+1) has the ratio
  f' / k = g(n) = (sqrt(pi) / 4) (n + 2) Gamma(n + 2) / Gamma(n + 3/2), which 1 + 0.9 n + 0.1 n^2 meets at n = 0, 1 and
  2, and to 0.2 % between them. With a d/da in place of n, U' / (k a) = 1 + 1.8 s + 0.4 s^2 + 0.2 ds / d ln a.

Where slip lowers the frequency by 8 % per factor e, the decrement alone is some 16 % too high, and the first formula
gives 12 % too much. A linear filter multiplies an exponential by a constant, so the rate of a linear
decay is exact. Half a window at each end is left out, so that no value depends on what was before the decay or after
the record. A constant offset (slip that stays) and other modes lie in the stop band of the window.

References
----------
.. [1] M. Feldman, Non-linear system vibration analysis using Hilbert transform I, Mechanical Systems and Signal
   Processing 8(2), 1994, 119-127, doi:10.1006/mssp.1994.1011.
.. [2] W. D. Iwan, A distributed-element model for hysteresis and its steady-state dynamic response, Journal of Applied
   Mechanics 33, 1966, 893-900, doi:10.1115/1.3625199.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, nan, pi

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.signal import fftconvolve
from scipy.signal.windows import blackmanharris

from wroll_fem.errors import InputError
from wroll_fem.typing import ComplexArray, FloatArray

PERIODS = 4
"""Length of the window in periods. Its stop band, -92 dB, begins at a distance of the frequency itself: an offset lies
there."""

FEWEST_PERIODS = 5
"""Periods of usable decay (without the ends) below which nothing is estimated."""

EXPECTED = 1.3
"""Highest frequency at which the decay is looked for, relative to that with sticking interfaces."""

LEVELS_PER_DECADE = 20
"""Amplitudes per decade at which frequency and damping are given."""

FLOOR = 1e-3
"""Amplitude relative to the largest below which a decay is not followed: what the window leaves of an offset and of
other modes, and convergence errors of the time steps."""

LEAST_RELEASED = 0.2
"""Smallest U' / (k a) that is used: a structure that slides everywhere has lost its stiffness."""

BEAT = 1.02
"""Growth of the amplitude of a free vibration from which it beats."""

CHANGE = 1.5
"""Ratio of the damping at two amplitudes of the averaged range from which one damping ratio does not describe it."""


@dataclass(frozen=True, eq=False)
class Decay:
    """Frequency and damping of a free vibration.

    Attributes
    ----------
    amplitude
        (m,) amplitudes (0-peak, unit of the motion), descending, about 20 per decade.
    frequency
        (m,) natural frequency at these amplitudes, Hz.
    damping
        (m,) damping ratio at these amplitudes.
    time
        (m,) time at which the amplitude is reached, s.
    f_hz, zeta
        Frequency and damping from the largest usable amplitude to half of it (logarithmic decrement); nan if there is
        no decay.
    invalid, doubts
        Why there is no value; why the values are doubtful; one sentence each.
    """

    amplitude: FloatArray
    frequency: FloatArray
    damping: FloatArray
    time: FloatArray
    f_hz: float = nan
    zeta: float = nan
    invalid: str = ""
    doubts: tuple[str, ...] = ()


def free_decay(
    motion: FloatArray, dt: float, *, start: float = 0.0, expected: float | None = None, slipping: bool = False
) -> Decay:
    """Frequency and damping of a decaying motion versus its amplitude.

    Parameters
    ----------
    motion
        (n,) displacement, velocity or acceleration of a free vibration.
    dt
        Time step, s.
    start
        Time of the first sample, s.
    expected
        Frequency (Hz) of the mode with sticking interfaces, which slip lowers: the decay is that of the largest line up
        to 1.3 times this value. None: of the largest line.
    slipping
        Whether slip changes the frequency; otherwise nonlinear springs do. It changes the damping ratio where the
        frequency depends on the amplitude.

    Raises
    ------
    InputError
        If the motion is no series of finite numbers.
    """
    values = np.asarray(motion, dtype=np.float64)
    if values.ndim != 1 or not np.isfinite(values).all() or not (isfinite(dt) and dt > 0.0):
        raise InputError("a decay must be a series of finite numbers with a positive time step", remedy="check it")
    if len(values) < 8 or not np.ptp(values) > 0.0:
        return _none("there is no motion after the shock")
    f = _dominant(values, dt, expected)
    for _ in range(2):  # the second time around the frequency found
        window = max(3, round(PERIODS / (f * dt)))
        count = len(values) - window + 1
        if count * dt * f < FEWEST_PERIODS:
            wanted = (PERIODS + FEWEST_PERIODS) / f
            return _none(
                f"the decay of {len(values) * dt:.3g} s is too short for a frequency of {f:.4g} Hz: "
                f"set excitation.decay to {wanted:.2g} s or more"
            )
        rate, level, phase = _envelope(values, dt, f, window)
        used = level > FLOOR * level.max()
        f = f + float(np.median(np.gradient(phase, dt)[used])) / (2.0 * pi)
        if not 0.0 < f < 0.25 / dt:
            return _none("the motion after the shock does not oscillate")
    time = start + dt * (0.5 * (window - 1) + np.arange(count))
    return _over_amplitude(time, level, rate, slipping=slipping)


def _none(reason: str) -> Decay:
    empty = np.zeros(0)
    return Decay(empty, empty, empty, empty, invalid=reason)


def _dominant(values: FloatArray, dt: float, expected: float | None) -> float:
    """Frequency of the largest line of the spectrum, Hz."""
    n = len(values)
    fade = 0.5 + 0.5 * np.cos(pi * np.arange(n) / n)
    spectrum = np.abs(np.fft.rfft((values - values[3 * n // 4 :].mean()) * fade, 4 * n))
    lines = np.fft.rfftfreq(4 * n, dt)
    if expected is not None:
        spectrum = np.where(lines < EXPECTED * expected, spectrum, 0.0)
    return float(max(lines[int(np.argmax(spectrum))], lines[1]))


def _envelope(values: FloatArray, dt: float, f: float, window: int) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Rates (n, complex, 1/s), amplitudes (n,) and phases (n,) relative to a rotation of frequency f."""
    weights = blackmanharris(window)
    turn = 2.0 * pi * f * dt
    rotated = values * np.exp(-1j * turn * np.arange(len(values)))
    z = 2.0 * fftconvolve(rotated, weights / weights.sum(), mode="valid")
    tiny = np.finfo(np.float64).tiny
    level, phase = np.maximum(np.abs(z), tiny), np.unwrap(np.angle(z))
    speed = np.gradient(phase, dt)  # relative to the rotation, rad/s
    level = level / _gain(weights, np.gradient(np.log(level), dt) + 1j * speed, dt)
    return np.gradient(np.log(level), dt) + 1j * (speed + 2.0 * pi * f), level, phase


def _gain(weights: FloatArray, rate: ComplexArray, dt: float) -> FloatArray:
    """Factor (n,) by which the window changes the amplitude of an exponential of this rate relative to the rotation.

    A frequency that changes with the amplitude lies off the centre of the window, and its factor changes with time.
    """
    middle = (np.arange(len(weights)) - 0.5 * (len(weights) - 1)) * dt
    few = np.unique(np.linspace(0, len(rate) - 1, 300).astype(int))
    fastest = 40.0 / (len(weights) * dt)  # beyond, the motion has vanished
    s = np.clip(rate[few].real, -fastest, fastest) + 1j * rate[few].imag
    gain = np.abs(np.exp(np.outer(s, middle)) @ weights)
    return np.asarray(PchipInterpolator(few, np.maximum(gain / weights.sum(), 1e-3))(np.arange(len(rate))))


def _released(amplitude: FloatArray, frequency: FloatArray, *, slipping: bool) -> FloatArray:
    """(m,) energy U' that the motion releases, relative to k a, from the logarithms of amplitude and frequency."""
    if len(amplitude) < 3:
        return np.ones(len(amplitude))
    s = np.clip(np.gradient(frequency, amplitude), -1.0, 1.0)
    if not slipping:
        return np.asarray(1.0 + 0.5 * s)
    return np.maximum(1.0 + 1.8 * s + 0.4 * s**2 + 0.2 * np.gradient(s, amplitude), LEAST_RELEASED)


def _over_amplitude(time: FloatArray, level: FloatArray, rate: ComplexArray, *, slipping: bool) -> Decay:
    first = int(np.argmax(level))
    time, level, rate = time[first:], level[first:], rate[first:]
    below = np.flatnonzero(level < FLOOR * level[0])
    last = int(below[0]) if below.size else len(level)
    time, level, rate = time[:last], level[:last], rate[:last]
    falling = np.minimum.accumulate(level)
    beats = float((level / falling).max())
    if len(level) < 3 or not falling[-1] < level[0]:
        return _none("the motion after the shock does not decay")
    count = max(2, int(np.ceil(LEVELS_PER_DECADE * np.log10(level[0] / falling[-1]))) + 1)
    amplitude = np.geomspace(level[0], falling[-1], count)
    at = np.unique([int(np.argmax(falling <= a * (1.0 + 1e-12))) for a in amplitude])
    amplitude, s = level[at], rate[at]
    half = int(np.argmax(falling <= 0.5 * level[0])) if falling[-1] <= 0.5 * level[0] else len(level) - 1
    elapsed = time[half] - time[0]
    doubts = []
    if falling[-1] > 0.5 * level[0]:
        doubts.append(
            f"the tip's amplitude falls to {100 * falling[-1] / level[0]:.0f} % only, not to half: zeta is that of a "
            "short part of the decay; set excitation.decay longer"
        )
    if beats > BEAT:
        doubts.append(
            f"the amplitude of the free vibration grows again by up to {100 * (beats - 1):.2g} %: two modes beat, and "
            "frequency and damping are those of both"
        )
    released = _released(np.log(amplitude), np.log(np.abs(s)), slipping=slipping)
    damping = -s.real / np.abs(s) * released
    upper = amplitude >= 0.5 * level[0] * (1.0 - 1e-12)
    share = float(np.mean(released[upper]))
    lost = -share * np.log(level[half] / level[0]) / elapsed
    turning = float(rate[: half + 1].imag.mean())
    size = np.hypot(lost, turning)
    inside = damping[upper]
    low, high = float(inside.min()), float(inside.max())
    if high > CHANGE * max(low, 1e-6) and high > 1e-4:
        doubts.append(
            f"the damping ratio changes from {100 * low:.2g} to {100 * high:.2g} % while the amplitude halves: one "
            "number does not describe it; use decay_damping versus decay_amplitude"
        )
    return Decay(
        amplitude, np.abs(s) / (2.0 * pi), damping, time[at], size / (2.0 * pi), lost / size,
        doubts=tuple(doubts),
    )  # fmt: skip
