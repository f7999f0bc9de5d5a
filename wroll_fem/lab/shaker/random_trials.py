"""Trials with a random motion of the base: pooled spectra, H1 and coherence, frequency and damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite, nan

import numpy as np
from scipy.integrate import trapezoid

from wroll_fem.errors import InputError
from wroll_fem.lab.shaker.curve import Curve
from wroll_fem.lab.shaker.trial import Trial, check_rate, to_acceleration
from wroll_fem.signals.quality import Circumstances, judge
from wroll_fem.signals.random.h1_damping import damping_of_h1
from wroll_fem.signals.random.welch import Spectra, averaged_spectra, peak_bias, wanted_resolution

BIAS, LARGEST_BIAS = 0.0133, 0.027
"""Part of the peak of a PSD that the resolution may take: wanted by `auto`, and the largest without a warning."""

FEWEST_AVERAGES, FIRST_SEGMENTS = 8, 16
"""Smallest number of segments with which `auto` still refines the resolution, and number of those of the first pass."""

FEWEST_LINES = 32
"""Smallest number of lines in the band that `auto` chooses."""

QUIET = 0.01
"""PSD of the base, relative to its median where it moves, below which a line is outside the band."""

COHERENT = 0.8
"""Mean coherence between the half-power points below which a warning is given."""

HANN_REACH = 1.5
"""Lines next to the ends of the band that are left out: there the Hann window averages over frequencies outside."""


def acceleration_spectra(trial: Trial, resolution: float) -> Spectra:
    """Averaged spectra of base and absolute tip acceleration of a trial.

    Other quantities are differentiated line by line, and a relative tip is added to the base as spectra.

    Raises
    ------
    InputError
        If the record is too short for the resolution (Hz).
    """
    try:
        raw = averaged_spectra(trial.base, trial.tip, trial.dt, resolution)
    except InputError as error:
        error.file = str(trial.path)
        raise
    f = raw.frequency
    x, y = to_acceleration(f, trial.base_order), to_acceleration(f, trial.tip_order)
    base, tip, cross = np.abs(x) ** 2 * raw.base, np.abs(y) ** 2 * raw.response, x.conj() * y * raw.cross
    if trial.relative:
        tip, cross = tip + base + 2.0 * cross.real, cross + base
    return Spectra(f, base, tip, cross, raw.averages)


def pooled(spectra: Sequence[Spectra]) -> Spectra:
    """Spectra of several trials, averaged with their numbers of averages as weights."""
    total = sum(one.averages for one in spectra)
    base, response, cross = (
        sum(one.averages / total * getattr(one, name) for one in spectra) for name in ("base", "response", "cross")
    )
    return Spectra(spectra[0].frequency, np.asarray(base), np.asarray(response), np.asarray(cross), total)


def moving_band(spectra: Spectra) -> tuple[float, float]:
    """Lowest and highest frequency, Hz, between which the base moves."""
    active = spectra.base > 1e-4 * spectra.base.max()
    level = float(np.median(spectra.base[active]))
    at = np.flatnonzero(spectra.base > QUIET * level)
    if not at.size:
        raise InputError("the base does not move", key="base", remedy="give another column, or set band")
    return float(spectra.frequency[at[0]]), float(spectra.frequency[at[-1]])


def random_curve(trials: Sequence[Trial], resolution: float, band: tuple[float, float] | None, method: str) -> Curve:
    """Curve of one condition from the spectra of its trials, or of one trial.

    Parameters
    ----------
    trials
        Trials with the same sampling rate.
    resolution
        Distance between the lines, Hz.
    band
        Lowest and highest frequency, Hz; None for that in which the base moves.
    method
        Estimator, a key of `ESTIMATORS`.

    Raises
    ------
    InputError
        If a record is too short, sampled too slowly for the band, or the trials differ in their sampling rate.
    """
    for trial in trials:
        if abs(trial.dt / trials[0].dt - 1.0) > 1e-6:
            raise InputError(
                f"{trial.rate:.6g} samples per second, and {trials[0].rate:.6g} in {trials[0].path}",
                file=str(trial.path), remedy="give trials of one condition the same rate, or make two conditions",
            )  # fmt: skip
        if band is not None:
            check_rate(trial, band[1])
    whole = pooled([acceleration_spectra(trial, resolution) for trial in trials])
    low, high = band if band is not None else moving_band(whole)
    edge = HANN_REACH * whole.resolution
    spectra = whole.within(low + edge, high - edge) if band is None else whole.within(low, high)
    if len(spectra.frequency) < FEWEST_LINES // 2:
        raise InputError(
            f"only {len(spectra.frequency)} lines of the spectra lie between {low:.4g} and {high:.4g} Hz",
            file=str(trials[0].path), key="resolution",
            remedy=f"give a resolution of {(high - low) / FEWEST_LINES:.2g} Hz or finer, or a wider band",
        )  # fmt: skip
    read = damping_of_h1(spectra, method)
    f, h1 = spectra.frequency, spectra.h1_corrected
    quality = judge(read, f, np.abs(h1), Circumstances())
    base, tip = (float(np.sqrt(trapezoid(psd, f))) for psd in (spectra.base, spectra.response))
    return Curve(
        f, h1, read, quality, base, tip, coherence=spectra.coherence, error=spectra.h1_error,
        resolution=spectra.resolution, averages=spectra.averages,
    )  # fmt: skip


def suited_resolution(trials: Sequence[Trial], band: tuple[float, float] | None, method: str) -> float:
    """Resolution, Hz, that suits the resonance of one condition: fine enough for its peak, with enough averages."""
    shortest = min(trial.duration for trial in trials)
    resolution = 0.5 * (FIRST_SEGMENTS + 1) / shortest
    finest = 0.5 * (FEWEST_AVERAGES + 1) / shortest
    for _ in range(3):
        curve = random_curve(trials, resolution, band, method)
        f_n, zeta = curve.f_n, curve.read.damping.zeta
        if not (isfinite(f_n) and isfinite(zeta) and zeta > 0.0):
            return resolution
        coarsest = float(np.ptp(curve.frequency)) / FEWEST_LINES
        resolution = max(min(wanted_resolution(f_n, zeta, BIAS), coarsest), finest)
    return resolution


def random_doubts(curve: Curve) -> list[str]:
    """Warnings about resolution and coherence of a curve, each with its remedy."""
    found = []
    f_n, zeta = curve.f_n, curve.read.damping.zeta
    bias = peak_bias(curve.resolution, f_n, zeta) if isfinite(f_n) and zeta > 0.0 else nan
    if bias > LARGEST_BIAS:
        finer = wanted_resolution(f_n, zeta, LARGEST_BIAS)
        found.append(
            f"the lines of the spectra, {curve.resolution:.3g} Hz apart, are coarse for a half-power width of "
            f"{2.0 * zeta * f_n:.3g} Hz: H1 is corrected by more than is certain; set resolution to {finer:.2g} Hz or "
            f"less, with records of {0.5 * (FEWEST_AVERAGES + 1) / finer:.3g} s or more"
        )
    shape = curve.read.shape
    if shape.complete and curve.coherence is not None:
        inside = (curve.frequency >= shape.f_low) & (curve.frequency <= shape.f_high)
        mean = float(curve.coherence[inside].mean()) if inside.any() else nan
        if mean < COHERENT:
            found.append(
                f"the coherence at the resonance is {mean:.2f}: noise, a nonlinear roll, or too coarse lines; "
                "average more trials, or use a sweep"
            )
    return found


def with_doubts(curve: Curve) -> Curve:
    """Curve whose quality also has the doubts about its spectra."""
    doubts = random_doubts(curve)
    if not doubts:
        return curve
    grade = "doubtful" if curve.quality.grade == "ok" else curve.quality.grade
    return replace(curve, quality=replace(curve.quality, grade=grade, reasons=(*curve.quality.reasons, *doubts)))
