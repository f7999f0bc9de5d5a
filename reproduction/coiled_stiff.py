"""Claims on the frequencies of the coil without slip ("coiled stiff"): C14 to C17, C28 to C32."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from reproduction.claim_group import ClaimGroup, study_figure
from reproduction.evidence import Evidence
from reproduction.verdict import Verdict
from reproduction.words import numbers
from wroll_fem.bodies.mode_shapes import main_bending
from wroll_fem.errors import InputError
from wroll_fem.plotting.shear_stiffness import MODULUS, SHEAR, crossing
from wroll_fem.plotting.study import StudyCase
from wroll_fem.typing import FloatArray

STIFF, KAPTON, MANDREL = "coiled_stiff", "kapton_roll", "kapton_mandrel"
MODULI = (2.5e9, 4.0e9)
HARMONICS, SOLID = "mesh.discretisation=fourier", "mesh.discretisation=three_dimensional"
OPEN = {
    "tip free": "mandrel.tip=free",
    "coil clamped at its base": "coil.base=clamped",
    "mandrel nu 0.30": "mandrel.material.nu=0.30",
    "2700 to 2800 kg/m^3": "mandrel.material.rho=2800",
    "tip mass of 0.05 kg": "mandrel.tip_mass=0.05",
}
"""Input that the thesis does not state -> override with another value than in the shipped case."""


def bending_index(data: xr.Dataset) -> int:
    """Index of the bending mode with the largest effective mass.

    Raises
    ------
    InputError
        If the modes include none.
    """
    index = main_bending(data["mode_kind"].values.tolist(), data["effective_mass_fraction"].values)
    if index is None:
        raise InputError("the modes include no bending mode", key="modal.count", remedy="increase it")
    return index


def bending(data: xr.Dataset) -> float:
    """Frequency of the main bending mode, Hz."""
    return float(data["mode_frequency"].values[bending_index(data)])


def frequencies(evidence: Evidence, cases: Sequence[Sequence[str]]) -> list[float]:
    """Bending frequency of cases (config, override, ...), Hz."""
    return [bending(data) for data in evidence.results(cases)]


def alone(members: Sequence[StudyCase]) -> float:
    """Bending frequency of the reference case of a study, Hz."""
    return next(bending(m.data) for m in members if m.reference)


def curve(members: Sequence[StudyCase], modulus: float | None = None) -> tuple[FloatArray, FloatArray]:
    """Interlayer shear moduli (Pa, ascending) and bending frequencies (Hz) of a study."""
    own = [m for m in members if not m.reference and (modulus is None or m.values[MODULUS] == modulus)]
    own.sort(key=lambda m: float(m.values[SHEAR]))
    return np.array([m.values[SHEAR] for m in own]), np.array([bending(m.data) for m in own])


def c14(evidence: Evidence) -> Verdict:
    f, independent, *others = frequencies(
        evidence, [(STIFF, SOLID), (STIFF, HARMONICS), *((STIFF, change) for change in OPEN.values())]
    )
    said = ", ".join(f"{words} {other:.1f}" for words, other in zip(OPEN, others, strict=True))
    value = f"f_n = {f:.2f} Hz; Fourier elements {independent:.2f} Hz; inputs not stated in the thesis: {said} Hz"
    return Verdict(value, 95.0 <= f <= 105.0)


def c15(evidence: Evidence) -> Verdict:
    members = evidence.study("shear_stiffness")
    G, f = curve(members)
    mass_alone = alone(members)
    high = G >= 0.999e8
    ratios = f[high] / mass_alone
    value = f"f_nsm = {mass_alone:.2f} Hz; f_n/f_nsm = {numbers(ratios, '.2f')} at "
    value += f"{numbers(G[high] / 1e9, 'g')} GPa; lowest of the scan {f[0] / mass_alone:.2f} at {G[0]:g} Pa"
    return Verdict(value, bool((ratios > 1).all()) and int(high.sum()) >= 5)


def c16(evidence: Evidence) -> Verdict:
    G, f = curve(evidence.study("shear_stiffness"))
    slope = np.diff(np.log(f)) / np.diff(np.log(G))
    middle = np.sqrt(G[1:] * G[:-1])
    top = int(slope.argmax())
    value = (
        f"f_n = {f[0]:.2f} Hz at {G[0]:g} Pa to {f[-1]:.2f} Hz at {G[-1]:g} Pa, d ln f/d ln G = {slope[0]:.4f} at the "
        f"low end, at most {slope[top]:.3f} (around {middle[top] / 1e6:.0f} MPa)"
    )
    return Verdict(value, bool((np.diff(f) > 0).all()) and bool(slope[0] < slope[top] / 3))


def c17(evidence: Evidence) -> Verdict:
    members = evidence.study("shear_stiffness")
    soft = min((m for m in members if not m.reference), key=lambda m: float(m.values[SHEAR])).data
    kinds, share = (
        soft["mode_kind"].values.tolist(),
        soft["effective_mass_fraction"].sel(component="x").values,
    )
    index = bending_index(soft)
    lower = [(str(kinds[k]), float(soft["mode_frequency"].values[k]), float(share[k])) for k in range(index)]
    value = ", ".join(f"{kind} {f:.1f} Hz" for kind, f, _ in lower) + f" below bending at {bending(soft):.1f} Hz; "
    value += f"effective mass along x at most {max((s for *_, s in lower), default=0.0):.0e} against {share[index]:.2f}"
    names = {kind for kind, *_ in lower} <= {"torsion", "axial"}
    return Verdict(value, bool(lower) and names and all(s < 0.1 * share[index] for *_, s in lower))


def kapton(modulus: float, G: float) -> tuple[str, str, str]:
    """Overrides of the Kapton roll with given in-plane and interlayer shear modulus, Pa."""
    return KAPTON, f"{MODULUS}={modulus!r}", f"{SHEAR}={G!r}"


def isotropic(modulus: float) -> float:
    """Shear modulus E/(2(1 + nu)) of Kapton, Pa."""
    return modulus / (2 * 1.35)


def softest(evidence: Evidence, modulus: float) -> float:
    """Lowest shear modulus for which bending is the fundamental mode, Pa, from Fourier elements."""
    case = evidence.roll(*kapton(modulus, isotropic(modulus)), HARMONICS)

    def search() -> xr.Dataset:
        from wroll_fem.coiled_stiff.frequency_bounds import softest_coil
        from wroll_fem.fem.fourier_roll import FourierRoll

        found = softest_coil(FourierRoll(case), case.coil.solid())
        if found is None:
            raise InputError(
                f"a Kapton roll of {modulus:g} Pa has no fundamental bending mode", remedy="use another modulus"
            )
        return xr.Dataset({"shear_modulus": found.shear_modulus})

    return float(evidence.kept("softest_kapton", search, case=case.hash())["shear_modulus"])


def c28(evidence: Evidence) -> Verdict:
    low = {modulus: 1.02 * softest(evidence, modulus) for modulus in MODULI}  # 1 % in f clear of the crossing
    ends = [kapton(modulus, G) for modulus in MODULI for G in (low[modulus], isotropic(modulus))]
    results = evidence.results(ends)
    gaps, parts = [], []
    for modulus, loose, tight in zip(MODULI, results[::2], results[1::2], strict=True):
        gaps.append(bending(tight) - bending(loose))
        parts.append(
            f"{modulus / 1e9:g} GPa: {bending(loose):.1f} Hz at {low[modulus]:.0f} Pa (lowest mode: "
            f"{loose['mode_kind'].values[0]}) to {bending(tight):.1f} Hz at {isotropic(modulus) / 1e9:.2f} GPa, "
            f"{gaps[-1]:.1f} Hz"
        )
    return Verdict("; ".join(parts), all(25 <= gap <= 55 for gap in gaps) and gaps[1] > gaps[0])


def weighed(evidence: Evidence, modulus: float, mandrel: float) -> float:
    """Shear modulus (Pa) at which the roll with the weighed density of Table 4.2 has the frequency of the mandrel."""
    moduli = np.geomspace(1e5, 1e7, 5)
    cases = [(*kapton(modulus, float(G)), HARMONICS, "coil.material.rho=2000") for G in moduli]
    return crossing(moduli, np.array(frequencies(evidence, cases)), mandrel)


def crossing_text(G: float) -> str:
    """Shear modulus of a crossing as text."""
    return f"{G / 1e6:.2f} MPa" if np.isfinite(G) else "no G from 0.1 to 10 MPa"


def c29(evidence: Evidence) -> Verdict:
    members = evidence.study("shear_stiffness_kapton")
    mandrel = alone(members)
    meets = [crossing(*curve(members, modulus), mandrel) for modulus in MODULI]
    parts = [f"{G / 1e6:.2f} MPa for {E / 1e9:g} GPa" for G, E in zip(meets, MODULI, strict=True)]
    (clamped,) = frequencies(evidence, [(*kapton(MODULI[0], 1e4), "coil.base=clamped")])
    heavy = [weighed(evidence, modulus, mandrel) for modulus in MODULI]
    value = (
        f"f_n = f_m = {mandrel:.2f} Hz at {' and '.join(parts)} with the density of Table 2.5; with that of Table 4.2 "
        f"(2000 kg/m^3) at {' and '.join(crossing_text(G) for G in heavy)}; with the coil clamped at its base "
    )
    if clamped > mandrel:
        value += f"there is no crossing ({clamped:.1f} Hz already at 10 kPa, 2.5 GPa)"
    else:
        value += f"{clamped:.1f} Hz at 10 kPa, 2.5 GPa"
    found = bool(np.isfinite(meets).all())
    return Verdict(value, found and min(meets) / 3.0 <= 1e6 <= 3.0 * max(meets))


def c30(evidence: Evidence) -> Verdict:
    mandrel, *tops = frequencies(evidence, [(MANDREL,), *(kapton(modulus, isotropic(modulus)) for modulus in MODULI)])
    return Verdict(f"{tops[0]:.1f} and {tops[1]:.1f} Hz against {mandrel:.1f} Hz", all(top > mandrel for top in tops))


def c31(evidence: Evidence) -> Verdict:
    readings = {}
    for wall in (1.6e-3, 1.5e-3):
        for words, diameter in (("outer", 0.080), ("mid-surface", 0.080 + wall)):
            sets = (f"geometry.mandrel_thickness={wall}", f"geometry.mandrel_outer_diameter={diameter}")
            readings[f"wall {1e3 * wall:g} mm, {words} diameter 80 mm"] = sets
    free, *found = frequencies(
        evidence,
        [(MANDREL, "mandrel.tip=free"), *((MANDREL, *s, *d) for s in readings.values() for d in ((), (HARMONICS,)))],
    )
    pairs = dict(zip(readings, zip(found[::2], found[1::2], strict=True), strict=True))
    value = "; ".join(f"{words}: {a:.2f} Hz (solid {b:.2f} Hz)" for words, (a, b) in pairs.items())
    value += f"; tip free to ovalise: {free:.2f} Hz"
    outer = [a for words, (a, _) in pairs.items() if "outer" in words]  # section 2.4 defines r_m as outer radius
    alike = all(abs(a / b - 1) < 0.01 for a, b in pairs.values())
    return Verdict(value, alike and all(145 <= f <= 155 for f in outer))


def c32(evidence: Evidence) -> Verdict:
    material = evidence.roll(KAPTON).coil.solid()
    value = f"G = {material.G_z_theta / 1e9:.4f} GPa, E_r = {material.E_r / 1e9:g} GPa in configs/{KAPTON}.yaml"
    exact = abs(material.G_z_theta / isotropic(4e9) - 1) < 1e-12 and abs(material.G_r_theta / isotropic(4e9) - 1) < 1e-4
    return Verdict(value, exact and abs(material.E_r - 0.01 * 4e9) < 1.0 and round(isotropic(4e9) / 1e9, 2) == 1.48)


GROUP = ClaimGroup(
    {"C14": c14, "C15": c15, "C16": c16, "C17": c17, "C28": c28, "C29": c29, "C30": c30, "C31": c31, "C32": c32},
    figures={
        "shear_stiffness": (
            "Fig 2.13: bending frequency of the case study over the shear stiffness between wraps",
            study_figure("shear_stiffness"),
        ),
        "shear_stiffness_band": (
            "Fig 2.17: bending frequency of the Kapton roll over the shear stiffness between wraps",
            study_figure("shear_stiffness_kapton", "shear_stiffness_band"),
        ),
    },
    studies=("shear_stiffness", "shear_stiffness_kapton"),
)
