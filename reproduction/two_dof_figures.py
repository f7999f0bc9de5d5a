"""Figures of chapter 5 that compare the two-mass model with the finite-element model."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, NullFormatter

from reproduction import two_dof_study as study
from reproduction.evidence import Evidence
from wroll_fem.case.material import IsotropicMaterial
from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.study import PRESSURE, StudyCase, natural_frequency
from wroll_fem.plotting.two_dof import plot_two_dof
from wroll_fem.signals.transmissibility import magnitude
from wroll_fem.two_dof import TwoMasses
from wroll_fem.typing import FloatArray

SPACE_STUDY = "layer_space"
DENSITY, MODULUS = "coil.material.rho", "coil.material.E"


def lab_values(evidence: Evidence) -> tuple[float, float]:
    """Density (kg/m^3) and modulus (Pa) of the lab roll's layer."""
    material = evidence.roll("lab_harmonic").coil.material
    assert isinstance(material, IsotropicMaterial)
    return float(material.rho), float(material.E)


def of_space(evidence: Evidence) -> list[StudyCase]:
    """Cases of the finite-element map that have a curve: at weak pressure heavy, stiff layers may open too widely."""
    return evidence.finished(SPACE_STUDY)[0]


def with_lab_density(evidence: Evidence) -> list[StudyCase]:
    """Cases of the finite-element map with the density of the lab roll."""
    rho = lab_values(evidence)[0]
    return [m for m in of_space(evidence) if float(m.values[DENSITY]) == rho]


def plot_both_models(evidence: Evidence) -> Axes:
    """Draw Fig. 5.6: finite elements (left) and two masses (right), over frequency / frequency of the mandrel alone."""
    modulus = lab_values(evidence)[1]
    members = [m for m in with_lab_density(evidence) if float(m.values[MODULUS]) == modulus]
    if not members:
        raise InputError(f"study {SPACE_STUDY} has no case of the lab roll", remedy="see its run folders")
    alone = natural_frequency(StudyCase("mandrel", {}, evidence.result("lab_mandrel")))
    size = (1.55 * style.WIDTH, 4.8)
    _, (left, right) = plt.subplots(1, 2, figsize=size, dpi=style.DPI, layout="constrained", sharey=True)
    style.axes(left)
    pressures = sorted({float(m.values[PRESSURE]) for m in members})
    share = np.linspace(0.0, 1.0, len(pressures))  # blue to red, the pale middle left out
    shades = plt.get_cmap("coolwarm")(np.where(share < 0.5, 0.84 * share, 0.58 + 0.84 * (share - 0.5)))
    for member in sorted(members, key=lambda m: float(m.values[PRESSURE])):
        pressure, data = float(member.values[PRESSURE]), member.data
        size_of = magnitude(data).values
        shade = shades[pressures.index(pressure)]
        left.plot(data["frequency"].values / alone, size_of, color=shade, lw=1.5, label=f"{1e-3 * pressure:g} kPa")
    plot_two_dof(study.series(evidence), right)
    for ax, words in ((left, "Frequency over that of the mandrel alone, $f/f_m$ (–)"), (right, "$\\omega$ (–)")):
        ax.axvline(1.0, color="black", lw=1.0, ls=":")
        ax.set_xlim(0.6, 2.0)
        ax.set_xlabel(words)
    left.set_ylim(bottom=0.3)
    left.set_ylabel("Transmissibility (–)")
    right.set_ylabel("")
    left.legend(title="External pressure", fontsize=8, title_fontsize=8, framealpha=0.9)
    rise = [peak_of(m)[0] / alone for m in (members[0], members[-1])]
    style.title(left, f"Finite elements, lab roll: peaks from {rise[0]:.2f} to {rise[1]:.2f} $f_m$", 60)
    ends = study.series(evidence)["omega_peak"].values[[0, -1]]
    style.title(right, f"Two masses: peaks from {ends[0]:.2f} to {ends[1]:.2f}", 60)
    return left


def peak_of(member: StudyCase) -> tuple[float, float]:
    """Resonance frequency (Hz) and peak of a case."""
    return float(member.data.attrs["f_n_hz"]), float(member.data.attrs["peak_transmissibility"])


def plot_stiffness(evidence: Evidence) -> Axes:
    """Draw the largest damping over the secondary stiffness for both models, relative to Table 5.2 and 2.8 GPa."""
    ax = style.axes(None, 4.4)
    own, modulus = TwoMasses(), lab_values(evidence)[1]
    lines = [
        (f"two masses, $m_2$ = {own.m2:g}: $k_2$ / {own.k2:g}", study.over_stiffness(evidence), own.k2, "o-"),
        ("lab roll, sweeps at 10, 30, 100 kPa: $E_l$ / 2.8 GPa", study.over_modulus(evidence), modulus, "s-"),
    ]
    steady = study.largest_damping(with_lab_density(evidence), MODULUS)
    lines.append(("the same, steady states at 10 to 320 kPa", {e: z for (e,), z in steady.items()}, modulus, "^--"))
    for (words, found, reference, mark), colour in zip(lines, (style.BLUE, style.RED, style.ORANGE), strict=True):
        values = np.array(list(found.items()))
        ax.plot(values[:, 0] / reference, 100 * values[:, 1], mark, color=colour, lw=1.8, label=words)
    ax.set_xscale("log", base=2)
    ax.set_yscale("log")
    plain_axis(ax)
    ax.set_yticks([2, 5, 10, 20, 30])
    ax.minorticks_off()
    ax.set_xlabel("Stiffness of the secondary over that of the reference (–)")
    ax.set_ylabel("Largest half-power damping (%)")
    ax.legend(fontsize=8, framealpha=0.9)
    style.title(ax, "Largest damping over the preloads against the stiffness of the secondary, in both models")
    return ax


def plot_layer_space(evidence: Evidence) -> Axes:
    """Draw both maps of largest damping over secondary mass and stiffness, relative to Table 5.2 and the lab roll."""
    density, modulus = lab_values(evidence)
    cases, failed = evidence.finished(SPACE_STUDY)
    found = study.largest_damping(cases, DENSITY, MODULUS)
    rho, young = sorted({key[0] for key in found}), sorted({key[1] for key in found})
    if len(rho) < 2 or len(young) < 2:
        raise InputError(f"study {SPACE_STUDY} has no map", remedy="give two densities and two moduli")
    roll = np.array([[found.get((r, e), np.nan) for r in rho] for e in young])
    space, own = study.space(evidence), TwoMasses()
    masses = space["zeta_max"].transpose("k2", "m2")
    size = (1.55 * style.WIDTH, 4.6)
    _, (left, right) = plt.subplots(1, 2, figsize=size, dpi=style.DPI, layout="constrained", sharex=True, sharey=True)
    draw_map(
        left, space["m2"].values / own.m2, space["k2"].values / own.k2, 100.0 * np.asarray(masses.values, dtype=float)
    )
    draw_map(right, np.array(rho) / density, np.array(young) / modulus, 100.0 * roll)
    left.set_ylabel("Stiffness of the secondary over the reference (–)")
    style.title(left, "Two masses: $m_2$/0.85, $k_2$/1.15", 60)
    rises = 100 * np.mean(np.diff(roll, axis=0)[np.isfinite(np.diff(roll, axis=0))] > 0.0)
    lacking = f"; {len(failed)} of {len(cases) + len(failed)} cases have no curve" if failed else ""
    style.title(
        right, f"Lab roll, finite elements: damping rises with the modulus in {rises:.0f} % of the steps{lacking}", 60
    )
    return left


def draw_map(ax: Axes, x: FloatArray, y: FloatArray, percent: FloatArray) -> None:
    """Draw contours of damping (%) over (y, x) on logarithmic axes, with the reference marked."""
    style.axes(ax)
    filled = ax.contourf(x, y, percent, levels=14, cmap="viridis")
    lines = ax.contour(x, y, percent, levels=np.asarray(filled.levels)[::2], colors="white", linewidths=0.7)
    ax.clabel(lines, fmt="%.3g", fontsize=7)
    style.figure_of(ax).colorbar(filled, ax=ax).set_label("Largest half-power damping (%)")
    ax.plot(1.0, 1.0, "o", color="white", mec="black", ms=6)
    ax.set_xscale("log", base=2)
    ax.set_yscale("log", base=2)
    plain_axis(ax)
    ax.grid(False)
    ax.set_xlabel("Mass of the secondary over the reference (–)")


def plain_axis(ax: Axes) -> None:
    """Format the tick labels of both axes without exponents."""
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
