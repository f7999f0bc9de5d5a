"""Part of its steady peak that a swept resonance reaches, against exact swept responses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from support.oscillator import swept_oscillator

from reproduction.sweep_rate import attainment
from wroll_fem.errors import InputError
from wroll_fem.signals.attainment import LIMIT, _envelope, rate_for_attainment, swept_peak
from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.estimators import peak_transmissibility
from wroll_fem.signals.sweeps import Chirp
from wroll_fem.signals.transmissibility import demodulated


@pytest.mark.parametrize(("p", "delta"), [(0.05, 0.1), (0.574, 0.84), (2.0, -1.0), (5.0, 3.0)])
def test_the_envelope_is_its_integral(p, delta):
    real, imag = (
        quad(lambda s, part=part: part(np.exp(-(1 + 1j * delta) * s + 0.5j * p * s**2)), 0.0, 40.0, limit=2000)[0]
        for part in (np.real, np.imag)
    )
    assert _envelope(p, delta) == pytest.approx(np.hypot(real, imag), rel=1e-6)


def check_peak(seed):
    """Random damping of 0.3 to 5 % and a rate of 0.05 to 4 times the limit of ISO 7626-2, up or down."""
    rng = np.random.default_rng([35, seed])
    zeta, share = float(rng.uniform(0.003, 0.05)), float(np.exp(rng.uniform(np.log(0.05), np.log(4.0))))
    f_n, down = float(rng.uniform(5.0, 500.0)), bool(rng.integers(2))
    rate = share * sweep_rate_limit(f_n, zeta)
    exact = attainment(zeta, rate / f_n, -1 if down else 1)
    assert swept_peak(f_n, zeta, rate, downward=down).attainment == pytest.approx(exact, abs=2e-3)


QUICK = (0, 2, 5, 6, 11)
"""Seeds of rates of 0.37 and 3.5 times the limit upwards, and of 0.11, 1.0 and 0.14 times the limit downwards."""


@pytest.mark.parametrize("seed", QUICK)
def test_the_peak_is_that_of_exact_sweeps(seed):
    check_peak(seed)


@pytest.mark.slow
def test_the_peak_is_that_of_more_exact_sweeps():
    for seed in sorted({*range(12)} - {*QUICK}):
        check_peak(seed)


def test_the_lag_is_that_of_a_demodulated_sweep():
    f_n, zeta = 150.0, 0.01
    motion = Chirp(1.0, 110.0, 200.0, sweep_rate_limit(f_n, zeta))
    time, _, tip = swept_oscillator(motion, f_n, zeta)
    curve = demodulated(time, tip, motion, points=4001, window_cycles=1)
    size = np.hypot(curve["transmissibility_real"], curve["transmissibility_imag"]).values
    expected = swept_peak(f_n, zeta, motion.rate_oct_per_min)
    lag = (float(curve["frequency"][size.argmax()]) - f_n) / (zeta * f_n)
    assert lag == pytest.approx(expected.lag, abs=0.03)
    assert size.max() / peak_transmissibility(zeta)[1] == pytest.approx(expected.attainment, abs=3e-3)


def test_a_very_slow_sweep_reaches_the_steady_peak():
    assert swept_peak(100.0, 0.01, 1e-4 * sweep_rate_limit(100.0, 0.01) * 0.99).attainment == 1.0
    slow = swept_peak(100.0, 0.01, 2e-3 * sweep_rate_limit(100.0, 0.01))
    assert slow.attainment == pytest.approx(1.0 - 0.01 * 0.0143 / 25.0, abs=2e-6)
    assert slow.lag == pytest.approx(2.0 * 2e-3 * LIMIT, rel=1e-3)


@pytest.mark.parametrize("down", [False, True])
def test_the_rate_grows_with_the_square_of_the_damping(down):
    """Claim C35 of the thesis: slope 2 within 0.1."""
    zetas = np.array([0.005, 0.01, 0.02, 0.05])
    rates = [rate_for_attainment(150.0, zeta, downward=down) for zeta in zetas]
    assert np.polyfit(np.log(zetas), np.log(rates), 1)[0] == pytest.approx(2.0, abs=0.1)
    for zeta, rate in zip(zetas, rates, strict=True):
        assert swept_peak(150.0, zeta, rate, downward=down).attainment == pytest.approx(0.9, abs=1e-6)


@pytest.mark.parametrize("call", [lambda: swept_peak(0.0, 0.01, 2.0), lambda: swept_peak(10.0, np.nan, 2.0),
                                  lambda: rate_for_attainment(10.0, 0.01, 1.0)])  # fmt: skip
def test_wrong_values_are_refused(call):
    with pytest.raises(InputError):
        call()
