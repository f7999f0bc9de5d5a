"""Quality of a damping ratio, on curves whose damping ratio is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.oscillator import steady, swept_oscillator

from wroll_fem.signals.base_motion import sweep_rate_limit
from wroll_fem.signals.estimators.curve_damping import estimate_damping
from wroll_fem.signals.quality import Circumstances, height_damping, judge
from wroll_fem.signals.sweeps import Chirp
from wroll_fem.signals.transmissibility import demodulated, magnitude, spectrum_ratio

F_N = 150.0


def swept(zeta, share, *, start=0.88, end=1.16, ramp=10):
    """Estimate and quality of an exact sweep of an oscillator at a share of the ISO 7626-2 rate."""
    motion = Chirp(5.0, start * F_N, end * F_N, share * sweep_rate_limit(F_N, zeta), ramp_cycles=ramp)
    time, base, tip = swept_oscillator(motion, F_N, zeta)
    curve = demodulated(time, tip, motion)
    f, T = curve["frequency"].values, curve["transmissibility_real"].values + 1j * curve["transmissibility_imag"].values
    spectrum = magnitude(spectrum_ratio(time, tip, base, frequency=f), "transmissibility_spectrum").values
    read = estimate_damping(f, T)
    return read, judge(read, f, np.abs(T), Circumstances(motion, 1.0, spectrum=spectrum))


def judged(f, T, **known):
    read = estimate_damping(f, T)
    return read, judge(read, f, np.abs(T), Circumstances(**{"participation": 1.0} | known))


def test_slow_sweep_of_an_oscillator_is_ok():
    read, quality = swept(0.02, 0.1)
    assert read.damping.zeta == pytest.approx(0.02, rel=0.01)
    assert quality.grade == "ok"
    assert quality.reasons == ()
    attrs = quality.as_attrs(read.as_attrs("demodulated envelope"))
    assert attrs["zeta"] == attrs["zeta_apparent"] == pytest.approx(read.damping.zeta)
    assert attrs["zeta_spread"] < 0.05


def test_ringing_curve_gives_no_damping_ratio():
    """At ten times the ISO rate the width of the first hump is several times that of the resonance."""
    read, quality = swept(0.005, 10.0)
    assert read.damping.zeta > 0.01
    assert quality.grade == "invalid"
    assert "ISO 7626-2 limit" in quality.reasons[0]
    assert any("from the height of the peak" in text and "the response rings" in text for text in quality.reasons)
    attrs = quality.as_attrs(read.as_attrs("demodulated envelope"))
    assert np.isnan(attrs["zeta"])
    assert attrs["zeta_apparent"] == pytest.approx(read.damping.zeta)
    assert "zeta_error" not in attrs


@pytest.mark.parametrize(("count", "fewest"), [(8, 1), pytest.param(60, 5, marks=pytest.mark.slow)])
def test_grades_of_random_sweeps_hold(count, fewest):
    """Oscillators and rates at random, seed 13: what is called ok is right, and what is called invalid is wrong."""
    random = np.random.default_rng(13)
    errors: dict[str, list[float]] = {"ok": [], "doubtful": [], "invalid": []}
    for _ in range(count):
        zeta, share = np.exp(random.uniform(np.log([0.003, 0.03]), np.log([0.05, 6.0])))
        wide = 1.0 + 12.0 * zeta
        read, quality = swept(zeta, share, start=1.0 / wide, end=wide, ramp=3)
        errors[quality.grade].append(abs(read.damping.zeta / zeta - 1.0))
    assert min(len(found) for found in errors.values()) >= fewest
    assert max(errors["ok"]) < 0.03
    assert min(errors["invalid"]) > 0.1


def test_sweep_that_starts_on_the_flank_is_doubtful():
    _, far = swept(0.01, 0.2, start=0.93)
    _, near = swept(0.01, 0.2, start=0.987, ramp=0)
    assert far.grade == "ok"
    assert near.grade == "doubtful"
    assert any("starts at 148.05 Hz, on the flank" in text and "excitation.f_start" in text for text in near.reasons)


def test_width_that_does_not_fit_the_height_is_doubtful_in_a_steady_curve():
    f = np.linspace(130.0, 170.0, 2001)
    T = steady(f, F_N, 0.01)
    read, fits = judged(f, T)
    assert fits.grade == "ok"
    assert height_damping(read.shape, 1.0) == pytest.approx(0.01, rel=1e-4)
    for participation, grade in ((1.4, "ok"), (1.6, "doubtful"), (0.7, "ok"), (0.6, "doubtful")):
        assert judged(f, T, participation=participation)[1].grade == grade
    _, other = judged(f, T, participation=0.6)
    assert "zeta = 1 % by half power, but 0.6 % from the height of the peak, 0.60/(2 T)" in other.reasons[0]
    assert judged(f, T, participation=None)[1].grade == "ok"


def test_second_peak_is_doubtful_and_named():
    f = np.linspace(130.0, 170.0, 2001)
    for height, grade in ((0.5, "ok"), (0.8, "doubtful")):
        T = steady(f, 145.0, 0.01) + height * (steady(f, 158.0, 0.01) - 1.0)
        _, quality = judged(f, T)
        assert quality.grade == grade
        assert all("2 peaks above 60 %" in text or "rises above" in text for text in quality.reasons)


def test_folds_large_damping_few_points_and_remarks_are_doubtful():
    f = np.linspace(100.0, 200.0, 2001)
    T = steady(f, F_N, 0.01)
    assert judged(f, T, several=(148.0, 148.001))[1].grade == "ok"
    assert "several periodic motions" in judged(f, T, several=(148.0, 149.0))[1].reasons[0]
    assert judged(f, T, remarks=("", "the step is too long"))[1].reasons == ("the step is too long",)
    wide = np.linspace(20.0, 500.0, 2001)
    assert "zeta is 28 %" in judged(wide, steady(wide, F_N, 0.25))[1].reasons[0]
    coarse = np.linspace(100.3, 200.0, 101)
    assert "points of the curve lie between" in judged(coarse, steady(coarse, F_N, 0.01))[1].reasons[0]


def test_curve_without_resonance_or_half_power_point_is_invalid_with_its_reason():
    f = np.linspace(100.0, 140.0, 401)
    _, none = judged(f, steady(f, F_N, 0.01))
    assert none.grade == "invalid"
    assert "no resonance inside" in none.reasons[0]
    f = np.linspace(149.5, 170.0, 401)
    _, half = judged(f, steady(f, F_N, 0.01))
    assert half.grade == "invalid"
    assert "no half-power point between" in half.reasons[0]
    assert half.reasons[1:] == ()


def test_what_is_known_besides_is_told_without_a_damping_ratio():
    """Ringing hides half-power points, so that the rate of the sweep is judged by the height of the peak."""
    f = np.linspace(149.5, 170.0, 401)
    for share, words in ((0.01, ["half-power", "a remark"]), (4.0, ["half-power", "ISO 7626-2 limit", "a remark"])):
        motion = Chirp(5.0, 140.0, 170.0, share * sweep_rate_limit(F_N, 0.01))
        _, quality = judged(f, steady(f, F_N, 0.01), motion=motion, remarks=("a remark",))
        assert quality.grade == "invalid"
        assert len(quality.reasons) == len(words)
        assert all(word in text for word, text in zip(words, quality.reasons, strict=True))
    away = np.linspace(100.0, 140.0, 401)
    _, none = judged(away, steady(away, F_N, 0.01), motion=motion, remarks=("a remark",))
    assert none.reasons == (none.reasons[0], "a remark")


def test_worst_reason_comes_first():
    read, quality = swept(0.005, 10.0)
    f = np.linspace(130.0, 170.0, 1001)
    known = Circumstances(participation=1.0, remarks=("a remark",))
    assert quality.reasons[0].startswith("sweep of")
    assert judge(replace(read), f, np.abs(steady(f, F_N, 0.01)), known).reasons[-1] == "a remark"
