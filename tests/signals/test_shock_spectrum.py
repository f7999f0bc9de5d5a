"""Shock response spectra and pulses against closed forms and an independent fine integration."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.integrate import trapezoid
from support.shock_forms import half_sine_spectrum, integrated_spectrum, sawtooth_spectrum

import wroll_fem as wf
from wroll_fem.errors import InputError
from wroll_fem.signals.shock.pulses import HalfSine, Sawtooth, Trapezoid
from wroll_fem.signals.shock.spectrum import INTERVALS, shock_spectra

T, A = 0.011, 200.0


def sampled(pulse, dt):
    return pulse.acceleration(dt * np.arange(round(pulse.duration / dt) + 1))


def test_spectrum_of_a_half_sine_equals_its_closed_form():
    """0.5 % asked; 200 samples per cycle of the highest frequency leave 1e-4 to the straight lines."""
    ratio = np.geomspace(0.02, 9.7, 300)
    dt = T / 2000
    found = wf.signals.shock_spectrum(sampled(HalfSine(A, T), dt), dt, ratio / T, np.inf)
    np.testing.assert_allclose(found, A * half_sine_spectrum(ratio), rtol=1e-5)


def test_spectrum_of_a_sawtooth_equals_its_closed_form():
    """1 % asked. The sample at the jump is its mean, so one step of the drop is a line: an error of first order."""
    ratio = np.geomspace(0.02, 9.7, 300)
    dt = T / 4000
    found = wf.signals.shock_spectrum(sampled(Sawtooth(A, T), dt), dt, ratio / T, np.inf)
    np.testing.assert_allclose(found, A * sawtooth_spectrum(ratio), rtol=2e-3)
    exact = A / T * dt * np.arange(4001)  # a record that ends with its peak: the drop after it is exact
    np.testing.assert_allclose(
        wf.signals.shock_spectrum(exact, dt, ratio / T, np.inf), A * sawtooth_spectrum(ratio), rtol=1e-5
    )


def test_a_very_short_pulse_leaves_the_velocity_change_times_omega():
    for pulse in (HalfSine(A, 1e-4), Sawtooth(A, 1e-4, after=1e-7), Trapezoid(A, 1e-4, rise=0.2, fall=0.3)):
        dt, f = 1e-7, np.array([1.0, 10.0])
        found = wf.signals.shock_spectrum(sampled(pulse, dt), dt, f, np.inf, interval="residual")
        np.testing.assert_allclose(found, pulse.velocity_change * 2 * np.pi * f, rtol=1e-5)


def test_a_slow_pulse_gives_its_peak_acceleration():
    for pulse in (HalfSine(A, 1.0), Trapezoid(A, 1.0, rise=0.4, fall=0.4)):
        f = np.array([500.0])
        found = wf.signals.shock_spectrum(sampled(pulse, 1e-4), 1e-4, f)
        np.testing.assert_allclose(found, A, rtol=2e-3)


def random_pulses(seed=16, count=6):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        kind = rng.choice([HalfSine, Trapezoid])
        yield kind(rng.uniform(10, 1000), 10 ** rng.uniform(-4, -1)), 10 ** rng.uniform(0.2, 1.5), rng.uniform(0.1, 8.0)


def test_random_pulses_equal_a_fine_integration():
    """Seed 16: kind, amplitude, length, Q and frequency; `solve_ivp` at 1e-9, extremes at 400 points per cycle."""
    for pulse, q, cycles in random_pulses():
        f = cycles / pulse.length
        dt = pulse.length / 4000
        breaks = [0.1 * pulse.length, 0.9 * pulse.length] if isinstance(pulse, Trapezoid) else []
        wanted = integrated_spectrum(lambda t, p=pulse: float(p.acceleration(t)), breaks, pulse.length, f, q, 2.0 / f)
        for name, value in wanted.items():
            interval, quantity = name.split()
            options = {"quantity": quantity, "interval": interval}
            found = wf.signals.shock_spectrum(sampled(pulse, dt), dt, [f], q, **options)
            assert found[0] == pytest.approx(value, rel=2e-4), (pulse, q, name)


def test_random_records_of_few_samples_equal_a_fine_integration():
    """Seed 17. The states are exact for straight lines even at 3 samples per cycle; extremes lie between samples."""
    rng = np.random.default_rng(17)
    for samples in (3.0, 7.0, 25.0):
        dt, f, q = 1e-3, 1e3 / samples, rng.uniform(0.8, 30.0)
        record = rng.normal(size=30)
        time = dt * np.arange(30)
        wanted = integrated_spectrum(
            lambda t, r=record, s=time: float(np.interp(t, s, r)), time, time[-1], f, q, 2.0 / f
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            for name, value in wanted.items():
                interval, quantity = name.split()
                options = {"quantity": quantity, "interval": interval}
                found = wf.signals.shock_spectrum(record, dt, [f], q, **options)
                assert found[0] == pytest.approx(value, rel=1e-4), (samples, q, name)


def test_spectrum_is_linear_and_does_not_change_with_the_start():
    rng = np.random.default_rng(3)
    record, f = rng.normal(size=500), np.geomspace(5.0, 100.0, 20)
    one = wf.signals.shock_spectrum(record, 1e-3, f)
    np.testing.assert_allclose(wf.signals.shock_spectrum(-7.0 * record, 1e-3, f), 7.0 * one, rtol=1e-12)
    record[0] = 0.0  # no jump at the start, which a pause would turn into a line
    one = wf.signals.shock_spectrum(record, 1e-3, f)
    later = wf.signals.shock_spectrum(np.append(np.zeros(123), record), 1e-3, f)
    np.testing.assert_allclose(later, one, rtol=1e-10)


def test_maximax_is_the_larger_of_primary_and_residual():
    pulse, f = sampled(HalfSine(A, T), T / 1000), np.geomspace(5.0, 2000.0, 30)
    parts = [wf.signals.shock_spectrum(pulse, T / 1000, f, interval=part) for part in ("primary", "residual")]
    whole = wf.signals.shock_spectrum(pulse, T / 1000, f)
    assert np.array_equal(whole, np.maximum(*parts))
    assert (parts[0] < parts[1]).any()
    assert (parts[0] > parts[1]).any()


def test_all_spectra_at_once_are_those_of_single_calls():
    record, f = np.random.default_rng(8).normal(size=300), np.geomspace(3.0, 90.0, 12)
    for quantity, values in shock_spectra(record, 1e-3, f, 17.0).items():
        for interval, row in zip(INTERVALS, values, strict=True):
            one = wf.signals.shock_spectrum(record, 1e-3, f, 17.0, quantity=quantity, interval=interval)
            np.testing.assert_allclose(row, one, rtol=1e-14)


def test_a_coarse_record_is_warned_about_or_resampled():
    """A sine at resonance with 4 samples per cycle: lines lose 18 %, resampling recovers it within 1 %."""
    f, q, cycles = 100.0, 10.0, 40
    fine, coarse = 1.0 / (400 * f), 1.0 / (4.0 * f)
    window = lambda t: np.sin(np.pi * t * f / cycles) ** 2 * np.sin(2 * np.pi * f * t + 0.4)  # noqa: E731
    exact = wf.signals.shock_spectrum(window(fine * np.arange(400 * cycles + 1)), fine, [f], q)
    record = window(coarse * np.arange(4 * cycles + 1))
    with pytest.warns(UserWarning, match=r"4 samples per cycle at 100 Hz.* 19 %"):
        low = wf.signals.shock_spectrum(record, coarse, [f], q)
    assert low / exact == pytest.approx(np.sinc(1 / 4) ** 2, rel=0.01)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert wf.signals.shock_spectrum(record, coarse, [f], q, resample=True) / exact == pytest.approx(1.0, rel=0.01)


def test_pulses_have_the_area_and_the_band_they_state():
    for pulse in (HalfSine(A, T, 0.003, 0.02), Sawtooth(A, T, 0.003, 0.02), Trapezoid(A, T, 0.003, 0.02, 0.25, 0.5)):
        n = 11 * 2000
        dt = T / n
        base = pulse.acceleration(dt * np.arange(round(pulse.duration / dt) + 1))
        assert base.sum() * dt == pytest.approx(pulse.velocity_change, rel=1e-6)
        assert np.all(base[: 3 * 2000] == 0.0)
        assert np.all(base[14 * 2000 + 1 :] == 0.0)
        f = np.linspace(0.0, pulse.highest_frequency_hz, 20001)[1:]
        step = 16  # its Fourier transform up to the band, against Parseval
        t = dt * step * np.arange(base[::step].size)
        few = f[::100]
        power = np.array([abs(trapezoid(base[::step] * np.exp(-2j * np.pi * x * t), t)) ** 2 for x in few])
        share = 2.0 * trapezoid(np.append(pulse.velocity_change**2, power), np.append(0.0, few))
        assert share / (np.sum(base**2) * dt) == pytest.approx(0.99, abs=1e-3)


def test_edges_of_zero_length_are_jumps_with_their_mean():
    box = Trapezoid(2.0, 1.0, rise=0.0, fall=0.0)
    np.testing.assert_array_equal(box.acceleration([-0.1, 0.0, 0.5, 1.0, 1.1]), [0.0, 1.0, 2.0, 1.0, 0.0])
    assert Sawtooth(2.0, 1.0).acceleration(1.0) == 1.0


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: HalfSine(-1.0, T), "excitation.amplitude"),
        (lambda: HalfSine(A, float("nan")), "excitation.duration"),
        (lambda: Sawtooth(A, T, before=-1.0), "excitation.before"),
        (lambda: Trapezoid(A, T, rise=0.7, fall=0.4), "excitation.rise"),
        (lambda: wf.signals.shock_spectrum([1.0], 1.0, [1.0]), "shape"),
        (lambda: wf.signals.shock_spectrum([1.0, np.nan], 1.0, [1.0]), r"acceleration\[1\] = nan"),
        (lambda: wf.signals.shock_spectrum([1.0, 2.0], 0.0, [1.0]), "dt = 0"),
        (lambda: wf.signals.shock_spectrum([1.0, 2.0], 1e-3, [0.0]), "natural_frequencies"),
        (lambda: wf.signals.shock_spectrum([1.0, 2.0], 1e-3, [1.0], 0.5), "q = 0.5"),
        (lambda: wf.signals.shock_spectrum([1.0, 2.0], 1e-3, [1.0], quantity="g"), "relative_displacement"),
    ],
)
def test_wrong_input_is_one_line(make, text):
    with pytest.raises(InputError, match=text) as error:
        make()
    assert "\n" not in str(error.value)
