"""Judges of the shaker tests and of the slip measurement of chapter 3: synthetic records and images."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.fake_evidence import FakeEvidence, bending_at, member, reference
from support.synthetic_roll import contact_points

from reproduction import camera_images, camera_slip, shaker_random, shaker_shock, shaker_sweeps
from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.shaker_records import measured
from reproduction.verdict import MET, NOT_MET
from wroll_fem.lab.shaker.synthetic import oscillator_tip
from wroll_fem.plotting.style import save_figure
from wroll_fem.signals.random.random_motion import random_record
from wroll_fem.typing import FloatArray


def oscillated(base: FloatArray, rate: float, f_n: float, zeta: float, case_hash: str = "") -> xr.Dataset:
    """Time history of an oscillator from rest on a shaken base."""
    tip = oscillator_tip(base, 1.0 / rate, f_n, zeta)
    data = {"base_acceleration": ("time", base), "tip_acceleration": ("time", tip - base)}
    return xr.Dataset(data, {"time": np.arange(len(base)) / rate}, {"case_hash": case_hash})


def chirp(rate: float = 8192.0) -> FloatArray:
    """Sweep of 60 to 300 Hz at 5 m/s^2 and the 7.88 oct/min of the experiment, with a smooth start."""
    growth = np.log(60.0) / 45.0
    time = np.arange(0.0, np.log(5.0) / growth, 1.0 / rate)
    return np.asarray(5.0 * np.minimum(time / 0.1, 1.0) * np.sin(2.0 * np.pi * 60.0 * np.expm1(growth * time) / growth))


class Kept(FakeEvidence):
    """Evidence that computes what is kept."""

    def kept(self, name: str, compute: Callable[[], xr.Dataset], **inputs: object) -> xr.Dataset:
        return Evidence.kept(self, name, compute, **inputs)

    def reference(self, study: str):
        return next(m for m in self.given[study] if m.reference)


# ---- sweeps --------------------------------------------------------------------------------------

TRUTH = {1e4: (136.0, 0.045), 1e5: (154.0, 0.03), 3e5: (159.0, 0.016)}
"""External pressure, Pa -> resonance, Hz, and damping ratio of linear rolls."""


def sweeps(folder: Path) -> Kept:
    """Sweeps of a mandrel and of three linear rolls."""
    base = chirp()
    alone = reference(oscillated(base, 8192.0, 150.5, 0.005, "m"))
    rolls = [
        member(oscillated(base, 8192.0, *truth, case_hash=f"{p}"), preload__pressure=p) for p, truth in TRUTH.items()
    ]
    bonded = member(bending_at(162.0), modal__interface="bonded", coil__base="free")
    return Kept(folder, {"shaker_sweep": [*rolls, alone], "bounds": [bonded]})


@pytest.mark.slow
def test_sweeps_of_linear_rolls_are_read_without_bias_of_the_rate(tmp_path: Path) -> None:
    """By the ratio of the spectra; the demodulated record of the mandrel is refused, those of the rolls are not."""
    evidence = sweeps(tmp_path)
    alone, *rolls = shaker_sweeps.readings(evidence)
    assert alone.f_n == pytest.approx(150.5, rel=2e-4)
    assert alone.zeta == pytest.approx(0.005, rel=0.02)
    assert np.isnan(alone.zeta_lab)
    for one, (f_n, zeta) in zip(rolls, TRUTH.values(), strict=True):
        assert one.f_n == pytest.approx(f_n, rel=3e-3)
        assert one.zeta == pytest.approx(zeta, rel=0.02)
        assert one.skew == pytest.approx(1.0, abs=0.1)
    assert rolls[0].zeta_lab == pytest.approx(0.045, rel=0.03)
    for name, word in {"C43": NOT_MET, "C45": MET, "C46": MET, "C47": MET, "C48": MET}.items():
        verdict = shaker_sweeps.GROUP.judges[name](evidence)
        assert verdict.word == word, verdict.value
    drawn(shaker_sweeps.GROUP, evidence, tmp_path)


def drawn(group: ClaimGroup, evidence: Evidence, folder: Path) -> None:
    """Draw the figures of a group: axes with labels and units."""
    for name, (_, draw) in group.figures.items():
        ax = draw(evidence)
        assert "(" in ax.get_ylabel()
        assert "imulated" in ax.get_title(loc="left")
        assert save_figure(ax, folder / f"{name}.png").stat().st_size > 10_000


READ = shaker_sweeps.Reading(0.0, 150.5, 0.005, 100.0, 1.0, 150.5, 0.005, 1.0)


@pytest.mark.parametrize(
    ("name", "changed", "word"),
    [
        ("C43", [{"skew": 3.0}, {"skew": 2.0}, {"skew": 1.1}], MET),
        ("C43", [{"skew": 2.0}, {"skew": 3.0}, {"skew": 1.1}], NOT_MET),
        ("C43", [{"skew": 1.04}, {"skew": 1.02}, {"skew": 1.0}], NOT_MET),
        ("C45", [{"f_n": 126.0}, {"f_n": 150.0}, {"f_n": 158.0}], NOT_MET),
        ("C46", [{"f_n": 134.0}, {"f_n": 150.0}, {"f_n": 152.0}], NOT_MET),
        ("C47", [{"zeta": 0.06}, {"zeta": 0.055}, {"zeta": 0.015}], NOT_MET),
        ("C47", [{"zeta": 0.11}, {"zeta": 0.03}, {"zeta": 0.015}], NOT_MET),
        ("C48", [{"zeta": 0.03}, {"zeta": 0.02}, {"zeta": 0.004}], NOT_MET),
    ],
)
def test_sweeps_are_judged_by_their_readings(
    name: str, changed: list[dict], word: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rolls = [READ._replace(pressure=p, **one) for p, one in zip((10.0, 100.0, 300.0), changed, strict=True)]
    monkeypatch.setattr(shaker_sweeps, "readings", lambda _: [READ, *rolls])
    bonded = member(bending_at(162.0), modal__interface="bonded", coil__base="free")
    assert shaker_sweeps.GROUP.judges[name](FakeEvidence(tmp_path, {"bounds": [bonded]})).word == word


# ---- random motion -------------------------------------------------------------------------------


def test_random_records_are_read_as_the_oscillators_that_made_them() -> None:
    base = random_record([20.0, 300.0], 1e-3, 20.0, 4096.0, seed=5)
    truth = {"a": (145.0, 0.03), "b": (155.0, 0.015)}
    found = measured({k: oscillated(base, 4096.0, *v) for k, v in truth.items()}, method="random", band=[80.0, 260.0])
    for k, (f_n, zeta) in enumerate(truth.values()):
        assert float(found["condition_f_n"][k]) == pytest.approx(f_n, rel=2e-3)
        assert float(found["condition_zeta"][k]) == pytest.approx(zeta, rel=0.05)
    assert found["base_level"].values == pytest.approx(np.full(2, base.std()), rel=0.25)  # within the band


def series(tension: float, f_n: list[float], zeta: list[float]) -> shaker_random.Series:
    level, small = np.array([0.1, 0.5, 1.0]), np.full(3, 1e-4)
    return shaker_random.Series(tension, level, 13 * level, 40 * level, np.array(f_n), small, np.array(zeta), small)


@pytest.mark.parametrize(
    ("alone", "loose", "words"),
    [
        ((150.0, 150.0), (153.0, 145.0), (MET, MET)),
        ((150.0, 148.0), (153.0, 145.0), (NOT_MET, MET)),  # a mandrel that changes
        ((150.0, 150.0), (153.0, 151.0), (NOT_MET, MET)),  # too little
        ((150.0, 150.0), (153.0, 135.0), (NOT_MET, MET)),  # too much
        ((150.0, 150.0), (159.0, 150.0), (MET, NOT_MET)),  # above the tight roll
    ],
)
def test_random_motion_is_judged_by_its_readings(
    alone: tuple[float, float], loose: tuple[float, float], words: tuple[str, str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    found = [
        series(0.0, [alone[0], alone[0], alone[1]], [0.005] * 3),
        series(20.0, [loose[0], np.mean(loose), loose[1]], [0.006, 0.02, 0.04]),
        series(60.0, [158.0, 157.0, 156.0], [0.005, 0.01, 0.02]),
    ]
    monkeypatch.setattr(shaker_random, "readings", lambda _: found)
    evidence = FakeEvidence(tmp_path)
    assert (shaker_random.c49(evidence).word, shaker_random.c50(evidence).word) == words
    if words == (MET, MET):
        ax = shaker_random.levels_figure(evidence)
        assert "20 N to 4.0 %" in ax.get_title(loc="left").replace("\xa0", " ").replace("\n", " ")


# ---- shock ---------------------------------------------------------------------------------------


def shocks(folder: Path, rolls: dict[float, tuple[float, float]]) -> Kept:
    time = np.arange(0.0, 1.0, 1.0 / 8192.0)
    base = np.where(time < 3e-3, 196.0 * np.sin(np.pi * time / 3e-3), 0.0)
    alone = reference(oscillated(base, 8192.0, 150.5, 0.005))
    found = [member(oscillated(base, 8192.0, *truth), preload__pressure=p) for p, truth in rolls.items()]
    return Kept(folder, {"shaker_shock": [*found, alone]})


def test_the_spectrum_of_a_shock_is_that_of_the_decay(tmp_path: Path) -> None:
    """|A(f_n)| of a decay a_0 exp(-zeta w t) sin(w t) is a_0 / (2 zeta w); to a tenth after ln(10)/(zeta w)."""
    evidence = shocks(tmp_path, {1e4: (135.0, 0.05), 1e5: (155.0, 0.04), 3e5: (160.0, 0.02)})
    alone = shaker_shock.responses(evidence)[0]
    rate = 0.005 * 2.0 * np.pi * 150.5
    assert alone.f_peak == pytest.approx(150.5, abs=0.15)
    assert float(alone.spectrum.max()) == pytest.approx(np.abs(alone.tip).max() / (2.0 * rate), rel=0.03)
    assert alone.fade == pytest.approx(np.log(10.0) / rate, rel=0.02)
    verdict = shaker_shock.c51(evidence)
    assert verdict.word == MET
    assert "lowest at 10 kPa" in verdict.value
    drawn(shaker_shock.GROUP, evidence, tmp_path)


@pytest.mark.parametrize(
    "rolls",
    [{1e4: (135.0, 0.05), 1e5: (155.0, 0.004)}, {1e4: (155.0, 0.05), 1e5: (140.0, 0.04)}],
    ids=["rings like a mandrel", "frequency falls"],
)
def test_shocks_otherwise_are_not_met(rolls: dict[float, tuple[float, float]], tmp_path: Path) -> None:
    assert shaker_shock.c51(shocks(tmp_path, rolls)).word == NOT_MET


# ---- images --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_targets_are_seen_as_they_move() -> None:
    """Rendered, recorded with noise, and read: slip within twice the noise floor, of some 2 um."""
    f, time = 143.8, np.linspace(0.0, 0.5, 12001)
    size = {0: 0.0, 1: 7e-6, 6: 8e-6, 11: 8.5e-6, 16: 9e-6}
    names = [f"axial_{g}_{layer}_{d}" for g in camera_images.GROUPS for layer in size for d in "hv"]
    wave = np.cos(2.0 * np.pi * f * time + 0.3)
    rows = []
    for name in names:
        _, g, layer, d = name.split("_")
        own = size[int(layer)] * (4 - int(g)) / 3.0 if d == "v" else 0.0
        rows.append((own + (5e-6 if d == "h" else 2e-6) * int(g)) * wave)  # what all targets of a group share
    history = xr.Dataset({"probe_displacement": (("probe", "time"), rows)}, {"time": time, "probe": names})
    found = camera_images.photographed(history, "axial", f, seed=3)
    floor = float(found["floor_m"])
    assert 0.5e-6 < floor < 2.5e-6
    for k in range(found.sizes["pair"]):
        g, layer, inside = (int(found[f"slip_{n}"][k]) for n in ("group", "layer", "relative_to"))
        wanted = (size[layer] - size[inside]) * (4 - g) / 3.0
        assert float(found["slip_amplitude"].sel(axis="y")[k]) == pytest.approx(wanted, abs=2.0 * floor)
        assert float(found["slip_amplitude"].sel(axis="x")[k]) < 2.0 * floor


def view(vertical: float, horizontal: float, beyond: float = 1e-6) -> camera_slip.Seen:
    """Slip that falls with the height; the same for all wraps."""
    group, layer = (a.ravel() for a in np.meshgrid([1, 2, 3], [1, 6, 11, 16], indexing="ij"))
    pairs = [(g, j, 6) for g in (1, 2, 3) for j in (11, 16)]
    group, layer, inside = (np.append(a, b) for a, b in zip(
        (group, layer, np.zeros(12, int)), np.transpose(pairs), strict=True
    ))  # fmt: skip
    fade = np.where(inside == 0, (4 - group) / 3.0, 0.0)
    return camera_slip.Seen(
        group, layer, inside, vertical * fade + np.where(inside == 6, beyond, 0.0), horizontal * fade, 1.7e-6
    )


def camera(
    folder: Path, monkeypatch: pytest.MonkeyPatch, outer: float = 0.1, **seen: tuple[float, float]
) -> FakeEvidence:
    """Evidence of two dwells that meets C52 to C55 but for what is changed."""
    sizes = {"loose": (8e-6, 1e-6), "across": (1e-6, 1e-6), "tight": (2e-6, 1e-6), "beyond": (1e-6, 0.0)} | seen
    faces = [
        {"axial": view(*sizes["loose"], sizes["beyond"][0]), "transverse": view(*sizes["across"])},
        {"axial": view(*sizes["tight"]), "transverse": view(*sizes["across"])},
    ]
    monkeypatch.setattr(camera_slip, "seen", lambda _: faces)
    members = []
    for case, factor in (("slip_20n", 3.0), ("slip_60n", 0.7)):
        data = contact_points(interfaces=2).assign_attrs(frequency_hz=145.0)
        fade = np.clip(1.0 - 2.0 * data["z_m"].values / data["z_m"].values.max(), 0.0, 1.0)
        scale = np.array([[factor], [outer * factor]])
        for name in ("peak_slip_axial", "peak_slip_hoop"):
            data[name] = ("interface", "point"), scale * fade * data[name].values[:1]
        members.append(member(data, name=case, case=case))
    return FakeEvidence(folder, {"shaker_slip": members})


@pytest.mark.parametrize("name", ["C52", "C53", "C54", "C55"])
def test_slip_as_the_camera_saw_it_is_met(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = camera_slip.GROUP.judges[name](camera(tmp_path, monkeypatch))
    assert verdict.word == MET, verdict.value


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("C52", {"loose": (31e-6, 1e-6)}),
        ("C52", {"tight": (2e-6, 6e-6)}),
        ("C53", {"across": (9e-6, 1e-6)}),
        ("C53", {"loose": (8e-6, 9e-6)}),
        ("C53", {"tight": (9e-6, 1e-6)}),
        ("C54", {"beyond": (4e-6, 0.0)}),
        ("C54", {"outer": 0.9}),
        ("C55", {"outer": 1.5}),
    ],
)
def test_slip_otherwise_is_not_met(name: str, changed: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = camera_slip.GROUP.judges[name](camera(tmp_path, monkeypatch, **changed))
    assert verdict.word == NOT_MET, verdict.value


@pytest.mark.parametrize("turned", ["z_m", "theta_rad"])
def test_slip_of_a_roll_that_is_turned_is_not_met(turned: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Largest at the base and on the axial face of the model; not on its head, or turned by a quarter."""
    evidence = camera(tmp_path, monkeypatch)
    data = evidence.given["shaker_slip"][0].data
    data[turned] = data["z_m"].max() - data["z_m"] if turned == "z_m" else data["theta_rad"] + 0.5 * np.pi
    assert camera_slip.c53(evidence).word == NOT_MET


def test_figures_of_the_images(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(camera_slip.GROUP, camera(tmp_path, monkeypatch), tmp_path)
    assert {path.stem for path in tmp_path.glob("*.png")} == {*camera_slip.GROUP.figures} != set()
