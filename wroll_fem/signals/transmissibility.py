r"""Transmissibility T(f) = (absolute tip acceleration) / (base acceleration), complex, from time histories.

Sign convention: base sin(2 pi f t) gives tip |T| sin(2 pi f t + arg T); a lagging tip has a
negative imaginary part (the e^{+i omega t} convention, as in numpy's FFT). Real and imaginary
part are stored apart, because NetCDF has no complex numbers.

Two estimates of a swept response are offered:

`demodulated` (the one to read f_n and damping from)
    The tip is resampled on a uniform grid of the *phase* phi of the base, multiplied by
    exp(-i phi) and smoothed by a symmetric kernel, hence without group delay; the base is treated
    the same and divides. For a geometric chirp, frequency is linear in phase, so a kernel of fixed
    length in cycles has a bandwidth that is a fixed fraction of the instantaneous frequency and the
    curve comes out on a uniform frequency grid.
`spectrum_ratio`
    Ratio of the Fourier transforms over the whole run. Free of the sweep's lag on a linear system
    whose response has died out by the end of the record, but for a nonlinear roll it mixes the response
    at one frequency with the ringing and the harmonics that the sweep excites at all other times.

The kernel is K' = 2 K - K*K, K being three moving averages over `window_cycles` cycles in a row.
K has a threefold zero at every multiple of 1/window_cycles of the instantaneous frequency, so the
double-frequency term and all harmonics of the response vanish; K' keeps them and reproduces
polynomials up to the third degree in frequency exactly. With window_cycles = 3: -3 dB at an offset of
0.13 f, support +-9 cycles (trimmed at both ends of the sweep).

Notes
-----
Limits of a chirp. Not the kernel but physics: the response of a resonance needs time to build up. The envelope
of a swept single-degree-of-freedom system (upward chirp, 150 Hz, zeta 1 %, rate R against the ISO 7626-2 limit
312 zeta^2 f_n oct/min of `sweep_rate_limit`) against its steady state, and what half power then reads from it
(exact responses; `tests/signals/test_signals.py` reproduces rows of the table; steady state has skewness -0.01):

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

So stay below a tenth of the limit for the shape of the curve and below a quarter of it for zeta to 2 %; at
2 oct/min and 150 Hz that is zeta > 2.1 % and > 1.3 %. `spectrum_ratio` has no such lag on a linear system: where the
two curves differ, the sweep is too fast or the roll nonlinear, and a slower sweep tells which.
A lightly damped structure passed faster than that rings on afterwards: the ringing at f_n beats with the sweep
and shows as ripples above the peak. It is physics and is not filtered away; slow the sweep down.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.signal import CZT, fftconvolve

from wroll_fem.errors import InputError
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.base_motion import TWO_PI, Chirp, Dwell
from wroll_fem.typing import ComplexArray, FloatArray

SAMPLES_PER_CYCLE = 32  # of the phase grid; even


def _checked(time: npt.ArrayLike, *signals: npt.ArrayLike) -> list[FloatArray]:
    """Arrays of one length with rising, finite time; (n,) each."""
    arrays = [np.asarray(a, dtype=np.float64) for a in (time, *signals)]
    if any(a.ndim != 1 or a.shape != arrays[0].shape for a in arrays) or arrays[0].size < 8:
        shapes = ", ".join(str(a.shape) for a in arrays)
        raise InputError(f"time history of shapes {shapes}", remedy="give one-dimensional series of equal length >= 8")
    if not all(np.isfinite(a).all() for a in arrays) or np.any(np.diff(arrays[0]) <= 0.0):
        raise InputError("time history with values that are not finite, or time that does not rise")
    return arrays


def _uniform(time: FloatArray, *signals: FloatArray) -> tuple[float, list[FloatArray]]:
    """Step and signals on a uniform grid; cubic splines where the steps differ (cut steps)."""
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
    """Ratio of the Fourier transforms of tip and base acceleration over the whole record.

    Parameters
    ----------
    time
        (n,) s. Uneven steps are resampled by cubic splines.
    absolute_tip, base
        (n,) absolute tip and base acceleration in the same unit; their means are removed.
    band
        Lowest and highest frequency wanted, Hz: the result holds the bins k / T inside it.
    frequency
        Uniform grid (Hz) to evaluate the transforms on instead (chirp-z transform of the same record:
        interpolates between the bins without changing the resolution).
    taper
        Last part of the record, as a fraction, that fades out by a half cosine in tip and base alike.

    Returns
    -------
    xr.Dataset
        `transmissibility_spectrum_real`, `transmissibility_spectrum_imag` over `frequency`;
        attribute `spectrum_resolution_hz`.

    Raises
    ------
    InputError
        For unusable series, an empty band, or a base without content somewhere in the band.

    Notes
    -----
    The resolution is 1 / T, T the length of the record: peaks narrower than a few 1/T come out too low.
    A response still ringing at the end of the record is cut off there and would leak into the whole band; the taper
    keeps the leak near the frequencies swept last. A record that holds the decay of the ringing is not changed by it.
    """
    t, tip, ground = _checked(time, absolute_tip, base)
    dt, (tip, ground) = _uniform(t, tip, ground)
    length = tip.size * dt
    if frequency is not None:
        grid = np.asarray(frequency, dtype=np.float64)
    elif band is not None:
        grid = np.arange(np.ceil(band[0] * length - 1e-9), np.floor(band[1] * length + 1e-9) + 1.0) / length
    else:
        raise InputError("neither band nor frequency given", remedy="name the frequencies wanted")
    if grid.size < 2 or grid[0] < 0.0 or grid[-1] > 0.5 / dt or np.ptp(np.diff(grid)) > 1e-6 * (grid[1] - grid[0]):
        raise InputError(
            f"no uniform grid of at least 2 frequencies below half the sampling rate ({0.5 / dt:g} Hz)",
            remedy=f"choose a band wider than 2/T = {2.0 / length:.3g} Hz inside it",
        )
    step = (grid[-1] - grid[0]) / (grid.size - 1)
    fade = max(1, round(taper * tip.size))
    window = np.ones(tip.size)
    window[-fade:] = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, fade + 1) / fade)
    transform = CZT(tip.size, grid.size, w=np.exp(-1j * TWO_PI * step * dt), a=np.exp(1j * TWO_PI * grid[0] * dt))
    above, below = transform(window * (tip - tip.mean())), transform(window * (ground - ground.mean()))
    if np.abs(below).min() < 1e-3 * np.linalg.norm(ground):  # white noise would have |X| = norm(x) everywhere
        raise InputError(
            f"the base does not move at {grid[np.abs(below).argmin()]:.4g} Hz", remedy="keep the band inside the sweep"
        )
    return _as_dataset(grid, above / below, "transmissibility_spectrum", spectrum_resolution_hz=1.0 / length)


def _kernel(window: int) -> FloatArray:
    """Smoothing kernel 2 K - K*K of the module text, (6 window + 1,); `window` samples per moving average, even."""
    box = np.full(window + 1, 1.0 / window)
    box[[0, -1]] *= 0.5
    single = np.convolve(np.convolve(box, box), box)
    twice = np.convolve(single, single)
    pad = (twice.size - single.size) // 2
    return 2.0 * np.pad(single, pad) - twice


def demodulated(
    time: npt.ArrayLike,
    absolute_tip: npt.ArrayLike,
    motion: Chirp,
    *,
    points: int = 1001,
    window_cycles: int = 3,
) -> xr.Dataset:
    """Complex envelope of a swept response against its base motion, over instantaneous frequency.

    Parameters
    ----------
    time
        (n,) s from the start of the sweep, at least 8 steps per cycle; steps need not be equal.
        A history that stops before the sweep's end gives the band it covers.
    absolute_tip
        (n,) absolute tip acceleration (relative + base), m/s^2.
    motion
        The chirp that moved the base.
    points
        Number of frequencies, uniform over the band that remains after trimming the kernel's half
        support (3 window_cycles cycles) at both ends.
    window_cycles
        Length of each of the three moving averages, cycles. More smooths ripples, fewer resolve
        sharper peaks: the kernel's own relative error at a peak is about 6 (window_cycles df / (2 zeta f_n))^4
        with df = `motion.growth`, the frequency gained per cycle in Hz (3e-5 at 4 oct/min, 150 Hz, zeta 1 %).

    Returns
    -------
    xr.Dataset
        `transmissibility_real`, `transmissibility_imag` over `frequency`.

    Raises
    ------
    InputError
        For unusable series, too few samples per cycle, or a sweep too short for the kernel.

    Notes
    -----
    On a steady harmonic the error is that of the cubic spline through the samples: below 1e-6 at 40 samples per
    cycle, 1e-4 at 12, 1e-3 at 8 (`tests/signals/test_signals.py`). The removed mean of the tip does not matter: a
    constant falls on a zero of the kernel. See the module text for the sweep's own limits.
    """
    t, tip = _checked(time, absolute_tip)
    phase = motion.phase(t)
    coarsest = float(np.diff(phase).max()) / TWO_PI
    if coarsest > 0.125 + 1e-9:
        raise InputError(f"{1.0 / coarsest:.3g} samples per cycle at the sweep's end", remedy="record 8 or more")
    if phase[0] < -1e-9:
        raise InputError("time history starts before the sweep", remedy="shift time so that the sweep starts at 0")
    first = np.ceil(phase[0] / TWO_PI * SAMPLES_PER_CYCLE - 1e-9)
    last = np.floor(phase[-1] / TWO_PI * SAMPLES_PER_CYCLE + 1e-9)
    grid = TWO_PI / SAMPLES_PER_CYCLE * np.arange(first, last + 1.0)
    kernel = _kernel(window_cycles * SAMPLES_PER_CYCLE)
    if grid.size < kernel.size + 4:
        need = kernel.size / SAMPLES_PER_CYCLE
        raise InputError(
            f"{grid.size / SAMPLES_PER_CYCLE:.4g} cycles of sweep are too few for a kernel of {need:.3g}",
            remedy="sweep longer or slower, or use fewer window_cycles",
        )
    resampled_time = motion.time_of_phase(grid)
    carrier = np.exp(-1j * grid)
    tip_envelope = fftconvolve(CubicSpline(phase, tip)(grid) * carrier, kernel, mode="valid")
    base_envelope = fftconvolve(motion.acceleration(resampled_time) * carrier, kernel, mode="valid")
    ratio = tip_envelope / base_envelope
    half = kernel.size // 2
    swept = motion.frequency(resampled_time[half : half + ratio.size])
    frequency = np.linspace(swept[0], swept[-1], points)
    smooth = CubicSpline(swept, ratio)(frequency)
    return _as_dataset(frequency, smooth, "transmissibility", demodulation_window_cycles=window_cycles)


def transmissibility(history: xr.Dataset, motion: Chirp, *, points: int = 1001) -> xr.Dataset:
    """Both estimates of a simulated sweep on one frequency grid.

    Parameters
    ----------
    history
        Has `tip_acceleration` (relative to the base) and `base_acceleration` over `time`.
    motion
        The chirp that moved the base.
    points
        Number of frequencies.

    Returns
    -------
    xr.Dataset
        `transmissibility_real/_imag` and `transmissibility_spectrum_real/_imag` over `frequency`.
    """
    time, base = history["time"].values, history["base_acceleration"].values
    tip = history["tip_acceleration"].values + base
    envelope = demodulated(time, tip, motion, points=points)
    spectrum = spectrum_ratio(time, tip, base, frequency=envelope["frequency"].values)
    return xr.merge([envelope, spectrum], combine_attrs="no_conflicts")


def magnitude(dataset: xr.Dataset, stem: str = "transmissibility") -> xr.DataArray:
    """|T| over `frequency` from the real and imaginary variables of `stem`."""
    real, imag = dataset[f"{stem}_real"], dataset[f"{stem}_imag"]
    size = real.copy(data=np.hypot(real.values, imag.values)).rename(f"{stem}_magnitude")
    return annotate(size.to_dataset())[f"{stem}_magnitude"]


def dwell_response(
    time: npt.ArrayLike, absolute_tip: npt.ArrayLike, motion: Dwell, *, cycles: int = 5
) -> dict[str, float]:
    """Steady-state transmissibility of a dwell: least squares on the fundamental over the last whole cycles.

    Parameters
    ----------
    time, absolute_tip
        (n,) s and m/s^2; the last `cycles` periods of the record are used.
    motion
        The dwell that moved the base.
    cycles
        Number of periods to fit; fitted are a constant and sine and cosine of the drive.

    Returns
    -------
    dict
        `magnitude` and `phase_rad` of T; `amplitude_m_s2` of the tip's fundamental (0-peak); `residual`: rms of what
        the fit leaves over the rms of the fundamental (harmonics and transients); `drift`: relative change of the
        fundamental between the first and second half of the window (0 when steady).

    Raises
    ------
    InputError
        When the record is shorter than the window or its ramp reaches into it.
    """
    t, tip = _checked(time, absolute_tip)
    window = cycles / motion.frequency_hz
    start = t[-1] - window
    if cycles < 2 or start < motion.ramp_cycles / motion.frequency_hz - 1e-9 / motion.frequency_hz:
        raise InputError(
            f"no {cycles} steady cycles in a record of {t[-1] * motion.frequency_hz:.4g} cycles "
            f"with a ramp of {motion.ramp_cycles:g}",
            remedy="record more cycles, or fit fewer (at least 2)",
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
