"""Oscillator with friction through `transmissibility`: f_n and zeta over the level against other computations.

The records are integrated with fine steps and get noise. Sweeps are compared with the first harmonic of the friction
(equivalent linearisation), random motions with a long record without noise.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.jenkins import backbone, integrate

import wroll_fem as wf
from wroll_fem.lab.shaker.random_trials import random_curve
from wroll_fem.lab.shaker.trial import Trial
from wroll_fem.signals.random.random_motion import random_record
from wroll_fem.signals.sweeps import Chirp
from wroll_fem.typing import FloatArray

pytestmark = pytest.mark.filterwarnings("ignore:Degrees of freedom", "ignore:invalid value")  # one record: no scatter

W0, SHARE, SLIP, ZETA = 2.0 * np.pi * 120.0, 0.2, 1e-5, 0.02  # stuck, rad/s; share of the element in the stiffness; m
FINE, KEEP = 16384.0, 8  # Hz; samples of the integration per sample of the record
ONSET = 2.0 * ZETA * W0**2 * SLIP  # base acceleration from which the resonance slides, m/s^2
LEVELS = (0.5, 3.0, 12.0)  # sticking, near the largest damping, sliding widely; relative to ONSET
UNITS = {"base_unit": "m/s^2", "tip_unit": "m/s^2"}
HARMONIC = 5e-4
"""Relative error of the first harmonic: the third one of this element is 1e-2 of it, and its square counts."""


def tip_of(base: FloatArray) -> FloatArray:
    """Absolute tip acceleration for the base acceleration at the fine steps; the last sample repeats its neighbour."""
    x = integrate(base[None], 1.0 / FINE, W0, SHARE, SLIP, ZETA, 0).motion[0]
    relative = np.zeros_like(x)
    relative[1:-1] = np.diff(x, 2) * FINE**2
    return relative + base


def noisy(folder: Path, name: str, base: FloatArray, seed: int, noise: float = 0.01) -> Path:
    """File of a trial with noise relative to the rms of each column."""
    rng = np.random.default_rng(seed)
    columns = {"base": base[::KEEP], "tip": tip_of(base)[::KEEP]}
    columns = {key: one + noise * one.std() * rng.standard_normal(one.size) for key, one in columns.items()}
    path = folder / f"{name}.npz"
    np.savez(path, time=np.arange(len(columns["base"])) * KEEP / FINE, **columns)
    return path


def linearised(level: float) -> tuple[float, float]:
    """Frequency of the peak, and half-power damping, of the first harmonic at a base acceleration."""
    a = np.geomspace(1e-3, 1e3, 6000) * SLIP
    stiff, zeta = backbone(a, W0, SHARE, SLIP, ZETA)
    friction = 2.0 * zeta * stiff**2 - 2.0 * ZETA * W0 * stiff  # loss stiffness without the dashpot
    frequency = np.arange(90.0, 150.0, 0.02)
    curve = []
    for omega in 2.0 * np.pi * frequency:
        dynamic = stiff**2 - omega**2 + 1j * (friction + 2.0 * ZETA * W0 * omega)
        at = float(np.interp(level, a * np.abs(dynamic), a))
        there = np.interp(at, a, dynamic.real) + 1j * np.interp(at, a, dynamic.imag)
        curve.append(abs(1.0 + omega**2 / there))
    found = wf.half_power(frequency, np.array(curve))
    return found.f_n, found.zeta


def test_sweeps_of_a_friction_oscillator_give_its_frequency_and_damping_over_the_level(tmp_path: Path) -> None:
    files, conditions = [], []
    for k, level in enumerate(LEVELS):
        base = Chirp(level * ONSET, 90.0, 150.0, 2.0).samples(1.0 / FINE)[1]
        files.append(noisy(tmp_path, f"sweep_{k}", base, k))
        conditions.append({"files": [files[-1].name], "level": level * ONSET})
    found = wf.lab.evaluate("transmissibility", files, conditions=conditions, figures=False, **UNITS).summary
    truth = np.array([linearised(level * ONSET) for level in LEVELS])
    error = np.abs(found["f_n_hz"] - truth[:, 0])
    assert (error < 2.6 / 1.96 * np.array(found["f_n_interval_hz"]) + HARMONIC * truth[:, 0]).all(), error
    error = np.abs(found["zeta"] - truth[:, 1])
    assert (error < 2.6 / 1.96 * np.array(found["zeta_interval"]) + 10.0 * HARMONIC * truth[:, 1]).all(), error
    assert max(np.array(found["f_n_interval_hz"]) / truth[:, 0]) < 5e-3  # the intervals say something
    assert max(np.array(found["zeta_interval"]) / truth[:, 1]) < 0.1
    assert truth[1, 1] > 1.5 * truth[0, 1]  # friction damps
    assert truth[0, 0] > truth[1, 0] > truth[2, 0]  # and softens


@pytest.mark.parametrize("level", LEVELS)
def test_random_records_of_a_friction_oscillator_give_those_of_a_long_record(level: float, tmp_path: Path) -> None:
    size = 3.0 * level * ONSET  # rms of a wide band drives the resonance less than a sine of this amplitude

    def motion(duration: float, seed: int) -> FloatArray:
        return size * random_record([40.0, 250.0], 1.0 / 210.0 / 9.80665**2, duration, FINE, seed=seed)

    files = [noisy(tmp_path, f"random_{k}", motion(20.0, k), k) for k in range(2)]
    settings = {"resolution": 1.0, "band": (60.0, 220.0), "figures": False} | UNITS
    found = wf.lab.evaluate("transmissibility", files, **settings).summary
    base = motion(300.0, 99)
    long = Trial(Path("long"), base[::KEEP], tip_of(base)[::KEEP], KEEP / FINE, 2, 2)
    truth = random_curve([long], 1.0, (60.0, 220.0), "rational_fraction").read.damping
    for name, value, own in (("f_n_hz", truth.f_n, truth.f_n_error), ("zeta", truth.zeta, truth.zeta_error)):
        interval = found[name.replace("_hz", "") + "_interval" + ("_hz" if name.endswith("_hz") else "")][0]
        assert abs(found[name][0] - value) < 2.6 * np.hypot(interval / 1.96, own), (name, found[name], value, interval)
        assert interval < 0.35 * value
