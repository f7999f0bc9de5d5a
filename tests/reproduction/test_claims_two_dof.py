"""Judges of chapter 5 (two-mass model): criteria fail on changed evidence; figures of both models."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from support.fake_evidence import judges

from reproduction import Evidence, base_spring, two_dof, two_dof_figures, two_dof_study
from reproduction.verdict import MET, NOT_MET, THESIS_ERROR
from wroll_fem.plotting.study import StudyCase
from wroll_fem.two_dof import PeriodicSolver, TwoMasses
from wroll_fem.two_dof.time import dwell

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
    assert judges("ch5", "appendices")[name](evidence).word == MET
    for study in ("series", "fine"):
        monkeypatch.setattr(two_dof_study, study, lambda _: curves(**changed))
    assert judges("ch5", "appendices")[name](evidence).word == NOT_MET


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
        assert judges("ch5", "appendices")[name](evidence).word == word


def test_largest_damping_above_the_lowest_capacity_is_an_error_of_the_thesis(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    peaks = curves()["peak_transmissibility"].values
    for changed, word in ((peaks, THESIS_ERROR), (np.sort(peaks), MET), (swapped(peaks, 3, 5), NOT_MET)):
        monkeypatch.setattr(two_dof_study, "fine", lambda _, t=changed: curves(peak_transmissibility=t))
        assert two_dof.c82(evidence).word == word


def test_closed_form_of_stuck_masses_accounts_for_the_short_dwell(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At F_c = 100 the masses creep, and the linear closed form equals the integrated run."""
    pressed = TwoMasses().preloaded(100.0)
    duration = 6.0 / (0.002 * 1.6)
    exact = dwell(pressed, 1.6, duration) / PeriodicSolver(pressed).motion(1.6).transmissibility
    assert two_dof_study.creeping_dwell(pressed, 1.6, duration) == pytest.approx(exact, rel=1e-5)
    for factor, word in ((exact, THESIS_ERROR), (1.0 + 1.5 * (exact - 1.0), NOT_MET), (1.04, MET)):
        data = xr.Dataset(
            {"periodic": (("friction_capacity", "omega"), [[1.0]]),
             "six_time_constants": (("friction_capacity", "omega"), [[factor]])},
            {"friction_capacity": [100.0], "omega": [1.6]},
        )  # fmt: skip
        monkeypatch.setattr(two_dof_study, "dwelt", lambda _, data=data: data)
        assert two_dof.c85(evidence).word == word


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


def modulus_study(zeta: Sequence[float]) -> list[StudyCase]:
    """Three moduli at two preloads; the second preload is the worse, and the last cannot be read."""
    found = []
    for modulus, value in zip((2.8e9, 5.6e9, 1.12e10), zeta, strict=True):
        for pressure, share in ((1e4, 1.0), (1e5, 0.5 if modulus < 1e10 else np.nan)):
            values = {"coil.material.E": modulus, "preload.pressure": pressure}
            found.append(StudyCase("m", values, xr.Dataset(attrs={"zeta": share * value})))
    return found


def test_largest_damping_over_stiffness_decides_in_both_models(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    stiffnesses = two_dof_study.STIFFNESSES
    space = xr.Dataset({"zeta_max": (("m2", "k2"), np.full((2, 2), 0.1))}, {"m2": [0.3, 2.2], "k2": [0.4, 2.7]})
    monkeypatch.setattr(two_dof_study, "space", lambda _: space)
    for values, word in (
        ([0.03, 0.02, 0.0, 0.07, 0.1, 0.2, 0.3], MET), ([0.03, 0.02, 0.0, 0.07, 0.1, 0.2, 0.1], NOT_MET),
    ):  # fmt: skip
        found = dict(zip(stiffnesses, values, strict=True))
        monkeypatch.setattr(two_dof_study, "over_stiffness", lambda _, found=found: found)
        assert two_dof.c88(evidence).word == word
    for text in ("damping_text", "thesis_text"):
        monkeypatch.setattr(base_spring, text, lambda _: "")
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


# ---- figures -------------------------------------------------------------------------------------


def layer_space() -> list[StudyCase]:
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
        found.append(StudyCase("m", values, data))
    return found


def test_both_models_are_drawn_side_by_side(evidence: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    members = layer_space()
    mandrel = xr.Dataset({"mode_frequency": ("mode", [150.0, 900.0]), "tip_participation": ("mode", [1.4, 0.3])})
    masses = evidence.result("two_dof", "two_dof.friction_capacity=[2, 20]", "two_dof.omega.points=30")
    monkeypatch.setattr(evidence, "finished", lambda _: (members, []))
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
    monkeypatch.setattr(evidence, "finished", lambda _: (members, [None]))
    monkeypatch.setattr(two_dof_study, "space", lambda _: space)
    monkeypatch.setattr(two_dof_study, "over_stiffness", lambda _: {1.15: 0.07, 2.3: 0.17})
    left = two_dof_figures.plot_layer_space(evidence)
    right = left.figure.axes[1]
    title = right.get_title(loc="left").replace("\xa0", " ").replace("\n", " ")
    assert "in 100 % of the steps; 1 of 9 cases have no curve" in title
    ax = two_dof_figures.plot_stiffness(evidence)
    masses, sweeps, steady = (line.get_xydata() for line in ax.get_lines())
    np.testing.assert_allclose(masses, [[1.0, 7.0], [2.0, 17.0]])
    np.testing.assert_allclose(sweeps, [[1.0, 3.96], [2.0, 7.92]])
    np.testing.assert_allclose(steady, sweeps)
    plt.close("all")
