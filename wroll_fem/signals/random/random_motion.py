r"""Stationary random base acceleration: one realisation of a PSD by independent spectral lines.

A record of duration T is a sum of cosines at the frequencies k / T inside the band of the PSD [1]_,

.. math:: a(t) = \sum_k A_k \cos(2\pi k t / T + \varphi_k), \qquad A_k^2 / 2 = \int_{\text{bin } k} S(f)\, df,

with independent phases, uniform in 0 to 2 pi. The bins tile the band, so that the mean square of the record is that of
the PSD. By the central limit theorem a(t) is Gaussian for many lines (its kurtosis is 3 - 1.5 / n for n equal lines).

The record starts and ends smoothly: value and first three derivatives are zero at t = 0 and, as T is the period of all
lines, at t = T. The components that violate these four conditions are removed in the least-squares sense, and the
amplitudes are restored, in turn. The lines keep the PSD, and no component lies outside the band.

References
----------
.. [1] M. Shinozuka, G. Deodatis, Simulation of stochastic processes by spectral representation, Applied Mechanics
   Reviews 44 (1991) 191-204, doi:10.1115/1.3119501.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, isfinite

import numpy as np
import numpy.typing as npt
from scipy.fft import irfft, next_fast_len, rfft

from wroll_fem.errors import InputError
from wroll_fem.signals.random.psd import PsdTable, duration_problem, line_orders
from wroll_fem.signals.sampled_motion import SampledMotion
from wroll_fem.typing import ComplexArray, FloatArray

LEAST_SAMPLING = 2.5
"""Smallest sampling rate of a record, divided by the highest frequency of the PSD."""

SAMPLES_PER_CYCLE = 20
"""Samples per cycle of the highest frequency, through which `RandomMotion` is interpolated."""

RESTORATIONS, CLIPPINGS = 30, 300
"""Number of times that the amplitudes are restored, and largest number of clippings for a crest limit."""


@dataclass(frozen=True)
class Lines:
    """Spectral lines of a periodic record: a(t) = Re sum_k c_k exp(2 pi i k t / T).

    Attributes
    ----------
    order
        (n,) numbers k of the lines.
    coefficient
        (n,) complex amplitudes c_k, m/s^2.
    """

    order: npt.NDArray[np.int64]
    coefficient: ComplexArray

    def samples(self, count: int) -> FloatArray:
        """(count,) samples of one period; ``count`` exceeds twice the largest order."""
        spectrum = np.zeros(count // 2 + 1, dtype=np.complex128)
        spectrum[self.order] = 0.5 * count * self.coefficient
        return np.asarray(irfft(spectrum, count))

    @property
    def rms(self) -> float:
        """Root mean square of the record, m/s^2."""
        return float(np.sqrt(0.5 * np.sum(np.abs(self.coefficient) ** 2)))


def random_lines(table: PsdTable, duration: float, seed: int, crest_limit: float | None = None) -> Lines:
    """Spectral lines of one realisation of a PSD; `random_record` describes the parameters.

    Raises
    ------
    InputError
        If the band has too few lines, or the crest limit is not reached.
    """
    problem = duration_problem(table, duration)
    if problem is not None:
        text, remedy = problem
        raise InputError(f"duration = {duration:g} s: {text}", key="duration", remedy=remedy)
    low, high = table.band
    order = np.array(line_orders(table, duration), dtype=np.int64)
    edges = np.concatenate([[low], (order[:-1] + 0.5) / duration, [high]])
    amplitude = np.sqrt(2.0 * np.diff(table.mean_square_below(edges)))
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(order))
    rest = _RestAtEnds(order, amplitude)
    coefficient = amplitude * np.exp(1j * phase)
    for _ in range(RESTORATIONS):
        coefficient = rest.imposed(coefficient)
        coefficient *= amplitude / np.abs(coefficient)
    lines = Lines(order, rest.at_level(coefficient))
    return lines if crest_limit is None else _limited(lines, rest, crest_limit)


@dataclass(frozen=True)
class _RestAtEnds:
    """Conditions that value and first three derivatives of a record vanish at its ends."""

    order: npt.NDArray[np.int64]
    amplitude: FloatArray

    @cached_property
    def _basis(self) -> FloatArray:
        """(2 n, 4) orthonormal directions, in real and imaginary parts of c / A, that the conditions exclude."""
        x = self.order / self.order[-1]
        bend = x**2 - np.mean(x**2)  # second and third derivative beside value and slope, well conditioned
        zero = np.zeros_like(x)
        even, odd = [np.ones_like(x), bend], [x, x * bend]
        columns = [np.concatenate([v, zero]) for v in even] + [np.concatenate([zero, v]) for v in odd]
        weight = np.tile(self.amplitude, 2)
        return np.asarray(np.linalg.qr(weight[:, None] * np.column_stack(columns))[0])

    def imposed(self, coefficient: ComplexArray) -> ComplexArray:
        """Coefficients nearest to ``coefficient`` (relative to the amplitudes) that fulfil the conditions."""
        scaled = coefficient / self.amplitude
        z = np.concatenate([scaled.real, scaled.imag])
        z -= self._basis @ (self._basis.T @ z)
        half = len(scaled)
        return np.asarray((z[:half] + 1j * z[half:]) * self.amplitude)

    def at_level(self, coefficient: ComplexArray) -> ComplexArray:
        """As `imposed`, scaled to the mean square of the PSD."""
        found = self.imposed(coefficient)
        return np.asarray(found * np.sqrt(np.sum(self.amplitude**2) / np.sum(np.abs(found) ** 2)))


def _limited(lines: Lines, rest: _RestAtEnds, crest_limit: float) -> Lines:
    """Lines with the same amplitudes and other phases, whose record stays within ``crest_limit`` times its rms.

    The record is clipped, and the amplitudes and the conditions at the ends are restored, in turn.
    """
    count = next_fast_len(16 * int(lines.order[-1]), real=True)
    bound = 0.98 * crest_limit * lines.rms  # peaks between the samples are up to 2 % higher
    least = np.inf
    for _ in range(CLIPPINGS):
        record = lines.samples(count)
        largest = float(np.abs(record).max())
        least = min(least, largest / lines.rms)
        if largest <= bound:
            return lines
        clipped = rfft(np.clip(record, -0.95 * bound, 0.95 * bound))[lines.order]
        lines = Lines(lines.order, rest.at_level(rest.amplitude * clipped / np.abs(clipped)))
    raise InputError(
        f"the crest factor does not fall below {least:.3g}", key="excitation.crest_limit",
        remedy=f"give {1.05 * least:.3g} or more, or leave it out",
    )  # fmt: skip


@dataclass(frozen=True)
class RandomMotion:
    """Random base motion with a given PSD.

    Attributes
    ----------
    table
        One-sided PSD of the acceleration.
    duration
        Duration, s; also the period of the spectral lines.
    seed
        Seed of the phases.
    factor
        Factor of the realisation: records of different level differ by it alone.
    crest_limit
        Largest |a|, divided by the rms; None for no limit.
    """

    table: PsdTable
    duration: float
    seed: int = 1
    factor: float = 1.0
    crest_limit: float | None = None

    @cached_property
    def _samples(self) -> SampledMotion:
        lines = random_lines(self.table, self.duration, self.seed, self.crest_limit)
        count = next_fast_len(ceil(SAMPLES_PER_CYCLE * self.table.band[1] * self.duration), real=True)
        record = self.factor * lines.samples(count)
        return SampledMotion(np.append(record, record[0]), self.duration / count)

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2; zero before the start and after the end."""
        return self._samples.acceleration(time)


def random_record(
    psd_frequency: npt.ArrayLike,
    psd_g2_per_hz: npt.ArrayLike,
    duration: float,
    sampling_rate: float,
    seed: int = 1,
    *,
    crest_limit: float | None = None,
) -> FloatArray:
    """Record of a random acceleration with a given PSD, in m/s^2.

    Parameters
    ----------
    psd_frequency
        (n,) frequencies of the PSD table, Hz, ascending.
    psd_g2_per_hz
        (n,) one-sided density, g^2/Hz (g = 9.80665 m/s^2), log-log between the rows; one number for a constant band.
    duration
        Duration, s; rounded to whole samples.
    sampling_rate
        Samples per second, at least `LEAST_SAMPLING` times the highest frequency.
    seed
        Seed of the phases; the same seed gives the same record.
    crest_limit
        Largest |a|, divided by the rms, about 3 or more; the phases are changed until the record keeps it.

    Returns
    -------
    (duration * sampling_rate,) acceleration, m/s^2, at the times 0, 1 / sampling_rate, ...

    Raises
    ------
    InputError
        If the table, duration or sampling rate is invalid, or the crest limit is not reached.

    Notes
    -----
    The rms equals that of the table, and the record has no component outside the band: every line of its discrete
    Fourier transform there is zero. It starts at zero, and ends one sample before it would be zero again.
    """
    table = PsdTable.of(psd_frequency, psd_g2_per_hz)
    for name, value in (("duration", duration), ("sampling_rate", sampling_rate)):
        if not (isfinite(value) and value > 0.0):
            raise InputError(
                f"{name} = {value:g} is not a positive number", key=name, remedy="give a number above zero"
            )
    high = table.band[1]
    if sampling_rate < LEAST_SAMPLING * high:
        raise InputError(
            f"the sampling rate of {sampling_rate:g} Hz is below {LEAST_SAMPLING:g} times the highest frequency, "
            f"{high:g} Hz",
            key="sampling_rate", remedy=f"give {LEAST_SAMPLING * high:g} Hz or more",
        )  # fmt: skip
    count = round(duration * sampling_rate)
    return random_lines(table, count / sampling_rate, seed, crest_limit).samples(count)
