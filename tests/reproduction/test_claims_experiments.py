"""Judges of chapters 3 and 6: arithmetic on the spot, sweeps and closed forms against independent values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from support.fake_evidence import FakeEvidence, bending_at, judges, member, reference

from reproduction import Evidence, experiments, realistic_scale, shaker_random, shaker_sweeps, sweep_rate
from reproduction.verdict import MET, NOT_MET, THESIS_ERROR
from wroll_fem.plotting.study import StudyCase
from wroll_fem.signals.estimators import peak_transmissibility

QUICK = {
    "C33": MET, "C34": MET, "C37": MET, "C56": MET, "C94": MET, "C103": MET, "C108": MET,
}  # fmt: skip
SIZED = {"C91": MET, "C92": NOT_MET, "C93": THESIS_ERROR}


@pytest.mark.parametrize("name", QUICK)
def test_what_needs_no_run_is_judged_on_the_spot(name: str, evidence: Evidence) -> None:
    verdict = judges("ch3", "ch6")[name](evidence)
    assert verdict.word == QUICK[name], verdict.value


@pytest.mark.slow
def test_the_claims_on_sizing_are_judged_on_one_sizing_of_the_mandrels(evidence: Evidence) -> None:
    found = {name: judges("ch6")[name](evidence) for name in SIZED}
    assert {name: verdict.word for name, verdict in found.items()} == SIZED, found


# ---- sweep rate ----------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [1, -1])
def test_attainment_is_that_of_the_equation_of_motion(direction: int) -> None:
    """z'' + 2 zeta z' + z = -sin(phase) in real numbers, swept through the resonance."""
    zeta, rate = 0.05, 1.25
    growth = direction * rate * np.log(2.0) / 60.0 / (2.0 * np.pi)
    start = 1.0 - direction * 0.6

    def slope(t: float, y: np.ndarray) -> list[float]:
        phase = start * np.expm1(growth * t) / growth
        return [y[1], -np.sin(phase) - 2.0 * zeta * y[1] - y[0]]

    time = np.linspace(0.0, np.log((1.0 + direction * 0.6) / start) / growth, 40001)
    found = solve_ivp(slope, (0.0, time[-1]), [0.0, 0.0], "DOP853", time, rtol=1e-9, atol=1e-10)
    near = np.abs(start * np.exp(growth * time) - 1.0) < 0.3
    peak = np.abs(2.0 * zeta * found.y[1] + found.y[0])[near].max() / peak_transmissibility(zeta)[1]
    assert 0.8 < peak < 0.97
    assert sweep_rate.attainment(zeta, rate, direction) == pytest.approx(peak, rel=1e-3)


def test_rates_that_grow_with_the_damping_itself_are_not_met(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    for power, word in ((2.0, MET), (1.95, MET), (1.0, NOT_MET)):
        rates = [500.0 * z**power for z in sweep_rate.ZETAS]
        monkeypatch.setattr(sweep_rate, "limits", lambda _, direction=1, rates=rates: rates)
        assert sweep_rate.c35(evidence).word == word


# ---- the lab roll --------------------------------------------------------------------------------


def swept(pressure: float, f_n: float) -> StudyCase:
    """Slow sweep with a resonance."""
    data = xr.Dataset({"transmissibility_real": ("frequency", np.ones(3))}, {"time": [0.0, 1.0]})
    return member(data.assign_attrs(f_n_hz=f_n, zeta=0.02, peak_transmissibility=20.0), preload__pressure=pressure)


def curve(low: float, high: float) -> xr.Dataset:
    """Backbone from one frequency at rest to another at the largest amplitude."""
    base = np.geomspace(0.4, 6.0, 40)
    f = low + (high - low) * np.log(base / 0.4) / np.log(15.0)
    data = {"resonance_frequency": ("tip_amplitude", f), "resonant_base_acceleration": ("tip_amplitude", base)}
    return xr.Dataset(data, {"tip_amplitude": np.geomspace(1e-6, 5e-4, 40)})


ENDS = {
    0.25: {1e4: (153.0, 130.0), 1e5: (159.0, 157.5), 1e6: (160.0, 159.0)},
    0.5: {1e4: (156.0, 140.0), 1e5: (159.0, 156.0), 1e6: (160.5, 160.0)},
}
"""Friction coefficient -> preload -> resonance at small and at large amplitude, Hz; meets C39 to C42."""


def lab(folder: Path, ends: dict[float, dict[float, tuple[float, float]]] | None = None) -> FakeEvidence:
    """Evidence of the lab roll over preload and level that meets C38 to C44 but for what is changed."""
    backbones = [
        member(curve(*pair), contact__friction__mu=mu, preload__pressure=p)
        for mu, by in (ENDS if ends is None else ENDS | ends).items()
        for p, pair in by.items()
    ]
    bonded = member(bending_at(162.0), modal__interface="bonded", coil__base="free")
    low = [swept(p, f) for p, f in ((1e3, 126.4), (3e3, 127.0))]
    studies = {"levels": backbones, "preload_low": low, "bounds": [bonded, reference(bending_at(150.5))]}
    return FakeEvidence(folder, studies)


@pytest.fixture(autouse=True)
def highest(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Largest resonance of the fast sweeps, for C42; readings of random motion, for the text of C40."""
    found = [158.0]
    sweep = shaker_sweeps.Reading(300.0, 0.0, 0.015, 60.0, 1.1, 0.0, 0.015, 1.1)
    monkeypatch.setattr(shaker_sweeps, "readings", lambda _: [sweep._replace(f_n=found[0])])
    ones = np.ones(3)
    series = [
        shaker_random.Series(t, ones, ones, ones, f * ones, ones, ones, ones) for t, f in ((0.0, 150.0), (20.0, 151.0))
    ]
    monkeypatch.setattr(shaker_random, "readings", lambda _: series)
    return found


@pytest.mark.parametrize("name", ["C38", "C39", "C40", "C42", "C44"])
def test_a_roll_as_in_the_experiments_is_met(name: str, tmp_path: Path) -> None:
    verdict = experiments.GROUP.judges[name](lab(tmp_path))
    assert verdict.word == MET, verdict.value


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("C39", {"ends": {0.25: {1e4: (152.0, 130.0), 1e5: (150.0, 140.0), 1e6: (160.0, 159.0)}}}),
        ("C39", {"ends": {0.25: {1e4: (152.0, 150.0), 1e5: (157.0, 151.0), 1e6: (160.0, 152.0)}}}),
        ("C40", {"ends": {0.25: {1e4: (150.0, 130.0), 1e5: (157.0, 148.0), 1e6: (160.0, 159.0)}}}),
        ("C42", {"ends": {0.25: {1e4: (152.0, 130.0), 1e5: (157.0, 148.0), 1e6: (164.0, 163.0)}}}),
        ("C44", {"ends": {0.25: {1e4: (152.0, 130.0), 1e5: (159.0, 157.5), 1e6: (160.0, 152.5)}}}),
    ],
)
def test_a_roll_otherwise_is_not_met(name: str, changed: dict, tmp_path: Path) -> None:
    assert experiments.GROUP.judges[name](lab(tmp_path, **changed)).word == NOT_MET


def test_a_sweep_above_the_bonded_roll_is_not_met(highest: list[float], tmp_path: Path) -> None:
    highest[0] = 163.5
    assert experiments.c42(lab(tmp_path)).word == NOT_MET


def test_more_friction_is_compared_preload_by_preload(tmp_path: Path) -> None:
    high = {1e4: (156.0, 140.0), 1e5: (160.4, 159.6), 1e6: (160.5, 160.0)}
    assert experiments.c41(lab(tmp_path, ends={0.5: high})).word == MET
    assert experiments.c41(lab(tmp_path, ends={0.5: high | {1e6: (159.0, 158.0)}})).word == NOT_MET
    assert experiments.c41(lab(tmp_path, ends={0.5: high | {1e4: (150.0, 120.0)}})).word == NOT_MET


def test_resonance_at_a_level_is_the_first_that_needs_it() -> None:
    data = curve(152.0, 130.0)
    assert experiments.at_level(data, 6.0) == pytest.approx(130.0)
    middle = np.sqrt(0.4 * 6.0)
    assert experiments.at_level(data, middle) == pytest.approx(141.0, abs=1e-6)
    assert np.isnan(experiments.at_level(data, 30.0))
    assert np.isnan(experiments.at_level(data, 0.01))


# ---- realistic scale -----------------------------------------------------------------------------


def test_lateral_buckling_is_the_windenburg_formula_for_a_tube_of_medium_length() -> None:
    """2.42 E (t/2r)^2.5 / ((1 - nu^2)^0.75 (L/2r - 0.45 sqrt(t/2r))), Windenburg and Trilling (1934)."""
    radius, wall, length, nu = 0.5, 2e-3, 1.0, realistic_scale.POISSON
    ratio = wall / (2.0 * radius)
    formula = 2.42 * realistic_scale.YOUNG * ratio**2.5 / ((1.0 - nu**2) ** 0.75)
    formula /= length / (2.0 * radius) - 0.45 * np.sqrt(ratio)
    critical, waves = realistic_scale.lateral_buckling(radius, wall, length)
    assert critical == pytest.approx(formula, rel=0.06)
    assert waves > 4


def sized(walls: tuple[float, float]) -> xr.Dataset:
    """Result of a sizing with two readings."""
    thickness = np.geomspace(1e-4, 0.05, 9)
    margin = np.column_stack([np.log(thickness / wall) + 0.25 for wall in (walls[0], 1e-3)])
    return xr.Dataset(
        {"wall_thickness": ("reading", list(walls)), "margin": (("mandrel_thickness", "reading"), margin)},
        coords={"reading": ["membrane", "surface"], "mandrel_thickness": thickness},
    )


@pytest.mark.parametrize(("ratio", "word"), [(1.09, MET), (1.11, NOT_MET)])
def test_one_reading_has_to_fit_all_three_walls(ratio: float, word: str, tmp_path: Path) -> None:
    printed = {f"sizing_{name.lower()}": one.wall for name, one in realistic_scale.STRUCTURES.items()}

    def answer(config: str, *overrides: str) -> xr.Dataset:
        """Membrane off by the ratio; surface exact but for one structure, which has no wall."""
        wall = printed[config]
        return sized((ratio * wall, np.nan if config == "sizing_sspp" else wall))

    verdict = realistic_scale.c92(FakeEvidence(tmp_path, answer=answer))
    assert verdict.word == word
    assert "closest: membrane" in verdict.value


def test_the_sizing_cases_are_the_structures(evidence: Evidence) -> None:
    structures = realistic_scale.STRUCTURES.values()
    for words, one in zip(realistic_scale.sizing_cases(printed_wall=True), structures, strict=True):
        sizing = evidence.case(*words).sizing
        sizes = (sizing.length, sizing.mandrel_outer_diameter, sizing.coil_outer_diameter)
        assert (*sizes, sizing.coil_mass, sizing.wall) == (one.length, one.diameter, one.outer, one.coil_mass, one.wall)
        material = (realistic_scale.YOUNG, realistic_scale.POISSON, realistic_scale.DENSITY, realistic_scale.YIELD)
        assert (sizing.E, sizing.nu, sizing.rho, sizing.yield_stress) == material
        assert (sizing.factor_of_safety, sizing.margin) == (realistic_scale.SAFETY, realistic_scale.MARGIN)
        assert (sizing.pressure, sizing.acceleration_g) == (realistic_scale.PRESSURE, 100.0)


@pytest.mark.parametrize(("fine", "word"), [(100.5, MET), (102.0, NOT_MET)])
def test_mandrel_frequencies_have_to_converge(fine: float, word: str, tmp_path: Path) -> None:
    def answer(config: str, *overrides: str) -> xr.Dataset:
        assert config == "lab_mandrel"
        return bending_at(fine if "mesh.axial=32" in overrides else 100.0)

    assert realistic_scale.c109(FakeEvidence(tmp_path, answer=answer)).word == word


def test_mandrels_of_the_structures_are_valid_cases(evidence: Evidence) -> None:
    for one in realistic_scale.STRUCTURES.values():
        case = evidence.case("lab_mandrel", *realistic_scale.mandrel_overrides(one))
        assert case.hash()
