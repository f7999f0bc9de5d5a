r"""Spectra of two stationary records by averaging (Welch): PSDs, transmissibility H1 and Hv, coherence, their errors.

Segments of length 1 / df with Hann windows overlap by half. With the averaged spectra G,

.. math::

    H_1 = G_{xy} / G_{xx}, \quad \gamma^2 = |G_{xy}|^2 / (G_{xx} G_{yy}), \quad
    H_v = \sqrt{G_{yy} / G_{xx}}\; G_{xy} / |G_{xy}|.

H1 is free of bias by noise in the response, and Hv, the geometric mean of H1 and H2, by equal relative noise in both.

Errors [1]_: the standard deviation of a PSD is 1 / sqrt(n), and that of :math:`|H_1|` is
:math:`\sqrt{(1 - \gamma^2) / (2 n \gamma^2)}`, both relative, with n independent averages [2]_. The Hann window
averages a spectrum over frequencies with a variance of df^2 / 3. This lowers a resonance peak of half-power width B_r
by the part :math:`(4/3) (df / B_r)^2`, and widens it. To this order the average of H is H + (df^2 / 6) H''; with second
differences the correction is H_k - (H_{k+1} - 2 H_k + H_{k-1}) / 6 (`Spectra.h1_corrected`).

References
----------
.. [1] J. S. Bendat, A. G. Piersol, Random Data, 4th edition, Wiley 2010, chapters 8 and 9, doi:10.1002/9781118032428.
.. [2] P. D. Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE Transactions on Audio
   and Electroacoustics 15 (1967) 70-73, doi:10.1109/TAU.1967.1161901.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, isfinite, sqrt

import numpy as np
import numpy.typing as npt
from scipy.integrate import trapezoid
from scipy.signal import csd, welch

from wroll_fem.errors import InputError
from wroll_fem.typing import ComplexArray, FloatArray

HALF_OVERLAP = 1.0 / 6.0
"""Correlation of a Hann window with itself, shifted by half of its length."""

FEWEST_SEGMENTS = 4
"""Smallest number of segments that are averaged."""

CORRELATED_LINES = 1.394
"""Factor of the standard errors of a fit to H1 that treats neighbouring lines as independent. Noise on lines of Hann
windows at distances 1 and 2 is correlated by 4/9 and 1/36: sqrt(1 + 2 (4/9 + 1/36))."""


@dataclass(frozen=True)
class Spectra:
    """Averaged spectra of a base record x and a response record y.

    Attributes
    ----------
    frequency
        (m,) Hz.
    base, response
        (m,) one-sided PSDs, (unit of the record)^2/Hz.
    cross
        (m,) cross spectrum conj(X) Y, complex.
    averages
        Number of independent averages.
    """

    frequency: FloatArray
    base: FloatArray
    response: FloatArray
    cross: ComplexArray
    averages: float

    @property
    def resolution(self) -> float:
        """Distance between the lines, Hz."""
        return float(self.frequency[1] - self.frequency[0])

    @property
    def h1(self) -> ComplexArray:
        """(m,) response over base, from cross spectrum and base PSD."""
        return np.asarray(self.cross / self.base)

    @property
    def h1_corrected(self) -> ComplexArray:
        """(m,) H1 without the bias of the resolution to second order; the first and last value are those of H1."""
        found = self.h1.copy()
        found[1:-1] -= np.diff(self.h1, 2) / 6.0
        return found

    @property
    def hv(self) -> ComplexArray:
        """(m,) response over base, geometric mean of H1 and H2."""
        size = np.abs(self.cross)
        return np.asarray(np.sqrt(self.response / self.base) * self.cross / np.where(size > 0.0, size, 1.0))

    @property
    def coherence(self) -> FloatArray:
        """(m,) coherence, 0 to 1."""
        return np.asarray(np.minimum(np.abs(self.cross) ** 2 / (self.base * self.response), 1.0))

    @property
    def psd_error(self) -> float:
        """Relative standard deviation of the PSDs."""
        return 1.0 / sqrt(self.averages)

    @property
    def h1_error(self) -> FloatArray:
        """(m,) relative standard deviation of |H1|."""
        least = np.maximum(self.coherence, 1e-12)
        return np.asarray(np.sqrt((1.0 - self.coherence) / (2.0 * self.averages * least)))

    def within(self, low: float, high: float) -> Spectra:
        """Spectra at the frequencies from ``low`` to ``high``, Hz."""
        keep = (self.frequency >= low) & (self.frequency <= high)
        return Spectra(
            self.frequency[keep], self.base[keep], self.response[keep], self.cross[keep], self.averages
        )  # fmt: skip


def averaged_spectra(base: npt.ArrayLike, response: npt.ArrayLike, dt: float, resolution: float) -> Spectra:
    """Averaged spectra of two records of the same times.

    Parameters
    ----------
    base, response
        (n,) records; their means are removed from each segment.
    dt
        Time step, s.
    resolution
        Distance between the lines, Hz: the inverse length of a segment.

    Raises
    ------
    InputError
        If the records differ in length, contain invalid values, or have fewer than `FEWEST_SEGMENTS` segments.
    """
    x, y = np.asarray(base, dtype=np.float64), np.asarray(response, dtype=np.float64)
    if x.ndim != 1 or x.shape != y.shape:
        raise InputError(
            f"the records have the shapes {x.shape} and {y.shape}", remedy="give two records of the same length"
        )
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise InputError("the records contain values that are not finite", remedy="remove invalid samples")
    for name, value in (("dt", dt), ("resolution", resolution)):
        if not (isfinite(value) and value > 0.0):
            raise InputError(
                f"{name} = {value:g} is not a positive number", key=name, remedy="give a number above zero"
            )
    length = max(8, round(1.0 / (resolution * dt)))
    count = segments(len(x), length)
    if count < FEWEST_SEGMENTS:
        need = 0.5 * (FEWEST_SEGMENTS + 1) * length * dt
        raise InputError(
            f"a record of {len(x) * dt:.4g} s has {max(count, 0)} segments of {length * dt:.4g} s, too few to average",
            key="resolution",
            remedy=f"give a record of {need:.3g} s or more, or a resolution of "
            f"{(FEWEST_SEGMENTS + 1) / (2.0 * len(x) * dt):.3g} Hz or coarser",
        )  # fmt: skip
    options = {"fs": 1.0 / dt, "nperseg": length, "noverlap": length - length // 2, "detrend": "constant"}
    frequency, base_psd = welch(x, **options)
    response_psd, cross = welch(y, **options)[1], csd(x, y, **options)[1]
    return Spectra(frequency[1:], base_psd[1:], response_psd[1:], cross[1:], independent_averages(count))


def pooled(spectra: Sequence[Spectra]) -> Spectra:
    """Average of the spectra of several independent records, at the same frequencies."""
    one, count = spectra[0], len(spectra)
    if count == 1:
        return one
    base, response, cross = (sum(getattr(s, part) for s in spectra) / count for part in ("base", "response", "cross"))
    return Spectra(one.frequency, base, response, cross, sum(s.averages for s in spectra))


def segments(samples: int, length: int) -> int:
    """Number of segments of ``length`` samples that overlap by half, in a record of ``samples``."""
    return (samples - length) // (length // 2) + 1 if samples >= length else 0


def independent_averages(count: int) -> float:
    """Number of independent averages of ``count`` segments with Hann windows that overlap by half (Welch)."""
    return count / (1.0 + 2.0 * (1.0 - 1.0 / count) * HALF_OVERLAP**2)


def peak_bias(resolution: float, f_n: float, zeta: float) -> float:
    """Part of a resonance peak that the resolution (Hz) takes, to first order: (4/3) (df / (2 zeta f_n))^2."""
    return 4.0 / 3.0 * (resolution / (2.0 * zeta * f_n)) ** 2


def wanted_resolution(f_n: float, zeta: float, bias: float = 0.01) -> float:
    """Resolution, Hz, at which a resonance peak is too low by the part ``bias``."""
    return 2.0 * zeta * f_n * sqrt(0.75 * bias)


def wanted_duration(resolution: float, random_error: float) -> float:
    """Length of a record, s, whose PSD has the relative standard deviation ``random_error`` at a resolution in Hz."""
    independent = 1.0 / random_error**2
    count = max(FEWEST_SEGMENTS, ceil(independent * (1.0 + 2.0 * HALF_OVERLAP**2)))
    return 0.5 * (count + 1) / resolution


def rms_error(frequency: npt.ArrayLike, psd: npt.ArrayLike, duration: float) -> float:
    """Relative standard deviation of the rms of a Gaussian record with the given PSD: 1 / (2 sqrt(B T)).

    B = (int S df)^2 / int S^2 df is the statistical bandwidth, ``duration`` the length T of the record, s.

    Notes
    -----
    The lines of `random_record` have fixed amplitudes, so that the rms of its responses scatters less.
    """
    f, density = np.asarray(frequency, dtype=np.float64), np.asarray(psd, dtype=np.float64)
    power, square = trapezoid(density, f), trapezoid(density**2, f)
    return float(0.5 * sqrt(square / (power**2 * duration))) if power > 0.0 else float("nan")
