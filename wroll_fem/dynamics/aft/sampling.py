"""Sampled phases of a period, at which friction laws are evaluated, and Fourier series at these phases."""

from __future__ import annotations

from dataclasses import dataclass, field

import numba
import numpy as np

from wroll_fem.dynamics.aft.kernel import Products, Series
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray


@dataclass(frozen=True)
class Sampling:
    """Sampled phases of a period, and the Fourier series at these phases.

    Attributes
    ----------
    harmonics, samples : number of harmonics H and number of samples N
    odd : whether the even harmonics are omitted, for motions whose second half period mirrors the first
    orders : (R,) harmonic number of each coefficient
    values : (N, R) motion at phase 2 pi j / N for unit coefficients
    velocities : (N, R) change of this motion per sample, (2 pi / N) d/d(phase)
    project : (R, N) matrix that gives the coefficients from the samples
    ramp, ramp_rate : (N + 1,) factor on the motion in the first period (half a cosine) and its change per sample
    """

    harmonics: int
    samples: int
    odd: bool = False
    orders: FloatArray = field(init=False)
    values: FloatArray = field(init=False)
    velocities: FloatArray = field(init=False)
    project: FloatArray = field(init=False)
    ramp: FloatArray = field(init=False)
    ramp_rate: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        if self.harmonics < 1:
            raise InputError(
                f"the number of harmonics is {self.harmonics}", key="harmonic.harmonics", remedy="use 1 or more"
            )
        if self.samples < 4 * self.harmonics + 4:
            raise InputError(
                f"{self.samples} samples per period do not resolve {self.harmonics} harmonics",
                key="harmonic.samples",
                remedy=f"use {4 * self.harmonics + 4} or more",
            )
        count, phase = self.samples, 2.0 * np.pi * np.arange(self.samples) / self.samples
        orders = np.concatenate([[0.0], np.repeat(np.arange(1.0, self.harmonics + 1, 2 if self.odd else 1), 2)])
        even = np.arange(len(orders)) % 2 == 0  # the constant, then the sines
        series = np.where(even, np.sin(phase[:, None] * orders), np.cos(phase[:, None] * orders))
        series[:, 0] = 1.0
        values, velocities, project = np.empty_like(series), np.empty_like(series), np.empty(series.shape[::-1])
        ramp, ramp_rate = np.empty(count + 1), np.empty(count + 1)
        _fill_series(series, orders, 0.0, values, velocities, project)
        _fill_ramp(0.0, ramp, ramp_rate)
        for name, array in (
            ("orders", orders), ("values", values), ("velocities", velocities), ("project", project), ("ramp", ramp),
            ("ramp_rate", ramp_rate),
        ):  # fmt: skip
            object.__setattr__(self, name, array)

    def shifted(self, shift: float) -> tuple[Series, FloatArray, FloatArray]:
        """Fourier series, ramp and its change per sample, at samples that are later by ``shift`` (in samples).

        The ramp remains the same function of the phase; its last value is 1.
        """
        if shift == 0.0:
            return Series(self.values, self.velocities, self.project), self.ramp, self.ramp_rate
        size, count = self.size, self.samples
        values, velocities, project = np.empty((count, size)), np.empty((count, size)), np.empty((size, count))
        ramp, ramp_rate = np.empty(count + 1), np.empty(count + 1)
        _fill_series(self.values, self.orders, shift, values, velocities, project)
        _fill_ramp(shift, ramp, ramp_rate)
        return Series(values, velocities, project), ramp, ramp_rate

    def products(self, shift: float) -> Products:
        """Matrices for the product of a motion and a periodic function, at samples later by ``shift`` (in samples)."""
        phase = 2.0 * np.pi / self.samples * (np.arange(self.samples) + shift)
        angles = np.arange(2 * self.harmonics + 1)[:, None] * phase
        return Products(2.0 / self.samples * np.concatenate([np.cos(angles), np.sin(angles)]), self.orders.astype(int))

    @property
    def size(self) -> int:
        """Number R of Fourier coefficients of a motion.

        It is 2 H + 1 for H harmonics. With ``odd``, only the constant term and the odd harmonics have coefficients.
        """
        return 2 * ((self.harmonics + 1) // 2 if self.odd else self.harmonics) + 1


@numba.njit(cache=True)
def _fill_series(series, orders, shift, values, velocities, project):
    """Fill the arrays of `Series` for samples that are later by ``shift`` (in samples) than those of ``series`` (N, R).

    ``orders`` (R,) is the harmonic number of each coefficient.
    """
    count, size = series.shape
    step = 2.0 * np.pi / count
    values[:, 0], velocities[:, 0], project[0] = series[:, 0], 0.0, series[:, 0] / count
    for column in range(1, size, 2):
        order = step * orders[column]
        cos, sin = np.cos(order * shift), np.sin(order * shift)
        for j in range(count):
            c, s = series[j, column], series[j, column + 1]
            c, s = cos * c - sin * s, cos * s + sin * c
            values[j, column], values[j, column + 1] = c, s
            velocities[j, column], velocities[j, column + 1] = -order * s, order * c
            project[column, j], project[column + 1, j] = 2.0 / count * c, 2.0 / count * s


@numba.njit(cache=True)
def _fill_ramp(shift, ramp, ramp_rate):
    """Fill the factor (N + 1,) on the motion in the first period, half a cosine, and its change per sample.

    The N samples are later by ``shift`` (in samples). The last factor is 1 for every shift: the periodic motion goes on
    from there.
    """
    count = ramp.shape[0] - 1
    for j in range(count + 1):
        grown = min(max((j + shift) / count, 0.0), 1.0)
        ramp[j], ramp_rate[j] = 0.5 * (1.0 - np.cos(np.pi * grown)), 0.5 * np.pi / count * np.sin(np.pi * grown)
    ramp[count] = 1.0


def mean_phase(weights: FloatArray, cosine: FloatArray, sine: FloatArray) -> float:
    """Phase, rad, at which oscillations c cos + s sin are largest, as a mean over (n,) oscillations with weights."""
    return -0.5 * float(np.angle(_weighted_square(weights, cosine, sine)))


def phase_slope(weights: FloatArray, cosine: FloatArray, sine: FloatArray) -> FloatArray:
    """(2, n) derivatives of `mean_phase` with respect to the cosines and the sines."""
    total = _weighted_square(weights, cosine, sine)
    slope = np.zeros(len(weights), complex) if total == 0.0 else weights * (cosine - 1j * sine) / total
    return np.array([-slope.imag, slope.real])


def _weighted_square(weights: FloatArray, cosine: FloatArray, sine: FloatArray) -> complex:
    """Sum of the squares of the complex amplitudes c - i s, with weights."""
    weighted = weights * cosine
    return complex(weighted @ cosine - (weights * sine) @ sine, -2.0 * float(weighted @ sine))
