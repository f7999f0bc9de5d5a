"""Trials of a winding machine: means, scatter within and between trials, and what is doubtful."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.simulated import correlated
from wroll_fem.lab.tension.trials import Trial, doubts, measure_trial, settings_of
from wroll_fem.numerics.inference import Estimate

TIME = np.arange(0.0, 30.0, 0.05)


def trial(mean: float, voltage: float = 6.0, current: float = 0.5, error: float = 0.1) -> Trial:
    return Trial(voltage, current, Estimate(mean, error, 100.0), 1.5, Estimate(0.0, 0.1, 100.0))


def test_setting_is_the_mean_of_its_trials_with_their_scatter() -> None:
    (found,) = settings_of([trial(39.0), trial(40.0), trial(42.0)])
    assert found.mean.value == pytest.approx(121.0 / 3.0)
    assert found.mean.error == pytest.approx(np.std([39.0, 40.0, 42.0], ddof=1) / np.sqrt(3.0))
    assert found.mean.freedom == 2.0
    assert found.between == pytest.approx(np.sqrt(np.var([39.0, 40.0, 42.0], ddof=1) - 0.1**2))
    assert found.scatter == pytest.approx(np.hypot(1.5, found.between))


def test_scatter_that_the_trials_explain_is_no_scatter_between_them() -> None:
    (found,) = settings_of([trial(39.9, error=0.2), trial(40.1, error=0.2)])
    assert found.between == 0.0
    assert found.mean.error > 0.0


def test_pooled_settings_share_their_degrees_of_freedom() -> None:
    trials = [trial(level + off, current=level / 40.0) for level in (20.0, 40.0, 60.0) for off in (-1.0, 0.0, 1.0)]
    for found in settings_of(trials, pooled=True):
        assert found.mean.freedom == 6.0
        assert found.mean.error == pytest.approx(1.0 / np.sqrt(3.0))
    single = settings_of([*trials, trial(80.0, current=2.0)], pooled=True)[-1]
    assert (single.trials, single.mean.error) == (1, pytest.approx(1.0))


def test_settings_are_sorted_and_told_apart_by_voltage_and_current() -> None:
    trials = [trial(1.0, v, c) for v in (6.0, 2.0) for c in (1.0, 0.0, 0.2) for _ in range(2)]
    found = settings_of(trials)
    assert [(one.voltage, one.current) for one in found] == [(v, c) for v in (2.0, 6.0) for c in (0.0, 0.2, 1.0)]
    assert all(one.trials == 2 for one in found)


def test_variances_within_and_between_are_recovered() -> None:
    rng = np.random.default_rng(1)
    trials = [
        measure_trial(TIME, 40.0 + 0.8 * rng.standard_normal() + correlated(rng, 1.5, len(TIME), 0.9), 6.0, 0.5)
        for _ in range(150)
    ]
    (found,) = settings_of(trials)
    assert found.within == pytest.approx(1.5, rel=0.03)
    assert found.between == pytest.approx(0.8, rel=0.2)  # 149 degrees of freedom, and 0.27 N from the scatter within
    # the samples are correlated: 600 of them are worth some 600 x 0.1/1.9 = 32
    assert np.mean([one.mean.error for one in trials]) == pytest.approx(1.5 / np.sqrt(600 * 0.1 / 1.9), rel=0.1)


def test_skip_leaves_out_start_and_end() -> None:
    tension = np.where((TIME < 3.0) | (TIME > 27.0), 0.0, 40.0)
    assert measure_trial(TIME, tension, 6.0, 0.5, skip=3.5).mean.value == pytest.approx(40.0)
    with pytest.raises(InputError, match=r"skip: 10 samples beside skip = 14.75 s at both ends"):
        measure_trial(TIME, tension, 6.0, 0.5, skip=14.75)


def test_drift_and_single_trials_are_reported() -> None:
    rng = np.random.default_rng(2)
    drifting = measure_trial(TIME, 40.0 + 0.2 * TIME + rng.standard_normal(len(TIME)), 6.0, 0.5, source="a.csv")
    found = doubts([drifting], settings_of([drifting]))
    assert "a.csv: the tension changes by +5." in found[0]
    assert "one trial at 6 V and 0.5 A" in found[1]
    assert drifting.drift.value == pytest.approx(0.2 * (TIME[-1] - TIME[0]), abs=4.0 * drifting.drift.error)


def test_time_that_does_not_rise_is_refused() -> None:
    time = TIME.copy()
    time[7] = time[6]
    with pytest.raises(InputError, match=r"time does not rise: sample 8 is at 0.3 s"):
        measure_trial(time, np.ones(len(time)), 6.0, 0.5)
