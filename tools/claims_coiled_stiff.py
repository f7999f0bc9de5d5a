"""Judge claims C14 to C17 and C28 to C32 of the source (coiled-stiff roll) and draw Figs. 2.13 and 2.17.

`.venv/bin/python tools/claims_coiled_stiff.py` prints one line per claim, writes docs/tables/coiled_stiff.md and two
figures into docs/figures. About five minutes on one core; every frequency is that of the three-dimensional model unless
said otherwise.
"""

from __future__ import annotations

import os
from functools import cache

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import xarray as xr
from chapter4_runs import ROOT, Verdict

from wroll_fem.analyses import run_analysis
from wroll_fem.case import Case, load_case
from wroll_fem.fem.fourier_roll import FourierRoll
from wroll_fem.fem.loosest import loosest_coil
from wroll_fem.grid import load_grid
from wroll_fem.modes import main_bending
from wroll_fem.plotting import save_figure
from wroll_fem.plotting.series import FIGURES
from wroll_fem.plotting.shear_stiffness import MODULUS, SHEAR, crossing
from wroll_fem.plotting.study import SeriesMember
from wroll_fem.progress import SilentProgress

DOCS = ROOT / "docs"
STIFF, MASS, KAPTON, MANDREL = "coiled_stiff", "coiled_stiff_mass", "kapton_roll", "kapton_mandrel"
MODULI = (2.5e9, 4.0e9)
FOURIER = "mesh.discretisation=fourier"
SAID = {
    "C14": "bending at about 100 Hz with G = 1 GPa (95 to 105 Hz)",
    "C15": "for G of 0.1 to 1 GPa stiffer than the same mass without stiffness",
    "C16": "flat at low G, strong growth beyond a threshold",
    "C17": "at low G axial or torsional shear lie below bending, with little mass",
    "C28": "disparity of 30 to 50 Hz for Kapton of 2.5 to 4 GPa (25 to 55 Hz, rising)",
    "C29": "below a G of about 1 MPa lower than the mandrel alone (0.05 to 20 MPa)",
    "C30": "for large G above the mandrel alone",
    "C31": "mandrel with a 0.05 kg tip mass at about 150 Hz (145 to 155 Hz)",
    "C32": "isotropic limit E/(2(1 + nu)) = 1.48 GPa, E_r = 0.04 GPa for 4 GPa",
}


@cache
def modes(name: str, *overrides: str) -> xr.Dataset:
    case = load_case(ROOT / "configs" / f"{name}.yaml", overrides)
    return run_analysis(case, progress=SilentProgress())


def bending(data: xr.Dataset) -> float:
    index = main_bending(data["mode_kind"].values.tolist(), data["effective_mass_fraction"].values)
    if index is None:
        raise RuntimeError("no bending mode: raise modal.count")
    return float(data["mode_frequency"].values[index])


def frequency(name: str, *overrides: str) -> float:
    return bending(modes(name, *overrides))


def study(name: str) -> list[SeriesMember]:
    """The cases of a study, in this process."""
    grid = load_grid(ROOT / "configs" / "studies" / f"{name}.yaml")
    return [
        SeriesMember(m.name, m.values, run_analysis(m.case, progress=SilentProgress()), reference=m.name == "reference")
        for m in grid.members
    ]


def curve(members: list[SeriesMember], modulus: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Shear stiffness in Pa and bending frequency in Hz, rising stiffness."""
    own = [m for m in members if not m.reference and (modulus is None or m.values[MODULUS] == modulus)]
    own.sort(key=lambda m: float(m.values[SHEAR]))
    return np.array([m.values[SHEAR] for m in own]), np.array([bending(m.data) for m in own])


def c14() -> Verdict:
    f = frequency(STIFF)
    others = {
        "tip free": ("mandrel.tip=free",),
        "coil clamped at its base": ("coil.base=clamped",),
        "mandrel nu 0.30": ("mandrel.material.nu=0.30",),
        "2700 to 2800 kg/m^3": ("mandrel.material.rho=2800",),
        "tip mass of 0.05 kg": ("mandrel.tip_mass=0.05",),
    }
    said = ", ".join(f"{words} {frequency(STIFF, *change):.1f}" for words, change in others.items())
    independent = frequency(STIFF, FOURIER)
    value = f"f_n = {f:.2f} Hz; harmonics around the axis {independent:.2f} Hz; what the source leaves open: {said} Hz"
    return Verdict(value, 95.0 <= f <= 105.0)


def c15(members: list[SeriesMember]) -> Verdict:
    G, f = curve(members)
    alone = next(bending(m.data) for m in members if m.reference)
    high = G >= 0.999e8
    ratios = f[high] / alone
    value = f"f_nsm = {alone:.2f} Hz; f_n/f_nsm = {', '.join(f'{r:.2f}' for r in ratios)} at "
    value += f"{', '.join(f'{g / 1e9:g}' for g in G[high])} GPa; lowest of the scan {f[0] / alone:.2f} at {G[0]:g} Pa"
    return Verdict(value, bool((ratios > 1).all()) and int(high.sum()) >= 5)


def c16(members: list[SeriesMember]) -> Verdict:
    G, f = curve(members)
    slope = np.diff(np.log(f)) / np.diff(np.log(G))
    middle = np.sqrt(G[1:] * G[:-1])
    top = int(slope.argmax())
    value = (
        f"f_n = {f[0]:.2f} Hz at {G[0]:g} Pa to {f[-1]:.2f} Hz at {G[-1]:g} Pa, d ln f/d ln G = {slope[0]:.4f} at the "
    )
    value += f"low end, at most {slope[top]:.3f} (around {middle[top] / 1e6:.0f} MPa)"
    return Verdict(value, bool((np.diff(f) > 0).all()) and slope[0] < slope[top] / 3)


def c17(members: list[SeriesMember]) -> Verdict:
    loosest = min((m for m in members if not m.reference), key=lambda m: float(m.values[SHEAR])).data
    kinds, share = loosest["mode_kind"].values.tolist(), loosest["effective_mass_fraction"].sel(component="x").values
    index = main_bending(kinds, loosest["effective_mass_fraction"].values)
    assert index is not None
    lower = [(str(kinds[k]), float(loosest["mode_frequency"].values[k]), float(share[k])) for k in range(index)]
    value = ", ".join(f"{kind} {f:.1f} Hz" for kind, f, _ in lower) + f" below bending at {bending(loosest):.1f} Hz; "
    value += f"effective mass along x at most {max((s for *_, s in lower), default=0.0):.0e} against {share[index]:.2f}"
    names = {kind for kind, *_ in lower} <= {"torsion", "axial"}
    return Verdict(value, bool(lower) and names and all(s < 0.1 * share[index] for *_, s in lower))


def kapton(modulus: float, G: float) -> tuple[str, str]:
    return f"{MODULUS}={modulus!r}", f"{SHEAR}={G!r}"


def isotropic(modulus: float) -> float:
    return modulus / (2 * 1.35)


def softest(modulus: float) -> float:
    """Lowest shear stiffness with a fundamental bending mode, Pa, from the model in harmonics."""
    case: Case = load_case(ROOT / "configs" / f"{KAPTON}.yaml", [*kapton(modulus, isotropic(modulus)), FOURIER])
    found = loosest_coil(FourierRoll(case), case.coil.material.solid())
    assert found is not None
    return float(found.shear_modulus)


def c28() -> Verdict:
    gaps, parts = [], []
    for modulus in MODULI:
        low = 1.02 * softest(modulus)  # 1 % in frequency clear of the crossing with torsion
        loose = modes(KAPTON, *kapton(modulus, low))
        tight = frequency(KAPTON, *kapton(modulus, isotropic(modulus)))
        first = str(loose["mode_kind"].values[0])
        gaps.append(tight - bending(loose))
        parts.append(
            f"{modulus / 1e9:g} GPa: {bending(loose):.1f} Hz at {low:.0f} Pa (lowest mode: {first}) to "
            f"{tight:.1f} Hz at {isotropic(modulus) / 1e9:.2f} GPa, {gaps[-1]:.1f} Hz"
        )
    return Verdict("; ".join(parts), all(25 <= gap <= 55 for gap in gaps) and gaps[1] > gaps[0])


def c29(members: list[SeriesMember]) -> Verdict:
    mandrel = next(bending(m.data) for m in members if m.reference)
    meets = [crossing(*curve(members, modulus), mandrel) for modulus in MODULI]
    parts = [f"{G / 1e6:.2f} MPa for {E / 1e9:g} GPa" for G, E in zip(meets, MODULI, strict=True)]
    clamped = frequency(KAPTON, *kapton(MODULI[0], 1e4), "coil.base=clamped")
    value = f"f_n = f_m = {mandrel:.2f} Hz at {' and '.join(parts)}; with the coil clamped at its base there is no "
    value += f"crossing ({clamped:.1f} Hz already at 10 kPa, 2.5 GPa)"
    if clamped < mandrel:
        value = value.split("; with")[0] + f"; with the coil clamped at its base {clamped:.1f} Hz at 10 kPa, 2.5 GPa"
    return Verdict(value, all(0.05e6 <= G <= 20e6 for G in meets))


def c30() -> Verdict:
    mandrel = frequency(MANDREL)
    tops = [frequency(KAPTON, *kapton(modulus, isotropic(modulus))) for modulus in MODULI]
    value = f"{tops[0]:.1f} and {tops[1]:.1f} Hz against {mandrel:.1f} Hz"
    return Verdict(value, all(top > mandrel for top in tops))


def c31() -> Verdict:
    readings = {}
    for wall in (1.6e-3, 1.5e-3):
        for words, diameter in (("outer", 0.080), ("mid-surface", 0.080 + wall)):
            change = (f"geometry.mandrel_thickness={wall}", f"geometry.mandrel_outer_diameter={diameter}")
            found = frequency(MANDREL, *change), frequency(MANDREL, *change, FOURIER)
            readings[f"wall {1e3 * wall:g} mm, {words} diameter 80 mm"] = found
    value = "; ".join(f"{words}: {a:.2f} Hz (solid {b:.2f} Hz)" for words, (a, b) in readings.items())
    free = frequency(MANDREL, "mandrel.tip=free")
    value += f"; tip not held round: {free:.2f} Hz"
    outer = [pair[0] for words, pair in readings.items() if "outer" in words]  # section 2.4 defines r_m as outer radius
    alike = all(abs(a / b - 1) < 0.01 for a, b in readings.values())
    return Verdict(value, alike and all(145 <= f <= 155 for f in outer))


def c32() -> Verdict:
    case = load_case(ROOT / "configs" / f"{KAPTON}.yaml")
    material = case.coil.material.solid()
    value = f"G = {material.G_z_theta / 1e9:.4f} GPa, E_r = {material.E_r / 1e9:g} GPa in configs/{KAPTON}.yaml"
    exact = abs(material.G_z_theta / isotropic(4e9) - 1) < 1e-12 and abs(material.G_r_theta / isotropic(4e9) - 1) < 1e-4
    return Verdict(value, exact and abs(material.E_r - 0.01 * 4e9) < 1.0 and round(isotropic(4e9) / 1e9, 2) == 1.48)


def main() -> None:
    stiff, band = study("shear_stiffness"), study("shear_stiffness_kapton")
    verdicts = {
        "C14": c14(), "C15": c15(stiff), "C16": c16(stiff), "C17": c17(stiff), "C28": c28(), "C29": c29(band),
        "C30": c30(), "C31": c31(), "C32": c32(),
    }  # fmt: skip
    rows = ["| id | the source says | computed here | verdict |", "|---|---|---|---|"]
    for name, verdict in verdicts.items():
        print(f"{name:<5} {verdict.text():<24} {verdict.value}")
        rows.append(f"| {name} | {SAID[name]} | {verdict.value} | **{verdict.text()}** |")
    text = ["Made by `.venv/bin/python tools/claims_coiled_stiff.py`.", "", *rows, ""]
    (DOCS / "tables" / "coiled_stiff.md").write_text("\n".join(text), encoding="utf-8")
    for figure, members in (("shear_stiffness", stiff), ("shear_stiffness_band", band)):
        print(save_figure(FIGURES[figure](members), DOCS / "figures" / f"{figure}.png"))


if __name__ == "__main__":
    main()
