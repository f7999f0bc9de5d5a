"""Upward and downward sweeps of a leaning resonance beside the folded curve of harmonic balance."""

from __future__ import annotations

import numpy as np
import pytest

import wroll_fem as wf

LOW, HIGH, SECONDS = 7.5, 15.0, 45.0
RINGING = 0.75
"""Distance to a fold, Hz, within which the jump of a sweep rings."""


@pytest.fixture(scope="module")
def duffing() -> wf.OwnStructure:
    """Oscillator of 10 Hz with a hardening spring and 3 % damping."""
    stiffness = (2.0 * np.pi * 10.0) ** 2
    spring = wf.joints.Spring(at=0, coefficients=(0.0, 0.0, 6e7), length=5e-3)
    return wf.structure(np.array([[stiffness]]), np.eye(1), [spring], damping=0.03)


def magnitude(result: wf.Result) -> tuple[np.ndarray, np.ndarray]:
    data = result.data
    return data["frequency"].values, np.hypot(data["transmissibility_real"], data["transmissibility_imag"]).values


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
@pytest.mark.parametrize("linear", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_sweeps_follow_their_branches_of_a_fold(duffing, linear):
    """Outside the fold both agree with the curve to 2 % of its peak; within it they are on their branches."""
    rate = {"ramp_cycles": 20, "rate_hz_per_s": (HIGH - LOW) / SECONDS}
    if not linear:
        rate = {"ramp_cycles": 20, "rate_oct_per_min": 60.0 * np.log2(HIGH / LOW) / SECONDS}
    f, T = magnitude(duffing.run_harmonic(wf.Chirp(f_start=LOW, f_end=HIGH, amplitude=1.5, **rate)))
    upper = int(np.flatnonzero(np.diff(f) < 0.0)[0])
    lower = int(np.flatnonzero(np.diff(f) < 0.0)[-1]) + 1
    folds = f[lower], f[upper]
    assert folds[1] - folds[0] > 0.1
    steps = wf.Integrator(steps_per_cycle=40)
    up, down = (
        magnitude(duffing.run_sweep(wf.Chirp(f_start=a, f_end=b, amplitude=1.5, **rate), integrator=steps))
        for a, b in ((LOW, HIGH), (HIGH, LOW))
    )
    for frequency, size in (up, down):
        left, right = frequency < folds[0] - RINGING, frequency > folds[1] + RINGING
        assert left.sum() > 200
        assert right.sum() > 50
        np.testing.assert_allclose(
            size[left], np.interp(frequency[left], f[: upper + 1], T[: upper + 1]), atol=0.02 * T.max()
        )
        np.testing.assert_allclose(size[right], np.interp(frequency[right], f[lower:], T[lower:]), atol=0.02 * T.max())
    middle = 0.5 * (folds[0] + folds[1])
    high, low = (np.interp(middle, *curve) for curve in (up, down))
    assert high == pytest.approx(np.interp(middle, f[: upper + 1], T[: upper + 1]), rel=0.02)
    assert low == pytest.approx(np.interp(middle, f[lower:], T[lower:]), rel=0.05)
