r"""Random records: rms, PSD, band, ends, distribution and crest factor against the PSD table."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch

import wroll_fem as wf
from wroll_fem.errors import InputError
from wroll_fem.signals.random.psd import NEGLIGIBLE, PsdTable, duration_problem, line_orders
from wroll_fem.signals.random.random_motion import RandomMotion, random_lines
from wroll_fem.signals.sampled_motion import SampledMotion

SHIPPED = ([20.0, 300.0], [0.01, 0.01])
SPECIFICATION = ([20.0, 80.0, 350.0, 2000.0], [0.01, 0.04, 0.04, 0.007])
GRAVITY = 9.80665


def random_table(seed: int) -> tuple[list[float], list[float]]:
    """Table of 2 to 6 rows between 5 and 500 Hz, with steps of up to a decade."""
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 7))
    frequency = np.sort(random.uniform(5.0, 500.0, count)) + 10.0 * np.arange(count)
    return frequency.tolist(), (10.0 ** random.uniform(-3.0, -1.0, count)).tolist()


TABLES = [SHIPPED, SPECIFICATION, random_table(1), random_table(2)]


@pytest.mark.parametrize("table", TABLES)
def test_the_closed_form_of_the_rms_equals_the_quadrature(table: tuple[list[float], list[float]]) -> None:
    psd = PsdTable.of(*table)
    whole = sum(quad(psd.density, a, b)[0] for a, b in zip(table[0][:-1], table[0][1:], strict=True))
    assert psd.rms == pytest.approx(np.sqrt(whole), rel=1e-7)  # of quad


def test_a_slope_of_minus_one_has_a_logarithm_as_integral() -> None:
    psd = PsdTable.of([10.0, 100.0], [0.1, 0.01])
    assert psd.rms == pytest.approx(GRAVITY * np.sqrt(np.log(10.0)), rel=1e-12)


@pytest.mark.parametrize("table", TABLES)
def test_rms_and_psd_of_a_record_are_those_of_the_table(table: tuple[list[float], list[float]]) -> None:
    rate, duration = 2.6 * table[0][-1], 30.0
    record, psd = wf.signals.random_record(*table, duration, rate, 3), PsdTable.of(*table)
    assert np.std(record) == pytest.approx(psd.rms, rel=1e-9)
    f, found = welch(record, rate, nperseg=round(rate))  # lines of 1 Hz, about 57 averages
    inside = (f > table[0][0] + 1.5) & (f < table[0][-1] - 1.5)  # a Hann window reaches over 1.5 lines
    decibels = np.abs(10.0 * np.log10(found[inside] / psd.density(f[inside])))
    assert np.quantile(decibels, 0.95) < 1.0


@pytest.mark.parametrize("table", TABLES)
def test_a_record_has_no_component_outside_the_band(table: tuple[list[float], list[float]]) -> None:
    rate, duration = 2.6 * table[0][-1], 10.0
    record = wf.signals.random_record(*table, duration, rate, 4)
    power = np.abs(np.fft.rfft(record)) ** 2
    f = np.fft.rfftfreq(len(record), 1.0 / rate)
    outside = (f < table[0][0] - 1.0 / duration) | (f > table[0][-1] + 1.0 / duration)
    assert power[outside].sum() < 1e-20 * power.sum()


def test_a_record_starts_and_ends_smoothly() -> None:
    motion = RandomMotion(PsdTable.of(*SHIPPED), 5.0, seed=5)
    rms = motion.table.rms
    near = np.array([0.0, 1e-4, 2e-4, 4e-4])  # 3 % to 12 % of a cycle of 300 Hz
    ends = np.array([motion.acceleration(near), motion.acceleration(5.0 - near)]) / rms
    assert np.abs(ends[:, 0]).max() < 1e-9
    assert np.all(np.abs(ends[:, 3]) < 32.0 * np.abs(ends[:, 2]) + 1e-9)  # fourth order: 2^4, and the next term
    assert np.abs(ends).max() < 0.02
    assert motion.acceleration(np.array([-1e-9, 5.0 + 1e-6])).tolist() == [0.0, 0.0]


def test_a_record_is_gaussian() -> None:
    record = wf.signals.random_record(*SHIPPED, 60.0, 1000.0, 6)
    scaled = record / record.std()
    shares = [np.mean(np.abs(scaled) < size) for size in (1.0, 2.0, 3.0)]
    np.testing.assert_allclose(shares, [0.68269, 0.95450, 0.99730], atol=0.003)  # about 33 000 independent values
    assert np.mean(scaled**4) == pytest.approx(3.0, abs=0.06)


def test_the_seed_fixes_the_record_and_another_gives_another() -> None:
    first, again, other = (wf.signals.random_record(*SHIPPED, 2.0, 1000.0, seed) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.2  # 560 lines: standard deviation 0.04


@pytest.mark.parametrize("limit", [3.0, 2.6])
def test_a_crest_limit_is_kept_without_a_change_of_the_psd(limit: float) -> None:
    record = wf.signals.random_record(*SHIPPED, 10.0, 6000.0, 1, crest_limit=limit)
    free = wf.signals.random_record(*SHIPPED, 10.0, 6000.0, 1)
    assert np.abs(record).max() <= limit * record.std() < np.abs(free).max()
    lines = [np.abs(np.fft.rfft(values))[210:2990] for values in (record, free)]
    np.testing.assert_allclose(lines[0], lines[1], rtol=0.02)  # the conditions at the ends move a few lines


def test_a_motion_is_the_sum_of_its_lines_at_any_time() -> None:
    table = PsdTable.of(*random_table(3))
    motion, lines = RandomMotion(table, 4.0, seed=7, factor=2.0), random_lines(table, 4.0, 7)
    time = np.random.default_rng(8).uniform(0.0, 4.0, 40)
    exact = 2.0 * (np.exp(2j * np.pi * np.outer(time, lines.order) / 4.0) @ lines.coefficient).real
    np.testing.assert_allclose(motion.acceleration(time), exact, atol=1e-6 * 2.0 * table.rms)


@pytest.mark.parametrize(("per_cycle", "error"), [(20, 6.5e-8), (10, 4.9e-6), (4, 2.1e-3)])
def test_the_spline_through_samples_has_the_stated_error(per_cycle: int, error: float) -> None:
    dt = 1.0 / per_cycle
    motion = SampledMotion(np.sin(2.0 * np.pi * dt * np.arange(40 * per_cycle + 1)), dt)
    time = np.linspace(10.0, 30.0, 4001)
    found = np.abs(motion.acceleration(time) - np.sin(2.0 * np.pi * time)).max()
    assert found == pytest.approx(error, rel=0.05)  # two digits are stated


def test_the_highest_frequency_has_all_but_a_ten_thousandth_of_the_energy_below() -> None:
    flat, falling = PsdTable.of(*SHIPPED), PsdTable.of([20.0, 300.0, 320.0, 2000.0], [0.01, 0.01, 1e-7, 1e-7])
    assert flat.highest_frequency_hz == 300.0
    highest = falling.highest_frequency_hz
    assert 290.0 < highest < 320.0
    share = 1.0 - float(falling.mean_square_below(highest)) / falling.rms**2
    assert 0.0 < share <= NEGLIGIBLE


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([300.0, 20.0], [0.01, 0.01], 10.0, 1000.0), "the frequencies must rise, but 20 Hz follows 300 Hz"),
        (([20.0, 300.0], [0.01, -0.01], 10.0, 1000.0), "the density at 300 Hz must be above zero, got -0.01"),
        (([20.0, 300.0], [0.01, 0.02, 0.03], 10.0, 1000.0), "3 densities for 2 frequencies"),
        (([20.0], [0.01], 10.0, 1000.0), "two or more rows, got 1"),
        (([0.0, 300.0], [0.01, 0.01], 10.0, 1000.0), "must be above zero, got 0"),
        (([20.0, 300.0], [0.01, float("nan")], 10.0, 1000.0), "must be above zero, got nan"),
        (([20.0, 300.0], 0.01, 10.0, 700.0), "below 2.5 times the highest frequency, 300 Hz"),
        (([20.0, 21.0], 0.01, 10.0, 700.0), "resolves 11 spectral lines in the band of 20 to 21 Hz"),
        (([20.0, 300.0], 0.01, 0.0, 700.0), "duration = 0 is not a positive number"),
    ],
)
def test_bad_input_is_named(arguments: tuple, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        wf.signals.random_record(*arguments)
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("duration", "lines"), [(1.8, 19), (1.9, 20)])
def test_twenty_spectral_lines_make_a_random_motion(duration: float, lines: int) -> None:
    """Lines k / duration in 20 to 30 Hz, ends included: 36 to 54, and 38 to 57."""
    table = PsdTable((20.0, 30.0), (0.01, 0.01))
    assert len(line_orders(table, duration)) == lines
    problem = duration_problem(table, duration)
    assert (problem is None) == (lines >= 20)
    assert problem is None or "resolves 19 spectral lines" in problem[0]


def test_a_crest_limit_out_of_reach_is_refused() -> None:
    with pytest.raises(InputError, match="does not fall below"):
        wf.signals.random_record(*SHIPPED, 1.0, 1000.0, 1, crest_limit=1.2)
