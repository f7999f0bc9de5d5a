"""Base motions and transmissibility against closed forms and an independent integrator."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from support.oscillator import steady, swept_oscillator

from wroll_fem.errors import InputError
from wroll_fem.signals.base_motion import Dwell, sweep_rate_limit
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.motions import base_motion
from wroll_fem.signals.sweeps import Chirp
from wroll_fem.signals.transmissibility import (
    demodulated,
    dwell_response,
    magnitude,
    spectrum_ratio,
    transmissibility,
)


def complex_of(dataset, stem="transmissibility"):
    return dataset[f"{stem}_real"].values + 1j * dataset[f"{stem}_imag"].values


# --- base motions -----------------------------------------------------------------------------------------------


def test_chirp_of_the_source_lasts_as_claimed():
    """C62: 125 to 175 Hz at 2 oct/min takes log2(1.4)/2 min; C95: 5 to 160 Hz at 15 oct/min takes 20 s."""
    assert Chirp(5.0, 125.0, 175.0, 2.0).duration == pytest.approx(14.563, abs=1e-3)
    assert Chirp(5.0, 5.0, 160.0, 15.0).duration == pytest.approx(20.0, rel=1e-12)


def test_chirp_doubles_its_frequency_once_per_octave_time():
    motion = Chirp(5.0, 10.0, 100.0, 2.0)
    np.testing.assert_allclose(motion.frequency([0.0, 30.0, 60.0]), [10.0, 20.0, 40.0], rtol=1e-12)
    assert motion.frequency(motion.duration) == pytest.approx(100.0, rel=1e-12)
    assert motion.frequency(motion.time_of_frequency(33.0)) == pytest.approx(33.0, rel=1e-12)


def test_chirp_phase_is_the_integral_of_its_frequency():
    motion = Chirp(5.0, 125.0, 175.0, 8.0)
    for t in (0.1, 1.7, motion.duration):
        integral = 2.0 * np.pi * quad(lambda s: float(motion.frequency(s)), 0.0, t, epsabs=1e-11, epsrel=1e-13)[0]
        assert float(motion.phase(t)) == pytest.approx(integral, rel=1e-11)
        assert float(motion.time_of_phase(motion.phase(t))) == pytest.approx(t, rel=1e-12)
    assert motion.phase(motion.duration) / (2.0 * np.pi) == pytest.approx(motion.cycles, rel=1e-12)


def test_motion_reaches_its_zero_to_peak_amplitude_after_a_smooth_ramp():
    for motion in (Chirp(5.0, 50.0, 60.0, 20.0, ramp_cycles=8.0), Dwell(5.0, 50.0, 40.0, ramp_cycles=8.0)):
        time, base = motion.samples(1e-4)
        ramp_end = 8.0 / 50.0
        assert np.abs(base[time > ramp_end]).max() == pytest.approx(5.0, rel=1e-3)
        assert np.abs(base[time < 0.25 * ramp_end]).max() < 0.2 * 5.0
        assert np.abs(base[time < 0.75 * ramp_end]).max() < 0.9 * 5.0
        jump = np.abs(np.diff(base)).max()
        assert jump < 1.05 * 5.0 * 2.0 * np.pi * 60.0 * 1e-4  # no step anywhere


def test_samples_cover_the_whole_motion():
    motion = Dwell(1.0, 50.0, 10.0)
    time, base = motion.samples(motion.duration / 400)
    assert time.size == 401
    assert time[-1] == pytest.approx(motion.duration, rel=1e-14)
    time, _ = motion.samples(motion.duration / 399.5)
    assert time[-2] < motion.duration < time[-1]
    assert motion.acceleration(-1.0) == 0.0
    assert base.size == 401


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: Chirp(5.0, 175.0, 175.0, 2.0), "excitation.f_end"),
        (lambda: Chirp(5.0, 125.0, 175.0, 0.0), "excitation.rate_oct_per_min"),
        (lambda: Chirp(-5.0, 125.0, 175.0, 2.0), "excitation.amplitude"),
        (lambda: Dwell(5.0, 100.0, 4.0, ramp_cycles=5.0), "excitation.ramp_cycles"),
        (lambda: Dwell(5.0, float("nan"), 4.0), "excitation.frequency"),
    ],
)
def test_impossible_motion_names_the_key(make, key):
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.key == key


def test_base_motion_follows_the_case_section():
    class Section:
        kind, amplitude, frequency, cycles = "dwell", 3.0, 150.0, 40.0

    assert base_motion(Section()) == Dwell(3.0, 150.0, 40.0, 5.0)
    Section.kind = "hammer"
    with pytest.raises(InputError, match="chirp"):
        base_motion(Section())


# --- demodulation -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("per_cycle", "tolerance"), [(40, 2e-6), (21.7, 2e-5), (12, 2e-4), (8, 2e-3)])
def test_demodulated_is_exact_on_a_steady_harmonic_with_harmonics_and_offset(per_cycle, tolerance):
    """A constant T with third harmonic, static offset and steps that differ comes back as T (contract: < 0.1 %)."""
    motion = Chirp(5.0, 100.0, 140.0, 20.0, ramp_cycles=5.0)
    rng = np.random.default_rng(1)
    time = np.arange(0.0, motion.duration, 1.0 / (140.0 * per_cycle * 1.15))
    time[1:-1] += 0.05 * (time[1] - time[0]) * rng.uniform(-1.0, 1.0, time.size - 2)
    T, phase = 7.0 * np.exp(-0.7j), motion.phase(time)
    harmonic = 0.1 * np.sin(3 * phase) if per_cycle >= 21 else 0.0
    tip = 5.0 * abs(T) * (np.sin(phase + np.angle(T)) + harmonic) + 2.0
    result = demodulated(time, tip, motion)
    away = result["frequency"].values > 107.0  # the ramp of the base is not in this tip
    error = np.abs(complex_of(result)[away] - T) / abs(T)
    assert error.max() < (tolerance if per_cycle != 21.7 else 2e-4)


def test_demodulated_follows_a_quasi_steady_resonance_without_group_delay():
    """zeta = 1 % at 4 oct/min: peak, frequency and phase of the curve written into the signal come back."""
    motion = Chirp(5.0, 130.0, 175.0, 4.0)
    time = np.arange(0.0, motion.duration, 1.0 / (175.0 * 40))
    phase, T = motion.phase(time), steady(motion.frequency(time), 150.0, 0.01)
    result = demodulated(time, 5.0 * np.abs(T) * np.sin(phase + np.angle(T)), motion)
    exact = steady(result["frequency"].values, 150.0, 0.01)
    np.testing.assert_allclose(complex_of(result), exact, atol=2e-4 * 50.0)
    assert result["frequency"].values[0] == pytest.approx(130.0 + 9 * motion.growth, abs=0.01)
    np.testing.assert_allclose(np.diff(result["frequency"], 2), 0.0, atol=1e-9)


def test_slow_chirp_of_an_oscillator_gives_its_closed_form_transmissibility():
    """At 5 % of the ISO 7626-2 rate the integrated response lies within the documented lag of the closed form."""
    zeta, f_n = 0.03, 150.0
    motion = Chirp(5.0, 110.0, 200.0, 0.05 * sweep_rate_limit(f_n, zeta), ramp_cycles=20)
    time, _, tip = swept_oscillator(motion, f_n, zeta, per_cycle=80)
    result = demodulated(time, tip, motion)
    frequency = result["frequency"].values
    inside = frequency > 115.0
    exact = steady(frequency, f_n, zeta)[inside]
    got = complex_of(result)[inside]
    assert np.abs(np.abs(got) / np.abs(exact) - 1.0).max() < 0.05
    assert np.abs(got).max() == pytest.approx(np.abs(exact).max(), rel=3e-3)


@pytest.mark.parametrize(
    ("share", "lost", "zeta_error", "skewness"),
    [(0.1, 0.003, 0.004, -0.11), (0.25, 0.009, 0.02, -0.22), (1.0, 0.058, 0.23, -0.34)],
)
def test_fast_chirp_lags_as_the_documented_table_says(share, lost, zeta_error, skewness):
    zeta, f_n = 0.01, 150.0
    motion = Chirp(5.0, 132.0, 174.0, share * sweep_rate_limit(f_n, zeta), ramp_cycles=10)
    time, _, tip = swept_oscillator(motion, f_n, zeta)
    result = demodulated(time, tip, motion)
    read = half_power(result["frequency"], magnitude(result))
    f = np.linspace(145.0, 155.0, 20001)
    true = half_power(f, np.abs(steady(f, f_n, zeta)))
    assert 1.0 - read.peak / true.peak == pytest.approx(lost, abs=0.001)
    assert read.zeta / true.zeta - 1.0 == pytest.approx(zeta_error, abs=0.01)
    assert read.skewness == pytest.approx(skewness, abs=0.01)


# --- spectrum ratio ---------------------------------------------------------------------------------------------


def test_spectrum_ratio_of_a_fast_chirp_has_no_lag_on_a_linear_system():
    """C36: with the ringing recorded to its end, the ratio equals the closed form at four times the ISO rate."""
    zeta, f_n = 0.01, 150.0
    motion = Chirp(5.0, 110.0, 200.0, 4.0 * sweep_rate_limit(f_n, zeta), ramp_cycles=5)
    time, base, tip = swept_oscillator(motion, f_n, zeta, per_cycle=120, tail=1.5)
    result = spectrum_ratio(time, tip, base, (120.0, 190.0))
    exact = steady(result["frequency"].values, f_n, zeta)
    error = np.abs(complex_of(result, "transmissibility_spectrum") - exact) / np.abs(exact)
    assert error.max() < 1e-3  # first-order hold between 120 samples per cycle
    assert result.attrs["spectrum_resolution_hz"] == pytest.approx(1.0 / time[-1], rel=1e-3)
    assert result["frequency"].diff("frequency").values == pytest.approx(1.0 / (time[-1] + time[1]), rel=1e-9)


def test_both_estimates_share_one_grid_and_agree_on_a_damped_slow_sweep():
    zeta, f_n = 0.04, 150.0
    motion = Chirp(5.0, 100.0, 210.0, 4.0, ramp_cycles=20)
    time, base, tip = swept_oscillator(motion, f_n, zeta)
    history = xr.Dataset(
        {"tip_acceleration": ("time", tip - base), "base_acceleration": ("time", base)}, coords={"time": time}
    )
    result = transmissibility(history, motion, points=401)
    inside = (result["frequency"].values > 130.0) & (result["frequency"].values < 175.0)  # the record's ends leak
    envelope = magnitude(result).values[inside]
    spectrum = magnitude(result, "transmissibility_spectrum").values[inside]
    exact = np.abs(steady(result["frequency"].values[inside], f_n, zeta))
    assert np.abs(spectrum / envelope - 1.0).max() < 0.03
    assert np.abs(spectrum / exact - 1.0).max() < 0.02  # absolute tip motion, though the history holds the relative one
    assert all(v.attrs["units"] and v.attrs["long_name"] for v in result.variables.values())


def test_unusable_histories_are_refused_in_words():
    motion = Chirp(5.0, 100.0, 200.0, 60.0)
    time, base = motion.samples(1e-4)
    with pytest.raises(InputError, match="same length"):
        demodulated(time, base[:-1], motion)
    with pytest.raises(InputError, match="finite"):
        demodulated(time, np.where(time > 0.5, np.nan, base), motion)
    with pytest.raises(InputError, match="samples per cycle"):
        demodulated(time[::10], base[::10], motion)
    with pytest.raises(InputError, match="too few"):
        demodulated(time[:1500], base[:1500], motion)
    with pytest.raises(InputError, match="does not move"):
        spectrum_ratio(time, base, np.sin(2 * np.pi * 20.0 * time) * np.hanning(time.size), (1000.0, 2000.0))
    with pytest.raises(InputError, match="2 or more equally spaced frequencies"):
        spectrum_ratio(time, base, base, (100.0, 100.001))


# --- dwell ------------------------------------------------------------------------------------------------------


def test_dwell_response_recovers_amplitude_and_phase_of_the_steady_state():
    zeta, f_n = 0.05, 150.0
    motion = Dwell(5.0, 140.0, 80.0)
    time, _, tip = swept_oscillator(motion, f_n, zeta, per_cycle=120)
    third = 0.2 * np.sin(3 * motion.phase(time))
    read = dwell_response(time, tip + third + 1.0, motion, cycles=6)
    exact = complex(steady(140.0, f_n, zeta))
    assert read["magnitude"] == pytest.approx(abs(exact), rel=1e-3)
    assert read["phase_rad"] == pytest.approx(np.angle(exact), abs=1e-3)
    assert read["residual"] == pytest.approx(0.2 / (5.0 * abs(exact)), rel=0.02)
    assert read["drift"] < 1e-3


def test_dwell_response_reports_a_transient_as_drift_and_refuses_the_ramp():
    motion = Dwell(5.0, 150.0, 20.0)
    time, _, tip = swept_oscillator(motion, 150.0, 0.005)
    assert dwell_response(time, tip, motion)["drift"] > 0.05
    with pytest.raises(InputError, match="steady cycles"):
        dwell_response(time, tip, motion, cycles=18)
    with pytest.raises(InputError, match="a fit over 1 cycles has no drift; use at least 2 cycles"):
        dwell_response(time, tip, motion, cycles=1)
