"""The random rolls of the benchmark are valid cases, the same in every run."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

from wroll_fem.case.loader import build_case


@pytest.fixture(scope="module")
def rolls(root: Path):
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(root / "benchmarks"))
        return importlib.import_module("random_rolls")


@pytest.fixture(scope="module")
def agreement(rolls):
    return importlib.import_module("roll_agreement")


HARMONIC = {
    "outcome": "curve", "f_n_hz": 100.0, "peak_transmissibility": 50.0, "zeta_apparent": 0.01,
    "half_power_low_hz": 99.0, "half_power_high_hz": 101.0, "warnings": [],
    "curve_hz": [50.0, 90.0, 100.0, 110.0, 150.0], "curve_magnitude": [1.3, 5.0, 50.0, 5.0, 0.8],
}  # fmt: skip
FAST = "sweep of 9 oct/min runs at 90 % of the ISO 7626-2 limit for ..."


@pytest.mark.parametrize(
    ("f_n", "peak", "warnings", "verdict"),
    [
        (100.9, 47.6, [], "agree"),
        (101.1, 50.0, [], "not explained"),
        (100.0, 47.4, [], "not explained"),
        (103.0, 40.0, [FAST], "explained"),
        (float("nan"), float("nan"), [], "not explained"),
        (101.1, 50.0, ["layers slide by up to 25 mm"], "not explained"),
    ],
)
def test_a_sweep_agrees_differs_with_a_warning_or_is_not_explained(agreement, f_n, peak, warnings, verdict) -> None:
    sweep = {"outcome": "curve", "f_n_hz": f_n, "peak_transmissibility": peak, "warnings": warnings}
    assert agreement.verdict("sweep", HARMONIC, sweep)["verdict"] == verdict


def test_a_dwell_is_compared_at_its_frequency(agreement) -> None:
    dwell = {"outcome": "curve", "frequency_hz": 90.0, "steady_magnitude": 5.2, "warnings": []}
    assert agreement.verdict("dwell", HARMONIC, dwell)["verdict"] == "agree"
    assert agreement.verdict("dwell", HARMONIC, dwell | {"frequency_hz": 100.0})["verdict"] == "not explained"
    assert agreement.verdict("dwell", HARMONIC, dwell | {"outcome": "limit"}) is None


def test_a_slow_sweep_runs_at_a_fifth_of_the_admissible_rate(rolls) -> None:
    motion = rolls.slow_sweep(HARMONIC)
    assert motion["rate_oct_per_min"] == pytest.approx(0.2 * 312 * 0.01**2 * 100.0, rel=1e-2)
    assert motion["f_start"] < 99.0 < 101.0 < motion["f_end"]
    steep = rolls.slow_sweep(HARMONIC | {"half_power_low_hz": 99.6})
    assert steep["rate_oct_per_min"] == pytest.approx(0.4 * 312 * 0.004**2 * 100.0, rel=1e-2)
    assert rolls.slow_sweep(HARMONIC | {"zeta_apparent": float("nan")}) is None
    build_case(rolls.random_case(0, "slow", HARMONIC))


def test_the_page_counts_what_was_run(rolls) -> None:
    reports = [HARMONIC | {"roll": 0, "analysis": "harmonic", "seconds": 3.0, "cause": ""}]
    reports.append(
        {"roll": 0, "analysis": "sweep", "seconds": 60.0, "cause": "not finished in 60 CPU s", "outcome": "limit"}
    )
    text = "\n".join(rolls.page(reports))
    assert text.startswith("1 random valid rolls (numbers 0), of 200")
    assert rolls.ranges({0, 1, 2, 5, 45, 46}) == "0-2, 5, 45-46"
    assert "| harmonic | 1 | 1 | 0 | 0 | 0 | 0 | 0 | 100.0 %" in text
    assert "| 0 | sweep | 60.0 | limit | not finished in 60 CPU s |" in text


def test_every_random_roll_is_a_valid_case(rolls) -> None:
    seen = set()
    for index in range(40):
        for analysis in ("harmonic", "backbone", "sweep", "dwell"):
            case = build_case(rolls.random_case(index, analysis))
            assert case.analysis == analysis
        seen.add((case.coil.base, case.mandrel.tip, case.coil.layers))
        assert 5e3 <= case.preload.pressure <= 2e5
        assert 0.05 <= case.friction.mu <= 1.0
        assert 0.049 <= case.excitation.amplitude / rolls.EARTH <= 3.01
    assert {base for base, _, _ in seen} == {"free", "clamped", "inner_edge"}
    assert {tip for _, tip, _ in seen} == {"rigid", "free"}
    assert {layers for _, _, layers in seen} == {1, 2, 3, 4}


def test_a_roll_is_the_same_in_every_run(rolls) -> None:
    assert rolls.random_roll(7) == rolls.random_roll(7)
    assert rolls.random_roll(7) != rolls.random_roll(8)
