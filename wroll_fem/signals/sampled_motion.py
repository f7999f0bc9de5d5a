"""Base motion given by samples: a quintic spline through them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_interp_spline

from wroll_fem.typing import FloatArray


@dataclass(frozen=True, eq=False)
class SampledMotion:
    """Base motion through equally spaced samples.

    Attributes
    ----------
    samples
        (n,) base acceleration, m/s^2, at the times 0, dt, 2 dt, ...; n >= 6.
    dt
        Time between samples, s.

    Notes
    -----
    The largest error of the quintic spline, relative to the amplitude, is 6.5e-8 with 20 samples per cycle, 4.9e-6 with
    10 and 2.1e-3 with 4 (`tests/signals/test_random_motion.py`). The motion is zero before the first and after the last
    sample.
    """

    samples: FloatArray
    dt: float

    @property
    def duration(self) -> float:
        """Duration of the motion, s."""
        return (len(self.samples) - 1) * self.dt

    @cached_property
    def _spline(self) -> BSpline:
        return make_interp_spline(self.dt * np.arange(len(self.samples)), self.samples, k=5)

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2."""
        t = np.asarray(time, dtype=np.float64)
        inside = (t >= 0.0) & (t <= self.duration * (1.0 + 1e-12))
        return np.asarray(np.where(inside, self._spline(np.clip(t, 0.0, self.duration)), 0.0))
