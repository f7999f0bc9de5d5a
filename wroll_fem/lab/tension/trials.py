r"""Tension of a winding machine at its settings: mean, scatter within a trial and between trials (thesis, Fig. 3.6).

Each trial i of a setting has a mean of its own, y_ij = T + b_i + w_ij: one-way random effects. The mean of the trials'
means has the standard error s/\sqrt{k}, with their standard deviation s and k - 1 degrees of freedom; it contains both
scatters. The variance between trials is the variance of the means, less the part that the scatter within explains,
which counts the correlation of the samples.

References
----------
.. [1] Searle, Casella, McCulloch (1992), Variance Components, chapter 3, doi:10.1002/9780470316856.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.numerics.inference import Estimate, linear_fit
from wroll_fem.typing import FloatArray

FEWEST = 20
"""Samples of a trial at least."""

DRIFT = 0.05
"""Relative change of the tension over a trial above which it is reported."""

TOGETHER = 0.01
"""Relative difference below which two settings of voltage or current are the same."""


class Trial(NamedTuple):
    """One trial.

    Attributes
    ----------
    voltage, current
        Voltage of the winding motor, V, and current of the membrane roller, A.
    mean
        Mean tension, N, with the error from the scatter within the trial.
    within
        Standard deviation within the trial, N.
    drift
        Change of the tension from start to end, N.
    source
        File, for messages.
    """

    voltage: float
    current: float
    mean: Estimate
    within: float
    drift: Estimate
    source: str = "trial"


@dataclass(frozen=True)
class Setting:
    """Tension at one voltage and current.

    Attributes
    ----------
    voltage, current
        V, A.
    trials
        Number of trials.
    mean
        Mean tension, N.
    within, between
        Standard deviation within a trial, and between the true means of trials, N; the latter is NaN for one trial.
    """

    voltage: float
    current: float
    trials: int
    mean: Estimate
    within: float
    between: float

    @property
    def scatter(self) -> float:
        """Standard deviation of a sample of any trial, N: the error bar of Fig. 3.6."""
        return float(np.hypot(self.within, 0.0 if np.isnan(self.between) else self.between))


def measure_trial(
    time: FloatArray, tension: FloatArray, voltage: float, current: float, *, skip: float = 0.0, source: str = "trial"
) -> Trial:
    """Evaluate a record of the tension.

    Parameters
    ----------
    time, tension
        (n,) s, N.
    voltage, current
        Settings of the trial, V, A.
    skip
        Time at the start and at the end that is left out, s.
    source
        File, for messages.

    Raises
    ------
    InputError
        If the time does not rise, or too few samples are left.
    """
    falls = np.flatnonzero(np.diff(time) <= 0.0)
    if falls.size:
        k = int(falls[0])
        raise InputError(
            f"time does not rise: sample {k + 2} is at {time[k + 1]:g} s, the one before at {time[k]:g} s",
            file=source, remedy="sort the record, or write the time with more digits",
        )  # fmt: skip
    used = (time >= time[0] + skip) & (time <= time[-1] - skip)
    if np.count_nonzero(used) < FEWEST:
        raise InputError(
            f"{np.count_nonzero(used)} samples beside skip = {skip:g} s at both ends", file=source, key="skip",
            remedy=f"lower skip; {FEWEST} samples are needed",
        )  # fmt: skip
    own, values = time[used], tension[used]
    mean = linear_fit({"mean": np.ones(len(own))}, values)["mean"]
    place = (own - own[0]) / (own[-1] - own[0]) - 0.5
    drift = linear_fit({"mean": np.ones(len(own)), "drift": place}, values)["drift"]
    return Trial(voltage, current, mean, float(np.std(values, ddof=1)), drift, source)


def settings_of(trials: Sequence[Trial], *, pooled: bool = False) -> list[Setting]:
    """Settings of all trials, by voltage, then current.

    Parameters
    ----------
    trials
        Trials of all settings.
    pooled
        Whether all settings share one standard deviation between trials: more degrees of freedom for few trials each.
    """
    groups = _grouped(trials)
    shared = _pooled(groups) if pooled else None
    return [_setting(group, shared) for group in groups]


def doubts(trials: Sequence[Trial], settings: Sequence[Setting]) -> list[str]:
    """Doubts about trials and settings, one sentence each."""
    found = []
    for trial in trials:
        low, high = trial.drift.interval()
        if abs(trial.drift.value) > DRIFT * abs(trial.mean.value) and low * high > 0.0:
            found.append(
                f"{trial.source}: the tension changes by {trial.drift.value:+.3g} N during the trial, mean "
                f"{trial.mean.value:.3g} N; the wraps are not wound at one tension"
            )
    single = [setting for setting in settings if setting.trials == 1]
    if single:
        listed = ", ".join(f"{one.voltage:g} V and {one.current:g} A" for one in single[:4])
        found.append(
            f"one trial at {listed}{' and others' if len(single) > 4 else ''}: the error has no scatter between "
            "trials and is too small; repeat the trial"
        )
    return found


def _grouped(trials: Sequence[Trial]) -> list[list[Trial]]:
    spans = [TOGETHER * (max(abs(getattr(t, name)) for t in trials) or 1.0) for name in ("voltage", "current")]

    def key(trial: Trial) -> tuple[int, int]:
        return round(trial.voltage / spans[0]), round(trial.current / spans[1])

    groups: dict[tuple[int, int], list[Trial]] = {}
    for trial in sorted(trials, key=key):
        groups.setdefault(key(trial), []).append(trial)
    return list(groups.values())


def _pooled(groups: Sequence[Sequence[Trial]]) -> tuple[float, float] | None:
    """Variance of the trials' means about those of their settings, and its degrees of freedom."""
    squares, freedom = 0.0, 0
    for group in groups:
        means = np.array([trial.mean.value for trial in group])
        squares, freedom = squares + float(np.sum((means - means.mean()) ** 2)), freedom + len(group) - 1
    return (squares / freedom, float(freedom)) if freedom else None


def _setting(group: Sequence[Trial], shared: tuple[float, float] | None) -> Setting:
    means = np.array([trial.mean.value for trial in group])
    count = len(group)
    within = float(np.sqrt(np.mean([trial.within**2 for trial in group])))
    voltage, current = (float(np.median([getattr(t, name) for t in group])) for name in ("voltage", "current"))
    if shared is None and count == 1:
        return Setting(voltage, current, 1, group[0].mean, within, float("nan"))
    variance, freedom = shared if shared is not None else (float(np.var(means, ddof=1)), count - 1.0)
    explained = float(np.mean([trial.mean.error**2 for trial in group]))
    between = float(np.sqrt(max(0.0, variance - explained)))
    return Setting(
        voltage,
        current,
        count,
        Estimate(float(means.mean()), float(np.sqrt(variance / count)), freedom),
        within,
        between,
    )
