"""Judges of the flight rolls on made-up steady curves."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from support.fake_evidence import FakeEvidence, judges, member

from reproduction import flight_rolls, flight_sensitivity
from reproduction.flight_curves import OCTAVES_PER_SECOND, THICKNESS, point, swept
from wroll_fem.plotting.study import StudyCase

PRESSURES = (1e4, 5e4, 1e5, 5e5)
WIDE = {"zeta": (0.02, 0.18, 0.06, 0.02), "f_n": (50.0, 60.0, 75.0, 85.0), "peak": (60.0, 7.0, 20.0, 50.0)}
"""Optimum of damping inside the range, wide range of frequency: iROSA and HabEx of the thesis."""
PLATEAU = {"zeta": (0.02, 0.05, 0.069, 0.07), "f_n": (80.0, 82.0, 83.0, 84.0), "peak": (60.0, 20.0, 10.0, 9.0)}
"""No optimum, narrow range of frequency: SSPP of the thesis."""


def curve(case: str, mu: float, pressure: float, f_n: float, zeta: float, peak: float, work: float = 1.0) -> StudyCase:
    """Steady curve whose friction work per cycle, J, is the same in the whole band."""
    frequency = np.linspace(40.0, 100.0, 61)
    size = peak / np.sqrt(1.0 + ((frequency - f_n) / (zeta * f_n)) ** 2)
    data = {
        "transmissibility_real": ("frequency", size), "transmissibility_imag": ("frequency", 0.0 * size),
        "friction_work_per_cycle": ("frequency", np.full_like(size, work)),
        "tip_amplitude": ("frequency", 1e-3 / zeta**0.5 * size / size.max()),
    }  # fmt: skip
    attrs = {"f_n_hz": f_n, "zeta": zeta, "peak_transmissibility": peak}
    dataset = xr.Dataset(data, {"frequency": frequency}, attrs)
    return member(dataset, case=case, preload__pressure=pressure, contact__friction__mu=mu)


def series(case: str, mu: float, scale: float = 1.0, **changed: tuple[float, ...]) -> list[StudyCase]:
    """Curves of one roll whose preloads are scaled to the same mu times preload; `scale` is that of the damping."""
    line = (PLATEAU if case == "sspp_friction" else WIDE) | changed
    rows = zip(PRESSURES, line["f_n"], line["zeta"], line["peak"], (1.0, 0.9, 1.1, 0.9), strict=True)
    return [curve(case, mu, p * 0.25 / mu, f, z * scale, t, w) for p, f, z, t, w in rows]


def chirp(curve: StudyCase, work: float) -> StudyCase:
    """Chirp with the tip motion of a steady curve, and friction work, J, that follows its damping or not."""
    tip = float(curve.data["tip_amplitude"].max())
    history = {"tip_displacement": ("time", [0.0, tip, -tip]), "friction_energy": ("time", [0.0, 0.5 * work, work])}
    response = curve.data[["transmissibility_real", "transmissibility_imag"]]
    return StudyCase(curve.name, curve.values, response.assign(history))


def rolls(
    folder: Path, irosa: float = 1.0, top: float = 0.5, size: dict[float, tuple[float, float]] | None = None,
    work: float = 30.0, slope: float = 1.0, **changed: tuple[float, ...],
) -> FakeEvidence:  # fmt: skip
    """The three rolls as in the thesis; `changed` applies to SSPP.

    `irosa` scales the damping of iROSA at mu = 0.5, `top` that of all rolls at 10 GPa. `size` is s -> factors on the
    damping of SSPP and HabEx; `work` the friction work of the chirps, J, which rises with the damping by `slope`.
    """
    studies: dict[str, list[StudyCase]] = {name: [] for name in ("flight_friction", "flight_modulus")}
    for mu in (0.125, 0.25, 0.5):
        far = 1.0 + 0.1 * (mu == 0.5)
        studies["flight_preload" if mu == 0.25 else "flight_friction"] = (
            studies["flight_friction"] if mu != 0.25 else []
        ) + [
            *series("irosa_friction", mu, irosa if mu == 0.5 else 1.0), *series("habex_friction", mu, far),
            *series("sspp_friction", mu, 1.0 + 0.3 * (mu == 0.5), **changed),
        ]  # fmt: skip
    for modulus, scale, shift in ((1e9, 1.5, 0.8), (1e10, top, 1.2)):
        for case in ("irosa_friction", "sspp_friction", "habex_friction"):
            line = PLATEAU if case == "sspp_friction" else WIDE
            moved = series(case, 0.25, scale, f_n=tuple(shift * f for f in line["f_n"]))
            studies["flight_modulus"] += [with_value(m, "coil.material.E", modulus) for m in moved]
    for case, name in (("irosa", "iROSA"), ("sspp", "SSPP"), ("habex", "HabEx")):
        members = []
        for s, (sspp, habex) in (size or {0.25: (3.0, 1.1), 0.5: (2.0, 1.1), 0.75: (1.5, 1.0)}).items():
            factor, shift = {"irosa": (1.0, 1.0), "sspp": (sspp, 1.0), "habex": (habex, 2.0 - s)}[case]
            shape = {} if case == "habex" or s == 0.75 else {"zeta": WIDE["zeta"]}
            line = WIDE if case != "sspp" else PLATEAU
            moved = series(f"{case}_friction", 0.25, factor, f_n=tuple(shift * f for f in line["f_n"]), **shape)
            members += [with_value(m, "coil.total_thickness", s * THICKNESS[name]) for m in moved]
        studies[f"flight_size_{case}"] = members
        sheared = series(f"{case}_friction", 0.25, 0.5)
        studies[f"flight_shear_{case}"] = [with_value(m, "coil.material.G_r_theta", 1e7) for m in sheared]
    studies["flight_inner_edge"] = studies["flight_preload"]
    studies["flight_chirp"] = [
        chirp(m, work * float(m.data.attrs["zeta"]) ** slope * float(m.data["tip_amplitude"].max()) ** 2 * 1e7)
        for m in studies["flight_preload"]
    ]
    return FakeEvidence(folder, studies)


def with_value(one: StudyCase, key: str, value: float) -> StudyCase:
    return StudyCase(one.name, {**one.values, key: value}, one.data)


@pytest.mark.parametrize("name", [f"C{n}" for n in range(96, 108) if n != 103])
def test_rolls_as_in_the_thesis_are_met(name: str, tmp_path: Path) -> None:
    verdict = judges("ch6")[name](rolls(tmp_path))
    assert verdict.holds, verdict.value


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("C96", {"peak": (9.0, 20.0, 10.0, 60.0)}),
        ("C97", {"zeta": (0.02, 0.07, 0.05, 0.02)}),
        ("C98", {"f_n": (50.0, 60.0, 70.0, 84.0)}),
        ("C101", {"zeta": (0.005, 0.05, 0.069, 0.07)}),
        ("C106", {"zeta": (0.02, 0.07, 0.05, 0.02)}),
        ("C105", {"irosa": 1.5}),
        ("C100", {"work": 3e4}),
        ("C102", {"slope": -2.0}),
        ("C104", {"top": 1.2}),
        ("C107", {"size": {0.25: (1.0, 1.1), 0.5: (2.0, 1.1), 0.75: (1.5, 1.0)}}),
        ("C107", {"size": {0.25: (3.0, 1.5), 0.5: (2.0, 1.1), 0.75: (1.5, 1.0)}}),
    ],
)
def test_rolls_otherwise_are_not_met(name: str, changed: dict, tmp_path: Path) -> None:
    assert not judges("ch6")[name](rolls(tmp_path, **changed)).holds


def test_work_of_the_chirp_is_the_number_of_its_cycles() -> None:
    """1 J per cycle: the cycles of a geometric chirp in a band are its width over R ln 2."""
    found = point(curve("irosa_friction", 0.25, 1e5, 70.0, 0.05, 20.0))
    time = math.log2(100.0 / 40.0) / OCTAVES_PER_SECOND
    cycles = 40.0 * (2.0 ** (OCTAVES_PER_SECOND * time) - 1.0) / (OCTAVES_PER_SECOND * math.log(2.0))
    assert found.sweep_work == pytest.approx(cycles, rel=1e-9)
    read = swept(chirp(curve("irosa_friction", 0.25, 1e5, 70.0, 0.05, 20.0), 12.0))
    assert read.norm == pytest.approx(12.0 / found.tip**2 / 70.0)


def test_figures_are_drawn(tmp_path: Path) -> None:
    for group in (flight_rolls.GROUP, flight_sensitivity.GROUP):
        for _, drawing in group.figures.values():
            axes = drawing(rolls(tmp_path))
            assert axes.get_lines()
            assert axes.get_ylabel()
    plt.close("all")
