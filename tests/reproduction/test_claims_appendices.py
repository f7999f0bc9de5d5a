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
    "C77": MET, "C86": MET, "C87": THESIS_ERROR, "C111": MET, "C112": MET, "C116": MET, "C117": MET,
    "C118": MET, "C121": THESIS_ERROR, "C122": THESIS_ERROR, "C123": EXPERIMENT, "C124": MET, "C126": THESIS_ERROR,
}  # fmt: skip
"""Verdicts of claims that need no run."""
LONG = ("C117", "C118")
"""They share the Gaussian fits of every method to thirteen curves."""


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow if n in LONG else []) for n in QUICK])
def test_what_needs_no_run_is_judged_on_the_spot(name: str, evidence: Evidence) -> None:
    verdict = judges("ch5", "appendices")[name](evidence)
    assert verdict.word == QUICK[name], verdict.value


# ---- appendices A to D ---------------------------------------------------------------------------


def over_slip(peaks: Sequence[float], frequencies: Sequence[float]) -> list[StudyCase]:
    found = []
    for slip, peak, f_n in zip((1e-7, 1e-4, 1e-6, 1e-5), peaks, frequencies, strict=True):
        f = np.linspace(110.0, 150.0, 801)
        curve = peak / np.sqrt(1.0 + (f - f_n) ** 2)
        data = xr.Dataset(
            {"transmissibility_real": ("frequency", curve), "transmissibility_imag": ("frequency", 0.0 * curve)},
            {"frequency": f},
            {"f_n_hz": f_n, "peak_transmissibility": peak, "zeta": 0.01, "skewness": 0.0},
        )
        found.append(StudyCase("m", {elastic_slip.SLIP: slip, "preload.pressure": 1.737e3}, data))
    return found


def test_distance_of_the_curves_has_to_fall_with_the_elastic_slip(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Peaks and frequencies at 0.1, 100, 1 and 10 um."""
    falling, steady = (110.0, 250.0, 115.0, 140.0), (127.4, 127.4, 127.4, 127.4)
    for peaks, frequencies, word in (
        (falling, steady, MET), (falling, (131.0, 127.4, 127.4, 127.4), NOT_MET),
        ((110.0, 250.0, 240.0, 245.0), steady, NOT_MET),
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
    f = np.linspace(110.0, 180.0, 1401)

    def curve(top: float) -> xr.Dataset:
        size = top / np.sqrt(1.0 + ((f - 140.0) / 6.0) ** 2) + 3.0 * np.sin(40.0 * f) * (f > 150.0)
        real = ("frequency", size)
        return xr.Dataset(
            {"transmissibility_real": real, "transmissibility_imag": ("frequency", 0.0 * size)}, {"frequency": f},
            {"f_n_hz": 1.0, "peak_transmissibility": top, "zeta": 0.1, "skewness": 0.0},
        )  # fmt: skip

    good = (19.4, 19.3, 19.0, 4.7)
    for coarse, fine, word in (
        (good, good, MET), ((19.4, 19.3, 18.0, 4.7), good, NOT_MET), (good, (19.4, 19.3, 18.0, 4.7), NOT_MET),
        (good, (19.4, 19.3, 19.0, 9.6), NOT_MET),
    ):  # fmt: skip
        members = [
            StudyCase("m", {integrators.SCHEME: name, integrators.STEPS: steps}, curve(t))
            for steps, peaks in ((40, fine), (15, coarse))
            for name, t in zip(integrators.NAMES, peaks, strict=True)
        ]
        monkeypatch.setattr(evidence, "study", lambda _, members=members: members)
        assert integrators.c113(evidence).word == word


def test_smoothed_peak_ignores_ripples() -> None:
    f = np.linspace(100.0, 200.0, 4001)
    smooth = 20.0 / np.sqrt(1.0 + ((f - 140.0) / 6.0) ** 2)
    found = []
    for size in (smooth, smooth + 2.0 * np.sin(2.0 * np.pi * f / 0.35)):
        data = {"transmissibility_real": ("frequency", size), "transmissibility_imag": ("frequency", 0.0 * size)}
        found.append(integrators.smoothed_peak(StudyCase("m", {}, xr.Dataset(data, {"frequency": f}))))
    exact = 20.0 * np.arcsinh(1.4 / 6.0) / (1.4 / 6.0)  # mean of the curve over 1.4 Hz on either side
    assert found[0] == pytest.approx(exact, rel=1e-3)
    assert found[1] == pytest.approx(exact, rel=0.01)


def scaled_curves(width: float) -> dict[tuple[float, float], xr.Dataset]:
    """Orbits whose half-power damping at F_c = 10 and s = 1 is larger by a factor."""
    omega = np.linspace(0.8, 1.2, 2001)
    found = {}
    for capacity in (3.0, 10.0):
        for scale in regularised_sign.SCALES:
            wide = 0.02 * (width if (capacity, scale) == (10.0, 1.0) else 1.0)
            orbit = 1.0 / np.sqrt(1.0 + ((omega - 1.0) / wide) ** 2)
            found[capacity, scale] = xr.Dataset({"orbit": ("omega", orbit)}, {"omega": omega})
    return found


def test_scales_of_the_regularised_sign_are_compared_by_peak_and_damping(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(regularised_sign, "capacities", lambda _: (1.0, 3.0, 10.0, 100.0))
    values, omegas = np.ones((2, 4, 5)), np.linspace(0.9, 1.15, 5)
    for off, width, word in ((0.09, 1.0, MET), (0.12, 1.0, NOT_MET), (0.09, 1.04, MET), (0.09, 1.06, NOT_MET)):
        monkeypatch.setattr(regularised_sign, "curves", lambda _, width=width: scaled_curves(width))
        values[1, 0, 3] = 1.0 + off
        data = xr.Dataset(
            {"transmissibility": (("capacity", "scale", "omega"), values)},
            {"capacity": list(regularised_sign.STUCK), "scale": list(regularised_sign.SCALES), "omega": omegas},
        )
        monkeypatch.setattr(regularised_sign, "in_band", lambda _, data=data: data)
        verdict = regularised_sign.c114(evidence)
        assert verdict.word == word
        assert "at omega 1.0875" in verdict.value


def runs_with_spikes(counts: dict[float, int], orbit_off: float = 0.0) -> dict[tuple[float, float], xr.Dataset]:
    """Curves with a sharp peak between the runs; the runs have a number of isolated points per scale."""
    omega, dwell = np.linspace(0.4, 2.0, 1601), np.linspace(0.4, 2.0, 41)
    orbit = 1.0 + 5.0 * np.exp(-(((omega - 1.08) / 0.01) ** 2))
    at = np.interp(dwell, omega, orbit)
    found = {}
    for capacity in (1.0, 10.0):
        for scale, count in counts.items():
            loose, off = at.copy(), at.copy()
            loose[2 : 2 + 4 * count : 4] *= 1.03 if capacity > 1.0 else 1.0
            off[7] *= 1.0 + orbit_off
            found[capacity, scale] = xr.Dataset(
                {"orbit": ("omega", orbit), "dwell_orbit": ("dwell", off), "loose": ("dwell", loose * off / at)},
                {"omega": omega, "dwell": dwell},
            )
    return found


def test_spikes_are_counted_on_a_fixed_grid(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regularised_sign, "capacities", lambda _: (1.0, 10.0))
    scales = regularised_sign.RUN_SCALES
    for counts, orbit_off, word in (
        ((0, 0, 0, 1, 3), 0.0, MET), ((0, 0, 1, 1, 3), 0.0, NOT_MET), ((0, 0, 0, 3, 1), 0.0, NOT_MET),
        ((0, 0, 0, 1, 3), 0.02, NOT_MET), ((0, 0, 0, 0, 0), 0.0, NOT_MET),
    ):  # fmt: skip
        found = runs_with_spikes(dict(zip(scales, counts, strict=True)), orbit_off)
        monkeypatch.setattr(regularised_sign, "curves", lambda _, found=found: found)
        verdict = regularised_sign.c115(evidence)
        assert verdict.word == word, (counts, verdict.value)


def test_orbits_and_runs_are_kept_one_by_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def short(capacity: float, scale: float, points: int) -> xr.Dataset:
        calls.append((capacity, scale))
        return xr.Dataset({"orbit": ("omega", [capacity * scale])}, attrs={"points": points})

    monkeypatch.setattr(regularised_sign, "orbits_and_runs", short)
    for _ in range(2):
        with Evidence(tmp_path, fast=True, workers=1) as evidence:
            found = regularised_sign.curves(evidence)
    assert len(calls) == len(found) == 4 * len(regularised_sign.RUN_SCALES)
    assert float(found[3.0, 5.0]["orbit"][0]) == 15.0


def test_estimators_are_judged_on_what_they_read(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    found = estimators.exact(estimators.HALF_POWER)  # judges take zeta alone, which is replaced

    def better(method: str) -> dict:
        """Half power right up to 0.2, and bells near the peak that read too much everywhere."""
        if method in estimators.NEAR_PEAK.values():
            return {z: replace(one, zeta=min(1.2 * z, 0.9)) for z, one in found.items()}
        return {z: replace(one, zeta=z * (1.0 if z <= 0.2 else 1.2)) for z, one in found.items()}

    monkeypatch.setattr(estimators, "exact", better)
    assert estimators.c117(evidence).word == NOT_MET  # no window saturates
    assert estimators.c118(evidence).word == NOT_MET  # 20 % off
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
