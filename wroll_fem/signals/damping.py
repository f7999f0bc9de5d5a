"""Half-power damping and skewness of a transmissibility curve (docs/theory.md, eq-readings)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan, sqrt

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from wroll_fem.errors import InputError
from wroll_fem.results.resonance import RISES_AGAIN
from wroll_fem.signals.attainment import swept_peak
from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.sweeps import Chirp, LinearSweep, Sweep
from wroll_fem.typing import FloatArray

LEAST_PROMINENCE = 0.01
"""Prominence below which the highest point of a curve counts as a ripple. The feet of this point are the lowest points
to its left and to its right. Its prominence is its height above the higher foot, divided by its height above zero. If
the band contains a half-power point, the highest point is not counted as a ripple."""

LARGEST_PARTICIPATION = 3.0
"""Largest product of the height of a peak and twice its damping ratio; a larger product indicates ringing. The product
is 1 for a single mass and 1.6 for the first mode of a cantilever. It is up to 2 for randomly chosen rolls with
friction, whose peaks do not have the width of a linear resonance."""


HEIGHT_FACTOR = 1.5
"""Largest factor between a damping ratio and that from the height of the peak, p / (2 T), where p is the participation
of the mode with sticking interfaces. For one linear mode the factor is 1."""


@dataclass(frozen=True)
class HalfPower:
    """Half-power damping of one resonance.

    Attributes
    ----------
    f_n, peak
        Frequency (Hz) and height of the highest point, even if it is not `resonant`; `as_attrs` then gives nan.
    f_low, f_high
        Half-power frequencies f1 < f_n < f2 at peak / sqrt 2, Hz; nan if outside the band.
    zeta
        Damping ratio (f2 - f1) / (2 f_n); nan if not `complete`.
    skewness
        (f2 - f_n) / (f_n - f1) - 1, positive for a long tail to the right; nan if not `complete`.
    complete
        Whether the peak and both half-power points lie inside the band.
    reason
        Why the result is not complete; empty otherwise.
    note
        Remark on a complete result: the curve rises above half power again elsewhere, so the result describes only the
        highest peak.
    resonant
        Whether the highest point counts as a resonance. It does not if it lies at an end of the band, is a ripple on a
        slope, or has the phase of a response far from resonance (`without_resonance`).
    """

    f_n: float
    peak: float
    f_low: float
    f_high: float
    zeta: float
    skewness: float
    complete: bool
    reason: str = ""
    note: str = ""
    resonant: bool = True

    def without_resonance(self, reason: str) -> HalfPower:
        """Copy in which the highest point does not count as a resonance, with the reason."""
        return replace(
            self, zeta=nan, skewness=nan, f_low=nan, f_high=nan, complete=False, resonant=False, reason=reason, note=""
        )

    def as_attrs(self) -> dict[str, float | str | bool]:
        """Values as attributes of a Dataset, named as in summary.json."""
        return {
            "f_n_hz": self.f_n if self.resonant else nan,
            "peak_transmissibility": self.peak if self.resonant else nan,
            "half_power_low_hz": self.f_low,
            "half_power_high_hz": self.f_high,
            "zeta": self.zeta,
            "zeta_method": "half power",
            "skewness": self.skewness,
            "half_power_complete": self.complete,
            "half_power_reason": self.reason or self.note,
        }


def _peak(frequency: FloatArray, magnitude: FloatArray) -> tuple[float, float, int]:
    """Frequency, height and index of the highest point.

    Frequency and height are those of the vertex of the parabola through this point and its neighbours, unless the point
    is at an end of the curve or the top is flat.
    """
    k = int(np.argmax(magnitude))
    if k == 0 or k == magnitude.size - 1:
        return float(frequency[k]), float(magnitude[k]), k
    left, right = frequency[k - 1] - frequency[k], frequency[k + 1] - frequency[k]
    low, high = magnitude[k - 1] - magnitude[k], magnitude[k + 1] - magnitude[k]
    curvature = (low / left - high / right) / (left - right)
    if curvature >= 0.0:  # flat top: three equal values
        return float(frequency[k]), float(magnitude[k]), k
    slope = low / left - curvature * left
    offset = -0.5 * slope / curvature
    return float(frequency[k] + offset), float(magnitude[k] + 0.5 * slope * offset), k


def _crossing(frequency: FloatArray, magnitude: FloatArray, level: float, start: int, step: int) -> float:
    """First frequency from index `start` in direction `step` at which the curve falls below `level`; nan if none."""
    side = np.arange(start, magnitude.size if step > 0 else -1, step)
    below = np.flatnonzero(magnitude[side] < level)
    if below.size == 0:
        return nan
    outer = int(side[below[0]])
    inner = outer - step
    first = int(np.clip(min(outer, inner) - 1, 0, magnitude.size - 4))
    stencil = slice(first, first + 4)
    origin, scale = frequency[inner], abs(frequency[outer] - frequency[inner])
    x, y = (frequency[stencil] - origin) / scale, magnitude[stencil]
    cubic = np.polynomial.Polynomial.fit(x, y, 3, domain=[x[0], x[-1]])
    ends = sorted((0.0, float(step)))
    if (cubic(ends[0]) - level) * (
        cubic(ends[1]) - level
    ) > 0.0:  # the level is reached at a grid point, within rounding errors
        return float(frequency[inner])
    return float(origin + scale * brentq(lambda s: float(cubic(s)) - level, *ends, xtol=1e-12))


def _no_maximum(f: FloatArray, m: FloatArray, k: int, *, beside: bool) -> str:
    """Text that says that the highest point (index k) is an end of the band or a ripple; empty if it is neither.

    ``beside`` tells whether one of its half-power points is inside the band.
    """
    if k in (0, m.size - 1):
        side = "lower" if k == 0 else "upper"
        return f"the highest point lies on the {side} end of the band ({f[k]:.5g} Hz): no resonance inside"
    foot = max(float(m[: k + 1].min()), float(m[k:].min()))
    if not beside and foot > (1.0 - LEAST_PROMINENCE) * m[k]:
        return (
            f"the highest point, at {f[k]:.5g} Hz, rises only {100.0 * (1.0 - foot / m[k]):.2g} % above the lowest "
            "point on one of its sides: no resonance inside"
        )
    return ""


def half_power(frequency: npt.ArrayLike, magnitude: npt.ArrayLike) -> HalfPower:
    """Half-power (3 dB) damping of the highest peak of a transmissibility curve.

    Parameters
    ----------
    frequency
        (n,) frequencies, Hz, ascending, n >= 5; the step may vary.
    magnitude
        (n,) |T|, not a level in dB.

    Returns
    -------
    HalfPower
        If the peak or a half-power point lies outside the band, `complete` is False, `zeta` and `skewness` are nan, and
        `reason` gives the cause. Without a maximum inside the band, `resonant` is False too.

    Raises
    ------
    InputError
        If the arrays do not form a curve: unequal shapes, frequencies not ascending, values not finite or negative.

    Notes
    -----
    The peak is the vertex of the parabola through three points. The crossings nearest to the peak on either side are
    interpolated by the cubic through four points. With 20 points across the half-power width, zeta is accurate to 2e-4
    and f_n to 1e-3 of half the width; the errors decrease with the square of the step.

    Half power is itself an estimate. For the exact absolute transmissibility of a single degree of freedom it gives

    =========  ======  ======  ======  ======  ======  ======
    true zeta  0.005   0.01    0.02    0.05    0.1     0.2
    =========  ======  ======  ======  ======  ======  ======
    estimate   0.0050  0.0100  0.0200  0.0502  0.1019  0.2144
    skewness   -0.005  -0.010  -0.020  -0.048  -0.090  -0.150
    =========  ======  ======  ======  ======  ======  ======

    and for a nonlinear roll it is an equivalent damping ratio that depends on the amplitude.
    """
    f, m = np.asarray(frequency, dtype=np.float64), np.asarray(magnitude, dtype=np.float64)
    if f.ndim != 1 or f.shape != m.shape or f.size < 5:
        raise InputError(
            f"frequency and magnitude have the shapes {f.shape} and {m.shape}",
            remedy="give two series of the same length, 5 points or more",
        )
    if not (np.isfinite(f).all() and np.isfinite(m).all()) or np.any(np.diff(f) <= 0.0) or np.any(m < 0.0):
        raise InputError(
            "the frequencies of a curve must increase and its magnitudes must be finite and not negative",
            remedy="sort the points by frequency and remove invalid ones",
        )
    f_n, peak, k = _peak(f, m)
    if not peak > 0.0:
        raise InputError(
            "the curve is zero everywhere", remedy="check that the base moves in the direction of the response"
        )
    level = peak / sqrt(2.0)
    f_low, f_high = _crossing(f, m, level, k, -1), _crossing(f, m, level, k, +1)
    problem = _no_maximum(f, m, k, beside=bool(np.isfinite([f_low, f_high]).any()))
    if problem:
        return HalfPower(f_n, peak, nan, nan, nan, nan, False, reason=problem, resonant=False)
    reasons = []
    if np.isnan(f_low):
        reasons.append(f"no half-power point between {f[0]:.5g} Hz and the peak at {f_n:.5g} Hz")
    if np.isnan(f_high):
        reasons.append(f"no half-power point between the peak at {f_n:.5g} Hz and {f[-1]:.5g} Hz")
    if reasons:
        return HalfPower(f_n, peak, f_low, f_high, nan, nan, False, reason="; ".join(reasons))
    again = (m > level) & ((f < f_low) | (f > f_high))
    again &= (f < f_low - 1e-9 * f_n) | (f > f_high + 1e-9 * f_n)
    note = f"{RISES_AGAIN} at {f[again][0]:.5g} Hz" if again.any() else ""
    zeta, skewness = (f_high - f_low) / (2.0 * f_n), (f_high - f_n) / (f_n - f_low) - 1.0
    return HalfPower(f_n, peak, f_low, f_high, zeta, skewness, True, note=note)


SLOW_ENOUGH = 0.25
"""Sweep rate, relative to the ISO 7626-2 limit, up to which zeta of a linear peak is at most 2 % too high (table in
`wroll_fem.signals.transmissibility`)."""

FLANK_SLOW_ENOUGH = 0.5
"""Sweep rate, relative to the ISO 7626-2 limit for the damping of the steeper flank, up to which a skewed peak is slow
enough. Friction makes one flank steep, and the sweep lags there first: f_n of random rolls
(benchmarks/random_rolls.py) differs from that of harmonic balance by 0.3 % below this rate, and by 1.5 % above it."""


def sweep_warning(motion: Sweep, read: HalfPower, participation: float | None = None) -> str | None:
    """Warning if a sweep is too fast for the resonance that it passes.

    Parameters
    ----------
    motion
        Sweep.
    read
        Half-power damping of the demodulated envelope.
    participation
        Participation of the resonant mode, if it is known (`likely_damping`).

    Returns
    -------
    str or None
        Warning with an admissible rate; None without a resonance in the band, or below `SLOW_ENOUGH` of the ISO 7626-2
        limit for zeta and `FLANK_SLOW_ENOUGH` of that for the steeper flank.

    Notes
    -----
    A sweep that is too fast gives a zeta that is too high, so the limit computed from it is too high as well. Repeat
    the check with the slower sweep. Ringing can hide a half-power point, or add the width of its own hump to that of a
    sharp peak. The limit then comes from the damping that the height of the peak allows (`likely_damping`).
    """
    if not read.resonant:
        return None
    zeta, origin = likely_damping(read, participation)
    limit = sweep_rate_limit(read.f_n, zeta)
    rate = motion.rate_at(read.f_n)
    share, slow = rate / limit, SLOW_ENOUGH * limit
    if read.complete:
        flank = min(read.f_n - read.f_low, read.f_high - read.f_n) / read.f_n
        flank_limit = sweep_rate_limit(read.f_n, flank)
        slow = min(slow, FLANK_SLOW_ENOUGH * flank_limit)
        if share <= SLOW_ENOUGH:
            zeta, share = flank, rate / flank_limit
            origin = " (from the steeper flank of a skewed peak)"
    if rate <= slow:
        return None
    reached = swept_peak(read.f_n, zeta, rate, downward=motion.downward).attainment
    remedy = f"sweep at {slow:.2g} oct/min or less"
    if isinstance(motion, Chirp):
        remedy = f"set excitation.rate_oct_per_min to {slow:.2g} or less"
    elif isinstance(motion, LinearSweep):
        remedy = f"set excitation.rate_hz_per_s to {motion.rate_hz_per_s * slow / rate:.2g} or less"
    return (
        f"sweep of {rate:.3g} oct/min runs at {100 * share:.0f} % of the ISO 7626-2 limit for "
        f"{read.f_n:.1f} Hz and zeta = {100 * zeta:.2f} %{origin}: the peak lags (a linear one reaches "
        f"{100 * reached:.0f} % of its steady height), and zeta and skewness are biased; "
        f"{remedy}"
    )


def likely_damping(read: HalfPower, participation: float | None = None) -> tuple[float, str]:
    """Damping ratio for the checks of sweep rate and time step, and a text about its origin.

    The text is empty if the damping ratio is the half-power damping.

    A single mode with the participation p has a peak of height p / (2 zeta). If the half-power damping gives more than
    `HEIGHT_FACTOR` times the participation, or more than `LARGEST_PARTICIPATION` if the participation is unknown, the
    peak is too high for its width, because the response rings. The damping ratio is then estimated from the height.
    """
    if not read.complete:
        return least_damping(read), " (from the height or one side of the peak, as a half-power point is missing)"
    largest = LARGEST_PARTICIPATION if participation is None else HEIGHT_FACTOR * participation
    if 2.0 * read.peak * read.zeta > largest:
        from_height = 0.5 * (LARGEST_PARTICIPATION if participation is None else participation) / read.peak
        return from_height, " (from the height of the peak, which is too high for its width because of ringing)"
    return read.zeta, ""


def least_damping(read: HalfPower) -> float:
    """Smallest of the damping ratios estimated from the height and from each half-power point of a peak.

    The height T gives 1 / (2 T), the value of a single mass on a shaken base; a mode with a participation of 1.6, such
    as the first of a uniform cantilever, has 1.6 times this value. A half-power point gives its distance from the peak
    divided by f_n. Lag and ringing change the height by 6 % at the ISO 7626-2 limit and by 12 % at twice this limit;
    they change the width more.
    """
    sides = [abs(f - read.f_n) / read.f_n for f in (read.f_low, read.f_high) if np.isfinite(f)]
    return float(min([0.5 / read.peak, *sides]))
