"""The estimator that a case names (`output.damping`): what reaches the summary, and where it is refused."""

from __future__ import annotations

import hashlib
import json

import numpy as np
import pytest
from support.paths import CONFIGS

from wroll_fem import analyses, load_case
from wroll_fem.analyses.curve_reading import read_response
from wroll_fem.errors import InputError
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.estimators import (
    ESTIMATORS,
    cubic_spring_transmissibility,
    estimate_damping,
    single_dof_transmissibility,
)

OSCILLATOR = CONFIGS / "oscillator.yaml"
F = np.linspace(100.0, 200.0, 801)
LINEAR = single_dof_transmissibility(F, 150.0, 0.1)


def test_every_estimator_reads_a_linear_curve_as_it_does_by_itself() -> None:
    true = estimate_damping(F, LINEAR, "rational_fraction")
    assert (true.damping.f_n, true.damping.zeta) == pytest.approx((150.0, 0.1), rel=1e-9)
    shape = half_power(F, np.hypot(LINEAR.real, LINEAR.imag))
    for method in ESTIMATORS:
        read = estimate_damping(F, LINEAR, method)
        assert read.shape == shape
        assert str(read.damping) == str(ESTIMATORS[method](F, LINEAR))
        assert read.warnings == []
        attrs = read.as_attrs("a curve")
        assert (attrs["f_n_hz"], attrs["zeta"]) == pytest.approx((read.damping.f_n, read.damping.zeta), rel=1e-12)
        assert attrs["zeta_method"] == f"{read.damping.method}, a curve"
        assert (attrs["half_power_low_hz"], attrs["skewness"]) == (shape.f_low, shape.skewness)
    assert estimate_damping(F, LINEAR, "half_power").as_attrs("")["zeta"] == shape.zeta  # to the last bit


def test_error_bars_are_those_of_noise() -> None:
    f, exact = F[::2], LINEAR[::2]
    noisy = exact + 0.01 * np.random.default_rng(1).standard_normal((2, f.size)).T @ [1.0, 1.0j]
    for method in ("half_power", "gaussian_fit", "rational_fraction"):
        attrs = estimate_damping(f, noisy, method).as_attrs("")
        assert 0.0 < attrs["zeta_error"] < 0.1 * attrs["zeta"]
        assert 0.0 < attrs["zeta_lower_bound"] <= attrs["zeta"] - attrs["zeta_error"]
        assert attrs["f_n_error_hz"] > 0.0
    assert "zeta_misfit" in attrs


def test_a_large_misfit_causes_a_warning() -> None:
    [warning] = estimate_damping(F, cubic_spring_transmissibility(F, 150.0, 0.03, 0.15), "rational_fraction").warnings
    assert "the misfit of the rational fraction is" in warning
    assert "zeta_misfit" in warning


def test_a_mode_outside_the_band_is_no_reading() -> None:
    below = F < 120.0
    read = estimate_damping(F[below], LINEAR[below], "rational_fraction")
    assert not read.damping.found
    assert read.warnings == ["rational fraction gives no damping: the fitted mode, 150 Hz, lies outside the band"]
    attrs = read.as_attrs("")
    assert np.isnan(attrs["zeta"])
    assert np.isnan(attrs["f_n_hz"])
    assert "zeta_error" not in attrs


@pytest.mark.parametrize("method", ESTIMATORS)
def test_a_maximum_in_phase_with_the_base_is_no_resonance(method: str) -> None:
    above = np.linspace(400.0, 420.0, 401)
    ripples = (0.74 + 0.1 * np.exp(-(((above - 413.4) / 3.0) ** 2))).astype(complex)
    read = estimate_damping(above, ripples, method)
    attrs = read.as_attrs("")
    assert np.isnan([attrs["f_n_hz"], attrs["zeta"], attrs["peak_transmissibility"]]).all()
    assert "has a phase of 0 degrees" in attrs["half_power_reason"]
    [warning] = read.warnings
    assert "no resonance inside" in warning or "gives no damping" in warning
    heavy = estimate_damping(F, single_dof_transmissibility(F, 150.0, 0.25), method)
    assert heavy.shape.resonant


def test_few_points_are_read_by_half_power_alone() -> None:
    """1e-12: magnitudes of an array with gaps in memory may differ from those of a copy in their last digit."""
    few, T = F[::133], LINEAR[::133]
    assert few.size == 7
    found = estimate_damping(few, T)
    assert found.as_attrs("")["zeta"] == pytest.approx(half_power(few, np.abs(T)).zeta, rel=1e-12)
    assert "zeta_error" not in found.as_attrs("")
    assert "7 points are too few" in estimate_damping(few, T, "gaussian_fit").warnings[0]
    with pytest.raises(InputError, match="unknown estimator"):
        estimate_damping(F, LINEAR, "thirds")


def test_the_default_changes_no_hash_and_another_method_does() -> None:
    plain, named, other = (
        load_case(OSCILLATOR, words) for words in ((), ["output.damping=half_power"], ["output.damping=choose"])
    )
    assert plain.hash() == named.hash() != other.hash()
    masses = load_case(CONFIGS / "two_dof.yaml")  # no files, no solver: all that can change a number as it stands
    before = {key: value for key, value in masses.resolved().items() if key != "output"}
    assert masses.hash() == hashlib.sha256(json.dumps(before, sort_keys=True).encode()).hexdigest()
    for words in ("output.figures=false", "output.every=7"):
        assert load_case(OSCILLATOR, [words]).hash() == plain.hash()
        assert load_case(OSCILLATOR, [words, "output.damping=choose"]).hash() == other.hash()


def test_summary_of_a_sweep_holds_what_the_case_asks_for() -> None:
    found = {}
    for method in ("half_power", "gaussian_fit"):
        case = load_case(
            OSCILLATOR, ["excitation.rate_oct_per_min=20", "integrator.steps_per_cycle=40", f"output.damping={method}"]
        )
        found[method] = analyses.summarise(analyses.run_analysis(case, progress=SilentProgress()), case)
    half, bell = found["half_power"], found["gaussian_fit"]
    assert half["zeta_method"] == "half power, demodulated envelope"
    assert bell["zeta_method"] == "Gaussian fit, demodulated envelope"
    assert 0.0 < abs(bell["zeta_apparent"] / half["zeta_apparent"] - 1.0) < 0.4
    for one in (half, bell):  # 20 oct/min is too fast
        assert one["zeta_quality"] == "invalid"
        assert np.isnan(one["zeta"])
        assert "zeta_error" not in one
        assert "ISO 7626-2 limit" in one["zeta_doubts"][0]
        assert set(one["zeta_doubts"]) <= set(one["warnings"])
    for name in ("peak_transmissibility", "half_power_low_hz", "skewness"):
        assert bell[name] == half[name]


def test_summary_of_a_harmonic_curve_holds_what_the_case_asks_for() -> None:
    words = [
        "mesh={circumferential: 8, axial: 2, grading: 1}",
        "harmonic={harmonics: 1, samples: 32}",
        "output.damping=gaussian_fit",
    ]
    case = load_case(CONFIGS / "lab_harmonic.yaml", words)
    data = analyses.run_analysis(case, progress=SilentProgress())
    summary = analyses.summarise(data, case)
    assert summary["zeta_method"] == "Gaussian fit, harmonic balance"
    half, bell = (read_response(data, method) for method in ("half_power", "gaussian_fit"))
    assert summary["zeta"] == bell.damping.zeta != half.damping.zeta
    assert summary["skewness"] == half.shape.skewness


def test_two_masses_are_read_by_the_same_estimators() -> None:
    words = ["two_dof.omega.points=60", "two_dof.friction_capacity=[2, 50]", "output.damping=choose"]
    case = load_case(CONFIGS / "two_dof.yaml", words)
    summary = analyses.summarise(analyses.run_analysis(case, progress=SilentProgress()), case)
    assert summary["zeta_method"] == ["rational fraction", "half power"]  # one-sided peak, sharp peak
    assert all(low < zeta for low, zeta in zip(summary["zeta_lower_bound"], summary["zeta"], strict=True))


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("tiny.yaml", "analysis dwell has no response curve from which damping is estimated"),
        ("lab_modal.yaml", "analysis modal has no response curve"),
        ("two_dof_design_space.yaml", "the map of the design space is computed with half_power"),
    ],
)
def test_an_estimator_without_a_curve_is_refused(file: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        load_case(CONFIGS / file, ["output.damping=choose"])
    assert "output.damping" in str(caught.value)
    assert load_case(CONFIGS / file, ["output.damping=half_power"])
