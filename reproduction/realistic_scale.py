"""Claims on the structures at realistic scale that need no roll with friction: C91 to C95, C103, C108 and C109.

The rolls with friction are in `flight_rolls`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.coiled_stiff import bending
from reproduction.evidence import Evidence
from reproduction.sweep_rate import attainment
from reproduction.verdict import THESIS_ERROR, Verdict
from reproduction.words import numbers
from wroll_fem.plotting import style

YOUNG, POISSON, DENSITY, YIELD = 70.0e9, 0.33, 2700.0, 280.0e6
"""Aluminium; the thesis states the yield stress (Pa) alone."""
SAFETY, MARGIN, PRESSURE = 1.2, 0.25, 5.0e5
"""Factor of safety, margin and wrapping pressure (Pa) of section 6.3."""


@dataclass(frozen=True)
class Structure:
    """Coiled structure of Table 6.1 on its mandrel of Table 6.2.

    Attributes
    ----------
    length, diameter, outer
        Length, outer diameter of the mandrel, outer diameter of the coil, m.
    coil_mass
        Mass of the coil, kg.
    wall
        Wall of the mandrel, m.
    printed
        AR, DR, MR, TR and k (kN/mm) as printed.
    """

    length: float
    diameter: float
    outer: float
    coil_mass: float
    wall: float
    printed: tuple[float, float, float, float, float]

    @property
    def coil_thickness(self) -> float:
        """Thickness of the coil, m."""
        return 0.5 * (self.outer - self.diameter)

    def area(self, wall: float) -> float:
        """Cross-section of the mandrel, m^2."""
        return math.pi * (self.diameter - wall) * wall

    def inertia(self, wall: float) -> float:
        """Second moment of area of the mandrel, m^4."""
        return math.pi / 64.0 * (self.diameter**4 - (self.diameter - 2.0 * wall) ** 4)

    def cap_mass(self, wall: float) -> float:
        """Mass of the end cap, a disk as thick as the wall, kg."""
        return DENSITY * 0.25 * math.pi * self.diameter**2 * wall

    @property
    def mandrel_mass(self) -> float:
        """Mass of the tube, kg."""
        return DENSITY * self.area(self.wall) * self.length

    @cached_property
    def metrics(self) -> tuple[float, float, float, float, float]:
        """AR, DR, MR, TR and k (kN/mm), equations 6.2 to 6.6."""
        return (
            self.length / self.diameter, self.diameter / self.outer, self.mandrel_mass / self.coil_mass,
            self.wall / self.coil_thickness, 3.0 * YOUNG * self.inertia(self.wall) / self.length**3 / 1e6,
        )  # fmt: skip

    def scaled(self, s: float) -> tuple[float, float]:
        """MR and DR with a coil of s times the thickness and the same density."""
        outer = self.diameter + 2.0 * s * self.coil_thickness
        mass = self.coil_mass * (outer**2 - self.diameter**2) / (self.outer**2 - self.diameter**2)
        return self.mandrel_mass / mass, self.diameter / outer


STRUCTURES = {
    "iROSA": Structure(3.0, 0.5, 0.8, 25.0, 2.5e-3, (6.0, 0.625, 1.2, 0.015, 1.0)),
    "SSPP": Structure(1.0, 0.4, 1.6, 500.0, 12.5e-3, (2.5, 0.25, 0.1, 0.02, 60.0)),
    "HabEx": Structure(3.0, 1.5, 4.0, 1500.0, 10.0e-3, (2.0, 0.375, 0.25, 0.01, 100.0)),
}
SCALES = (0.25, 0.5, 0.75, 1.0)
"""Scale factors s of the coil thickness (Table 6.3)."""


def c91(evidence: Evidence) -> Verdict:
    limits = (1e-9, 1e-9, 0.25, 0.25, 0.1)  # AR and DR exact; MR, TR within 25 %, k within 10 %
    parts, holds = [], True
    for name, one in STRUCTURES.items():
        parts.append(f"{name} {numbers(one.metrics, '.3g')}")
        off = np.abs(np.array(one.metrics) / np.array(one.printed) - 1.0)
        holds = holds and bool(np.all(off <= limits))
    shells = evidence.results(sizing_cases(printed_wall=True))
    stiffness = numbers((d.attrs["tip_stiffness_n_per_m"] / 1e6 for d in shells), ".3g")
    value = (
        f"AR, DR, MR, TR, k (kN/mm): {'; '.join(parts)}; aluminium {DENSITY:g} kg/m^3, {YOUNG / 1e9:g} GPa; tip "
        f"stiffness of the shells, with shear deformation: {stiffness} kN/mm"
    )
    return Verdict(value, holds)


# ---- wall of the mandrel -------------------------------------------------------------------------


def sizing_cases(*, printed_wall: bool = False) -> list[tuple[str, ...]]:
    """Case of the sizing of each structure: search for the walls, or the wall of Table 6.2."""
    return [
        (f"sizing_{name.lower()}", *([f"sizing.wall={one.wall!r}"] if printed_wall else []))
        for name, one in STRUCTURES.items()
    ]


def c92(evidence: Evidence) -> Verdict:
    found = evidence.results(sizing_cases())
    walls = {
        str(name): [float(d["wall_thickness"].sel(reading=name)) for d in found] for name in found[0]["reading"].values
    }
    printed = np.array([one.wall for one in STRUCTURES.values()])
    off = {name: float(np.abs(np.array(own) / printed - 1.0).max()) for name, own in walls.items()}
    closest = min(off, key=lambda name: math.inf if math.isnan(off[name]) else off[name])
    range_of_figure = slice(1e-3, 2e-2)
    margins = [d["margin"].sel(mandrel_thickness=range_of_figure).values for d in found]
    rises = all(bool(np.all(np.diff(lines, axis=0) > 0.0)) for lines in margins)
    listed = "; ".join(f"{_words(name)}: {numbers((1e3 * t for t in own), '.2f')}" for name, own in walls.items())
    value = (
        f"shell, wall in mm of iROSA, SSPP, HabEx (printed {numbers(1e3 * printed, 'g')}): {listed}; closest: "
        f"{_words(closest)}, {100 * off[closest]:.0f} % off at most; margin {'rises' if rises else 'does not rise'} "
        "with the wall (1 to 20 mm)"
    )
    return Verdict(value, rises and off[closest] <= 0.1)


def _words(reading: str) -> str:
    return reading.replace("_", " ")


# ---- buckling, sweep -----------------------------------------------------------------------------


def lateral_buckling(radius: float, wall: float, length: float) -> tuple[float, int]:
    """Classical buckling pressure (Pa) under lateral pressure and number of waves around, simply supported ends.

    Donnell's equation with one half wave along the axis, x = pi r/(n L):
    p = (E t/r) [n^2 (1 + x^2)^2 t^2/(12 r^2 (1 - nu^2)) + x^4/(n^2 (1 + x^2)^2)].
    """
    n = np.arange(2, 60)
    x2 = (math.pi * radius / (n * length)) ** 2
    bending = n**2 * (1.0 + x2) ** 2 * wall**2 / (12.0 * radius**2 * (1.0 - POISSON**2))
    found = YOUNG * wall / radius * (bending + x2**2 / (n**2 * (1.0 + x2) ** 2))
    k = int(found.argmin())
    return float(found[k]), int(n[k])


def c93(evidence: Evidence) -> Verdict:
    parts, holds = [], True
    for name, one in STRUCTURES.items():
        critical, waves = lateral_buckling(0.5 * (one.diameter - one.wall), one.wall, one.length)
        holds = holds and critical / 2.0 > PRESSURE
        parts.append(f"{name} {critical / 1e6:.2g} MPa, n = {waves}")
    shells = [d.attrs for d in evidence.results(sizing_cases(printed_wall=True))]
    finite = ", ".join(f"{d['buckling_pressure_pa'] / 1e6:.3g} MPa (n = {d['buckling_waves']})" for d in shells)
    value = (
        f"classical, simply supported ends: {'; '.join(parts)}; shells with clamped base and rigid tip ring: {finite}; "
        "applied 0.5 MPa"
    )
    return Verdict(value, holds, "" if holds else THESIS_ERROR)


def c94(evidence: Evidence) -> Verdict:
    quality, allowable = 1.0 / (2.0 * 0.005), YIELD / (SAFETY * (1.0 + MARGIN))
    value = f"Q = 1/(2 x 0.005) = {quality:g}; allowable stress {allowable / 1e6:.1f} MPa"
    return Verdict(value, abs(quality - 100.0) < 1e-9 and abs(allowable / 186.7e6 - 1.0) < 1e-3)


def c95(evidence: Evidence) -> Verdict:
    rate = math.log2(160 / 5) / (20 / 60)
    reached = ", ".join(f"{100 * attainment(0.01, rate / f):.0f} % at {f:g} Hz" for f in (10.0, 40.0, 160.0))
    value = f"{rate:g} oct/min; running peak of a resonance with 1 %: {reached} of the steady one"
    return Verdict(value, abs(rate - 15.0) < 1e-9)


# ---- energy, ratios, mandrels --------------------------------------------------------------------


def c103(evidence: Evidence) -> Verdict:
    """Unit of the expression, and its value for an oscillator: E_F of a cycle over x^2 gives pi c w/f_n."""
    zeta, f_n, tip, mass = 0.02, 30.0, 2e-3, 7.0
    omega = 2.0 * math.pi * f_n
    per_cycle = math.pi * 2.0 * zeta * mass * omega * omega * tip**2
    found = per_cycle / tip**2 / f_n
    closed = 16.0 * math.pi**4 * zeta * mass * f_n / (2.0 * math.pi)
    value = (
        "J/(m^2 Hz) = J s/m^2, energy per cycle over x^2 and f_n rather than power; for an oscillator 8 pi^3 zeta m "
        f"f_n per cycle ({found:.1f} J s/m^2 at 2 %, 30 Hz, 7 kg)"
    )
    return Verdict(value, abs(found / closed - 1.0) < 1e-12)


def c108(evidence: Evidence) -> Verdict:
    found = {name: [one.scaled(s) for s in SCALES] for name, one in STRUCTURES.items()}
    said = "; ".join(
        f"{name} MR {numbers((mr for mr, _ in line), '.3g')}, DR {numbers((dr for _, dr in line), '.3g')}"
        for name, line in found.items()
    )
    large = all(mr > 1.0 and dr > 0.5 for mr, dr in found["iROSA"])
    small = found["SSPP"][-1][0] < 0.1 * found["iROSA"][-1][0]
    return Verdict(f"s = {numbers(SCALES, 'g')}: {said}", large and small)


def mandrel_overrides(one: Structure) -> list[str]:
    """Overrides of configs/lab_mandrel.yaml for the mandrel of a structure, with its end cap as tip mass."""
    return [
        f"geometry.length={one.length!r}", f"geometry.mandrel_outer_diameter={one.diameter!r}",
        f"geometry.mandrel_thickness={one.wall!r}", f"mandrel.material={{E: {YOUNG}, nu: {POISSON}, rho: {DENSITY}}}",
        f"mandrel.tip_mass={one.cap_mass(one.wall)!r}", "output.fields=none", "output.figures=false", "modal.count=30",
    ]  # fmt: skip


def c109(evidence: Evidence) -> Verdict:
    meshes = ((32, 16), (64, 32))
    cases = [
        ("lab_mandrel", *mandrel_overrides(one), f"mesh.circumferential={around}", f"mesh.axial={along}")
        for one in STRUCTURES.values()
        for around, along in meshes
    ]
    found = np.reshape([bending(data) for data in evidence.results(cases)], (len(STRUCTURES), len(meshes)))
    change = np.abs(found[:, 1] / found[:, 0] - 1.0)
    inside = ["inside" if 5.0 <= f <= 160.0 else "outside" for f in found[:, 1]]
    said = "; ".join(
        f"{name} {f:.1f} Hz ({place} 5 to 160 Hz, {100 * c:.2f} % on halving the elements)"
        for name, f, place, c in zip(STRUCTURES, found[:, 1], inside, change, strict=True)
    )
    return Verdict(f"base clamped, both ends round, end cap as tip mass: {said}", bool(np.all(change < 0.01)))


def plot_margin(evidence: Evidence) -> Axes:
    """Draw Fig. 6.1 for the faces away from the ends and for the faces of the whole tube."""
    ax = style.axes(None)
    found = evidence.results(sizing_cases())
    for (name, one), data, colour in zip(STRUCTURES.items(), found, style.LINES, strict=False):
        walls = 1e3 * data["mandrel_thickness"].values
        for reading, dash in (("surface_away_from_ends", "-"), ("surface", "--")):
            line = 100.0 * data["margin"].sel(reading=reading).values
            ax.plot(walls, line, dash, color=colour, label=name if dash == "-" else None)
        ax.plot(1e3 * one.wall, 25.0, "o", color=colour)
    ax.axhline(25.0, color="black", lw=0.8)
    ax.set_xscale("log")
    ax.set_xlim(1.0, 30.0)
    ax.set_ylim(-100, 200)
    ax.xaxis.set_major_formatter("{x:g}")
    ax.set_xlabel("Wall of the mandrel (mm)")
    ax.set_ylabel("Margin against yield (%)")
    ax.legend(fontsize=8)
    style.title(ax, "Margin at the faces away from the ends (lines) and in the whole tube (dashed); dots: Table 6.2")
    return ax


def plot_ratios(evidence: Evidence) -> Axes:
    """Draw Fig. 6.12."""
    ax = style.axes(None)
    for (name, one), colour in zip(STRUCTURES.items(), style.LINES, strict=False):
        line = np.array([one.scaled(s) for s in SCALES])
        ax.semilogx(line[:, 0], line[:, 1], "o-", color=colour, label=name)
    ax.set_xlabel("Mass ratio MR (–)")
    ax.set_ylabel("Diameter ratio DR (–)")
    ax.legend(fontsize=8)
    style.title(ax, "Mass and diameter ratio for coils of 0.25 to 1 times the thickness (right to left)")
    return ax


GROUP = ClaimGroup(
    {"C91": c91, "C92": c92, "C93": c93, "C94": c94, "C95": c95, "C103": c103, "C108": c108, "C109": c109},
    figures={
        "ch6_margin": ("Fig 6.1: margin over the wall of the mandrel", plot_margin),
        "ch6_ratios": ("Fig 6.12: diameter ratio over mass ratio", plot_ratios),
    },
)
