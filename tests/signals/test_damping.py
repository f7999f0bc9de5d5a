"""Half-power damping against the closed form of a base-excited oscillator, solved independently."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.step_error import Oscillator
from wroll_fem.errors import InputError
from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.damping import HalfPower, half_power, least_damping, likely_damping, sweep_warning
from wroll_fem.signals.estimators.curve_damping import estimate_damping
from wroll_fem.signals.sweeps import Chirp
from wroll_fem.signals.transmissibility import demodulated, magnitude


def curve(r, zeta):
    return np.sqrt((1.0 + (2 * zeta * r) ** 2) / ((1.0 - r**2) ** 2 + (2 * zeta * r) ** 2))


def exact_half_power(zeta):
    """Peak from its closed form, r^2 = (sqrt(1 + 8 zeta^2) - 1) / (4 zeta^2); crossings by root finding."""
    r_n = np.sqrt(np.sqrt(1.0 + 8.0 * zeta**2) - 1.0) / (2.0 * zeta)
    peak = curve(r_n, zeta)
    level = peak / np.sqrt(2.0)
    ends = [brentq(lambda r: curve(r, zeta) - level, *sorted((r_n, far)), xtol=1e-15) for far in (1e-6, 10.0)]
    return r_n, peak, *ends


@pytest.mark.parametrize("zeta", [0.005, 0.01, 0.02, 0.05, 0.1, 0.2])
@pytest.mark.parametrize("points_per_width", [20, 200])
def test_half_power_matches_the_exact_curve(zeta, points_per_width):
    r_n, peak, low, high = exact_half_power(zeta)
    step = 150.0 * (high - low) / points_per_width
    frequency = np.arange(150.0 * max(low - 2 * zeta, 0.05), 150.0 * (high + 3 * zeta), step) + 0.37 * step
    read = half_power(frequency, curve(frequency / 150.0, zeta))
    coarse = points_per_width == 20
    assert read.complete
    assert not read.reason
    assert not read.note
    assert read.f_n == pytest.approx(150.0 * r_n, abs=150.0 * zeta * (1e-3 if coarse else 1e-5))
    assert read.peak == pytest.approx(peak, rel=1e-4 if coarse else 1e-7)
    assert read.f_low == pytest.approx(150.0 * low, rel=1e-4 if coarse else 1e-6)
    assert read.f_high == pytest.approx(150.0 * high, rel=1e-4 if coarse else 1e-6)
    assert read.zeta == pytest.approx((high - low) / (2 * r_n), rel=2e-4 if coarse else 2e-6)
    assert read.skewness == pytest.approx((high - r_n) / (r_n - low) - 1.0, abs=5e-3 if coarse else 1e-4)


def test_one_percent_damping_reads_one_percent():
    """C37: within 1 % of 1 %."""
    frequency = np.linspace(130.0, 170.0, 4001)
    assert half_power(frequency, curve(frequency / 150.0, 0.01)).zeta == pytest.approx(0.01, rel=0.01)


def test_peak_is_found_between_grid_points():
    frequency = np.linspace(100.0, 200.0, 101)
    read = half_power(frequency, 20.0 - 0.007 * (frequency - 150.4) ** 2)
    assert read.f_n == pytest.approx(150.4, abs=1e-9)
    assert read.peak == pytest.approx(20.0, abs=1e-9)


def test_reading_does_not_need_a_uniform_grid():
    frequency = np.sort(np.random.default_rng(3).uniform(120.0, 180.0, 3000))
    _, _, low, high = exact_half_power(0.02)
    assert half_power(frequency, curve(frequency / 150.0, 0.02)).zeta == pytest.approx((high - low) / 2, rel=1e-3)


def test_long_right_tail_has_positive_skewness_and_mirror_negative():
    frequency = np.linspace(-1.0, 3.0, 4001)
    tail = 1.0 / np.sqrt(1.0 + (frequency / np.where(frequency > 0.0, 0.2, 0.1)) ** 2)
    assert half_power(frequency + 150.0, tail).skewness == pytest.approx(1.0, abs=0.02)
    assert half_power(153.0 - frequency[::-1], tail[::-1]).skewness == pytest.approx(-0.5, abs=0.02)


@pytest.mark.parametrize(
    ("band", "words"),
    [
        ((149.5, 170.0), "no half-power point between 149.5 Hz and the peak"),
        ((130.0, 150.5), "to 150.5 Hz|and 150.5 Hz"),
        ((155.0, 170.0), "lower end of the band"),
        ((120.0, 145.0), "upper end of the band"),
    ],
)
def test_half_power_point_outside_the_band_is_never_a_silent_number(band, words):
    frequency = np.linspace(*band, 801)
    read = half_power(frequency, curve(frequency / 150.0, 0.01))
    assert not read.complete
    assert np.isnan(read.zeta)
    assert np.isnan(read.skewness)
    assert re.search(words, read.reason)
    assert read.as_attrs()["half_power_complete"] is False
    assert np.isnan(read.as_attrs()["zeta"])


def test_second_peak_above_half_power_is_noted():
    frequency = np.linspace(100.0, 200.0, 5001)
    two = curve(frequency / 130.0, 0.01) + 0.95 * curve(frequency / 170.0, 0.01)
    read = half_power(frequency, two)
    assert read.complete
    assert read.f_n == pytest.approx(130.0, abs=0.1)
    assert "again at 168" in read.note


def test_flat_top_and_level_on_a_grid_point_are_read():
    read = half_power(np.arange(7.0), [0.0, np.sqrt(0.5), 1.0, 1.0, 1.0, np.sqrt(0.5), 0.0])
    assert read.complete
    assert read.f_n == pytest.approx(2.5, abs=0.51)
    assert read.f_low == pytest.approx(1.0, abs=0.1)
    assert read.f_high == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize(
    ("frequency", "size"),
    [
        ([1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 1.0]),
        ([1.0, 2.0, 2.0, 4.0, 5.0], [1.0, 2.0, 3.0, 1.0, 0.0]),
        ([1.0, 2.0, 3.0, 4.0, 5.0], [1.0, -2.0, 3.0, 1.0, 0.0]),
        ([1.0, 2.0, 3.0, 4.0, 5.0], [0.0] * 5),
        ([1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 1.0, float("nan"), 1.0, 0.0]),
    ],
)
def test_what_is_no_curve_is_refused(frequency, size):
    with pytest.raises(InputError):
        half_power(frequency, size)


def test_independent_peak_formula_is_itself_right():
    """The closed form used above, against a minimiser."""
    for zeta in (0.005, 0.05, 0.2):
        found = minimize_scalar(
            lambda r, z=zeta: -curve(r, z), bounds=(0.5, 1.2), method="bounded", options={"xatol": 1e-10}
        )
        assert exact_half_power(zeta)[0] == pytest.approx(found.x, abs=1e-6)


def test_too_fast_sweep_is_named_with_the_rate_that_would_do():
    frequency = np.linspace(130.0, 170.0, 4001)
    read = half_power(frequency, curve(frequency / 150.0, 0.01))
    limit = sweep_rate_limit(150.0, 0.01)
    assert limit == pytest.approx(312.0 * 0.01**2 * 150.0)
    assert sweep_warning(Chirp(5.0, 130.0, 170.0, 0.24 * limit), read) is None
    assert "to 1.2 or less" in (sweep_warning(Chirp(5.0, 130.0, 170.0, 0.5 * limit), read) or "")
    outside = half_power(frequency[:1990], curve(frequency[:1990] / 150.0, 0.01))
    assert (
        sweep_warning(Chirp(5.0, 130.0, 170.0, 10 * limit), outside) is None
    )  # no resonance, which has its own reason


def test_a_skewed_peak_is_swept_for_its_steeper_flank():
    """Random roll 80: at 15 % of the limit for zeta = 5.5 %, and f_n of the sweep 1.5 % above the steady one."""
    read = HalfPower(395.1, 17.6, 386.5, 429.8, zeta=0.0549, skewness=3.03, complete=True)
    limit = sweep_rate_limit(395.1, 8.6 / 395.1)
    band = 269.9, 682.2
    assert sweep_warning(Chirp(19.9, *band, 0.49 * limit), read) is None
    told = sweep_warning(Chirp(19.9, *band, 0.95 * limit), read) or ""
    assert "runs at 95 % of the ISO 7626-2 limit for 395.1 Hz and zeta = 2.18 % (from the steeper flank" in told
    assert f"to {0.5 * limit:.2g} or less" in told


@pytest.mark.parametrize("band", [(130.0, 150.5), (149.5, 170.0), (149.5, 150.5)])
def test_too_fast_sweep_is_named_without_half_power_points(band):
    frequency = np.linspace(*band, 801)
    read = half_power(frequency, curve(frequency / 150.0, 0.01))
    assert read.resonant
    assert not read.complete
    assert least_damping(read) == pytest.approx(0.01, rel=0.02)
    limit = sweep_rate_limit(150.0, 0.01)
    assert sweep_warning(Chirp(5.0, *band, 0.2 * limit), read) is None
    assert "as a half-power point is missing" in (sweep_warning(Chirp(5.0, *band, 0.3 * limit), read) or "")


def test_a_sweep_that_rings_through_an_undamped_resonance_is_too_fast():
    """Its hump of ringing is wide and complete, f_n 2 % high: by that width alone the rate would be admissible."""
    motion = Chirp(5.0, 450.0, 700.0, 65.0, ramp_cycles=10.0)
    dt = 1.0 / (40.0 * 700.0)
    time = dt * np.arange(int(motion.duration / dt))
    base = motion.acceleration(time)
    relative = Oscillator(600.0, 1e-6).response(Scheme.named("no_damping"), dt, base)
    acceleration = base + np.gradient(np.gradient(relative, dt), dt)
    found = demodulated(time, acceleration, motion)
    read = half_power(found["frequency"].values, np.abs(magnitude(found).values))
    assert read.complete
    assert read.f_n / 600.0 - 1.0 > 0.01
    assert motion.rate_oct_per_min < 0.25 * sweep_rate_limit(read.f_n, read.zeta)
    assert "ringing" in (sweep_warning(motion, read) or "")


@pytest.mark.parametrize("zeta", [0.005, 0.02, 0.05])
def test_a_linear_resonance_does_not_ring(zeta):
    frequency = np.linspace(100.0, 200.0, 8001)
    for participation in (1.0, 1.6):  # a single mass, the first mode of a cantilever
        read = half_power(frequency, participation * curve(frequency / 150.0, zeta))
        assert likely_damping(read) == (read.zeta, "")


@pytest.mark.parametrize("band", [(155.0, 170.0), (120.0, 145.0), (10.0, 20.0)])
def test_a_band_without_a_maximum_has_no_resonance(band):
    frequency = np.linspace(*band, 801)
    read = half_power(frequency, curve(frequency / 150.0, 0.01))
    attrs = read.as_attrs()
    assert not read.resonant
    assert np.isnan([attrs["f_n_hz"], attrs["peak_transmissibility"], attrs["zeta"]]).all()
    assert "no resonance inside" in attrs["half_power_reason"]


def test_a_ripple_on_a_slope_is_no_resonance():
    frequency = np.linspace(120.0, 145.0, 801)
    x = np.linspace(0.0, 1.0, 801)
    slope = 5.0 - (x - 0.2) ** 2  # highest point inside, by 0.8 %
    k = int(np.argmax(slope))
    assert 0 < k < 800
    assert slope[k] / max(slope[0], slope[-1]) < 1.01
    read = half_power(frequency, slope)
    assert not read.resonant
    assert "rises" in read.reason


def test_a_high_point_in_antiphase_is_a_resonance_and_a_low_one_is_not() -> None:
    """A sweep that rings through a sharp resonance has any phase at its highest point; a ripple is low."""
    frequency = np.linspace(90.0, 110.0, 401)
    magnitude = 1.0 / np.abs(1.0 - (frequency / 100.0) ** 2 + 0.02j * frequency / 100.0)  # 50 at 100 Hz
    high, low = (estimate_damping(frequency, share * -magnitude.astype(complex)) for share in (1.0, 0.1))
    assert high.shape.resonant
    assert high.shape.f_n == pytest.approx(100.0, rel=1e-3)
    assert not low.shape.resonant
    assert "no resonance inside" in low.shape.reason
