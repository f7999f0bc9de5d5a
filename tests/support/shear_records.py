"""Records of shear tests with known truth: the program's own test and friction laws, sampled, with seeded noise."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.signal import lfilter

from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.tribology import ShearTest, run_shear_test
from wroll_fem.typing import FloatArray

TEST = ShearTest(interfaces=5, normal_force=200.0)


def correlated(rng: np.random.Generator, size: float, count: int, phi: float = 0.6) -> FloatArray:
    """Noise (count,) of standard deviation ``size`` with the correlation ``phi`` from sample to sample."""
    driving = size * np.sqrt(1.0 - phi**2) * rng.standard_normal(count + 100)
    return np.asarray(lfilter([1.0], [1.0, -phi], driving))[100:]


@cache
def _curve(test: ShearTest) -> tuple[FloatArray, FloatArray]:
    # 45 steps up to 1.5 times the onset of slip: step 30 is the onset, and the curve is straight between the steps
    data = run_shear_test(test, steps=45)
    return data["platen_displacement"].values, data["shear_force"].values


def ramp(
    rng: np.random.Generator | None = None, *, test: ShearTest = TEST, count: int = 900, drop: float = 0.0,
    force_noise: float = 0.3, length_noise: float = 2e-8, duration: float = 60.0,
) -> ShearRecord:  # fmt: skip
    """Loading up to 1.5 times the displacement at slip; afterwards the force is lower by ``drop`` (N)."""
    x, force = _curve(test)
    at = np.linspace(0.0, 45.0, count)
    platen, measured = np.interp(at, np.arange(46), x), np.interp(at, np.arange(46), force)
    measured = measured - drop * (at > 30.0)
    if rng is not None:
        measured = measured + correlated(rng, force_noise, count)
        platen = platen + length_noise * rng.standard_normal(count)
    return ShearRecord(np.linspace(0.0, duration, count), platen, measured, test.normal_force)
