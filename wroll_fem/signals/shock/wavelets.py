r"""Base motions composed of wavelets, whose velocity and displacement end at zero.

.. math:: a_g(t) = \sum_m A_m \sin\frac{2\pi f_m (t - d_m)}{N_m} \sin 2\pi f_m (t - d_m), \qquad
          0 \le t - d_m \le \frac{N_m}{2 f_m}

with an odd number :math:`N_m \ge 3` of half cycles. Each term is the difference of two cosines with a whole number of
periods each, so that its first and second integral are zero at its end [1]_.

References
----------
.. [1] R. C. Yang, Safeguard BMD system: development of a waveform synthesis technique, Ralph M. Parsons Company,
   SAF-64, 1970.
.. [2] D. O. Smallwood, A. R. Nord, Matching shock spectra with sums of decaying sinusoids compensated for shaker
   velocity and displacement limitations, Shock and Vibration Bulletin 44(3), 1974, 43-56.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np
import numpy.typing as npt

from wroll_fem.signals.shock.pulses import band_of_record, require_number
from wroll_fem.signals.shock.spectrum import GOOD_SAMPLES
from wroll_fem.typing import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Wavelets:
    """Sum of wavelets.

    Attributes
    ----------
    lines, level, half_cycles, delay
        (m,) frequency (Hz), amplitude (m/s^2, with its sign), odd number of half cycles, and start (s) of each.
    before, after
        Time without base acceleration before and after the wavelets, s.
    """

    lines: FloatArray
    level: FloatArray
    half_cycles: IntArray
    delay: FloatArray
    before: float = 0.0
    after: float = 0.0

    def __post_init__(self) -> None:
        for name in ("before", "after"):
            require_number(name, getattr(self, name), positive=False, remedy="give a time in s, 0 for none")

    @property
    def length(self) -> float:
        """Time from the first to the end of the last wavelet, s."""
        return float(np.max(self.delay + 0.5 * self.half_cycles / self.lines))

    @property
    def duration(self) -> float:
        """Duration of the motion, s."""
        return self.before + self.length + self.after

    @property
    def end(self) -> float:
        """Time at which the base stands still, s."""
        return self.before + self.length

    @cached_property
    def amplitude(self) -> float:
        """Largest base acceleration, m/s^2."""
        return float(np.abs(self._samples[1]).max())

    @cached_property
    def highest_frequency_hz(self) -> float:
        """Frequency below which 99 % of the energy of the motion lies, Hz."""
        dt, base = self._samples
        return band_of_record(base, dt, pad=4)

    @property
    def velocity_change(self) -> float:
        """Change of the velocity of the base, m/s: zero."""
        return 0.0

    def acceleration(self, time: npt.ArrayLike) -> FloatArray:
        """Base acceleration at `time` (s), m/s^2."""
        t = np.asarray(time, dtype=np.float64) - self.before
        found = np.zeros_like(t)
        for f, a, n, d in zip(self.lines, self.level, self.half_cycles, self.delay, strict=True):
            inside = (t > d) & (t < d + 0.5 * n / f)
            phase = 2.0 * pi * f * (t[inside] - d)
            found[inside] += a * np.sin(phase / n) * np.sin(phase)
        return found

    @cached_property
    def _samples(self) -> tuple[float, FloatArray]:
        dt = 1.0 / (GOOD_SAMPLES * float(self.lines.max()))
        return dt, self.acceleration(self.before + dt * np.arange(int(np.ceil(self.length / dt)) + 1))
