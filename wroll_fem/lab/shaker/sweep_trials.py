"""Trials with a swept motion of the base: demodulation with the phase of the base, frequency and damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, hypot, nan

import numpy as np
from scipy.signal import fftconvolve, hilbert, resample_poly

from wroll_fem.errors import InputError
from wroll_fem.lab.shaker.curve import Curve
from wroll_fem.lab.shaker.trial import Trial, check_rate, to_acceleration
from wroll_fem.signals.attainment import swept_peak
from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.estimators import CurveDamping, estimate_damping
from wroll_fem.signals.measured_sweep import measured_sweep
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.signals.sweeps import Sweep
from wroll_fem.signals.transmissibility import WINDOW_CYCLES, demodulated, smoothing_kernel
from wroll_fem.typing import ComplexArray, FloatArray

POINTS = 1001
"""Frequencies of a curve."""

SAMPLES = 10.0
"""Samples per cycle to which records are interpolated before the demodulation."""

Errors = tuple[float, float]

WIDENING = 0.36
"""Relative error of zeta by half power over the square of the sweep rate, relative to the limit of ISO 7626-2 (table in
`wroll_fem.signals.transmissibility`: 0.4 % at 0.1, 2 % at 0.25, 9 % at 0.5)."""

LAG_ERROR = 0.35
"""Standard error of the correction of the lag, relative to it: a fit to the flanks lags by two thirds of the peak."""

COARSE = 4
"""Samples per cycle of the noise whose effect on the curve is followed; the demodulation passes 0.13 of a frequency."""

DRAWS, SEED = 40, 1
"""Number of noisy repetitions for the error bars of a sweep, and their seed."""


@dataclass(frozen=True, eq=False)
class Swept:
    """Demodulated trial.

    Attributes
    ----------
    motion
        Sweep of the base.
    time
        (n,) times of the part of the record, s.
    base, tip
        (n,) samples of it.
    frequency, response
        (m,) Hz, ascending, and complex ratio of the accelerations.
    trial
        The trial.
    """

    motion: Sweep
    time: FloatArray
    base: FloatArray
    tip: FloatArray
    frequency: FloatArray
    response: ComplexArray
    trial: Trial


def swept(trial: Trial, band: tuple[float, float] | None) -> Swept:
    """Demodulate a trial.

    Raises
    ------
    InputError
        If the base does not sweep, the record is too short, or sampled too slowly for the band.
    """
    try:
        motion, part = measured_sweep(trial.base, trial.dt, band)
        check_rate(trial, motion.band[1])
        factor = ceil(SAMPLES * motion.band[1] * trial.dt)
        base, tip = trial.base[part], trial.tip[part]
        if factor > 1:
            base, tip = (resample_poly(x, factor, 1, window=("kaiser", 8.0), padtype="line") for x in (base, tip))
            motion, inner = measured_sweep(base, trial.dt / factor)
            base, tip = base[inner], tip[inner]
        time = trial.dt / factor * np.arange(len(base))
        found = demodulated(time, tip, motion, points=POINTS)
    except InputError as error:
        error.file = error.file or str(trial.path)
        raise
    f = found["frequency"].values
    raw = found["transmissibility_real"].values + 1j * found["transmissibility_imag"].values
    ratio = raw * to_acceleration(f, trial.tip_order) / to_acceleration(f, trial.base_order)
    return Swept(motion, time, base, tip, f, ratio + 1.0 if trial.relative else ratio, trial)


def sweep_curve(parts: Sequence[Swept], method: str, *, errors: bool = True) -> Curve:
    """Curve of one condition: mean of its trials on their common band.

    Parameters
    ----------
    parts
        Demodulated trials.
    method
        Estimator, a key of `ESTIMATORS`.
    errors
        Whether standard errors are computed, by repeated demodulation of noise.

    Raises
    ------
    InputError
        If the trials have no band in common.
    """
    low, high = max(one.frequency[0] for one in parts), min(one.frequency[-1] for one in parts)
    if not low < high:
        raise InputError("the sweeps of the condition have no band in common", key="conditions", remedy="separate them")
    grid = np.linspace(low, high, POINTS)
    each = [_on(grid, one) for one in parts]
    mean = np.mean(each, axis=0)
    read = _estimate(grid, mean, method)
    motion = max((one.motion for one in parts), key=lambda one: one.rate_at(0.5 * (low + high)))
    quality = judge(read, grid, np.abs(mean), Circumstances(motion))
    if read.damping.found and read.shape.resonant:
        f_error, zeta_error = _errors(parts, grid, mean, read, method) if errors else (nan, nan)
        read = replace(read, damping=replace(read.damping, f_n_error=f_error, zeta_error=zeta_error))
        read = _for_rate(read, motion)
    base = float(np.mean([_amplitude(one, read.shape.f_n) for one in parts])) if read.shape.resonant else nan
    return Curve(grid, mean, read, quality, base, base * read.shape.peak)


def _estimate(grid: FloatArray, response: ComplexArray, method: str) -> CurveDamping:
    """Estimate from the curve of a sweep; a fit of a fraction takes its magnitude, as the phase lags in a sweep."""
    by_size = method in ("rational_fraction", "choose")
    return estimate_damping(grid, np.abs(response) if by_size else response, method, noise=0.0)


def _on(grid: FloatArray, one: Swept) -> ComplexArray:
    parts = (np.interp(grid, one.frequency, part) for part in (one.response.real, one.response.imag))
    real, imaginary = parts
    return np.asarray(real + 1j * imaginary)


def _amplitude(one: Swept, frequency: float) -> float:
    """Amplitude of the base acceleration (0-peak, m/s^2) when the sweep passes a frequency (Hz)."""
    at = float(one.motion.time_of_frequency(frequency))
    near = np.abs(one.time - at) <= 2.0 / frequency
    size = float(np.abs(hilbert(one.base - one.base.mean()))[near].mean())
    return size * float(np.abs(to_acceleration(np.array([frequency]), one.trial.base_order))[0])


def _noise(one: Swept, band: tuple[float, float]) -> float:
    """Rms of what the curve does not explain of the tip inside a band (Hz), in the unit of the record."""
    f, ratio = one.frequency, one.response - 1.0 if one.trial.relative else one.response
    raw = ratio * to_acceleration(f, one.trial.base_order) / to_acceleration(f, one.trial.tip_order)
    now = one.motion.frequency(one.time)
    near = (now >= band[0]) & (now <= band[1])
    gain = np.interp(now, f, raw.real) + 1j * np.interp(now, f, raw.imag)
    rest = one.tip - one.tip.mean() - (gain * hilbert(one.base - one.base.mean())).real
    return float(np.sqrt(np.mean(rest[near] ** 2)))


def _noise_curves(one: Swept, band: tuple[float, float], level: float, count: int) -> tuple[FloatArray, ComplexArray]:
    """Frequencies (n,) and errors (count, n) of a curve due to white noise of the tip, demodulated like the tip.

    White noise of standard deviation s at the sampling rate r has, in `COARSE` samples per cycle of frequency f, the
    standard deviation s sqrt(COARSE f / r) for the same density; a sine of amplitude A has the envelope A / 2.
    """
    kernel = smoothing_kernel(WINDOW_CYCLES * COARSE)
    ends = sorted(float(one.motion.phase(one.motion.time_of_frequency(f))) for f in band)
    step = 2.0 * np.pi / COARSE
    phase = np.arange(ends[0] - 0.5 * kernel.size * step, ends[1] + 0.5 * kernel.size * step, step)
    half = kernel.size // 2
    f = one.motion.frequency(one.motion.time_of_phase(phase[half:-half]))
    middle = 0.5 * (band[0] + band[1])
    amplitude = _amplitude(one, middle) / float(np.abs(to_acceleration(np.array([middle]), one.trial.base_order))[0])
    size = level * np.sqrt(COARSE * middle / one.trial.rate) * 2.0 / amplitude
    size *= float(np.abs(to_acceleration(np.array([middle]), one.trial.tip_order))[0])
    size /= float(np.abs(to_acceleration(np.array([middle]), one.trial.base_order))[0])
    rng = np.random.default_rng(SEED)
    white = (
        size / np.sqrt(2.0) * (rng.standard_normal((count, len(phase))) + 1j * rng.standard_normal((count, len(phase))))
    )
    smooth = fftconvolve(white, kernel[None, :], mode="valid", axes=1)
    order = np.argsort(f)
    return f[order], smooth[:, order]


def _errors(parts: Sequence[Swept], grid: FloatArray, mean: ComplexArray, read: CurveDamping, method: str) -> Errors:
    """Standard errors of f_n (Hz) and zeta: scatter of estimates with white noise of the tip's own level."""
    shape = read.shape
    wide = 2.0 * (shape.f_high - shape.f_low) if shape.complete else 0.2 * shape.f_n
    band = max(float(grid[0]), shape.f_n - wide), min(float(grid[-1]), shape.f_n + wide)
    inner = (shape.f_low, shape.f_high) if shape.complete else band
    one = parts[0]
    level = float(np.sqrt(np.mean([_noise(part, inner) ** 2 for part in parts]) / len(parts)))
    f, errors = _noise_curves(one, band, level, DRAWS)
    near = (grid >= band[0]) & (grid <= band[1])
    found = []
    for error in errors:
        noisy = mean.copy()
        noisy[near] += np.interp(grid[near], f, error.real) + 1j * np.interp(grid[near], f, error.imag)
        again = _estimate(grid, noisy, method)
        if again.damping.found:
            found.append((again.damping.f_n, again.damping.zeta))
    if len(found) < DRAWS // 2:
        return nan, nan
    f_error, zeta_error = np.std(np.array(found), axis=0, ddof=1)
    return float(f_error), float(zeta_error)


def _for_rate(read: CurveDamping, motion: Sweep) -> CurveDamping:
    """Reading for the sweep rate: the lag of a linear peak is taken out, and what remains of it enters the errors."""
    found = read.damping
    rate = motion.rate_at(found.f_n)
    lag = swept_peak(found.f_n, found.zeta, rate, downward=motion.downward).lag * found.zeta * found.f_n
    wider = WIDENING * (rate / sweep_rate_limit(found.f_n, found.zeta)) ** 2 * found.zeta
    return replace(
        read,
        damping=replace(
            found, f_n=found.f_n + lag if motion.downward else found.f_n - lag,
            f_n_error=hypot(found.f_n_error, LAG_ERROR * lag), zeta_error=hypot(found.zeta_error, wider),
        ),
    )  # fmt: skip
