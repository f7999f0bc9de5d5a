"""Judges of chapter 2 on the solid coil: fake evidence, and one case study on a coarse mesh."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.fake_evidence import FakeEvidence, bending_at, member, reference

from reproduction import Evidence, coil_slip, coiled_stiff, design_map
from reproduction.verdict import MET, NOT_MET, THESIS_ERROR
from wroll_fem.plotting.study import StudyCase

# ---- the coil without slip -----------------------------------------------------------------------

STIFFNESS = (1e4, 1e5, 1e7, 1e8, 1.8e8, 3.2e8, 5.6e8, 1e9)


def scan(frequencies: Sequence[float], mass_alone: float = 50.0) -> list[StudyCase]:
    shear = "coil__material__G_r_theta"
    found = [member(bending_at(f), **{shear: G}) for G, f in zip(STIFFNESS, frequencies, strict=True)]
    return [*reversed(found), reference(bending_at(mass_alone))]


RISING = (72.0, 72.1, 74.0, 80.0, 84.0, 89.0, 94.0, 98.0)


@pytest.mark.parametrize(
    ("name", "members", "word"),
    [
        ("C15", scan(RISING), MET),
        ("C15", scan(RISING, mass_alone=81.0), NOT_MET),
        ("C15", scan(RISING)[2:], NOT_MET),
        ("C16", scan(RISING), MET),
        ("C16", scan((72.0, 72.1, 71.0, 80.0, 84.0, 89.0, 94.0, 98.0)), NOT_MET),
        ("C16", scan(tuple(50.0 * (G / 1e4) ** 0.1 for G in STIFFNESS)), NOT_MET),
        ("C17", scan(RISING), MET),
        ("C17", scan((15.0, *RISING[1:])), NOT_MET),
    ],
)
def test_scan_of_the_shear_stiffness(name: str, members: list[StudyCase], word: str, tmp_path: Path) -> None:
    evidence = FakeEvidence(tmp_path, {"shear_stiffness": members})
    assert coiled_stiff.GROUP.judges[name](evidence).word == word


def test_heavy_modes_below_bending_are_noticed(tmp_path: Path) -> None:
    members = scan(RISING)
    share = members[-2].data["effective_mass_fraction"]
    assert members[-2].values["coil.material.G_r_theta"] == 1e4
    share[0, 0] = 0.2
    assert coiled_stiff.c17(FakeEvidence(tmp_path, {"shear_stiffness": members})).word == NOT_MET


def kapton(folder: Path, loose: float, tight: float, stiffer: float = 1.04, mandrel: float = 153.0) -> FakeEvidence:
    """Rolls whose frequency rises with ln G from `loose` to `tight`; those of 4 GPa have `stiffer` times as much."""

    def answer(config: str, *overrides: str) -> xr.Dataset:
        given = dict(text.split("=") for text in overrides)
        if config == "kapton_mandrel":
            return bending_at(mandrel)
        if "coil.base" in given:
            return bending_at(1.1 * mandrel)
        modulus, G = (float(given[key]) for key in ("coil.material.E_theta", "coil.material.G_r_theta"))
        share = np.log(G / 700.0) / np.log(1e9 / 700.0)
        return bending_at((1.0 if modulus < 3e9 else stiffer) * (loose + (tight - loose) * share))

    members = [
        member(
            answer("kapton_roll", f"coil.material.E_theta={E}", f"coil.material.G_r_theta={G}"),
            coil__material__E_theta=E, coil__material__G_r_theta=G,
        )
        for E in (2.5e9, 4e9) for G in (1e3, 1e4, 1e5, 1e6, 1e7, 1e9)
    ]  # fmt: skip
    return FakeEvidence(folder, {"shear_stiffness_kapton": [*members, reference(bending_at(mandrel))]}, answer=answer)


@pytest.mark.parametrize(
    ("ends", "words"),
    [
        ((130.0, 175.0), {"C28": MET, "C29": MET, "C30": MET}),
        ((130.0, 175.0, 0.9), {"C28": NOT_MET}),
        ((140.0, 150.0), {"C28": NOT_MET, "C30": NOT_MET}),
        ((100.0, 160.0), {"C28": NOT_MET, "C29": NOT_MET, "C30": MET}),
        ((150.0, 200.0), {"C29": NOT_MET}),
    ],
)
def test_kapton_roll_against_its_mandrel(ends: tuple[float, ...], words: dict[str, str], tmp_path: Path) -> None:
    evidence = kapton(tmp_path, *ends)
    for name, word in words.items():
        verdict = coiled_stiff.GROUP.judges[name](evidence)
        assert verdict.word == word, (name, verdict.value)


@pytest.mark.parametrize(("f", "word"), [(97.0, MET), (94.0, NOT_MET), (106.0, NOT_MET)])
def test_case_study_bends_at_about_100_hz(f: float, word: str, tmp_path: Path) -> None:
    assert coiled_stiff.c14(FakeEvidence(tmp_path, answer=lambda *_: bending_at(f))).word == word


@pytest.mark.parametrize(
    ("shell", "solid", "word"), [(150.0, 150.5, MET), (156.0, 156.1, NOT_MET), (150.0, 152.0, NOT_MET)]
)
def test_mandrel_is_read_with_shells_and_solids(shell: float, solid: float, word: str, tmp_path: Path) -> None:
    def answer(_: str, *overrides: str) -> xr.Dataset:
        return bending_at(solid if coiled_stiff.HARMONICS in overrides else shell)

    assert coiled_stiff.c31(FakeEvidence(tmp_path, answer=answer)).word == word


# ---- map of mandrels -----------------------------------------------------------------------------


def mandrels(values: np.ndarray, mandrel: float = 100.0) -> xr.Dataset:
    dims = ("mandrel_radius", "mandrel_thickness")
    data = {"frequency_disparity": (dims, values), "frequency_mandrel": (dims, np.full(values.shape, mandrel))}
    return xr.Dataset(data, attrs={"own_frequency_tightest": 200.0, "own_frequency_loosest": 150.0})


GROWING = np.array([[30.0, 20.0, 10.0], [60.0, 40.0, 30.0], [90.0, 70.0, 50.0]])


@pytest.mark.parametrize(
    ("plastic", "metal", "words"),
    [
        (GROWING, 0.1 * GROWING, (MET, MET)),
        (GROWING[::-1], 0.1 * GROWING, (NOT_MET, MET)),
        (GROWING[:, ::-1], 0.1 * GROWING, (NOT_MET, NOT_MET)),
        (GROWING, 1.1 * GROWING, (MET, NOT_MET)),
        (np.where(GROWING == 40.0, np.nan, GROWING), 0.1 * GROWING, (NOT_MET, NOT_MET)),
    ],
)
def test_map_of_mandrels(plastic: np.ndarray, metal: np.ndarray, words: tuple[str, str], tmp_path: Path) -> None:
    def answer(_: str, *overrides: str) -> xr.Dataset:
        return mandrels(metal if "mandrel.material.E=70.0e9" in overrides else plastic)

    evidence = FakeEvidence(tmp_path, answer=answer)
    assert (design_map.c26(evidence).word, design_map.c27(evidence).word) == words
    assert design_map.variants(evidence).count("\n") == len(design_map.OTHERS) + 1


# ---- slip of the case study ----------------------------------------------------------------------


@pytest.fixture(scope="module")
def coarse(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """Case study in harmonics on a coarse mesh."""
    evidence = Evidence(tmp_path_factory.mktemp("slip"), workers=1)
    few = ("mesh.axial=12", "mesh.radial=3", "mesh.circumferential=12", "modal.count=2")
    return evidence.result("case_study", coil_slip.HARMONICS, *few)


def test_slip_of_the_case_study_is_judged_where_it_is(coarse: xr.Dataset, tmp_path: Path) -> None:
    evidence = FakeEvidence(tmp_path, answer=lambda *_: coarse)
    found = {name: judge(evidence) for name, judge in coil_slip.GROUP.judges.items() if name != "C25"}
    assert {name for name, verdict in found.items() if verdict.word != MET} <= {"C18", "C21", "C22"}
    assert "mean over 5 mm" in found["C18"].value
    assert coil_slip.onset(coarse) == pytest.approx(
        float((coarse["friction_capacity"] / coarse["shear_resultant"]).min()), rel=1e-12
    )
    firm = coil_slip.other_capacity(coarse, lambda r: 8.0 * np.interp(r, *capacity(coarse)))
    assert coil_slip.onset(firm) == pytest.approx(8.0 * coil_slip.onset(coarse), rel=1e-6)
    assert coil_slip.c18(FakeEvidence(tmp_path, answer=lambda *_: firm)).word == MET


def capacity(data: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    order = np.argsort(data["r_m"].values)
    return data["r_m"].values[order], data["friction_capacity"].values[order]


@pytest.mark.parametrize(
    ("name", "mirror"), [("C19", "z_m"), ("C20", "r_m"), ("C23", "theta_rad"), ("C24", "r_m"), ("C24", "z_m")]
)
def test_slip_in_the_wrong_place_is_noticed(name: str, mirror: str, coarse: xr.Dataset, tmp_path: Path) -> None:
    """The roll turned upside down, inside out, or a quarter around."""
    turned = coarse.copy()
    values = coarse[mirror].values
    changed = values + 0.5 * np.pi if mirror == "theta_rad" else values.max() + values.min() - values
    turned[mirror] = "point", changed
    assert coil_slip.GROUP.judges[name](FakeEvidence(tmp_path, answer=lambda *_: turned)).word == NOT_MET


@pytest.mark.parametrize(("top", "word"), [(15.0, MET), (14.5, NOT_MET)])
def test_level_scales_the_stress(top: float, word: str, tmp_path: Path) -> None:
    def answer(_: str, override: str) -> xr.Dataset:
        level = 1.0 if override.endswith("[1]") else top
        return xr.Dataset({"shear_resultant_history": ("time", level * np.abs(np.sin(np.linspace(0.0, 9.0, 200))))})

    assert coil_slip.c25(FakeEvidence(tmp_path, answer=answer)).word == word


@pytest.mark.parametrize(("ratio", "holds"), [(1.9, True), (1.5, False), (2.3, False)])
def test_root_section_is_the_lowest_row(ratio: float, holds: bool, coarse: xr.Dataset, tmp_path: Path) -> None:
    scaled = coarse.copy()
    scaled["shear_rz"] = coarse["shear_rz"] * ratio / coil_slip.RootSection(coarse).ratio()[0]
    assert coil_slip.c21(FakeEvidence(tmp_path, answer=lambda *_: scaled)).holds is holds


def test_average_over_the_root_is_the_integral_of_the_profile(coarse: xr.Dataset) -> None:
    """A stress that grows with the height has half its value at the top as its mean."""
    linear = coarse.copy()
    linear["shear_rz"] = 1e6 * coarse["z_m"] / 0.1
    linear["shear_rt"] = 0.5 * linear["shear_rz"]
    first = float(coarse["z_m"].min())
    found = coil_slip.averaged(linear, 0.1)
    exact = 1e6 * (0.5 * 0.1 + 0.5 * first**2 / 0.1) / 0.1
    assert found.rz == pytest.approx(exact, rel=0.01)
    assert found.ratio == pytest.approx(2.0)
    assert found.onset(4e6, 0.5) == pytest.approx(2e6 / np.hypot(exact, 0.5 * exact), rel=0.01)
    nodes = coil_slip.at_nodes("1 mm", linear)  # linear to the lower edge, where it vanishes
    assert abs(nodes.rz) < 1e-3


def test_one_smearing_length_has_to_give_onset_and_ratio(
    coarse: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    evidence = FakeEvidence(tmp_path, answer=lambda *_: coarse)
    _, printed, mu = coil_slip.pressures(evidence)
    resultant = mu * printed / 5.0

    def one(ratio: float, onset: float) -> coil_slip.Smeared:
        return coil_slip.Smeared("x", ratio * 1e6, 1e6, 5.0 / onset * resultant)

    for found, word in (([one(1.8, 5.0)], THESIS_ERROR), ([one(1.8, 20.0), one(1.1, 5.0)], NOT_MET)):
        monkeypatch.setattr(coil_slip, "all_smeared", lambda _, found=found: found)
        assert coil_slip.c18(evidence).word == word
