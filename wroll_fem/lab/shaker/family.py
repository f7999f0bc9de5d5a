"""Family of transmissibility curves over level and tension: Dataset, summary and warnings.

A reading has two errors: the standard error of the estimator on the curve of all trials, and the scatter of the trials,
whose mean has the standard error s / sqrt(n). The 95 % interval takes the larger of both, with Student's factor for the
scatter of n trials.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan, sqrt
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import t as student

from wroll_fem.lab.shaker.conditions import Condition
from wroll_fem.lab.shaker.curve import Curve
from wroll_fem.typing import FloatArray

NORMAL_95 = 1.96
"""Half width of the 95 % interval of a normal distribution, standard deviations."""

FEWEST_TRIALS = 3
"""Smallest number of trials whose scatter enters the interval; Student's factor of two trials is 12.7."""

LARGE_SCATTER = 3.0
"""Scatter of the trials, relative to the standard error of one trial, above which a warning is given."""


@dataclass(frozen=True, eq=False)
class Measured:
    """Curves of one condition.

    Attributes
    ----------
    condition
        Files, level and tension.
    whole
        Curve of all trials.
    each
        Curve of each trial.
    """

    condition: Condition
    whole: Curve
    each: tuple[Curve, ...]

    def scatter(self, name: str) -> float:
        """Standard deviation of `f_n` or `zeta` over the trials; nan for one trial."""
        values = np.array([getattr(curve, name) for curve in self.each])
        values = values[np.isfinite(values)]
        return float(values.std(ddof=1)) if values.size > 1 else nan

    def error(self, name: str) -> float:
        """Standard error of `f_n` or `zeta` by the estimator; nan without a reading."""
        value = getattr(self.whole.read.damping, f"{name}_error")
        return float(value) if isfinite(getattr(self.whole, name)) else nan

    def interval(self, name: str) -> float:
        """Half width of the 95 % interval of `f_n` or `zeta`."""
        own = NORMAL_95 * self.error(name)
        count = sum(isfinite(getattr(curve, name)) for curve in self.each)
        if count < FEWEST_TRIALS:
            return own
        spread = float(student.ppf(0.975, count - 1)) * self.scatter(name) / sqrt(count)
        return spread if not isfinite(own) else max(own, spread)


def family_dataset(measured: Sequence[Measured], method: str) -> xr.Dataset:
    """Dataset of the family: curves on a common grid, and readings per condition and per trial."""
    grid = _grid([one.whole for one in measured])
    curves = np.array([one.whole.on(grid) for one in measured])
    per_condition = {
        "condition_name": [one.condition.name for one in measured],
        "tension": [one.condition.tension for one in measured],
        "nominal_level": [one.condition.level for one in measured],
        "base_level": [one.whole.base_level for one in measured],
        "tip_level": [one.whole.tip_level for one in measured],
        "condition_f_n": [one.whole.f_n for one in measured],
        "condition_zeta": [one.whole.zeta for one in measured],
        "condition_peak": [one.whole.peak for one in measured],
        "zeta_grade": [one.whole.quality.grade for one in measured],
    }
    for name in ("f_n", "zeta"):
        per_condition |= {
            f"condition_{name}_error": [one.error(name) for one in measured],
            f"condition_{name}_scatter": [one.scatter(name) for one in measured],
            f"condition_{name}_interval": [one.interval(name) for one in measured],
        }
    trials = [
        (k, path, curve)
        for k, one in enumerate(measured)
        for path, curve in zip(one.condition.files, one.each, strict=True)
    ]
    per_trial = {
        "trial_file": [str(path) for _, path, _ in trials],
        "trial_condition": [k for k, _, _ in trials],
        "trial_f_n": [curve.f_n for _, _, curve in trials],
        "trial_zeta": [curve.zeta for _, _, curve in trials],
        "trial_base_level": [curve.base_level for _, _, curve in trials],
    }
    data: dict[str, Any] = {name: ("condition", np.array(values)) for name, values in per_condition.items()}
    data |= {name: ("trial", np.array(values)) for name, values in per_trial.items()}
    data |= {"family_real": (_AXES, curves.real.copy()), "family_imag": (_AXES, curves.imag.copy())}
    if method == "random":
        data |= {
            "family_coherence": (_AXES, np.array([_on(grid, one.whole, one.whole.coherence) for one in measured])),
            "family_error": (_AXES, np.array([_on(grid, one.whole, one.whole.error) for one in measured])),
        }
    coordinates = {"frequency": grid, "condition": np.arange(len(measured)), "trial": np.arange(len(trials))}
    return xr.Dataset(data, coords=coordinates, attrs={"method": method})


_AXES = ("condition", "frequency")


def _grid(curves: Sequence[Curve]) -> FloatArray:
    """Frequencies from the lowest to the highest of all curves, in the finest steps."""
    if all(np.array_equal(one.frequency, curves[0].frequency) for one in curves):
        return curves[0].frequency
    step = min(float(np.diff(one.frequency).min()) for one in curves)
    low, high = min(one.frequency[0] for one in curves), max(one.frequency[-1] for one in curves)
    return np.asarray(np.linspace(low, high, round((high - low) / step) + 1))


def _on(grid: FloatArray, curve: Curve, values: FloatArray | None) -> FloatArray:
    if values is None:
        return np.full(grid.size, np.nan)
    return np.interp(grid, curve.frequency, values, left=np.nan, right=np.nan)


def family_summary(measured: Sequence[Measured], method: str) -> dict[str, Any]:
    """Entries of summary.json: lists over the conditions."""
    found: dict[str, Any] = {
        "base_motion": method,
        "conditions": [one.condition.name for one in measured],
        "trials": [len(one.each) for one in measured],
        "tension_n": [one.condition.tension for one in measured],
        "base_level_m_s2": [one.whole.base_level for one in measured],
        "tip_level_m_s2": [one.whole.tip_level for one in measured],
        "f_n_hz": [one.whole.f_n for one in measured],
        "f_n_interval_hz": [one.interval("f_n") for one in measured],
        "f_n_error_hz": [one.error("f_n") for one in measured],
        "f_n_scatter_hz": [one.scatter("f_n") for one in measured],
        "zeta": [one.whole.zeta for one in measured],
        "zeta_interval": [one.interval("zeta") for one in measured],
        "zeta_error": [one.error("zeta") for one in measured],
        "zeta_scatter": [one.scatter("zeta") for one in measured],
        "zeta_quality": [one.whole.quality.grade for one in measured],
        "zeta_method": [one.whole.read.damping.method for one in measured],
        "peak_transmissibility": [one.whole.peak for one in measured],
        "skewness": [one.whole.read.shape.skewness for one in measured],
    }
    if method == "random":
        found["psd_resolution_hz"] = [one.whole.resolution for one in measured]
        found["psd_averages"] = [one.whole.averages for one in measured]
    return found


def family_doubts(one: Measured) -> list[str]:
    """Warnings about one condition, each with its remedy."""
    found = list(one.whole.quality.reasons)
    count = len(one.each)
    for name, words in (("f_n", "resonance frequencies"), ("zeta", "damping ratios")):
        single = one.error(name) * sqrt(count)  # expected of one trial
        if count >= FEWEST_TRIALS and one.scatter(name) > LARGE_SCATTER * single > 0.0:
            found.append(
                f"the {words} of its {count} trials scatter {one.scatter(name) / single:.1f} times as much as noise "
                "explains: the roll or the set-up changed between the trials; look at them one by one"
            )
    return found
