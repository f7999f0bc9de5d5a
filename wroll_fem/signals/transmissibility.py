r"""Complex transmissibility T(f), absolute tip acceleration divided by base acceleration, from time histories.

Sign convention: a base acceleration sin(2 pi f t) gives the tip acceleration |T| sin(2 pi f t + arg T); a lagging tip
has a negative imaginary part (the e^{+i omega t} convention, as in the FFT of numpy). Real and imaginary part are
stored separately, because NetCDF has no complex numbers.

There are two estimates for a swept response:

`demodulated` (used for f_n and damping)
    The tip acceleration is resampled on a uniform grid of the *phase* phi of the base, multiplied by exp(-i phi) and
    smoothed by a symmetric kernel, so there is no group delay. The base acceleration is treated in the same way, and
    the ratio is taken. A kernel of fixed length in cycles has a bandwidth that is a fixed fraction of the instantaneous
    frequency. For a geometric chirp the frequency is linear in phase, and the curve is obtained on a uniform frequency
    grid; for a linear sweep it is interpolated. A downward sweep gives a curve over rising frequency, too.
`spectrum_ratio`
    Ratio of the Fourier transforms over the whole run. It is free of the lag of the sweep for a linear system whose
    response has decayed at the end of the record. For a nonlinear roll it mixes the response at one frequency with the
    ringing and the harmonics excited by the sweep at all other times.

The kernel is K' = 2 K - K*K, where K is three successive moving averages over `window_cycles` cycles. K has a triple
zero at every multiple of 1/window_cycles of the instantaneous frequency, so it removes the double-frequency term and
all harmonics of the response. K' has the same zeros and reproduces polynomials in frequency up to the third degree
exactly. With window_cycles = 3 it has -3 dB at an offset of 0.13 f and a support of +-9 cycles (trimmed at both ends
of the sweep).

Notes
-----
Limits of a chirp. The limit is physical and not due to the kernel: a resonance needs time to build up. The table
compares the envelope of a swept single degree of freedom (150 Hz, zeta 1 %, upward chirp) with its steady state, and
gives the error of the half-power damping. R is the sweep rate; the limit is the ISO 7626-2 limit 312 zeta^2 f_n oct/min
of `sweep_rate_limit`. The responses are exact; the skewness of the steady state is -0.01.
`tests/signals/test_signals.py` reproduces rows of the table.

=========  ==========  ====================  ==============  ========
R / limit  peak lost   peak shift/(zeta f)   error of zeta   skewness
=========  ==========  ====================  ==============  ========
0.05       0.2 %       0.06                  0.1 %           -0.06
0.1        0.3 %       0.11                  0.4 %           -0.11
0.25       0.9 %       0.27                  2 %             -0.22
0.5        2.5 %       0.48                  9 %             -0.30
1          5.8 %       0.84                  23 %            -0.34
2          11.5 %      1.40                  48 %            -0.35
=========  ==========  ====================  ==============  ========

Use less than a tenth of the limit for an accurate shape of the curve, and less than a quarter for an error of zeta
below 2 %; at 2 oct/min and 150 Hz this requires zeta > 2.1 % and > 1.3 %. `spectrum_ratio` has no such lag for a linear
system. If the two curves differ, the sweep is too fast or the roll is nonlinear; a slower sweep distinguishes the two.
After a faster sweep a lightly damped structure rings: the ringing at f_n beats with the sweep and causes ripples above
the peak. It is part of the response and is not filtered; use a slower sweep.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.signal import CZT, fftconvolve

from wroll_fem.errors import InputError
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.base_motion import TWO_PI, Dwell
from wroll_fem.signals.sweeps import Sweep
from wroll_fem.signals.tip import absolute_tip
from wroll_fem.typing import ComplexArray, FloatArray

STEADY = 0.02
"""Drift or residual of a dwell, relative to its fundamental, above which the response does not count as steady."""

WINDOW_CYCLES = 3
"""Default length of each of the three moving averages of the demodulation, cycles."""

SAMPLES_PER_CYCLE = 32  # number of samples per cycle of the phase grid; even


def _checked(time: npt.ArrayLike, *signals: npt.ArrayLike) -> list[FloatArray]:
    """Check a time history: finite values, ascending times, equal lengths; return the (n,) arrays."""
    arrays = [np.asarray(a, dtype=np.float64) for a in (time, *signals)]
    if any(a.ndim != 1 or a.shape != arrays[0].shape for a in arrays) or arrays[0].size < 8:
        shapes = ", ".join(str(a.shape) for a in arrays)
        raise InputError(
            f"time and signals have the shapes {shapes}", remedy="give series of the same length, 8 points or more"
        )
    if not all(np.isfinite(a).all() for a in arrays) or np.any(np.diff(arrays[0]) <= 0.0):
        raise InputError(
            "the values of a time history must be finite and its times must increase", remedy="remove invalid points"
        )
    return arrays


def _uniform(time: FloatArray, *signals: FloatArray) -> tuple[float, list[FloatArray]]:
    """Time step and signals on a uniform grid, interpolated by cubic splines if the steps differ."""
    steps = np.diff(time)
    dt = float(np.median(steps))
    if np.ptp(steps) < 1e-6 * dt:
        return dt, list(signals)
    count = max(8, round((time[-1] - time[0]) / dt) + 1)
    grid = np.linspace(time[0], time[-1], count)
    return float(grid[1] - grid[0]), [CubicSpline(time, s)(grid) for s in signals]


def _as_dataset(frequency: FloatArray, ratio: ComplexArray, stem: str, **attrs: object) -> xr.Dataset:
    data = {f"{stem}_real": ("frequency", ratio.real.copy()), f"{stem}_imag": ("frequency", ratio.imag.copy())}
    return annotate(xr.Dataset(data, coords={"frequency": frequency}, attrs=attrs))


def spectrum_ratio(
    time: npt.ArrayLike,
    absolute_tip: npt.ArrayLike,
    base: npt.ArrayLike,
    band: tuple[float, float] | None = None,
    *,
    frequency: npt.ArrayLike | None = None,
    taper: float = 0.05,
) -> xr.Dataset:
    """Transmissibility of a whole record: ratio of the Fourier transforms of tip and base acceleration.

    Parameters
    ----------
    time
        (n,) times, s; non-uniform steps are resampled with cubic splines.
    absolute_tip, base
        (n,) absolute tip and base acceleration in the same unit; their means are removed.
    band
        Lowest and highest frequency, Hz; the result has the frequencies k / T inside the band.
    frequency
        Uniform frequency grid (Hz) instead of the band. The chirp-z transform interpolates between the frequencies
        k / T; the resolution does not change.
    taper
        Fraction of the record at its end that is faded out by a half cosine, in tip and base acceleration alike.

    Returns
    -------
    xr.Dataset
        `transmissibility_spectrum_real`, `transmissibility_spectrum_imag` over `frequency`;
        attribute `spectrum_resolution_hz`.

    Raises
    ------
    InputError
        If the series are not a time history, the band is empty, or the base does not move at a frequency in the band.

    Notes
    -----
    The resolution is 1 / T, where T is the duration of the record; peaks narrower than a few 1/T are too low. A
    response that is still ringing at the end of the record is truncated, which causes leakage. The taper limits the
    leakage to the frequencies swept last. It does not affect a record in which the ringing has decayed.
    """
    t, tip, ground = _checked(time, absolute_tip, base)
    dt, (tip, ground) = _uniform(t, tip, ground)
    length = tip.size * dt
    if frequency is not None:
        grid = np.asarray(frequency, dtype=np.float64)
    elif band is not None:
        grid = np.arange(np.ceil(band[0] * length - 1e-9), np.floor(band[1] * length + 1e-9) + 1.0) / length
    else:
        raise InputError("neither band nor frequency is given", remedy="give one of them")
    if grid.size < 2 or grid[0] < 0.0 or grid[-1] > 0.5 / dt or np.ptp(np.diff(grid)) > 1e-6 * (grid[1] - grid[0]):
        raise InputError(
            "2 or more equally spaced frequencies are needed, all between 0 Hz and half the sampling rate "
            f"({0.5 / dt:g} Hz)",
            remedy=f"use a band below half the sampling rate that is wider than {2.0 / length:.3g} Hz (2 / duration)",
        )
    step = (grid[-1] - grid[0]) / (grid.size - 1)
    fade = max(1, round(taper * tip.size))
    window = np.ones(tip.size)
    window[-fade:] = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, fade + 1) / fade)
    transform = CZT(tip.size, grid.size, w=np.exp(-1j * TWO_PI * step * dt), a=np.exp(1j * TWO_PI * grid[0] * dt))
    above, below = transform(window * (tip - tip.mean())), transform(window * (ground - ground.mean()))
    if np.abs(below).min() < 1e-3 * np.linalg.norm(ground):  # white noise would have |X| = norm(x) everywhere
        raise InputError(
            f"the base does not move at {grid[np.abs(below).argmin()]:.4g} Hz", remedy="use a band inside the sweep"
        )
    return _as_dataset(grid, above / below, "transmissibility_spectrum", spectrum_resolution_hz=1.0 / length)


def smoothing_kernel(window: int) -> FloatArray:
    """(6 window + 1,) smoothing kernel 2 K - K*K; K is three successive moving averages of `window` (even) samples."""
    box = np.full(window + 1, 1.0 / window)
    box[[0, -1]] *= 0.5
    single = np.convolve(np.convolve(box, box), box)
    twice = np.convolve(single, single)
    pad = (twice.size - single.size) // 2
    return 2.0 * np.pad(single, pad) - twice


def demodulated(
    time: npt.ArrayLike,
    absolute_tip: npt.ArrayLike,
    motion: Sweep,
    *,
    points: int = 1001,
    frequency: FloatArray | None = None,
    window_cycles: int = WINDOW_CYCLES,
) -> xr.Dataset:
    """Transmissibility of a swept response by demodulation, versus instantaneous frequency.

    Parameters
    ----------
    time
        (n,) times from the start of the sweep, s, with at least 8 steps per cycle; the steps may vary. If the history
        ends before the sweep, the result covers the band up to its end.
    absolute_tip
        (n,) absolute tip acceleration (relative + base), m/s^2.
    motion
        Base motion.
    points
        Number of frequencies, uniform over the band that remains after removing half the support of the kernel
        (3 window_cycles cycles) at both ends.
    frequency
        (n,) frequencies of the result in their place, Hz; those beyond the band have the value at its end.
    window_cycles
        Length of each of the three moving averages, cycles. A longer window smooths ripples, a shorter one resolves
        sharper peaks. The relative error of the kernel at a peak is about 6 (window_cycles df / (2 zeta f_n))^4, where
        df = `motion.growth` is the frequency increase per cycle, Hz (3e-5 at 4 oct/min, 150 Hz, zeta 1 %).

    Returns
    -------
    xr.Dataset
        `transmissibility_real`, `transmissibility_imag` over `frequency`.

    Raises
    ------
    InputError
        If the series are not a time history, the samples per cycle are too few, or the sweep is shorter than the
        kernel.

    Notes
    -----
    For a steady sine the only error is due to the cubic spline through the samples: below 1e-6 at 40 samples per cycle,
    1e-4 at 12, 1e-3 at 8 (`tests/signals/test_signals.py`). The mean of the tip acceleration has no effect, because a
    constant lies at a zero of the kernel. The limits of the sweep rate are given in the docstring of the module.
    """
    t, tip = _checked(time, absolute_tip)
    phase = motion.phase(t)
    coarsest = float(np.diff(phase).max()) / TWO_PI
    if coarsest > 0.125 + 1e-9:
        raise InputError(
            f"{1.0 / coarsest:.3g} samples per cycle at the highest frequency are too few", remedy="use 8 or more"
        )
    if phase[0] < -1e-9:
        raise InputError(
            "the time history starts before the sweep", remedy="shift the time so that the sweep starts at 0"
        )
    first = np.ceil(phase[0] / TWO_PI * SAMPLES_PER_CYCLE - 1e-9)
    last = np.floor(phase[-1] / TWO_PI * SAMPLES_PER_CYCLE + 1e-9)
    grid = TWO_PI / SAMPLES_PER_CYCLE * np.arange(first, last + 1.0)
    kernel = smoothing_kernel(window_cycles * SAMPLES_PER_CYCLE)
    if grid.size < kernel.size + 4:
        need = kernel.size / SAMPLES_PER_CYCLE
        raise InputError(
            f"{grid.size / SAMPLES_PER_CYCLE:.4g} cycles of sweep are too few for a kernel of {need:.3g} cycles",
            remedy="use a longer or slower sweep, or fewer window_cycles",
        )
    resampled_time = motion.time_of_phase(grid)
    carrier = np.exp(-1j * grid)
    tip_envelope = fftconvolve(CubicSpline(phase, tip)(grid) * carrier, kernel, mode="valid")
    base_envelope = fftconvolve(motion.acceleration(resampled_time) * carrier, kernel, mode="valid")
    ratio = tip_envelope / base_envelope
    half = kernel.size // 2
    swept = motion.frequency(resampled_time[half : half + ratio.size])
    if motion.downward:
        swept, ratio = swept[::-1], ratio[::-1]
    frequency = np.linspace(swept[0], swept[-1], points) if frequency is None else frequency
    smooth = CubicSpline(swept, ratio)(np.clip(frequency, swept[0], swept[-1]))
    return _as_dataset(frequency, smooth, "transmissibility", demodulation_window_cycles=window_cycles)


def transmissibility(
    history: xr.Dataset, motion: Sweep, *, points: int = 1001, frequency: FloatArray | None = None
) -> xr.Dataset:
    """Transmissibility of a simulated sweep by demodulation and by the ratio of spectra, on one frequency grid.

    Parameters
    ----------
    history
        Dataset with `tip_acceleration` (relative to the base) and `base_acceleration` over `time`.
    motion
        Base motion.
    points, frequency
        Number of frequencies, or the frequencies themselves (Hz).

    Returns
    -------
    xr.Dataset
        `transmissibility_real/_imag` and `transmissibility_spectrum_real/_imag` over `frequency`.

    Raises
    ------
    InputError
        If the history cannot be demodulated; see `demodulated` and `spectrum_ratio`.
    """
    time, base = history["time"].values, history["base_acceleration"].values
    tip = absolute_tip(history)
    envelope = demodulated(time, tip, motion, points=points, frequency=frequency)
    spectrum = spectrum_ratio(time, tip, base, frequency=envelope["frequency"].values)
    return xr.merge([envelope, spectrum], combine_attrs="no_conflicts")


def magnitude(dataset: xr.Dataset, stem: str = "transmissibility") -> xr.DataArray:
    """Magnitude versus frequency of the complex curve that is stored in ``<stem>_real`` and ``<stem>_imag``."""
    real, imag = dataset[f"{stem}_real"], dataset[f"{stem}_imag"]
    size = real.copy(data=np.hypot(real.values, imag.values)).rename(f"{stem}_magnitude")
    return annotate(size.to_dataset())[f"{stem}_magnitude"]


def dwell_response(
    time: npt.ArrayLike, absolute_tip: npt.ArrayLike, motion: Dwell, *, cycles: int = 5
) -> dict[str, float]:
    """Steady-state transmissibility of a dwell, from a least-squares fit of the fundamental to the last cycles.

    Parameters
    ----------
    time, absolute_tip
        (n,) times, s, and absolute tip acceleration, m/s^2; the last `cycles` periods are used.
    motion
        Base motion.
    cycles
        Number of periods. The fit consists of a constant and of sine and cosine at the frequency of the base.

    Returns
    -------
    dict
        `magnitude` and `phase_rad` of T; `amplitude_m_s2`: amplitude of the fundamental of the tip (0-peak);
        `residual`: rms of the residual (harmonics and transients) divided by the rms of the fundamental; `drift`:
        relative change of the fundamental between the first and second half of the window (0 in the steady state).

    Raises
    ------
    InputError
        If the record is shorter than the window, or the start ramp extends into the window.
    """
    if cycles < 2:
        raise InputError(f"a fit over {cycles} cycles has no drift", remedy="use at least 2 cycles for the fit")
    t, tip = _checked(time, absolute_tip)
    window = cycles / motion.frequency_hz
    start = t[-1] - window
    if start < motion.ramp_cycles / motion.frequency_hz - 1e-9 / motion.frequency_hz:
        raise InputError(
            f"a record of {t[-1] * motion.frequency_hz:.4g} cycles with a start ramp of {motion.ramp_cycles:g} has "
            f"fewer than {cycles} steady cycles",
            remedy="use more cycles in the record, or fewer in the fit (at least 2)",
        )
    keep = t > start + 1e-9 * window
    middle = keep & (t <= start + 0.5 * window)

    def fit(mask: npt.NDArray[np.bool_]) -> tuple[complex, FloatArray]:
        angle = motion.phase(t[mask])
        columns = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
        (sine, cosine, mean), *_ = np.linalg.lstsq(columns, tip[mask], rcond=None)
        return complex(sine, cosine), tip[mask] - columns @ np.array([sine, cosine, mean])

    whole, left = fit(keep)
    early, _ = fit(middle)
    late, _ = fit(keep & ~middle)
    size = abs(whole)
    return {
        "magnitude": size / motion.amplitude,
        "phase_rad": float(np.angle(whole)),
        "amplitude_m_s2": size,
        "residual": float(np.sqrt(2.0 * np.mean(left**2)) / size) if size > 0.0 else 0.0,
        "drift": abs(late - early) / size if size > 0.0 else 0.0,
    }


def unsteadiness(response: Mapping[str, float]) -> str:
    """Reason why the response of a dwell is not steady; empty if neither drift nor residual exceeds `STEADY`.

    Parameters
    ----------
    response
        Result of `dwell_response`.
    """
    reasons = []
    if response["drift"] > STEADY:
        reasons.append(f"the fundamental still changes by {100 * response['drift']:.2g} % (steady_drift)")
    if response["residual"] > STEADY:
        reasons.append(
            f"harmonics and transients are {100 * response['residual']:.2g} % of the fundamental (steady_residual)"
        )
    return " and ".join(reasons)


def undamped(frequency: FloatArray, natural: FloatArray, participation: FloatArray) -> FloatArray:
    """Magnitude |T| for undamped modes with frequencies f_n and participations p: |1 + sum of p f^2 / (f_n^2 - f^2)|.

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz.
    natural
        (n_modes,) natural frequencies, Hz.
    participation
        (n_modes,) products p of tip displacement and participation factor of each mode.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(np.abs(1.0 + participation @ (frequency**2 / (natural[:, None] ** 2 - frequency**2))))
