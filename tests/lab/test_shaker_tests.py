"""Transmissibility from records of a shaker test, against oscillators with known frequency and damping."""

from __future__ import annotations

from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.stats import binom

import wroll_fem as wf
from wroll_fem.errors import InputError
from wroll_fem.lab.examples import example_files
from wroll_fem.lab.shaker.random_trials import random_curve, suited_resolution
from wroll_fem.lab.shaker.sweep_trials import sweep_curve, swept
from wroll_fem.lab.shaker.synthetic import oscillator_tip
from wroll_fem.lab.shaker.trial import Trial
from wroll_fem.signals.random.random_motion import random_record
from wroll_fem.signals.sweeps import Chirp, LinearSweep, Sweep

F_N, ZETA, RATE = 120.0, 0.02, 1024.0
FAST = {"figures": False, "base_unit": "m/s^2", "tip_unit": "m/s^2"}


def random_trial(seed: int = 1, *, f_n: float = F_N, duration: float = 40.0, noise: float = 0.03) -> Trial:
    """Random trial: integrated at four times the sampling rate, with noise on the tip."""
    base = random_record([20.0, 300.0], 0.001, duration, 4.0 * RATE, seed=seed)
    tip = oscillator_tip(base, 0.25 / RATE, f_n, ZETA)[::4]
    base = base[::4]
    noisy = tip + noise * tip.std() * np.random.default_rng(seed).standard_normal(tip.size)
    return Trial(Path(f"random_{seed}"), base, noisy, 1.0 / RATE, 2, 2)


def swept_trial(motion: Sweep, seed: int = 1, noise: float = 1.0) -> Trial:
    base = motion.samples(0.25 / RATE)[1]
    tip = oscillator_tip(base, 0.25 / RATE, F_N, ZETA)[::4]
    rng = np.random.default_rng(seed)
    errors = noise * rng.standard_normal((2, tip.size))
    return Trial(Path("sweep"), base[::4] + 0.02 * errors[0], tip + 0.5 * errors[1], 1.0 / RATE, 2, 2)


def write(folder: Path, trial: Trial, name: str = "trial.npz", **other: Any) -> Path:
    path = folder / name
    time = np.arange(trial.base.size) * trial.dt
    np.savez(path, **({"time": time, "base": trial.base, "tip": trial.tip} | other))
    return path


def misses(repetitions: int) -> tuple[int, int]:
    """Repetitions in which f_n, and zeta, lie outside the 95 % interval of a random trial."""
    found = [0, 0]
    for seed in range(repetitions):
        trial = random_trial(seed, duration=20.0)
        resolution = suited_resolution([trial], None, "rational_fraction")
        read = random_curve([trial], resolution, None, "rational_fraction").read.damping
        found[0] += abs(read.f_n - F_N) > 1.96 * read.f_n_error
        found[1] += abs(read.zeta - ZETA) > 1.96 * read.zeta_error
    return found[0], found[1]


def test_the_truth_lies_inside_the_interval_of_random_trials() -> None:
    assert max(misses(20)) <= binom.ppf(0.99, 20, 0.10)  # at most 10 % outside


@pytest.mark.slow
def test_the_truth_lies_inside_the_interval_in_90_of_100_random_trials() -> None:
    assert max(misses(100)) <= 10


@pytest.mark.parametrize(
    "motion",
    [Chirp(5.0, 70.0, 190.0, 2.0), Chirp(5.0, 190.0, 70.0, 2.0), LinearSweep(5.0, 70.0, 190.0, 2.0)],
    ids=["up", "down", "linear"],
)
def test_a_sweep_gives_frequency_and_damping_of_the_oscillator(motion: Sweep) -> None:
    curve = sweep_curve([swept(swept_trial(motion), None)], "half_power")
    peak = F_N * sqrt((sqrt(1.0 + 8.0 * ZETA**2) - 1.0) / (4.0 * ZETA**2))
    found = curve.read.damping
    assert curve.quality.grade == "ok"
    assert abs(found.f_n - peak) < 2.6 * found.f_n_error  # 99 %
    assert abs(found.zeta - ZETA) < 2.6 * found.zeta_error
    assert found.f_n_error < 0.002 * F_N
    assert found.zeta_error < 0.03 * ZETA
    assert abs(curve.base_level / 5.0 - 1.0) < 0.01
    assert abs(curve.tip_level / (5.0 / (2.0 * ZETA)) - 1.0) < 0.02


def test_error_bars_of_sweeps_are_those_of_repetitions() -> None:
    motion = Chirp(5.0, 90.0, 150.0, 2.0)
    found = []
    for seed in range(10):
        read = sweep_curve([swept(swept_trial(motion, seed, noise=4.0), None)], "half_power").read.damping
        found.append((read.f_n, read.zeta, read.f_n_error, read.zeta_error))
    values = np.array(found)
    ratio = values[:, :2].std(axis=0, ddof=1) / values[:, 2:].mean(axis=0)
    assert (ratio > 0.36).all()  # chi-square of 9 degrees of freedom, 99.9 %
    assert (ratio < 1.76).all()


def test_quantity_and_unit_of_the_sensors_do_not_change_the_result(tmp_path: Path) -> None:
    trial = random_trial(2, noise=0.0)
    omega = 2.0 * np.pi * np.fft.rfftfreq(trial.base.size, trial.dt)
    omega[0] = 1e30  # no mean
    velocity = np.fft.irfft(np.fft.rfft(trial.tip) / (1j * omega), trial.tip.size)
    shift = np.fft.irfft(np.fft.rfft(trial.tip - trial.base) / -(omega**2), trial.tip.size)
    settings = FAST | {"band": (60.0, 240.0), "resolution": 0.5}
    plain = wf.lab.evaluate("transmissibility", [write(tmp_path, trial)], **settings)
    as_speed = write(tmp_path, trial, "speed.npz", tip=1e3 * velocity, base=trial.base / 9.80665)
    as_shift = write(tmp_path, trial, "shift.npz", tip=1e3 * shift)
    others = (
        wf.lab.evaluate("transmissibility", [as_speed], **(settings | {"tip_unit": "mm/s", "base_unit": "g"})),
        wf.lab.evaluate("transmissibility", [as_shift], **(settings | {"tip_unit": "mm"}), tip_relative=True),
    )
    for other in others:
        for name, least in (("f_n_hz", 1e-4), ("zeta", 5e-3), ("base_level_m_s2", 1e-6), ("tip_level_m_s2", 2e-3)):
            # the window of a segment, not the quantity, makes the difference: it leaks over 1.5 lines
            assert other.summary[name][0] == pytest.approx(plain.summary[name][0], rel=least), name
        flank = (plain.data["frequency"] < 90.0).values  # |T| is 1.3 to 2.3 there
        sizes = [np.hypot(one.data["family_real"], one.data["family_imag"]).values[0, flank] for one in (other, plain)]
        np.testing.assert_allclose(*sizes, rtol=0.03)


def test_the_example_gives_its_truth(tmp_path: Path) -> None:
    files = example_files("transmissibility", tmp_path / "records")
    truth = yaml.safe_load((tmp_path / "records" / "truth.yaml").read_text(encoding="utf-8"))
    found = wf.lab.evaluate("transmissibility", files, settings_file=tmp_path / "records" / "settings.yaml").summary
    assert found["base_motion"] == "random"
    assert found["trials"] == [3, 3, 3, 3]
    for k, one in enumerate(truth):
        assert abs(found["f_n_hz"][k] - one["f_n_hz"]) < 1.5 * found["f_n_interval_hz"][k]  # 99.7 %
        assert abs(found["zeta"][k] - one["zeta"]) < 1.5 * found["zeta_interval"][k]


def test_trials_that_differ_widen_the_interval_and_are_named(tmp_path: Path) -> None:
    files = [
        write(tmp_path, random_trial(k, f_n=f_n, duration=20.0), f"{k}.npz")
        for k, f_n in enumerate((118.0, 120.0, 122.0))
    ]
    found = wf.lab.evaluate("transmissibility", files, **FAST, resolution=0.6)
    assert found.summary["f_n_scatter_hz"][0] == pytest.approx(2.0, rel=0.02)
    assert found.summary["f_n_interval_hz"][0] == pytest.approx(4.303 * 2.0 / sqrt(3.0), rel=0.02)  # Student, n = 3
    assert any("scatter" in text and "changed between the trials" in text for text in found.warnings)


def test_folders_are_conditions_and_patterns_name_them(tmp_path: Path) -> None:
    for name in ("loose", "tight"):
        (tmp_path / name).mkdir()
    files = [write(tmp_path / name, random_trial(3, duration=10.0)) for name in ("loose", "tight")]
    settings = FAST | {"resolution": 1.0}
    assert wf.lab.evaluate("transmissibility", files, **settings).summary["conditions"] == ["loose", "tight"]
    rows = [{"files": ["tight/*"], "tension": 60.0}, {"files": ["loose/*"], "tension": 20.0, "level": 2.0}]
    found = wf.lab.evaluate("transmissibility", files, **settings, conditions=rows)
    assert found.summary["conditions"] == ["60 N", "20 N at 2 m/s²"]
    assert found.data["nominal_level"].values[1] == 2.0


def wrong(tmp_path: Path) -> dict[str, tuple[dict[str, Any], dict[str, Any]]]:
    """Message -> what stands in the file, and settings."""
    trial = random_trial(4, duration=10.0)
    time = np.arange(trial.base.size) * trial.dt
    gap, back, bad = time.copy(), time.copy(), trial.tip.copy()
    gap[5000:] += 0.2
    back[700] = back[600]
    bad[40] = np.nan
    half = time.size // 2
    turning = np.sin(2.0 * np.pi * np.cumsum(np.r_[np.linspace(30, 200, half), np.linspace(200, 30, half)]) * trial.dt)
    mixed = np.sin(2.0 * np.pi * 50.0 * time[: trial.base.size]) + 0.7 * trial.base / trial.base.std()
    return {
        "tip: no column 'tip'; did you mean 'top'": ({"tip": None, "top": trial.tip}, {}),
        "tip_unit: unknown unit 'gal'; use one of": ({}, {"tip_unit": "gal"}),
        "sample 41 is nan": ({"tip": bad}, {}),
        "gap of 0.201 s after": ({"time": gap}, {}),
        "time does not rise": ({"time": back}, {}),
        "too few to average": ({}, {"resolution": 0.2}),
        "are fewer than 2.5 times the highest frequency, 450": ({}, {"band": (20.0, 450.0)}),
        "band: must be two frequencies in ascending order": ({}, {"band": (80.0, 40.0)}),
        "lines of the spectra lie between": ({}, {"band": (100.0, 110.0), "resolution": 2.0}),
        "column 'base' is the time": ({}, {"time": "base"}),
        "no file matches '*.csv'": ({}, {"conditions": [{"files": ["*.csv"]}]}),
        "belongs to two conditions": ({}, {"conditions": [{"files": ["*"]}, {"files": ["*.npz"]}]}),
        "turns or stands still": ({"base": turning, "tip": turning}, {"method": "sweep"}),
        "the motion of the base is not recognised": ({"base": mixed}, {}),
        "all samples are equal": ({"base": np.ones_like(time)}, {}),
    }  # fmt: skip


@pytest.mark.parametrize("number", range(15))
def test_bad_records_are_refused_in_one_line(number: int, tmp_path: Path) -> None:
    message, (columns, settings) = list(wrong(tmp_path).items())[number]
    trial = random_trial(4, duration=10.0)
    columns = {"time": np.arange(trial.base.size) * trial.dt, "base": trial.base, "tip": trial.tip} | columns
    path = tmp_path / "bad.npz"
    np.savez(path, **{name: values for name, values in columns.items() if values is not None})
    with pytest.raises(InputError) as caught:
        wf.lab.evaluate("transmissibility", [path], **(FAST | settings))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_clipped_record_is_a_warning(tmp_path: Path) -> None:
    trial = random_trial(5, duration=10.0)
    path = write(tmp_path, trial, tip=np.clip(trial.tip, -1.0 * trial.tip.std(), trial.tip.std()))
    found = wf.lab.evaluate("transmissibility", [path], **FAST, resolution=1.0)
    assert any("may be clipped" in text for text in found.warnings)


def test_one_file_of_noise_and_one_sweep_are_told_apart(tmp_path: Path) -> None:
    first = write(tmp_path, random_trial(6, duration=10.0), "noise.npz")
    second = write(tmp_path, swept_trial(Chirp(5.0, 70.0, 190.0, 8.0)), "sweep.npz")
    with pytest.raises(InputError, match=r"noise.npz is random and .*sweep.npz a sweep"):
        wf.lab.evaluate("transmissibility", [first, second], **FAST)
    found = wf.lab.evaluate("transmissibility", [second], **FAST)
    assert found.summary["base_motion"] == "sweep"
