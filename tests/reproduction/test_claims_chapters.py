"""Judges of chapters 2 and 4: real evidence if it is cheap, fake evidence for criteria that must fail."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from support.fake_evidence import FakeEvidence, bending_at, judges, member, reference
from support.synthetic_roll import contact_points

from reproduction import Evidence, base_spring, friction_rate, lab_model, layer_slip, layers, preload_series
from reproduction.reproduce import GROUPS, claim_groups
from reproduction.verdict import MET, NOT_MET, THESIS_ERROR
from reproduction.words import monotone, numbers, rank_correlation, table
from wroll_fem.errors import InputError, WrollError
from wroll_fem.plotting.study import StudyCase

# ---- real evidence -------------------------------------------------------------------------------


class NoRuns(Evidence):
    """Evidence that reads case files and runs nothing."""

    def map(self, *_: object, **__: object) -> list[object]:
        raise InputError("no run")

    def study(self, *_: object) -> list[StudyCase]:
        raise InputError("no run")

    finished = study  # type: ignore[assignment]

    def kept(self, *_: object, **__: object) -> xr.Dataset:
        raise InputError("no run")


@pytest.mark.slow
def test_figures_that_need_no_run_are_drawn(tmp_path: Path) -> None:
    evidence, drawn = NoRuns(tmp_path, workers=1), []
    for group in (group for chapter in GROUPS for group in claim_groups(chapter)):
        for name, (_, figure) in group.figures.items():
            with suppress(WrollError):
                figure(evidence)
                drawn.append(name)
    plt.close("all")
    assert "ch4_friction_law" in drawn, drawn
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    "name", ["C1", "C2", "C3", "C4", "C5", "C6", "C7", "C8", "C10", "C11", "C12", "C13", "C32", "C57", "C61", "C62"]
)
def test_what_needs_no_run_is_judged_on_the_case_files(name: str, tmp_path: Path) -> None:
    verdict = judges("ch2", "ch4")[name](Evidence(tmp_path, workers=1))
    assert verdict.word == (THESIS_ERROR if name in ("C2", "C5", "C13") else MET), verdict.value
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("config", "override", "name"),
    [
        ("winding_case_study", "winding.wraps=299", "C10"),
        ("winding_case_study", "winding.mu=0.25", "C11"),
        ("winding_case_study", "winding.web.radial_modulus.K2=41", "C5"),
        ("kapton_roll", "coil.material.E_r=0.1e9", "C32"),
        ("lab_sweep", "coil.total_thickness=1.5e-3", "C57"),
        ("lab_sweep", "excitation.f_end=180", "C62"),
        ("winding_lab", "winding.wraps=100", "C61"),
    ],
)
def test_another_input_is_noticed(config: str, override: str, name: str, tmp_path: Path) -> None:
    evidence = Evidence(tmp_path, fast=True, workers=1)
    evidence.__dict__["_coarse"] = {"cases": {config: [override]}, "studies": {}}
    assert judges("ch2", "ch4")[name](evidence).holds is False


@pytest.mark.slow
def test_soft_and_hard_roll_are_judged_on_their_study(tmp_path: Path) -> None:
    assert judges("ch2")["C9"](Evidence(tmp_path, workers=1)).word == MET
    assert (tmp_path / "studies" / "winding_hardness" / "batch.csv").is_file()


# ---- written-down results ------------------------------------------------------------------------


PRELOADS = (1e4, 3e4, 1e5, 3e5)
GOOD = {
    "f_n": (134.0, 144.0, 153.0, 159.0),
    "zeta": (0.045, 0.035, 0.025, 0.014),
    "peak": (19.0, 22.0, 34.0, 63.0),
    "work": (0.19, 0.16, 0.13, 0.11),
    "skewness": (3.0, 2.0, 1.0, 0.5),
}
"""A series that meets C64 to C70, one value per preload."""


def sweep(pressure: float, f_n: float, zeta: float, peak: float, work: float, skewness: float = 1.0) -> StudyCase:
    """A chirp from 100 to 200 Hz in 10 s; nine tenths of the friction work come around f_n, the rest at the start."""
    time = np.linspace(0.0, 10.0, 20001)
    frequency = 100.0 * 2.0 ** (time / 10.0)
    around = 1.0 / (1.0 + np.exp(-np.clip((frequency - f_n) / 2.0, -50, 50)))
    early = 1.0 - np.exp(-time / 0.05)
    data = {
        "friction_energy": ("time", work * (0.9 * around + 0.1 * early)),
        "input_work": ("time", work * np.ones_like(time)),
        "numerical_dissipation": ("time", 1e-3 * work * np.ones_like(time)),
        "transmissibility_real": ("frequency", np.ones(3)),
    }
    attrs = {
        "f_n_hz": f_n, "zeta": zeta, "peak_transmissibility": peak, "skewness": skewness,
        "excitation_kind": "chirp", "f_start_hz": 100.0, "rate_oct_per_min": 6.0,
    }  # fmt: skip
    dataset = xr.Dataset(data, coords={"time": time, "frequency": [100.0, 150.0, 200.0]}, attrs=attrs)
    return member(dataset, name=f"p{pressure:g}", preload__pressure=pressure)


def springs() -> list[StudyCase]:
    """Guided base: the stiffer the spring, the less f_n moves with the preload and the less it damps."""
    return [
        member(
            xr.Dataset(
                {"resonance_frequency": ("tip_amplitude", [170.0, 135.0 + spread * (p > 1e4), 100.0]),
                 "resonant_base_acceleration": ("tip_amplitude", [1.0, 5.5, 9.0])},
                {"tip_amplitude": [1e-5, 1e-4, 5e-4]}, {"zeta_max": 1e-3 * spread},
            ),
            coil__base_stiffness=k, coil__material__E=modulus, preload__pressure=p,
        )
        for k, spread in ((1e9, 1.0), (0.0, 25.0), (1e7, 12.0))
        for modulus in (2.8e9, 5.6e9)
        for p in (1e5, 1e4)
    ]  # fmt: skip


def backbone(slip: float) -> xr.Dataset:
    """Motions up to 0.5 mm at the tip: slipping share and friction work grow with the tip amplitude."""
    tip = np.geomspace(1e-5, 5e-4, 30)
    data = {"slipping_fraction": ("tip_amplitude", slip * tip / 5e-4),
            "friction_work_per_cycle": ("tip_amplitude", slip * tip**2)}  # fmt: skip
    return xr.Dataset(data, {"tip_amplitude": tip}, {"tip_amplitude_at_zeta_max_m": 2e-4})


def roll(folder: Path, held: float = 0.3, **changed: Sequence[float]) -> FakeEvidence:
    """Evidence of the lab roll whose free sweeps are `GOOD` but for what is changed; `held` is the clamped slip."""
    series = GOOD | changed
    free = [sweep(p, **{key: values[k] for key, values in series.items()}) for k, p in enumerate(PRELOADS)]
    stiff = [sweep(p, 167.3 + 1e-7 * p, 0.02 - 1e-9 * p, 398.0, 0.05 + 1e-8 * p, 6.0) for p in PRELOADS]
    bounds = [
        member(bending_at(f, mass_total_kg=0.37), modal__interface=interface, coil__base=base)
        for interface, base, f in (
            ("bonded", "free", 162.0), ("bonded", "clamped", 166.3), ("frictionless", "free", 126.0),
            ("frictionless", "clamped", 165.9),
        )
    ]  # fmt: skip
    bounds.append(reference(bending_at(150.5, mass_total_kg=0.18)))
    prestressed = [
        member(bending_at(f), preload__pressure=3e5, preload__geometric_stiffness=True, modal__interface=interface)
        for interface, f in (("stuck", 159.0), ("bonded", 161.4))
    ]
    pressed = sweep(300e3, **{key: values[-1] for key, values in series.items()})
    pressed.values["preload.geometric_stiffness"] = True
    slips = {"free": 0.4, "clamped": held}
    motions = [member(backbone(slip), coil__base=base, preload__pressure=3e4) for base, slip in slips.items()]
    summaries = {f"p{p:g}": {"interface_pressure_mean_pa": [0.58 * p], "energy_balance_error": 1e-5} for p in PRELOADS}
    studies = {
        "preload": free, "preload_clamped": stiff, "bounds": bounds, "prestress": prestressed,
        "prestress_sweep": [pressed], "base_motion": motions, "base_spring": springs(),
    }  # fmt: skip
    return FakeEvidence(folder, studies, summaries)


SERIES = {**preload_series.GROUP.judges, **{name: lab_model.GROUP.judges[name] for name in ("C59", "C60", "C76")}}


@pytest.mark.parametrize("name", list(SERIES))
def test_a_series_as_the_source_has_it_is_met(name: str, tmp_path: Path) -> None:
    verdict = SERIES[name](roll(tmp_path))
    assert verdict.word == MET, verdict.value


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("C64", {"f_n": (120.0, 144.0, 153.0, 159.0)}),
        ("C64", {"f_n": (134.0, 144.0, 153.0, 175.0)}),
        ("C64", {"zeta": (0.09, 0.035, 0.025, 0.014)}),
        ("C65", {"peak": (19.0, 35.0, 34.0, 63.0)}),
        ("C65", {"skewness": (0.04, 0.0, 0.0, 0.0)}),
        ("C66", {"f_n": (134.0, 144.0, 148.0, 149.0)}),
        ("C66", {"f_n": (151.0, 152.0, 153.0, 159.0)}),
        ("C67", {"zeta": (0.045, 0.015, 0.035, 0.044)}),
        ("C69", {"work": (0.19, 0.20, 0.13, 0.11)}),
        ("C70", {"work": (0.11, 0.13, 0.16, 0.19)}),
        ("C59", {"f_n": (134.0, 144.0, 153.0, 158.0)}),
    ],
)
def test_a_series_that_turns_is_not_met(name: str, changed: dict[str, Sequence[float]], tmp_path: Path) -> None:
    assert SERIES[name](roll(tmp_path, **changed)).word == NOT_MET


@pytest.mark.parametrize("end", [0, -1])
@pytest.mark.parametrize("share", [0.15, 0.6])
def test_friction_must_work_most_and_fastest_around_resonance(end: int, share: float, tmp_path: Path) -> None:
    """0.15 of it there and the rest evenly: fastest, not most; 0.6 there and the rest at once: most, not fastest."""
    evidence = roll(tmp_path)
    m = evidence.given["preload"][end]
    time, work = m.data["time"].values, m.data["friction_energy"].values
    rest = time / time[-1] if share < 0.5 else np.minimum(time / 0.05, 1.0)
    m.data["friction_energy"] = "time", share * work + (1.0 - share) * work[-1] * rest
    assert preload_series.c68(evidence).word == NOT_MET


@pytest.mark.parametrize(("held", "word"), [(0.3, MET), (0.15, THESIS_ERROR), (0.0, THESIS_ERROR)])
def test_a_clamped_base_that_removes_the_slip_is_an_error_of_the_thesis(held: float, word: str, tmp_path: Path) -> None:
    assert lab_model.c60(roll(tmp_path, held)).word == word


def test_guided_base_is_listed_over_its_stiffness(tmp_path: Path) -> None:
    evidence = roll(tmp_path)
    evidence.given["dwell_layers_spring"] = [
        member(dwelt((k, k, k))[0].data, coil__base_stiffness=s, excitation__amplitude=29.41995)
        for s, k in ((1e7, 2.0), (0.0, 1.0))
    ]
    assert (
        "guided base, 0, 1e+07, 1e+09 N/m^2 along the axis: f_n spans 25.0, 12.0, 1.0 Hz"
        in lab_model.c60(evidence).value
    )
    assert "largest zeta 2.50, 1.20, 0.10 % at 2.8 GPa" in base_spring.damping_text(evidence)
    slips = [1e6 * layer_slip.outer_slips(m)[1] for m in reversed(evidence.given["dwell_layers_spring"])]
    assert slips[1] == pytest.approx(2.0 * slips[0])
    assert f"interface 2 moves by {slips[0]:.2f}, {slips[1]:.2f} um" in base_spring.second_interface_text(evidence)
    assert base_spring.spring_table(evidence).count("\n") == 4


@pytest.mark.parametrize("name", ["C65", "C67", "C70"])
def test_trends_are_judged_from_the_largest_damping_upward(name: str, tmp_path: Path) -> None:
    """The lowest preload lies below the optimum: less damping, a higher peak."""
    turn = {"zeta": (0.02, 0.045, 0.025, 0.014), "peak": (40.0, 19.0, 34.0, 63.0)}
    verdict = SERIES[name](roll(tmp_path, **turn))
    assert verdict.word == MET, verdict.value
    assert "30 kPa outside, 17.4 kPa at the interface" in verdict.value


def test_energy_that_does_not_balance_fails_the_law_of_friction(tmp_path: Path) -> None:
    evidence = roll(tmp_path)
    evidence.summaries["p30000"]["energy_balance_error"] = 0.02
    assert lab_model.c76(evidence).word == NOT_MET


def test_masses_are_those_of_the_bodies(tmp_path: Path) -> None:
    verdict = lab_model.c58(roll(tmp_path))
    assert verdict.word == THESIS_ERROR
    assert "coil 0.1900 kg" in verdict.value
    assert "tube 0.1300 kg" in verdict.value


@pytest.mark.parametrize(
    ("coarse", "free", "word"), [(161.5, 161.5, MET), (158.0, 161.5, NOT_MET), (161.5, 158.0, MET)]
)
def test_mesh_claim_compares_the_clamped_base_with_its_finest_mesh(
    coarse: float, free: float, word: str, tmp_path: Path
) -> None:
    linear, loose = (
        [
            member(bending_at(f), mesh__circumferential=around, mesh__axial=along)
            for around, along, f in ((16, 5, 150.0), (30, 10, own), (30, 40, 162.0), (16, 40, 140.0))
        ]
        for own in (coarse, free)
    )
    friction = [
        member(sweep(1e5, f, 0.02, 30.0, 0.1).data, mesh__grading=grading, mesh__axial=along)
        for grading, along, f in ((1, 10, 152.0), (6, 10, 153.0), (6, 20, 154.0))
    ]
    evidence = FakeEvidence(tmp_path, {"mesh_linear": loose, "mesh_linear_clamped": linear, "mesh_friction": friction})
    verdict = lab_model.c63(evidence)
    assert verdict.word == word
    assert "-1.30 % off in f_n" in verdict.value


# ---- layers --------------------------------------------------------------------------------------


def dwelt(strength: Sequence[float]) -> list[StudyCase]:
    """Dwells at 1, 2, 3 g whose relative displacements are multiples of one field; it slips where it exceeds 1 um."""
    found = []
    for g, factor in zip((1, 2, 3), strength, strict=True):
        data = contact_points(interfaces=5)
        for name in ("peak_slip_axial", "peak_slip_hoop"):
            data[name] = factor * data[name]
        data["slipped"] = np.hypot(data["peak_slip_axial"], data["peak_slip_hoop"]) > 1e-6
        found.append(member(data, name=f"{g} g", excitation__amplitude=9.80665 * g))
    return found


def stack(
    folder: Path, strength: Sequence[float] = (1.0, 2.0, 3.0), other: Sequence[float] | None = None
) -> FakeEvidence:
    """Dwells at 200 Pa on each layer, and a series at other contact pressures."""
    summaries = {"1 g": {"interface_pressure_mean_pa": [1000.0, 800.0, 600.0, 400.0, 200.0]}}
    members, contact = dwelt(strength), dwelt((1.0, 2.0, 3.0) if other is None else other)
    for m in contact:
        m.values["preload.pressure"] = [351.5] * 5  # type: ignore[index]
    sprung = [member(members[2].data, coil__base_stiffness=0.0, excitation__amplitude=29.41995)]
    given = {
        "dwell_layers": members, "dwell_layers_clamped": members, "dwell_layers_contact": contact,
        "dwell_layers_spring": sprung,
    }  # fmt: skip
    return FakeEvidence(folder, given, summaries)


@pytest.mark.parametrize("name", ["C71", "C72", "C73", "C74"])
def test_layers_that_slip_as_the_source_has_it_are_met(name: str, tmp_path: Path) -> None:
    verdict = layers.GROUP.judges[name](stack(tmp_path))
    assert verdict.word == MET, verdict.value


def test_layers_that_slip_otherwise_are_not_met(tmp_path: Path) -> None:
    rings = stack(tmp_path)
    rings.summaries["1 g"]["interface_pressure_mean_pa"] = [569.0, 456.0, 343.0, 229.0, 115.0]
    assert layers.c71(rings).word == THESIS_ERROR  # the closed form of the rings explains it
    rings.summaries["1 g"]["interface_pressure_mean_pa"] = [700.0, 456.0, 343.0, 229.0, 115.0]
    assert layers.c71(rings).word == NOT_MET
    assert layers.c74(stack(tmp_path, other=(2.0, 1.0, 3.0))).word == NOT_MET
    assert layers.c72(stack(tmp_path, other=(1e3, 1e3, 1e3))).word == NOT_MET
    assert layers.c74(stack(tmp_path, (2.0, 1.0, 3.0))).word == NOT_MET
    everywhere = stack(tmp_path, (1e3, 1e3, 1e3))
    assert layers.c72(everywhere).word == NOT_MET
    assert layers.c74(everywhere).word == NOT_MET
    sideways = stack(tmp_path)
    for m in sideways.given["dwell_layers"]:
        m.data["peak_slip_hoop"], m.data["peak_slip_axial"] = m.data["peak_slip_axial"], m.data["peak_slip_hoop"]
    assert layers.c73(sideways).word == NOT_MET
    outside = stack(tmp_path)
    slipped = outside.given["dwell_layers"][0].data["slipped"]
    slipped.values[:2] = slipped.values[1::-1]
    assert layers.c72(outside).word == NOT_MET
    stuck = stack(tmp_path)
    less, more = stuck.given["dwell_layers"][:2]
    for one in more.data["slipped"].values[:2]:
        one &= more.data["z_m"].values > 0.8 * more.data["z_m"].values[one].max()
    assert layers.areas(more).sum() < layers.areas(less).sum()
    assert np.count_nonzero(layers.areas(more)) >= np.count_nonzero(layers.areas(less))
    assert layers.c74(stuck).word == NOT_MET


def test_slipped_area_and_height_are_those_of_the_points(tmp_path: Path) -> None:
    data = dwelt((1.0, 2.0, 3.0))[0]
    slipped, area = data.data["slipped"].values, data.data["area"].values
    np.testing.assert_allclose(layers.areas(data), (slipped * area).sum(axis=1), rtol=1e-12)
    assert layers.top(data) == data.data["z_m"].values[slipped.any(axis=0)].max()
    slip = layers.largest(data)
    assert (slip.interface, slip.hoop, slip.angle) == (0, pytest.approx(0.0, abs=1e-20), 0.0)
    assert slip.axial == pytest.approx(3e-6)


@pytest.mark.parametrize(("two", "word"), [(0.03, MET), (0.02, NOT_MET)])
def test_one_interface_is_compared_with_two(two: float, word: str, tmp_path: Path) -> None:
    members = [
        member(sweep(p, 140.0, zeta, 20.0, 0.1).data, preload__pressure=p, coil__layers=n)
        for n, p, zeta in ((1, 1e4, 0.03), (1, 3e4, 0.04), (2, 1e4, two), (2, 3e4, 0.5 * two))
    ]
    assert layers.c75(FakeEvidence(tmp_path, {"layer_count": members})).word == word


@pytest.mark.parametrize(
    ("f_n", "zeta", "word"), [(140.5, 0.032, MET), (142.0, 0.03, NOT_MET), (140.0, 0.034, NOT_MET)]
)
def test_rate_dependent_friction_is_compared_preload_by_preload(
    f_n: float, zeta: float, word: str, tmp_path: Path
) -> None:
    members = [
        member(sweep(p, f, z, 20.0, 0.1).data, preload__pressure=p, case=case)
        for p in (1e4, 1e5)
        for case, f, z in (("lab_sweep", 140.0, 0.03), ("lab_sweep_rate", f_n, zeta))
    ]
    evidence = FakeEvidence(tmp_path, {"friction_laws": members})
    assert friction_rate.c125(evidence).word == word
    del members[-1]
    assert friction_rate.c125(evidence).word == NOT_MET


# ---- words ---------------------------------------------------------------------------------------


def test_monotone_has_the_slack_of_the_checklist() -> None:
    assert monotone([1.0, 2.0, 3.0], 1)
    assert not monotone([1.0, 2.0, 3.0], -1)
    assert monotone([0.0, 50.0, 49.6, 100.0], 1)
    assert not monotone([0.0, 50.0, 49.4, 100.0], 1)
    assert not monotone([1.0, 1.0], 1)
    assert not monotone([1.0, np.nan, 2.0], 1)


def test_words_of_a_table() -> None:
    assert rank_correlation([1.0, 2.0, 5.0], [9.0, 8.0, 1.0]) == pytest.approx(-1.0)
    assert numbers([1.0, 2.25], ".1f") == "1.0, 2.2"
    assert table(("a", "b"), [("1", "2")]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"
