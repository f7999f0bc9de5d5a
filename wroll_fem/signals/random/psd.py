r"""Acceleration power spectral density (PSD) given by a table, as in test specifications.

Between the rows of the table the density S is a straight line over logarithmic axes,

.. math:: S(f) = S_i (f / f_i)^{n}, \qquad n = \ln(S_{i+1} / S_i) / \ln(f_{i+1} / f_i),

so that the mean square has a closed form; outside the table S is zero. PSDs are one-sided.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, sqrt

import numpy as np
import numpy.typing as npt

from wroll_fem.errors import InputError
from wroll_fem.signals.random.psd_rows import table_problem
from wroll_fem.typing import FloatArray

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of gravity, m/s^2."""

FEWEST_LINES = 20
"""Smallest number of spectral lines in the band: with fewer a record is not Gaussian (kurtosis below 2.92)."""

NEGLIGIBLE = 1e-4
"""Part of the mean square that may lie above `PsdTable.highest_frequency_hz`."""


@dataclass(frozen=True)
class PsdTable:
    """One-sided acceleration PSD: rows of frequency and density; log-log between them, zero outside.

    Attributes
    ----------
    frequency
        Frequencies of the rows, Hz, ascending; two or more.
    g2_per_hz
        Density at these frequencies, g^2/Hz, with g = 9.80665 m/s^2; above zero.

    Raises
    ------
    InputError
        If the lists differ in length, a frequency is not above the one before, or a density is not above zero.
    """

    frequency: tuple[float, ...]
    g2_per_hz: tuple[float, ...]

    def __post_init__(self) -> None:
        problem = table_problem(self.frequency, self.g2_per_hz)
        if problem is not None:
            key, text, remedy = problem
            raise InputError(text, key=f"excitation.psd.{key}", remedy=remedy)

    @classmethod
    def of(cls, frequency: npt.ArrayLike, g2_per_hz: npt.ArrayLike) -> PsdTable:
        """Table from arrays or lists; one density stands for a constant band."""
        f = np.atleast_1d(np.asarray(frequency, dtype=np.float64))
        density = np.atleast_1d(np.asarray(g2_per_hz, dtype=np.float64))
        if density.size == 1:
            density = np.full(f.shape, density[0])
        return cls(tuple(f.tolist()), tuple(density.tolist()))

    @cached_property
    def _rows(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Frequencies, densities (n,), exponents (n - 1,) and mean square below each row (n,), g^2."""
        f, density = np.array(self.frequency), np.array(self.g2_per_hz)
        slope = np.diff(np.log(density)) / np.diff(np.log(f))
        parts = _power_integral(density[:-1], slope, f[:-1], f[1:])
        return f, density, slope, np.concatenate([[0.0], np.cumsum(parts)])

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency, Hz."""
        return self.frequency[0], self.frequency[-1]

    def density(self, frequency: npt.ArrayLike) -> FloatArray:
        """Density at frequencies (n,), Hz, in (m/s^2)^2/Hz; zero outside the table."""
        at = np.asarray(frequency, dtype=np.float64)
        f, density, _, _ = self._rows
        inside = (at >= f[0]) & (at <= f[-1])
        found = np.exp(np.interp(np.log(np.clip(at, f[0], f[-1])), np.log(f), np.log(density)))
        return np.asarray(np.where(inside, found, 0.0) * STANDARD_GRAVITY**2)

    def mean_square_below(self, frequency: npt.ArrayLike) -> FloatArray:
        """Mean square (m/s^2)^2 of the components below frequencies (n,), Hz, in closed form."""
        f, density, slope, below = self._rows
        at = np.clip(np.asarray(frequency, dtype=np.float64), f[0], f[-1])
        row = np.clip(np.searchsorted(f, at, side="right") - 1, 0, len(slope) - 1)
        inside = _power_integral(density[row], slope[row], f[row], at)
        return np.asarray((below[row] + inside) * STANDARD_GRAVITY**2)

    @property
    def rms(self) -> float:
        """Root mean square of the acceleration, m/s^2, in closed form."""
        return sqrt(float(self.mean_square_below(self.band[1])))

    @property
    def highest_frequency_hz(self) -> float:
        """Highest frequency with energy, Hz: all but `NEGLIGIBLE` of the mean square lies below it.

        It is the end of the table unless the density falls so far that the end contributes nothing.
        """
        low, high = self.band
        wanted = (1.0 - NEGLIGIBLE) * float(self.mean_square_below(high))
        grid = np.linspace(low, high, 20001)
        found = float(grid[np.searchsorted(self.mean_square_below(grid), wanted)])
        return high if found > 0.99 * high else found


def line_orders(table: PsdTable, duration: float) -> range:
    """Numbers k of the spectral lines k / duration inside the band."""
    low, high = table.band
    return range(ceil(low * duration - 1e-9), int(high * duration + 1e-9) + 1)


def duration_problem(table: PsdTable, duration: float) -> tuple[str, str] | None:
    """Problem and remedy if a record of ``duration`` seconds has too few spectral lines in the band; None otherwise."""
    count, (low, high) = len(line_orders(table, duration)), table.band
    if count >= FEWEST_LINES:
        return None
    return (
        f"a record of this length resolves {count} spectral lines in the band of {low:g} to {high:g} Hz, too few for "
        f"a random motion ({FEWEST_LINES})",
        f"give {(FEWEST_LINES + 1) / (high - low):.3g} s or more, or a wider band",
    )


def _power_integral(density: FloatArray, slope: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Integral of density (f / low)^slope from low to high, with the limit at slope -1."""
    width, power = np.log(high / low), np.asarray(slope) + 1.0
    small = np.abs(power * width) < 1e-12
    safe = np.where(small, 1.0, power)
    return np.asarray(density * low * np.where(small, width, np.expm1(safe * width) / safe))
