"""Quality of the damping ratio of a transmissibility curve: ok, doubtful or invalid, with reasons.

Each check compares the estimate with something else that is known: the height of the peak, the sweep rate, the start of
the sweep, other estimators. A doubtful damping ratio is stated with its reasons. An invalid one is not stated.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite, nan, sqrt
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.signal import find_peaks

from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.damping import HEIGHT_FACTOR, SLOW_ENOUGH, HalfPower, half_power, likely_damping, sweep_warning
from wroll_fem.signals.estimators.curve_damping import CurveDamping
from wroll_fem.signals.estimators.half_power import METHOD as HALF_POWER
from wroll_fem.signals.sweeps import Sweep
from wroll_fem.typing import FloatArray

Grade = Literal["ok", "doubtful", "invalid"]

SECOND_PEAK, PROMINENCE = 0.6, 0.05
"""Height of a second peak, relative to the highest, that makes a damping ratio doubtful, and its least prominence."""

NOISE_OF_PEAK = 5.0
"""Least prominence of a second peak on a curve with noise, in standard deviations of the noise: two neighbouring points
differ by this in one of 2000 cases."""

TOO_FAST = 0.5
"""Sweep rate, relative to the ISO 7626-2 limit for the estimated damping ratio, above which this ratio is invalid. It
is then at least 13 % too high: the limit increases with the estimate, so that this share corresponds to 0.65 of the
limit for the true damping ratio (table in `wroll_fem.signals.transmissibility`)."""

START = 0.04
"""Transient from the start of a sweep that remains at the lower half-power point, relative to the peak, above which the
damping ratio is doubtful."""

FEWEST_POINTS = 6
"""Smallest number of points of a curve between its half-power points."""

LARGEST_ZETA = 0.2
"""Damping ratio above which half power is more than 7 % too high, even for a single mode."""

FOLD = 0.01
"""Width of the band with several motions, relative to the half-power width, above which zeta is doubtful."""

SMOOTHED = 0.25
"""Part of the half-power width over which spectra are averaged. It widens a linear peak by 1 %."""

SPREAD = 0.25
"""Largest relative difference between the damping ratios from the demodulated envelope and from the spectra."""


@dataclass(frozen=True)
class Quality:
    """Grade of a damping ratio, with the reasons for it.

    Attributes
    ----------
    grade
        "ok", "doubtful" or "invalid".
    reasons
        One sentence for each check that failed, worst first.
    spread
        Relative difference between the half-power damping of envelope and spectra; nan without both.
    """

    grade: Grade
    reasons: tuple[str, ...]
    spread: float = nan

    def as_attrs(self, attrs: dict[str, Any]) -> dict[str, Any]:
        """Attributes of an estimate (`CurveDamping.as_attrs`), extended by its quality.

        ``zeta_apparent`` is the estimate, whatever its quality. If it is invalid, ``zeta`` is nan and has no error bar.
        """
        found = attrs | {
            "zeta_quality": self.grade, "zeta_doubts": "\n".join(self.reasons), "zeta_apparent": attrs["zeta"],
        }  # fmt: skip
        if isfinite(self.spread):
            found["zeta_spread"] = self.spread
        if self.grade == "invalid":
            found = {name: value for name, value in found.items() if name not in ("zeta_error", "zeta_lower_bound")}
            found["zeta"] = nan
        return found


@dataclass(frozen=True)
class Circumstances:
    """What is known about a curve besides its points.

    Attributes
    ----------
    motion
        Sweep that gave the curve; None for a curve of steady motions.
    participation
        Height of the peak times twice the damping ratio, of the mode with sticking interfaces; None if unknown.
    several
        Lowest and highest frequency (Hz) between which several periodic motions exist; None for a curve without folds.
    spectrum
        (n,) magnitude of the ratio of the spectra of the same sweep, at the frequencies of the curve; None without it.
    remarks
        Warnings of the run that concern its damping ratio.
    rigid
        |T| of the rigid structure: 1, or 0 if a force excites it.
    """

    motion: Sweep | None = None
    participation: float | None = None
    several: tuple[float, float] | None = None
    spectrum: FloatArray | None = None
    remarks: tuple[str, ...] = ()
    rigid: float = 1.0


def judge(read: CurveDamping, frequency: FloatArray, magnitude: FloatArray, known: Circumstances) -> Quality:
    """Quality of a damping ratio.

    Parameters
    ----------
    read
        Estimate.
    frequency, magnitude
        (n,) curve: Hz and |T|, in the order of the branch if it has folds.
    known
        What is known besides.
    """
    told = tuple(text for text in read.warnings if text != read.shape.note)
    curve = _Curve(read, frequency, magnitude, known)
    if not read.damping.found or not read.shape.resonant:
        # a sweep that is too fast may be what hides a half-power point
        reasons = *(told or (read.damping.reason or read.shape.reason,)), *(doubt.text for doubt in _sweep_rate(curve))
        return Quality("invalid", tuple(dict.fromkeys(text for text in (*reasons, *known.remarks) if text)))
    found = [doubt for check in _CHECKS for doubt in check(curve)]
    found += [_Doubt("doubtful", text) for text in (*told, *known.remarks) if text]
    worst = [doubt.text for doubt in found if doubt.grade == "invalid"]
    rest = [doubt.text for doubt in found if doubt.grade == "doubtful"]
    grade: Grade = "invalid" if worst else "doubtful" if rest else "ok"
    return Quality(grade, tuple(dict.fromkeys(worst + rest)), curve.spread)


def height_damping(shape: HalfPower, participation: float, rigid: float = 1.0) -> float:
    """Damping ratio of one linear mode whose peak has this height: p / (2 sqrt(T^2 - 1)); nan if T is 1 or less.

    ``rigid`` replaces 1 (`Circumstances`).
    """
    return 0.5 * participation / sqrt(shape.peak**2 - rigid**2) if shape.peak > rigid else nan


class _Doubt(NamedTuple):
    grade: Grade
    text: str


@dataclass(frozen=True)
class _Curve:
    """Curve, its estimate and what is known besides, as the checks need them."""

    read: CurveDamping
    frequency: FloatArray
    magnitude: FloatArray
    known: Circumstances

    @property
    def zeta(self) -> float:
        return self.read.damping.zeta

    @property
    def shape(self) -> HalfPower:
        return self.read.shape

    @property
    def least_zeta(self) -> float:
        """Smaller of the damping ratios from the width and from the height of the peak."""
        return min(likely_damping(self.shape, self.known.participation)[0], self.zeta)

    @property
    def sweep_share(self) -> float:
        """Sweep rate relative to the ISO 7626-2 limit for the smaller damping ratio; 0 for steady motions."""
        motion = self.known.motion
        f_n = self.shape.f_n
        return 0.0 if motion is None else motion.rate_at(f_n) / sweep_rate_limit(f_n, self.least_zeta)

    @property
    def hasty(self) -> bool:
        """Whether a sweep is too fast for a linear peak as sharp as this one, so that the response rings."""
        return self.sweep_share > SLOW_ENOUGH

    @property
    def spread(self) -> float:
        """Relative difference between the half-power damping of envelope and spectra; nan if one of them has none.

        The spectra are averaged over `SMOOTHED` of the half-power width, since their ripple can hide the peak.
        """
        shape, spectrum = self.shape, self.known.spectrum
        if spectrum is None or not shape.complete:
            return nan
        step = (self.frequency[-1] - self.frequency[0]) / (len(self.frequency) - 1)
        half = min(len(spectrum) // 8, int(0.5 * SMOOTHED * (shape.f_high - shape.f_low) / step))
        count = 1 + 2 * half
        smooth = np.convolve(np.pad(spectrum, half, mode="edge"), np.full(count, 1.0 / count), "valid")
        return abs(half_power(self.frequency, smooth).zeta / shape.zeta - 1.0)


_Doubts = Iterator[_Doubt]
_RINGS = "the response rings; sweep more slowly, or use harmonic"


def _sweep_rate(curve: _Curve) -> _Doubts:
    if curve.known.motion is None:
        return
    text = sweep_warning(curve.known.motion, curve.shape, curve.known.participation)
    if text:
        yield _Doubt("invalid" if curve.sweep_share > TOO_FAST else "doubtful", text)


def _height(curve: _Curve) -> _Doubts:
    participation = curve.known.participation
    if participation is None:
        return
    expected = height_damping(curve.shape, participation, curve.known.rigid)
    factor = curve.zeta / expected
    if not isfinite(factor) or 1.0 / HEIGHT_FACTOR <= factor <= HEIGHT_FACTOR:
        return
    numbers = (
        f"zeta = {100 * curve.zeta:.3g} % by {curve.read.damping.method}, but {100 * expected:.3g} % from the height "
        f"of the peak, {participation:.2f}/(2 T)"
    )
    if factor > 1.0 and curve.hasty:
        yield _Doubt("invalid", f"{numbers}: {_RINGS}")
        return
    remedy = "use the peak and the friction work, or the damping versus amplitude from backbone"
    yield _Doubt("doubtful", f"{numbers}: one damping ratio does not describe this peak; {remedy}")


def _second_peak(curve: _Curve) -> _Doubts:
    highest = float(curve.magnitude.max())
    prominence = max(PROMINENCE, NOISE_OF_PEAK * curve.read.noise)
    tops, _ = find_peaks(curve.magnitude, height=SECOND_PEAK * highest, prominence=prominence * highest)
    others = [k for k in tops if curve.magnitude[k] < highest]
    if others:
        second = max(others, key=lambda k: curve.magnitude[k])
        text = (
            f"the curve has {len(others) + 1} peaks above {100 * SECOND_PEAK:.0f} % of the highest; the second, at "
            f"{curve.frequency[second]:.5g} Hz, reaches {100 * curve.magnitude[second] / highest:.0f} % of it"
        )
    elif curve.shape.note:
        text = curve.shape.note
    else:
        return
    if curve.hasty:
        yield _Doubt("invalid", f"{text}: {_RINGS}")
    else:
        yield _Doubt("doubtful", f"{text}: zeta describes only the highest; narrow the band to one resonance")


def _start(curve: _Curve) -> _Doubts:
    motion, shape = curve.known.motion, curve.shape
    if motion is None or not shape.complete:
        return
    first, flank = (-1, shape.f_high) if motion.downward else (0, shape.f_low)
    seconds = max(float(motion.time_of_frequency(flank)), 0.0)
    decay = np.exp(-2.0 * np.pi * curve.least_zeta * shape.f_n * seconds)
    rest = float(curve.magnitude[first] / shape.peak * decay)
    if rest > START:
        yield _Doubt(
            "doubtful",
            f"the sweep starts at {motion.f_start:.5g} Hz, on the flank of the peak at {shape.f_n:.5g} Hz, and the "
            f"transient of its start is still {100 * rest:.2g} % of the peak at the half-power point; set "
            "excitation.f_start further from the resonance",
        )


def _spectra(curve: _Curve) -> _Doubts:
    if curve.spread > SPREAD:
        yield _Doubt(
            "doubtful",
            f"the spectra of the same sweep give a half-power zeta that differs by {100 * curve.spread:.0f} %: the "
            "sweep is too fast for this peak, or the peak depends strongly on the amplitude; compare with a slower "
            "sweep or with harmonic",
        )


def _fold(curve: _Curve) -> _Doubts:
    if curve.known.several is None or not curve.shape.complete:
        return
    low, high = curve.known.several
    if high - low > FOLD * (curve.shape.f_high - curve.shape.f_low):
        yield _Doubt(
            "doubtful",
            f"between {low:.6g} and {high:.6g} Hz several periodic motions exist: sweeps up and down pass different "
            "peaks, and zeta is that of the largest motions",
        )


def _size(curve: _Curve) -> _Doubts:
    if curve.zeta > LARGEST_ZETA and curve.read.damping.method == HALF_POWER:
        yield _Doubt(
            "doubtful",
            f"zeta is {100 * curve.zeta:.0f} %: above {100 * LARGEST_ZETA:.0f} % half power is more than 7 % too high, "
            "and other modes contribute to the peak",
        )


def _points(curve: _Curve) -> _Doubts:
    shape = curve.shape
    if not shape.complete:
        return
    inside = int(np.count_nonzero((curve.frequency >= shape.f_low) & (curve.frequency <= shape.f_high)))
    if inside < FEWEST_POINTS:
        yield _Doubt(
            "doubtful", f"only {inside} points of the curve lie between the half-power points; narrow the band"
        )


_CHECKS = (_sweep_rate, _height, _second_peak, _start, _spectra, _fold, _size, _points)
