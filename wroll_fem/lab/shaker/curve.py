"""Transmissibility curve of one condition or one trial, with its reading and the level of the excitation."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np

from wroll_fem.signals.estimators import CurveDamping
from wroll_fem.signals.quality import Quality
from wroll_fem.typing import ComplexArray, FloatArray


@dataclass(frozen=True, eq=False)
class Curve:
    """Transmissibility with frequency, damping and level.

    Attributes
    ----------
    frequency
        (m,) Hz, ascending.
    response
        (m,) absolute tip over base acceleration, complex.
    read
        Frequency and damping.
    quality
        Quality of the damping ratio.
    base_level, tip_level
        Acceleration of base and tip, m/s^2: rms inside the band (random), 0-peak at the resonance (sweep).
    coherence, error
        (m,) coherence, and relative standard deviation of the magnitude; None for a sweep.
    resolution
        Distance between the lines of the spectra, Hz; nan for a sweep.
    averages
        Independent averages of the spectra; nan for a sweep.
    """

    frequency: FloatArray
    response: ComplexArray
    read: CurveDamping
    quality: Quality
    base_level: float
    tip_level: float
    coherence: FloatArray | None = None
    error: FloatArray | None = None
    resolution: float = nan
    averages: float = nan

    @property
    def f_n(self) -> float:
        """Resonance frequency, Hz; nan without a resonance."""
        return float(self.read.damping.f_n) if self.read.shape.resonant else nan

    @property
    def zeta(self) -> float:
        """Damping ratio; nan if there is none, or if it is invalid."""
        return nan if self.quality.grade == "invalid" else float(self.read.damping.zeta)

    @property
    def peak(self) -> float:
        """Height of the peak; nan without a resonance."""
        return float(self.read.shape.peak) if self.read.shape.resonant else nan

    def on(self, grid: FloatArray) -> ComplexArray:
        """(n,) response at the frequencies ``grid`` by linear interpolation; nan outside the band of the curve."""
        inside = (grid >= self.frequency[0] - 1e-9) & (grid <= self.frequency[-1] + 1e-9)
        real, imaginary = (
            np.interp(grid, self.frequency, part) for part in (self.response.real, self.response.imag)
        )  # fmt: skip
        return np.where(inside, real + 1j * imaginary, np.nan)
