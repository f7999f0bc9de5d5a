"""Judges of the appendices: claims that need no run, and criteria that fail on changed evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.fake_evidence import judges

from reproduction import Evidence, elastic_slip, estimators, integrators, kapton_friction, regularised_sign, shear_tests
from reproduction.verdict import EXPERIMENT, MET, NOT_MET, THESIS_ERROR
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.plotting.study import StudyCase
from wroll_fem.tribology import RateAndState

QUICK = {
    "C77": MET, "C86": MET, "C87": THESIS_ERROR, "C111": MET, "C112": MET, "C116": MET, "C117": NOT_MET,
    "C118": NOT_MET, "C121": THESIS_ERROR, "C122": THESIS_ERROR, "C123": EXPERIMENT, "C124": MET, "C126": THESIS_ERROR,
}  # fmt: skip
"""Verdicts of claims that need no run."""


@pytest.mark.parametrize("name", QUICK)
def test_what_needs_no_run_is_judged_on_the_spot(name: str, evidence: Evidence) -> None:
    verdict = judges("ch5", "appendices")[name](evidence)
    assert verdict.word == QUICK[name], verdict.value


# ---- appendices A to D ---------------------------------------------------------------------------


def over_slip(peaks: Sequence[float], frequencies: Sequence[float]) -> list[StudyCase]:
    found = []
    for slip, peak, f_n in zip((1e-7, 1e-4, 1e-6, 1e-5), peaks, frequencies, strict=True):
        data = xr.Dataset(attrs={"f_n_hz": f_n, "peak_transmissibility": peak, "zeta": 0.01, "skewness": 0.0})
        found.append(StudyCase("m", {elastic_slip.SLIP: slip, "preload.pressure": 1.0e3}, data))
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
            StudyCase("m", {integrators.SCHEME: name}, xr.Dataset(attrs={"f_n_hz": 1.0, "peak_transmissibility": t}))
            for name, t in zip(integrators.NAMES, peaks, strict=True)
        ]
        monkeypatch.setattr(evidence, "study", lambda _, members=members: members)
        assert integrators.c113(evidence).word == word


def test_scales_of_the_regularised_sign_are_compared_on_the_whole_band(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    values, omegas = np.ones((2, 4, 5)), np.linspace(0.9, 1.15, 5)
    for off, word in ((5e-4, MET), (2e-3, NOT_MET)):
        values[1, 0, 3] = 1.0 + off
        data = xr.Dataset(
            {"transmissibility": (("capacity", "scale", "omega"), values)},
            {"capacity": list(regularised_sign.STUCK), "scale": list(regularised_sign.SCALES), "omega": omegas},
        )
        monkeypatch.setattr(regularised_sign, "in_band", lambda _, data=data: data)
        verdict = regularised_sign.c114(evidence)
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
        found = {(1.0, s): one for s in regularised_sign.SCALES}
        monkeypatch.setattr(regularised_sign, "curves", lambda _, found=found: found)
        verdict = regularised_sign.c115(evidence)
        assert verdict.word == word
        assert "1, 1, 1, 1 of 2 points" in verdict.value


def test_orbits_and_runs_are_kept_one_by_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def short(capacity: float, scale: float, points: int) -> xr.Dataset:
        calls.append((capacity, scale))
        return xr.Dataset({"orbit": ("omega", [capacity * scale])}, attrs={"points": points})

    monkeypatch.setattr(regularised_sign, "orbits_and_runs", short)
    for _ in range(2):
        with Evidence(tmp_path, fast=True, workers=1) as evidence:
            found = regularised_sign.curves(evidence)
    assert len(calls) == len(found) == 4 * len(regularised_sign.SCALES)
    assert float(found[3.0, 5.0]["orbit"][0]) == 15.0


def test_estimators_are_judged_on_what_they_read(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    exact = estimators.exact

    def better(method: str) -> dict:
        """Readings as the thesis claims them: right up to 0.2, half power above and the fit below beyond."""
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
