"""Damping estimators on curves whose damping is known exactly (appendix D of the thesis)."""

from __future__ import annotations

from math import isnan, log, sqrt

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.estimators import (
    ESTIMATORS,
    choose,
    cubic_spring_transmissibility,
    curve_shape,
    gaussian_fit,
    half_power_estimate,
    lower_bound,
    peak_transmissibility,
    rational_fraction,
    single_dof_half_power,
    single_dof_transmissibility,
)
from wroll_fem.signals.estimators.estimate import noise_level
from wroll_fem.signals.estimators.single_dof import HALF_POWER_LIMIT

WIDE = np.linspace(0.0, 3.0, 3001)
NEAR = np.linspace(120.0, 180.0, 1001)


def dof(zeta, f=WIDE, f_n=1.0):
    return single_dof_transmissibility(f, f_n, zeta)


def noisy(T, share, seed=0):
    draws = np.random.default_rng(seed).standard_normal((2, T.size))
    return T + share * np.abs(T).max() * (draws[0] + 1j * draws[1])


def modes(f, *pairs):
    """Absolute transmissibility of several modes (f_n, zeta, share of the tip's motion)."""
    return 1.0 + sum(g * f**2 / (f_n**2 - f**2 + 2j * z * f_n * f) for f_n, z, g in pairs)


# ---- the exact single degree of freedom ------------------------------------------------------------


def test_single_dof_is_the_solved_equation_of_motion():
    for r in (0.3, 1.0, 2.5):
        matrix = np.array([[1.0 - r**2 + 2j * 0.2 * r]])  # relative motion under -(-r^2) of the base
        relative = np.linalg.solve(matrix, [r**2])[0]
        assert dof(0.2, np.array([r]))[0] == pytest.approx(1.0 + relative, abs=1e-14)


@pytest.mark.parametrize("zeta", [0.005, 0.05, 0.2, 0.35, 0.5])
def test_half_power_reads_its_closed_form(zeta):
    r, peak = peak_transmissibility(zeta)
    read = half_power(WIDE, np.abs(dof(zeta)))
    assert (read.f_n, read.peak) == pytest.approx((r, peak), rel=1e-5)
    # C116 at 1e-4; the finest resonance has ten points in its width
    assert read.zeta == pytest.approx(single_dof_half_power(zeta), rel=1e-4 if zeta >= 0.05 else 2e-3)
    assert single_dof_half_power(zeta) > zeta


def test_half_power_has_no_reading_where_the_peak_is_below_root_two():
    assert peak_transmissibility(HALF_POWER_LIMIT)[1] == pytest.approx(sqrt(2.0), abs=1e-12)
    assert isnan(single_dof_half_power(HALF_POWER_LIMIT + 1e-9))
    estimate = half_power_estimate(WIDE, dof(0.6))
    assert not estimate.found
    assert "no half-power point" in estimate.reason
    with pytest.raises(InputError, match="between 0 and 1"):
        peak_transmissibility(1.2)


# ---- Gaussian fit ----------------------------------------------------------------------------------


@pytest.mark.parametrize("centre", ["peak", "free"])
def test_gaussian_fit_returns_the_bell_it_is_given(centre):
    f, b, c = np.linspace(50.0, 150.0, 801), 101.3, 11.0
    bell = 7.0 * np.exp(-(((f - b) / c) ** 2))
    for window in ("narrowest", "objective"):
        found = gaussian_fit(f, bell, centre=centre, window=window)
        assert found.f_n == pytest.approx(b, rel=1e-6)
        assert found.zeta == pytest.approx(c * sqrt(log(2.0) / 2.0) / b, rel=1e-5)
        assert found.misfit < 1e-5


def test_window_of_the_printed_objective_is_the_best_one_between_the_trial_windows():
    """Ripples and bumps leave a best window inside the band; the trial windows of two bands differ."""
    found = []
    for low, high in ((50.0, 150.0), (45.0, 155.0)):
        f = np.linspace(low, high, 1601)
        ripples = 1.0 + 0.003 * np.cos(2.0 * np.pi * (f - 100.0) / 2.1)
        bumps = np.exp(-(((f - 130.0) / 8.0) ** 2)) + np.exp(-(((f - 70.0) / 8.0) ** 2))
        bell = 7.0 * np.exp(-(((f - 100.0) / 11.0) ** 2)) * ripples + bumps
        found.append(gaussian_fit(f, bell, window="objective", draws=2).details["bell"].d)
    assert found[0] == pytest.approx(found[1], rel=1e-3)


def test_narrowest_window_ends_at_half_power_of_the_data():
    found = gaussian_fit(WIDE, dof(0.2), window="narrowest")
    bell, top = found.details["bell"], np.abs(dof(0.2)).max()
    assert found.details["at_constraint"]
    np.testing.assert_allclose(bell(np.array(found.window)), top / sqrt(2.0), rtol=1e-6)
    assert bell.b == pytest.approx(peak_transmissibility(0.2)[0], rel=1e-5)  # the printed equality


def test_gaussian_fit_is_the_least_squares_one_in_its_window():
    found = gaussian_fit(WIDE, dof(0.3), window="narrowest", centre="free")
    bell = found.details["bell"]
    f = np.linspace(*found.window, 4001)
    T = np.abs(single_dof_transmissibility(f, 1.0, 0.3))

    def miss(a, b, c):
        return np.mean((a * np.exp(-(((f - b) / c) ** 2)) - T) ** 2)

    least = miss(bell.a, bell.b, bell.c)
    assert sqrt(2.0 * least) == pytest.approx(bell.rmse, rel=1e-2)  # over d, as printed, not over 2 d
    for change in (0.997, 1.003):
        assert miss(change * bell.a, bell.b, bell.c) > least
        assert miss(bell.a, change * bell.b, bell.c) > least
        assert miss(bell.a, bell.b, change * bell.c) > least


def test_gaussian_fit_reads_too_much_at_high_damping():  # C117: the thesis says too little
    read = {z: gaussian_fit(WIDE, dof(z)).zeta for z in (0.1, 0.15, 0.2, 0.3, 0.5)}
    assert all(abs(read[z] / z - 1.0) < 0.03 for z in (0.1, 0.15, 0.2))
    assert 0.32 < read[0.3] < single_dof_half_power(0.3)
    assert 0.61 < read[0.5] < single_dof_half_power(0.5)


def test_printed_objective_depends_on_the_band_and_the_narrowest_window_does_not():
    short = WIDE[WIDE <= 1.5]
    assert gaussian_fit(WIDE, dof(0.05)).zeta > 2.0 * gaussian_fit(short, dof(0.05, short)).zeta
    narrow = [gaussian_fit(f, dof(0.05, f), window="narrowest").zeta for f in (WIDE, short)]
    assert narrow[0] == pytest.approx(narrow[1], rel=1e-8)
    assert narrow[0] == pytest.approx(0.05, rel=0.05)


def test_gaussian_fit_without_room_says_why():
    cut = WIDE[(WIDE > 0.8) & (WIDE < 1.2)]
    assert "falls to half power" in gaussian_fit(cut, dof(0.4, cut)).reason
    beyond = WIDE[WIDE > 1.2]
    assert "no resonance inside" in gaussian_fit(beyond, dof(0.1, beyond)).reason
    with pytest.raises(InputError, match="narrowest"):
        gaussian_fit(WIDE, dof(0.1), window="widest")


# ---- rational fraction -----------------------------------------------------------------------------


@pytest.mark.parametrize("zeta", [0.005, 0.05, 0.3, 0.6])
def test_rational_fraction_is_exact_on_one_mode(zeta):
    for T in (dof(zeta), np.abs(dof(zeta))):  # with and without phase
        found = rational_fraction(WIDE, T)
        assert (found.f_n, found.zeta) == pytest.approx((1.0, zeta), rel=1e-9)
        assert found.details["modes"] == 1


@pytest.mark.parametrize("gap", [4.0, 2.0, 1.0])
def test_rational_fraction_tells_close_modes_apart(gap):
    T = modes(NEAR, (150.0, 0.01, 0.8), (150.0 + gap, 0.012, 0.5), (700.0, 0.01, 0.3))
    found = rational_fraction(NEAR, T)
    assert found.details["modes"] == 2
    np.testing.assert_allclose(found.details["f_n_all"], [150.0, 150.0 + gap], rtol=1e-5)
    np.testing.assert_allclose(found.details["zeta_all"], [0.010, 0.012], rtol=1e-4)
    if gap == 2.0:  # one peak to the eye, and to half power
        assert half_power_estimate(NEAR, T).zeta > 1.4 * 0.01
        assert choose(NEAR, T).method == "half power"


def test_mode_under_the_peak_is_the_one_reported():
    T = modes(NEAR, (140.0, 0.02, 0.3), (160.0, 0.01, 0.8))
    assert rational_fraction(NEAR, T, modes=2, level=0.1).f_n == pytest.approx(160.0, rel=1e-6)


def test_a_few_points_or_wrong_wishes_are_refused():
    few = np.linspace(0.0, 3.0, 61)
    assert "too few" in rational_fraction(few, dof(0.01, few)).reason
    with pytest.raises(InputError, match="complex transmissibility"):
        rational_fraction(WIDE, np.abs(dof(0.1)), modes=2)
    with pytest.raises(InputError, match="between 0 and 1"):
        rational_fraction(WIDE, dof(0.1), level=2.0)
    with pytest.raises(InputError, match="number of modes must be positive"):
        rational_fraction(WIDE, dof(0.1), modes=0)


# ---- noise and error bars --------------------------------------------------------------------------


def test_noise_level_is_that_of_the_noise_and_zero_on_a_smooth_curve():
    T = np.abs(dof(0.02, NEAR, 150.0))
    assert noise_level(NEAR, T) < 1e-4
    rough = T + 0.1 * np.random.default_rng(1).standard_normal(T.size)
    assert noise_level(NEAR, rough) == pytest.approx(0.1, rel=0.12)


def test_noise_level_does_not_depend_on_the_steps_of_the_curve():
    """Points inserted at a peak are no noise: differences by index took them for it."""
    steps = np.tile([1.0, 0.1, 0.1, 1.0], NEAR.size // 4)
    f = NEAR[0] + (NEAR[-1] - NEAR[0]) * np.cumsum(steps) / steps.sum()
    T = np.abs(dof(0.02, f, 150.0))
    assert noise_level(f, T) < 1e-4
    rough = T + 0.1 * np.random.default_rng(1).standard_normal(T.size)
    assert noise_level(f, rough) == pytest.approx(0.1, rel=0.12)


@pytest.mark.parametrize(
    ("method", "options"),
    [
        (half_power_estimate, {"draws": 20}),
        (gaussian_fit, {"window": "narrowest", "draws": 6}),
        (rational_fraction, {}),
    ],
)
def test_standard_errors_are_the_scatter_over_many_measurements(method, options):
    f = np.linspace(130.0, 170.0, 301)
    T = dof(0.02, f, 150.0)
    count = 10 if method is gaussian_fit else 40
    found = [method(f, noisy(T, 0.01, seed), **options) for seed in range(count)]
    zeta, errors = np.array([e.zeta for e in found]), np.array([e.zeta_error for e in found])
    ratio = errors.mean() / zeta.std(ddof=1)
    assert 0.5 < ratio < 2.0
    if method is rational_fraction:  # best by far; its bias is smaller than its scatter
        assert abs(zeta.mean() - 0.02) < zeta.std()
        assert zeta.std() < 1e-4


def test_lower_bound_is_the_prescribed_damping_of_the_curve():
    for z in (0.05, 0.2, 0.4):
        assert lower_bound(half_power_estimate(WIDE, dof(z))) == pytest.approx(z, rel=1e-3)
    high = gaussian_fit(WIDE, dof(0.4), window="narrowest")
    assert lower_bound(high) == pytest.approx(0.4, rel=1e-3)
    low = gaussian_fit(WIDE, dof(0.05), window="narrowest")  # read too small: the bar is as long, and points down
    assert low.zeta < 0.05
    assert lower_bound(low) == pytest.approx(2.0 * low.zeta - 0.05, rel=1e-2)
    assert isnan(lower_bound(gaussian_fit(WIDE, dof(0.05))))  # window not set by the constraint
    assert isnan(lower_bound(half_power_estimate(WIDE, dof(0.6))))
    assert lower_bound(rational_fraction(WIDE, dof(0.4))) == pytest.approx(0.4, rel=1e-9)


# ---- which method ----------------------------------------------------------------------------------


def test_prominence_and_symmetry_are_what_they_say():
    shape = curve_shape(WIDE, dof(0.2))
    r, peak = peak_transmissibility(0.2)
    read = half_power(WIDE, np.abs(dof(0.2)))
    assert shape.prominence == pytest.approx(1.0 - 1.0 / peak, rel=1e-4)  # the foot is T = 1 at rest
    assert shape.symmetry == pytest.approx((read.f_high - r) / (r - read.f_low), rel=1e-3)
    assert curve_shape(WIDE, dof(0.6)).symmetry == 0.0


def test_method_follows_the_shape_and_says_so():
    sharp = choose(WIDE, dof(0.05))
    assert sharp.method == "half power"
    assert "prominence 0.90" in sharp.reason
    flat = dof(0.45)
    assert choose(WIDE, flat).method == "rational fraction"
    assert choose(WIDE, flat).zeta == pytest.approx(0.45, rel=1e-8)
    assert choose(WIDE, flat, otherwise="gaussian").method == "Gaussian fit"
    assert choose(WIDE, flat, prominence=0.2).method == "half power"
    assert choose(WIDE, noisy(flat, 0.02)).zeta == pytest.approx(0.45, rel=0.02)
    for wrong in ({"prominence": 1.5}, {"symmetry": -0.1}, {"otherwise": "circle"}):
        with pytest.raises(InputError):
            choose(WIDE, flat, **wrong)


@pytest.mark.parametrize("lean", [-0.1, -0.05, 0.05, 0.1])
def test_a_leaning_curve_is_not_taken_for_a_linear_one(lean):
    T = cubic_spring_transmissibility(NEAR, 150.0, 0.02, lean)
    assert np.sign(half_power(NEAR, np.abs(T)).skewness) == -np.sign(lean)  # long tail on the side it leans from
    found = choose(NEAR, T)
    assert found.method == "Gaussian fit"
    assert "rational fraction rejected: its largest misfit" in found.reason
    assert found.zeta == pytest.approx(0.02, rel=0.2)


def test_a_choice_among_known_fits_is_that_of_fits_of_its_own():
    leaning = cubic_spring_transmissibility(NEAR, 150.0, 0.02, 0.1)
    for f, T, method in ((WIDE, dof(0.45), "rational fraction"), (NEAR, leaning, "Gaussian fit")):
        fits = {name: ESTIMATORS[name](f, T) for name in ("half_power", "gaussian_fit", "rational_fraction")}
        alone, known = choose(f, T), choose(f, T, fits=fits)
        assert known.method == method
        assert (known.zeta, known.f_n, known.reason) == (alone.zeta, alone.f_n, alone.reason)


def test_leaning_curve_without_lean_is_the_linear_one():
    np.testing.assert_allclose(
        cubic_spring_transmissibility(NEAR, 150.0, 0.02, 1e-9), dof(0.02, NEAR, 150.0), rtol=1e-6
    )


def test_curves_that_are_none_are_refused():
    f, T = WIDE, np.abs(dof(0.1))
    for wrong in ((f[:5], T[:5]), (f, T[:-1]), (f[::-1], T), (f, -T), (f, np.where(f > 1.0, np.nan, T))):
        with pytest.raises(InputError):
            choose(*wrong)


@pytest.mark.parametrize("zeta", [0.3, 0.5])
def test_gaussian_fit_near_the_peak_is_held_to_half_power_at_its_ends(zeta):
    """Where no free bell falls to half power within the reach, the bell ends there, and the damping saturates."""
    f = np.linspace(0.0, 3.0, 3001)
    T = np.abs(single_dof_transmissibility(f, 1.0, zeta))
    found = gaussian_fit(f, T, reach=0.2, draws=2)
    low, high = found.window
    bell = found.details["bell"]
    assert high - low <= 0.4 * 0.5 * (high + low) * (1.0 + 1e-9)
    assert bell(high) == pytest.approx(T.max() / np.sqrt(2.0), rel=1e-3)
    assert found.zeta < 0.25
    # the height is the best one: a taller and a flatter bell through the same ends fit worse
    inside = (f >= low) & (f <= high)
    q = (bell.d / bell.c) ** 2

    def misfit(q):
        shape = np.exp(q * (1.0 - ((f[inside] - bell.b) / bell.d) ** 2)) / np.sqrt(2.0)
        return np.sum((T.max() * shape - T[inside]) ** 2)

    assert misfit(q) < min(misfit(1.05 * q), misfit(0.95 * q))


def test_gaussian_fit_near_the_peak_is_free_on_a_sharp_peak():
    f = np.linspace(0.5, 1.5, 4001)
    T = np.abs(single_dof_transmissibility(f, 1.0, 0.05))
    near = gaussian_fit(f, T, reach=0.2, draws=2)
    assert near.zeta == pytest.approx(gaussian_fit(f, T, draws=2).zeta, rel=0.01)
    with pytest.raises(InputError, match="reach"):
        gaussian_fit(f, T, reach=-0.1)
    with pytest.raises(InputError, match="reach"):
        gaussian_fit(f, T, reach=0.2, centre="free")
