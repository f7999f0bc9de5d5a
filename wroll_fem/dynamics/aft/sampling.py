"""Sampled phases of a period, at which friction laws are evaluated, and Fourier series at these phases."""

from __future__ import annotations

from dataclasses import dataclass, field

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
    values : (N, R) motion at phase 2 pi j / N for unit coefficients
    velocities : (N, R) change of this motion per sample, (2 pi / N) d/d(phase)
    project : (R, N) matrix that gives the coefficients from the samples
    ramp, ramp_rate : (N + 1,) factor on the motion in the first period (half a cosine) and its change per sample
    """

    harmonics: int
    samples: int
    odd: bool = False
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
        values, slopes = np.zeros((count, self.size)), np.zeros((count, self.size))
        values[:, 0] = 1.0
        for column in range(1, self.size, 2):
            k = self.orders[column]
            cos, sin = np.cos(k * phase), np.sin(k * phase)
            values[:, column], values[:, column + 1] = cos, sin
            slopes[:, column], slopes[:, column + 1] = -k * sin, k * cos
        ramp, ramp_rate = _ramp(count, 0.0)
        for name, array in (
            ("values", values),
            ("velocities", 2.0 * np.pi / count * slopes),
            ("project", _projection(values)),
            ("ramp", ramp),
            ("ramp_rate", ramp_rate),
        ):
            object.__setattr__(self, name, array)

    def shifted(self, shift: float) -> tuple[Series, FloatArray, FloatArray]:
        """Fourier series, ramp and its change per sample, at samples that are later by ``shift`` (in samples).

        The ramp remains the same function of the phase.
        """
        if shift == 0.0:
            return Series(self.values, self.velocities, self.project), self.ramp, self.ramp_rate
        step = 2.0 * np.pi / self.samples
        angle = step * shift * self.orders[1::2]
        values, velocities = _turned(self.values, angle), np.zeros_like(self.values)
        np.multiply(values[:, 2::2], -step * self.orders[1::2], out=velocities[:, 1::2])
        np.multiply(values[:, 1::2], step * self.orders[1::2], out=velocities[:, 2::2])
        return Series(values, velocities, _projection(values)), *_ramp(self.samples, shift)

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

    @property
    def orders(self) -> FloatArray:
        """(R,) harmonic number of each coefficient."""
        return np.concatenate([[0.0], np.repeat(np.arange(1.0, self.harmonics + 1, 2 if self.odd else 1), 2)])


def _turned(series: FloatArray, angle: FloatArray) -> FloatArray:
    """Series (N, R) with the phase of each harmonic later by ``angle`` (H,), rad."""
    cos, sin, out = np.cos(angle), np.sin(angle), series.copy()
    out[:, 1::2] = cos * series[:, 1::2] - sin * series[:, 2::2]
    out[:, 2::2] = cos * series[:, 2::2] + sin * series[:, 1::2]
    return out


def _projection(values: FloatArray) -> FloatArray:
    """(R, N) matrix that gives Fourier coefficients from samples, for the series ``values`` (N, R) at the samples."""
    project = 2.0 / len(values) * values.T
    project[0] *= 0.5
    return np.ascontiguousarray(project)


def _ramp(count: int, shift: float) -> tuple[FloatArray, FloatArray]:
    """Factor (N + 1,) on the motion in the first period, half a cosine of the phase, and its change per sample.

    The N = ``count`` samples are later by ``shift`` (in samples).
    """
    grow = np.clip((np.arange(count + 1) + shift) / count, 0.0, 1.0)
    return 0.5 * (1.0 - np.cos(np.pi * grow)), 0.5 * np.pi / count * np.sin(np.pi * grow)


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
