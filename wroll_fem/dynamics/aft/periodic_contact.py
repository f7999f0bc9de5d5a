"""Contact of a structure during one period of a periodic motion (see `harmonic_contact`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.dynamics.aft import kernel
from wroll_fem.typing import BoolArray, FloatArray


@dataclass(frozen=True)
class PeriodicContact:
    """Motion, elastic slip and traction during one period, at the n contact points where the laws are evaluated.

    The traction t is stored as the traction correction s: t minus the linear traction t_0 + D_0 (g - g_0). g is the
    relative displacement, D_0 the reference contact stiffness, and the index 0 denotes the preload state.

    Attributes
    ----------
    jump_coefficients : (3 n, R) Fourier coefficients of g - g_0, m
    shift : shift of the samples (in samples), see `HarmonicContact.shift`
    series : Fourier series at the samples
    sampled : motion at the samples
    hysteresis : elastic slip, and which points slide
    correction : (3 n, N) s = t - t_0 - D_0 (g - g_0), Pa
    coefficients : (3 n, R) Fourier coefficients of ``correction``, Pa
    open : (n, N) whether the surfaces are apart
    pressure_change : (n,) largest change of the pressure, relative to the preload pressure
    """

    jump_coefficients: FloatArray
    shift: float
    series: kernel.Series
    sampled: kernel.SampledMotion
    hysteresis: kernel.Hysteresis
    correction: FloatArray
    coefficients: FloatArray
    open: BoolArray
    pressure_change: FloatArray

    @property
    def rate(self) -> FloatArray:
        """(3 n, N) change of the motion per sample, m."""
        return np.asarray(self.jump_coefficients @ self.series.velocities.T)

    @property
    def periodicity_error(self) -> float:
        """Largest change of the elastic slip during the last period computed, relative to gamma*."""
        return float(self.hysteresis.change.max(initial=0.0))
