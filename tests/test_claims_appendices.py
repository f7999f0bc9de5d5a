"""Judges of chapter 5 and the appendices: what needs no run is judged for real, criteria fail on changed evidence."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

from wroll_fem.claims import (
    Evidence,
    Verdict,
    elastic_slip,
    estimators,
    integrators,
    kapton_friction,
    shear_tests,
    smoothed_sign,
    two_dof,
    two_dof_figures,
    two_dof_study,
)
from wroll_fem.claims.checklist import explanations, of_chapters
from wroll_fem.claims.reproduce import families
from wroll_fem.claims.verdict import EXPERIMENT, MET, NOT_MET, THESIS_ERROR
from wroll_fem.dynamics.hht import Scheme
from wroll_fem.lab import RateAndState
from wroll_fem.plotting.study import SeriesMember

KNOWN = {
    **dict.fromkeys(("C85", "C88", "C89", "C110", "C114", "C117", "C118"), NOT_MET),
    **dict.fromkeys(("C87", "C121", "C122", "C126"), THESIS_ERROR),
}
"""Verdicts of the full run that need an explanation."""
QUICK = {
    "C77": MET, "C86": MET, "C87": THESIS_ERROR, "C111": MET, "C112": MET, "C116": MET, "C117": NOT_MET,
    "C118": NOT_MET, "C121": THESIS_ERROR, "C122": THESIS_ERROR, "C123": EXPERIMENT, "C124": MET, "C126": THESIS_ERROR,
}  # fmt: skip
"""Verdicts of claims that need no run."""


def judges() -> dict[str, Callable[[Evidence], Verdict]]:
    return {name: one for chapter in ("ch5", "appendices") for f in families(chapter) for name, one in f.judges.items()}


@pytest.fixture
def evidence(tmp_path: Path) -> Evidence:
    return Evidence(tmp_path, workers=1)


@pytest.mark.parametrize("chapter", ["ch5", "appendices"])
def test_every_claim_of_the_chapter_has_one_judge(chapter: str) -> None:
    names = [name for family in families(chapter) for name in family.judges]
    assert sorted(names) == sorted(claim.id for claim in of_chapters([chapter]))
    figures = [name for one in ("ch5", "appendices") for family in families(one) for name in family.figures]
    assert len(figures) == len(set(figures))


@pytest.mark.parametrize("name", KNOWN)
def test_claims_that_are_not_met_or_name_an_error_are_explained(name: str) -> None:
    text = explanations()[name]
    if KNOWN[name] == NOT_MET:
        assert "computed" in text.lower()
        assert "cause" in text.lower()


@pytest.mark.parametrize("name", QUICK)
def test_what_needs_no_run_is_judged_on_the_spot(name: str, evidence: Evidence) -> None:
    verdict = judges()[name](evidence)
    assert verdict.word == QUICK[name], verdict.value


# ---- chapter 5 -----------------------------------------------------------------------------------


def curves(**changed: Sequence[float]) -> xr.Dataset:
    """Readings of the two masses as the full run has them."""
    line = {
        "peak_transmissibility": [91.85, 9.689, 14.21, 25.52, 50.91, 99.17, 230.2, 385.6],
        "omega_peak": [0.8286, 0.9676, 1.0299, 1.0641, 1.0752, 1.0786, 1.0782, 1.0780],
        "skewness": [0.19, 1.526, 1.134, 0.972, 0.460, -0.141, -0.122, -0.001],
        "zeta": [0.0023, 0.0706, 0.0503, 0.0277, 0.0137, 0.0069, 0.0027, 0.0013],
    } | changed
    data = {name: ("friction_capacity", list(values)) for name, values in line.items()}
    data["transmissibility"] = "friction_capacity", np.ones(8)
    capacities = [1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0]
    return xr.Dataset(data, {"friction_capacity": capacities}, {"energy_balance_error": 1e-9})


def swapped(values: Sequence[float], i: int, j: int) -> list[float]:
    found = list(values)
    found[i], found[j] = found[j], found[i]
    return found


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("C81", {"omega_peak": [0.84, *curves()["omega_peak"].values[1:]]}),
        ("C82", {"peak_transmissibility": swapped(curves()["peak_transmissibility"].values, 3, 5)}),
        ("C83", {"peak_transmissibility": swapped(curves()["peak_transmissibility"].values, 3, 5)}),
        ("C83", {"omega_peak": swapped(curves()["omega_peak"].values, 3, 5)}),
        ("C83", {"skewness": swapped(curves()["skewness"].values, 5, 7)}),
        ("C84", {"skewness": swapped(curves()["skewness"].values, 1, 6)}),
    ],
)
def test_readings_of_the_two_masses_decide(
    name: str, changed: dict[str, Sequence[float]], evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    for study in ("series", "fine"):
        monkeypatch.setattr(two_dof_study, study, lambda _: curves())
    assert judges()[name](evidence).word == MET
    for study in ("series", "fine"):
        monkeypatch.setattr(two_dof_study, study, lambda _: curves(**changed))
    assert judges()[name](evidence).word == NOT_MET


def over_motions(names: Sequence[str], factor: float) -> xr.Dataset:
    """Two methods that differ by a factor at one point."""
    values = np.ones((2, 3))
    other = values.copy()
    other[1, 2] = factor
    dims = ("friction_capacity", "omega")
    data = {names[0]: (dims, values), names[1]: (dims, other), "periods": (dims, 40.0 * values)}
    return xr.Dataset(data, {"friction_capacity": [1.0, 2.0], "omega": [0.5, 1.0, 1.5]})


@pytest.mark.parametrize(
    ("name", "study", "names", "near", "far"),
    [("C78", "settled", ("periodic", "in_time"), 1 + 5e-5, 1 + 2e-4),
     ("C85", "dwelt", ("periodic", "six_time_constants"), 1.04, 1.06)],
)  # fmt: skip
def test_two_ways_to_a_motion_are_compared(
    name: str, study: str, names: Sequence[str], near: float, far: float, evidence: Evidence,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    for factor, word in ((near, MET), (far, NOT_MET)):
        monkeypatch.setattr(two_dof_study, study, lambda _, factor=factor: over_motions(names, factor))
        assert judges()[name](evidence).word == word


def test_energy_and_convergence_of_the_series_decide(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(two_dof_study, "series", lambda _: curves().assign_attrs(energy_balance_error=2e-6))
    assert two_dof.c79(evidence).word == NOT_MET
    monkeypatch.setattr(two_dof_study, "fine", lambda _: curves())
    for factor, word in ((1.0, MET), (1.002, NOT_MET)):
        finer = curves(peak_transmissibility=factor * curves()["peak_transmissibility"].values)
        monkeypatch.setattr(two_dof_study, "finer", lambda _, finer=finer: finer)
        monkeypatch.setattr(two_dof, "PeriodicSolver", SameAgain)
        assert two_dof.c80(evidence).word == word


class SameAgain:
    """A solver that finds what `curves` holds."""

    def __init__(self, pressed: object, *, accuracy: float) -> None:
        assert accuracy < 1e-5
        self.capacity = pressed.capacity  # type: ignore[attr-defined]

    def motion(self, omega: float) -> object:
        tops = curves()["peak_transmissibility"].sel(friction_capacity=self.capacity)
        return type("Motion", (), {"transmissibility": float(tops)})


def modulus_study(zeta: Sequence[float]) -> list[SeriesMember]:
    """Three moduli at two preloads; the second preload is the worse, and the last cannot be read."""
    found = []
    for modulus, value in zip((2.8e9, 5.6e9, 1.12e10), zeta, strict=True):
        for pressure, share in ((1e4, 1.0), (1e5, 0.5 if modulus < 1e10 else np.nan)):
            values = {"coil.material.E": modulus, "preload.pressure": pressure}
            found.append(SeriesMember("m", values, xr.Dataset(attrs={"zeta": share * value})))
    return found


def test_largest_damping_over_stiffness_decides_in_both_models(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    stiffnesses = two_dof_study.STIFFNESSES
    space = xr.Dataset({"zeta_max": (("m2", "k2"), np.full((2, 2), 0.1))}, {"m2": [0.3, 2.2], "k2": [0.4, 2.7]})
    monkeypatch.setattr(two_dof_study, "space", lambda _: space)
    for values, word in (([0.01, 0.02, 0.03, 0.04, 0.05, 0.06], MET), ([0.03, 0.02, 0.07, 0.1, 0.2, 0.3], NOT_MET)):
        found = dict(zip(stiffnesses, values, strict=True))
        monkeypatch.setattr(two_dof_study, "over_stiffness", lambda _, found=found: found)
        assert two_dof.c88(evidence).word == word
    for zeta, word in (([0.09, 0.06, 0.03], MET), ([0.03, 0.06, 0.09], NOT_MET), ([0.09, 0.03, 0.06], NOT_MET)):
        members = modulus_study(zeta)
        monkeypatch.setattr(evidence, "study", lambda _, members=members: members)
        verdict = two_dof.c89(evidence)
        assert verdict.word == word
        assert "10, 100 kPa" in verdict.value
    assert two_dof_study.over_modulus(evidence)[1.12e10] == 0.06


@pytest.mark.parametrize(
    ("tops", "skew", "word"),
    [((1.08, 1.08, 0.74), -0.5, MET), ((1.08, 1.08, 1.01), -0.5, NOT_MET), ((0.99, 1.08, 0.74), -0.5, NOT_MET),
     ((1.08, 1.08, 0.74), 0.1, NOT_MET)],
)  # fmt: skip
def test_arrangements_are_told_apart(
    tops: Sequence[float], skew: float, word: str, evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    def one(top: float, lean: float) -> xr.Dataset:
        return xr.Dataset({"omega_peak": ("f", [0.9, 1, 1, top]), "skewness": ("f", [lean, lean, lean, 0.0])})

    found = {name: one(top, skew if k == 1 else 1.0) for k, (name, top) in enumerate(zip("abc", tops, strict=True))}
    monkeypatch.setattr(two_dof_study, "arrangements", lambda _: found)
    assert two_dof.c90(evidence).word == word


# ---- appendices A to D ---------------------------------------------------------------------------


def over_slip(peaks: Sequence[float], frequencies: Sequence[float]) -> list[SeriesMember]:
    found = []
    for slip, peak, f_n in zip((1e-7, 1e-4, 1e-6, 1e-5), peaks, frequencies, strict=True):
        data = xr.Dataset(attrs={"f_n_hz": f_n, "peak_transmissibility": peak, "zeta": 0.01, "skewness": 0.0})
        found.append(SeriesMember("m", {elastic_slip.SLIP: slip, "preload.pressure": 1.0e3}, data))
    return found


def test_change_of_both_readings_has_to_fall_with_the_elastic_slip(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    falling, stays = (110.0, 250.0, 115.0, 140.0), (127.4, 127.9, 127.5, 127.85)
    for peaks, frequencies, word in (
        (falling, (127.4, 130.0, 127.5, 128.0), MET), (falling, stays, NOT_MET),
        ((110.0, 250.0, 240.0, 245.0), (127.4, 130.0, 127.5, 128.0), NOT_MET),
    ):  # fmt: skip
        members = over_slip(peaks, frequencies)
        monkeypatch.setattr(evidence, "study", lambda _, members=members: members)
        assert elastic_slip.c110(evidence).word == word
    monkeypatch.setattr(elastic_slip, "loop_area_error", lambda: 2e-6)
    assert elastic_slip.c110(evidence).word == NOT_MET


def test_loop_area_of_one_point_is_exact() -> None:
    assert elastic_slip.loop_area_error() < 1e-12
    assert elastic_slip.loop_area_error(mu=0.5, pressure=3e5, slip=2e-7, amplitude=3.2e-6) < 1e-12


def test_numerical_damping_is_that_of_the_stepper(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    named = Scheme.named

    def wrong(name: str) -> Scheme:
        return replace(named(name), gamma=0.52) if name == "no_damping" else named(name)

    monkeypatch.setattr(integrators.Scheme, "named", staticmethod(wrong))
    assert integrators.c112(evidence).word == NOT_MET


def test_schemes_are_compared_by_their_peaks(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    for peaks, word in (((19.4, 19.3, 19.0, 4.7), MET), ((19.4, 19.3, 18.0, 4.7), NOT_MET),
                        ((19.4, 19.3, 19.0, 9.6), NOT_MET)):  # fmt: skip
        members = [
            SeriesMember("m", {integrators.SCHEME: name}, xr.Dataset(attrs={"f_n_hz": 1.0, "peak_transmissibility": t}))
            for name, t in zip(integrators.NAMES, peaks, strict=True)
        ]
        monkeypatch.setattr(evidence, "study", lambda _, members=members: members)
        assert integrators.c113(evidence).word == word


def test_scales_of_the_smoothed_sign_are_compared_on_the_whole_band(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    values, omegas = np.ones((2, 4, 5)), np.linspace(0.9, 1.15, 5)
    for off, word in ((5e-4, MET), (2e-3, NOT_MET)):
        values[1, 0, 3] = 1.0 + off
        data = xr.Dataset(
            {"transmissibility": (("capacity", "scale", "omega"), values)},
            {"capacity": list(smoothed_sign.STUCK), "scale": list(smoothed_sign.SCALES), "omega": omegas},
        )
        monkeypatch.setattr(smoothed_sign, "in_band", lambda _, data=data: data)
        verdict = smoothed_sign.c114(evidence)
        assert verdict.word == word
        assert "at 1.0875" in verdict.value


def test_one_rough_point_of_an_orbit_is_noticed(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    omega = np.linspace(0.4, 2.0, 9)
    for off, word in ((0.009, MET), (0.03, NOT_MET)):
        orbit = np.ones(9)
        orbit[4] += off
        one = xr.Dataset(
            {"orbit": ("omega", orbit), "loose": ("dwell", [1.0, 1.3]), "tight": ("dwell", [1.0, 1.0])},
            {"omega": omega, "dwell": [0.4, 2.0]},
        )
        found = {(1.0, s): one for s in smoothed_sign.SCALES}
        monkeypatch.setattr(smoothed_sign, "curves", lambda _, found=found: found)
        verdict = smoothed_sign.c115(evidence)
        assert verdict.word == word
        assert "1, 1, 1, 1 of 2 points" in verdict.value


def test_orbits_and_runs_are_kept_one_by_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def short(capacity: float, scale: float, points: int) -> xr.Dataset:
        calls.append((capacity, scale))
        return xr.Dataset({"orbit": ("omega", [capacity * scale])}, attrs={"points": points})

    monkeypatch.setattr(smoothed_sign, "orbits_and_runs", short)
    for _ in range(2):
        with Evidence(tmp_path, fast=True, workers=1) as evidence:
            found = smoothed_sign.curves(evidence)
    assert len(calls) == len(found) == 4 * len(smoothed_sign.SCALES)
    assert float(found[3.0, 5.0]["orbit"][0]) == 15.0


def test_estimators_are_judged_on_what_they_read(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    exact = estimators.exact

    def better(method: str) -> dict:
        """Readings as the source claims them: right up to 0.2, half power above and the fit below beyond."""
        lean = {estimators.HALF_POWER: 1.2, estimators.PRINTED: 0.8}.get(method, 1.0)
        found = exact(method)
        return {z: replace(one, zeta=z * (1.0 if z <= 0.2 else lean)) for z, one in found.items()}

    monkeypatch.setattr(estimators, "exact", better)
    assert estimators.c117(evidence).word == MET
    assert estimators.c118(evidence).word == MET
    assert estimators.c116(evidence).word == NOT_MET  # not the closed form


# ---- appendix E ----------------------------------------------------------------------------------


def test_capacity_and_stiffness_of_stacks_decide(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    force = np.array(shear_tests.PRESSURES) * shear_tests.ShearTest.area
    count = np.array(shear_tests.LAYERS)[:, None] + 1.0
    good = {
        "shear_capacity_n": 0.5 * force * np.ones((2, 1)),
        "shear_stiffness_n_m": 2.0 * force / count,
        "shear_modulus_pa": force * np.ones((2, 1)),
    }
    bad = {
        "offset": {"shear_capacity_n": good["shear_capacity_n"] * np.array([[1.0], [1.02]])},
        "curved": {"shear_capacity_n": force**1.3 * np.ones((2, 1))},
        "other coefficient": {"shear_capacity_n": 0.25 * force * np.ones((2, 1))},
        "alike": {"shear_stiffness_n_m": force * np.ones((2, 1))},
        "no preload": {"shear_stiffness_n_m": np.ones((2, len(force))) / count},
    }
    monkeypatch.setattr(shear_tests, "readings", lambda _, name: good[name])
    assert shear_tests.c119(evidence).word == shear_tests.c120(evidence).word == MET
    for name, change in bad.items():
        monkeypatch.setattr(shear_tests, "readings", lambda _, key, change=change: (good | change)[key])
        judge = shear_tests.c119 if "shear_capacity_n" in change else shear_tests.c120
        assert judge(evidence).word == NOT_MET, name


def test_real_stacks_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shear_tests, "LAYERS", (4, 9))
    monkeypatch.setattr(shear_tests, "PRESSURES", (5e4, 1e5, 2e5))
    with Evidence(tmp_path, workers=1) as evidence:
        assert shear_tests.c119(evidence).word == shear_tests.c120(evidence).word == MET
    assert len(list((tmp_path / "kept").glob("shear_test-*.nc"))) == 6


def test_a_state_that_is_not_renewed_fails_the_criterion(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kapton_friction, "CONSTANTS", RateAndState(distance=5.0e-4))
    assert kapton_friction.c122(evidence).word == NOT_MET


def test_default_coefficient_is_read_from_the_case(evidence: Evidence) -> None:
    assert "default mu = 0.25" in kapton_friction.c123(evidence).value
    assert "17.6 mm/s" in kapton_friction.c124(evidence).value


# ---- figures -------------------------------------------------------------------------------------


def layer_space() -> list[SeriesMember]:
    """Two densities, two moduli and two preloads of the lab roll: the stiffer damps more, mass does nothing."""
    frequency = np.linspace(80.0, 340.0, 50)
    found = []
    for rho, modulus, pressure in product((1000.0, 2000.0), (2.8e9, 5.6e9), (1e4, 4e4)):
        zeta, f_n = 0.04 * modulus / 2.8e9 * (1.0 - 1e-6 * pressure), 130.0 + 1e-3 * pressure
        T = frequency**2 / (f_n**2 - frequency**2 + 2j * zeta * f_n * frequency) + 1.0
        data = xr.Dataset(
            {"transmissibility_real": ("frequency", T.real), "transmissibility_imag": ("frequency", T.imag)},
            {"frequency": frequency}, {"f_n_hz": f_n, "peak_transmissibility": abs(T).max(), "zeta": zeta},
        )  # fmt: skip
        values = {"coil.material.rho": rho, "coil.material.E": modulus, "preload.pressure": pressure}
        found.append(SeriesMember("m", values, data))
    return found


def test_both_models_are_drawn_side_by_side(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    members = layer_space()
    mandrel = xr.Dataset({"mode_frequency": ("mode", [150.0, 900.0]), "tip_participation": ("mode", [1.4, 0.3])})
    masses = evidence.result("two_dof", "two_dof.friction_capacity=[2, 20]", "two_dof.omega.points=30")
    monkeypatch.setattr(evidence, "study", lambda _: members)
    monkeypatch.setattr(evidence, "result", lambda *_: mandrel)
    monkeypatch.setattr(two_dof_study, "series", lambda _: masses)
    ax = two_dof_figures.plot_both_models(evidence)
    assert [line.get_label() for line in ax.get_lines()[:2]] == ["10 kPa", "40 kPa"]
    assert ax.get_lines()[0].get_xdata()[0] == pytest.approx(80.0 / 150.0)
    assert "0.93 to 1.13" in ax.get_title(loc="left")
    plt.close("all")


def test_maps_and_lines_of_largest_damping_are_drawn(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    members = layer_space()
    space = xr.Dataset({"zeta_max": (("m2", "k2"), np.outer([0.1, 0.2], [1.0, 2.0]))}, {"m2": [0.5, 1.0], "k2": [1, 2]})
    monkeypatch.setattr(evidence, "study", lambda _: members)
    monkeypatch.setattr(two_dof_study, "space", lambda _: space)
    monkeypatch.setattr(two_dof_study, "over_stiffness", lambda _: {1.15: 0.07, 2.3: 0.17})
    left = two_dof_figures.plot_layer_space(evidence)
    right = left.figure.axes[1]
    assert "in 100 % of the steps" in right.get_title(loc="left").replace("\xa0", " ").replace("\n", " ")
    ax = two_dof_figures.plot_stiffness(evidence)
    masses, sweeps, steady = (line.get_xydata() for line in ax.get_lines())
    np.testing.assert_allclose(masses, [[1.0, 7.0], [2.0, 17.0]])
    np.testing.assert_allclose(sweeps, [[1.0, 3.96], [2.0, 7.92]])
    np.testing.assert_allclose(steady, sweeps)
    plt.close("all")
