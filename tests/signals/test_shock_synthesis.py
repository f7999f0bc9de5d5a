"""Synthesis of a base motion from its shock response spectrum."""

from __future__ import annotations

import numpy as np
import pytest

import wroll_fem as wf
from wroll_fem.errors import InputError
from wroll_fem.signals.shock.synthesis import spectrum_error_db, synthesise_shock
from wroll_fem.signals.shock.table import SpectrumTable, largest_ratio

G = 9.80665


def table(frequency, level_g, q=10.0):
    return SpectrumTable(tuple(map(float, frequency)), tuple(G * a for a in level_g), q)


TABLES = [
    table((20, 200, 1000), (5, 100, 100)),
    table((20, 200, 400, 1000), (8, 100, 100, 60)),
    table((10, 100), (10, 10), 5.0),
    table((50, 300, 800), (3, 40, 40), 25.0),
]


@pytest.mark.parametrize("wanted", TABLES)
def test_synthesised_motion_has_its_spectrum_and_stands_still_at_the_end(wanted):
    """Within 1.5 dB at every sixth octave, computed from samples twice as fine as those of the iteration."""
    motion = synthesise_shock(wanted, seed=4, before=0.01, after=0.05)
    lines = wanted.lines()
    assert np.all(lines[1:] / lines[:-1] <= 2.0 ** (1 / 6) * (1 + 1e-12))
    dt = 1.0 / (40.0 * lines[-1])
    time = dt * np.arange(int(motion.duration / dt) + 1)
    base = motion.acceleration(time)
    found = wf.signals.shock_spectrum(base, dt, lines, wanted.q)
    assert np.abs(20.0 * np.log10(found / wanted.at(lines))).max() < 1.5
    assert np.abs(spectrum_error_db(motion, wanted)[1]).max() < 1.5
    velocity = np.cumsum(base) * dt
    displacement = np.cumsum(velocity) * dt
    assert abs(velocity[-1]) < 1e-6 * np.abs(velocity).max()
    assert abs(displacement[-1]) < 1e-4 * np.abs(displacement).max()
    assert np.all(base[time < 0.01] == 0.0)
    assert np.all(base[time > motion.end] == 0.0)
    assert motion.amplitude == pytest.approx(np.abs(base).max(), rel=0.02)
    power = np.cumsum(np.abs(np.fft.rfft(base)) ** 2)
    share = np.interp(motion.highest_frequency_hz, np.fft.rfftfreq(base.size, dt), power / power[-1])
    assert share == pytest.approx(0.99, abs=6e-3)  # lines 4 Hz apart


def test_same_seed_gives_the_same_motion_and_another_seed_another():
    time = np.linspace(0.0, 0.2, 500)
    one, again, other = (synthesise_shock(TABLES[2], seed=seed).acceleration(time) for seed in (1, 1, 2))
    assert np.array_equal(one, again)
    assert not np.allclose(one, other, atol=0.1)


def test_no_random_record_exceeds_the_largest_ratio_of_two_responses():
    """Seed 5: noise, tones and pulses; the limit is proven, so that not one of the pairs may exceed it."""
    rng = np.random.default_rng(5)
    time = 1e-3 * np.arange(3000)
    closest = 0.0
    for q in (2.0, 10.0):
        f1 = 20.0
        for ratio in (0.25, 0.8, 1.3, 4.0):
            records = [rng.normal(size=3000), np.sign(np.sin(2 * np.pi * f1 * time)), np.exp(-10 * time), time < 0.02]
            records.append(np.sign(np.sin(2 * np.pi * f1 * ratio * time)))
            for record in records:
                one, two = wf.signals.shock_spectrum(record, 1e-3, [f1, ratio * f1], q)
                closest = max(closest, two / one / largest_ratio(ratio, q))
    assert 0.5 < closest <= 1.0


def test_no_fall_is_deeper_than_a_square_wave_at_resonance():
    """From low to very high frequencies, 4 Q / pi and 1 for the static response: the limit of the closed form."""
    assert largest_ratio(1e-3, 20.0) == pytest.approx(4.0 * 20.0 / np.pi, rel=0.05)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: synthesise_shock(table((10, 100, 2000), (5, 500, 5))), r"no shock has this spectrum.*flatten"),
        (lambda: synthesise_shock(table((10, 20, 100), (0.001, 10, 10))), r"no shock has this spectrum.*flatten"),
        (lambda: synthesise_shock(table((20, 200, 500), (10, 500, 60))), r"no motion was found within 1.5 dB"),
        (lambda: table((10, 10, 20), (1, 1, 1)), "does not ascend"),
        (lambda: table((10, 20), (1, 0)), "excitation.srs.acceleration"),
        (lambda: table((10,), (1,)), "two rows"),
        (lambda: table((10, 20), (1, 1, 1)), "2 frequencies and 3"),
        (lambda: table((10, 20), (1, 1), 0.5), "excitation.srs.q"),
    ],
)
def test_spectrum_that_no_shock_has_is_refused_in_one_line(make, text):
    with pytest.raises(InputError, match=text) as error:
        make()
    assert "\n" not in str(error.value)
