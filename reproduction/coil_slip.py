"""Claims on the slip of the case study of section 2.4 (C12, C18 to C25), with other meshes and inputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup, Drawing
from reproduction.evidence import Evidence
from reproduction.verdict import THESIS_ERROR, Verdict
from reproduction.winding import at_the_mandrel, core_of
from reproduction.words import table
from wroll_fem.case import ModalTransientCase
from wroll_fem.coiled_stiff.slip_criterion import cycle_maximum, onset_levels, slips
from wroll_fem.plotting.coil_slip import grid_of, plot_root_sections, plot_shear_distribution, plot_slip_zone
from wroll_fem.typing import FloatArray
from wroll_fem.winding import wound_roll
from wroll_fem.winding.radial_modulus import RadialModulus

STUDY = "case_study"
HARMONICS = "mesh.discretisation=fourier"
FINE = (STUDY, HARMONICS, "mesh.axial=48", "mesh.radial=10")
UNIFORM = ("mesh.circumferential=16", "mesh.grading=1", "mesh.radial=3", "mesh.radial_grading=1")
LAW = "winding.web.radial_modulus={law: constant, E_r: %s}"
MESHES: dict[str, tuple[str, ...]] = {
    "three-dimensional, as configs/case_study.yaml": (),
    "the same, 16 around": ("mesh.circumferential=16",),
    "the same, root elements 5 times higher": ("mesh.circumferential=16", "mesh.grading=8"),
    "the same, 3 equal elements through the coil":
        ("mesh.circumferential=16", "mesh.radial=3", "mesh.radial_grading=1"),
    "uniform, 16 x 30 x 3 (root elements of 10 mm)": (*UNIFORM, "mesh.axial=30"),
    "uniform, 16 x 12 x 3": (*UNIFORM, "mesh.axial=12"),
    "harmonics, the same divisions": (HARMONICS,),
    "harmonics, twice as many along the axis": (HARMONICS, "mesh.axial=48"),
    "harmonics, twice as many both ways": FINE[1:],
}  # fmt: skip
"""Description -> overrides of the case study."""
LENGTHS = (1e-3, 2e-3, 5e-3, 10e-3)
"""Heights over which the shear at the mandrel interface is averaged (C18, C21), m."""
COARSE = {"10 mm": (STUDY, *UNIFORM, "mesh.axial=30"), "25 mm": (STUDY, *UNIFORM, "mesh.axial=12")}
"""Element height of the uniform meshes whose stresses are extrapolated to nodes -> case."""
ONSET, RATIO = (2.5, 10.0), (1.6, 2.2)
"""Accepted onset (g) and ratio of srz to srt."""


# ---- readings ------------------------------------------------------------------------------------


def onset(data: xr.Dataset) -> float:
    """Base acceleration at which the first point slips, g."""
    return float(data["slip_onset"].min())


def from_axis(degrees: float) -> float:
    """Angular distance to 0 or 180 degrees, whichever is nearer."""
    return min(abs(degrees) % 180.0, 180.0 - abs(degrees) % 180.0)


def place(data: xr.Dataset, point: int) -> str:
    """Position of a point of the coil as text."""
    depth = 1e3 * (float(data["r_m"][point]) - data.attrs["mandrel_radius_m"])
    angle = from_axis(float(np.degrees(data["theta_rad"].values[point])))  # the same for its mirror images, which tie
    height = 1e3 * float(data["z_m"][point])
    return f"{depth:.2f} mm from the mandrel, {height:.2f} mm above the base, {angle:.0f} deg from the axis"


class RootSection:
    """Lowest row of quadrature points: amplitudes (n_r, n_theta) of both components at the highest level."""

    def __init__(self, data: xr.Dataset) -> None:
        grid = grid_of(data)
        self.grid, self.depth = grid, grid.r - data.attrs["mandrel_radius_m"]
        top = float(data["amplitude_g"][-1])
        self.all = {name: top * data[f"shear_{name}"].values[grid.numbers] for name in ("rz", "rt")}
        self.root = {name: values[:, 0, :] for name, values in self.all.items()}

    def ratio(self) -> FloatArray:
        """(n_z,) ratio of the largest srz to the largest srt in each row of points."""
        return np.asarray(self.all["rz"].max(axis=(0, 2)) / self.all["rt"].max(axis=(0, 2)))

    def half_depth(self, name: str, row: int = 0) -> float:
        """Distance from the mandrel within which a component exceeds half its largest value in a row of points, m."""
        over_r = self.all[name][:, row, :].max(axis=1)
        below = np.flatnonzero(over_r < 0.5 * over_r.max())
        after = below[below > over_r.argmax()]
        if not after.size:
            return float(self.depth[-1])
        k = int(after[0])
        return float(np.interp(0.5 * over_r.max(), over_r[[k, k - 1]], self.depth[[k, k - 1]]))

    def angle(self, name: str) -> float:
        """Angle from the x axis of the largest value, deg."""
        column = np.unravel_index(self.root[name].argmax(), self.root[name].shape)[1]
        return from_axis(float(np.degrees(self.grid.theta[column])))


# ---- smeared over the root -----------------------------------------------------------------------


@dataclass(frozen=True)
class Smeared:
    """Shear at the root of the mandrel interface, smeared in one way.

    Attributes
    ----------
    words
        Description.
    rz, rt
        Largest srz and srt around the circumference per g, Pa.
    resultant
        Largest resultant per g, Pa.
    """

    words: str
    rz: float
    rt: float
    resultant: float

    @property
    def ratio(self) -> float:
        """Largest srz over largest srt."""
        return self.rz / self.rt

    def onset(self, pressure: float, mu: float) -> float:
        """Base acceleration (g) at which the interface slips under a pressure (Pa)."""
        return mu * pressure / self.resultant


def smeared(words: str, parts: dict[str, FloatArray]) -> Smeared:
    """Reading of both components (n_theta,) per g, which are in phase at resonance."""
    rz, rt = parts["rz"], parts["rt"]
    return Smeared(words, float(rz.max()), float(rt.max()), float(np.hypot(rz, rt).max()))


def averaged(data: xr.Dataset, height: float) -> Smeared:
    """Components averaged over the lowest part (m) of the row of points next to the mandrel."""
    grid = grid_of(data)
    z, parts = np.concatenate([[0.0], grid.z]), {}
    for name in ("rz", "rt"):
        values = data[f"shear_{name}"].values[grid.numbers][0]
        values = np.concatenate([values[:1], values])  # constant below the lowest point
        steps = 0.5 * (values[1:] + values[:-1]) * np.diff(z)[:, None]
        integral = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(steps, axis=0)])
        parts[name] = np.array([np.interp(height, z, column) for column in integral.T]) / height
    return smeared(f"mean over {1e3 * height:g} mm", parts)


def at_nodes(words: str, data: xr.Dataset) -> Smeared:
    """Components extrapolated linearly from the lowest, innermost points to the nodes of the root edge."""
    grid, parts = grid_of(data), {}
    inward = (data.attrs["mandrel_radius_m"] - grid.r[0]) / (grid.r[1] - grid.r[0])
    down = -grid.z[0] / (grid.z[1] - grid.z[0])
    for name in ("rz", "rt"):
        corner = data[f"shear_{name}"].values[grid.numbers][:2, :2]
        edge = corner[0] + inward * (corner[1] - corner[0])
        parts[name] = np.abs(edge[0] + down * (edge[1] - edge[0]))
    return smeared(f"at nodes, elements of {words}", parts)


def all_smeared(evidence: Evidence) -> list[Smeared]:
    """Averages on the finest mesh, and stresses at the nodes of coarse uniform meshes."""
    fine, *coarse = evidence.results([FINE, *COARSE.values()])
    nodes = [at_nodes(words, data) for words, data in zip(COARSE, coarse, strict=True)]
    return [*(averaged(fine, height) for height in LENGTHS), *nodes]


def pressures(evidence: Evidence) -> tuple[float, float, float]:
    """Pressure at the mandrel (Pa) with K2 as a number and as printed, and the coefficient of friction."""
    winding = evidence.case(STUDY).expect(ModalTransientCase).wound
    printed = at_the_mandrel(winding, RadialModulus.pfeiffer(1.0e3, 40.0e9), core_of(winding))
    return float(wound_roll(winding).pressure[0]), printed, winding.friction_coefficient


def explained_by(evidence: Evidence) -> list[Smeared]:
    """Readings that, with K2 as printed, give both the onset and the ratio of the thesis."""
    _, printed, mu = pressures(evidence)
    return [
        one
        for one in all_smeared(evidence)
        if ONSET[0] <= one.onset(printed, mu) <= ONSET[1] and RATIO[0] <= one.ratio <= RATIO[1]
    ]


# ---- claims --------------------------------------------------------------------------------------


def c12(evidence: Evidence) -> Verdict:
    both = cycle_maximum(np.array([3e6 + 0j]), np.array([4e6 + 0j]))
    definition = bool(np.isclose(both[0], 5e6, rtol=1e-15) and not slips(both, np.array([5e6]))[0])
    return Verdict("3 and 4 MPa in phase: 5 MPa, no slip at a capacity of 5 MPa", definition)


def c18(evidence: Evidence) -> Verdict:
    data, fine = evidence.results([(STUDY,), FINE])
    first = int(np.argmin(data["slip_onset"].values))
    number, printed, mu = pressures(evidence)
    said = "; ".join(
        f"{one.words} {one.onset(number, mu):.2f} and {one.onset(printed, mu):.1f} g" for one in all_smeared(evidence)
    )
    value = (
        f"onset {onset(data):.3f} g ({onset(fine):.3f} g on the finest mesh), {place(data, first)}; at the mandrel "
        f"with K2 = 40 and with K2 as printed: {said}"
    )
    holds = ONSET[0] <= onset(data) <= ONSET[1]
    return Verdict(value, holds, THESIS_ERROR if not holds and explained_by(evidence) else "")


def c19(evidence: Evidence) -> Verdict:
    data = evidence.result(STUDY)
    z, length = float(data["z_m"][int(np.argmax(data["shear_resultant"].values))]), data.attrs["length_m"]
    value = f"largest {1e3 * z:.2f} mm above the base, {100 * z / length:.2f} % of L"
    return Verdict(value, bool(z <= 0.05 * length))


def c20(evidence: Evidence) -> Verdict:
    data = evidence.result(STUDY)
    over_r = data["shear_resultant"].values[grid_of(data).numbers].max(axis=(1, 2))
    value = (
        f"{over_r[0] / 1e6:.2f} to {over_r[-1] / 1e6:.3f} MPa per g, largest step outward "
        f"{np.diff(over_r).max() / 1e6:+.3f} MPa"
    )
    return Verdict(value, bool(np.all(np.diff(over_r) < 0)))


def c21(evidence: Evidence) -> Verdict:
    section = RootSection(evidence.result(STUDY))
    ratio, height = section.ratio(), 1e3 * section.grid.z
    rows = ", ".join(f"{ratio[k]:.2f} at {height[k]:.2f} mm" for k in np.flatnonzero(height < 4.0))
    said = ", ".join(f"{one.ratio:.2f} ({one.words})" for one in all_smeared(evidence))
    both = explained_by(evidence)
    value = f"rows of points: {rows}; smeared: {said}; onset and ratio of the thesis together: "
    value += ", ".join(one.words for one in both) or "none"
    holds = bool(RATIO[0] <= ratio[0] <= RATIO[1])
    return Verdict(value, holds, THESIS_ERROR if both and not holds else "")


def c22(evidence: Evidence) -> Verdict:
    data = evidence.result(STUDY)
    section = RootSection(data)
    rows = {"lowest row": 0, "1 % of L up": int(np.abs(section.grid.z - 0.01 * data.attrs["length_m"]).argmin())}
    depth = {where: [1e3 * section.half_depth(name, row) for name in ("rz", "rt")] for where, row in rows.items()}
    text = "; ".join(f"{where}: {rz:.2f} mm (srz), {rt:.2f} mm (srt)" for where, (rz, rt) in depth.items())
    return Verdict(f"above half its largest value: {text}", all(rt > rz for rz, rt in depth.values()))


def c23(evidence: Evidence) -> Verdict:
    section = RootSection(evidence.result(STUDY))
    angle = {name: section.angle(name) for name in ("rz", "rt")}
    value = f"srz {angle['rz']:.1f} deg, srt {angle['rt']:.1f} deg from the axis of excitation"
    return Verdict(value, angle["rz"] <= 15.0 and angle["rt"] >= 75.0)


def c24(evidence: Evidence) -> Verdict:
    data = evidence.result(STUDY)
    first, attrs = int(np.argmin(data["slip_onset"].values)), data.attrs
    depth, z = float(data["r_m"][first]) - attrs["mandrel_radius_m"], float(data["z_m"][first])
    thickness = attrs["coil_outer_radius_m"] - attrs["mandrel_radius_m"]
    value = (
        f"{place(data, first)}; capacity there {float(data['friction_capacity'][first]) / 1e6:.2f} MPa, "
        f"largest {attrs['capacity_mandrel_pa'] / 1e6:.2f} MPa"
    )
    return Verdict(value, bool(depth < 0.1 * thickness and z < 0.1 * attrs["length_m"]))


def c25(evidence: Evidence) -> Verdict:
    alone = evidence.results([(STUDY, "excitation.amplitude_g=[1]"), (STUDY, "excitation.amplitude_g=[15]")])
    last = [float(one["shear_resultant_history"].values[-65:].max()) for one in alone]  # 64 times per cycle
    value = f"time histories of their own at 15 g and 1 g: ratio {last[1] / last[0]:.6f}"
    return Verdict(value, abs(last[1] / last[0] / 15.0 - 1.0) < 0.01)


# ---- beside the claims ---------------------------------------------------------------------------


def meshes(evidence: Evidence) -> str:
    rows = []
    results = evidence.results([(STUDY, *overrides) for overrides in MESHES.values()])
    for name, data in zip(MESHES, results, strict=True):
        rows.append(
            (
                name, f"{data.sizes['point']}", f"{data.attrs['f_n_hz']:.3f}", f"{onset(data):.4f}",
                place(data, int(np.argmin(data["slip_onset"].values))), f"{data['shear_resultant'].max() / 1e6:.2f}",
                f"{RootSection(data).ratio()[0]:.2f}", f"{100 * float(data['slipping_volume_fraction'][-1]):.2f}",
            )
        )  # fmt: skip
    head = (
        "mesh", "points", "f_n, Hz", "onset, g", "where", "largest shear, MPa per g", "srz/srt, lowest row",
        "slips at 15 g, %",
    )  # fmt: skip
    return table(head, rows)


def truncation(evidence: Evidence) -> str:
    counts = (1, 4, 10, 20, 40)
    results = evidence.results([(STUDY, HARMONICS, f"modal.count={count}") for count in counts])
    rows = [
        (
            f"{count}", f"{data.sizes['mode']}", f"{100 * data.attrs['participating_mass_fraction']:.1f}",
            f"{data.attrs['transmissibility']:.3f}", f"{onset(data):.4f}",
        )
        for count, data in zip(counts, results, strict=True)
    ]  # fmt: skip
    return table(("modal.count", "along x", "mass, %", "transmissibility", "onset, g"), rows)


def inputs(evidence: Evidence) -> str:
    """Table of the slip onset with other capacities, base frequencies and base conditions."""
    case = evidence.case(*FINE).expect(ModalTransientCase)
    winding = case.wound
    mu = winding.friction_coefficient
    wraps, outer = wound_roll(winding).wraps, 0.5 * case.geometry.mandrel_outer_diameter + case.coil.total_thickness
    laws = [(*FINE, LAW % E_r) for E_r in ("0.1e9", "1.0e9", "40.0e9")]
    given, soft, hard, rigid, coarse, at_100, clamped = evidence.results(
        [
            FINE, *laws, (STUDY, *UNIFORM, "mesh.axial=30", LAW % "40.0e9"), (*FINE, "excitation.frequency=100"),
            (*FINE, "coil.base=clamped"),
        ]
    )  # fmt: skip
    on_wraps = other_capacity(given, lambda r: mu * np.interp(r, wraps.radius, wraps.pressure, right=0.0))
    stiff = other_capacity(given, lambda r: mu * winding.stress * np.log(outer / np.minimum(r, outer)))
    rows = []
    for name, data in {
        "as given, E_r = 40 (1 kPa + P)": given,
        "the same, grid of the thesis": on_wraps,
        "constant E_r = 0.1 GPa (that of the solid)": soft,
        "constant E_r = 1 GPa": hard,
        "constant E_r = 40 GPa (K2 as printed)": rigid,
        "the same, three-dimensional, uniform 16 x 30 x 3": coarse,
        "no wrap relaxes, P = T ln(r_o/r)": stiff,
        "as given, base at 100 Hz": at_100,
        "as given, coil clamped at the base": clamped,
    }.items():
        pressure = data.attrs["capacity_mandrel_pa"] / mu / 1e6
        rows.append(
            (name, f"{pressure:.2f}", f"{onset(data):.3f}", place(data, int(np.argmin(data["slip_onset"].values))))
        )
    return table(("input", "pressure at the mandrel, MPa", "onset, g", "where"), rows)


def other_capacity(data: xr.Dataset, capacity_at: Callable[[FloatArray], FloatArray]) -> xr.Dataset:
    """Results with another friction capacity (Pa, function of the radius in m); the shear stress does not change."""
    found = data.copy()
    found["slip_onset"] = "point", onset_levels(data["shear_resultant"].values, capacity_at(data["r_m"].values))
    radius = np.array([data.attrs["mandrel_radius_m"]])
    return found.assign_attrs(capacity_mandrel_pa=float(capacity_at(radius)[0]))


def of_the_case_study(plot: Callable[[xr.Dataset], Axes]) -> Drawing:
    """Figure of the case study."""
    return lambda evidence: plot(evidence.result(STUDY))


GROUP = ClaimGroup(
    {"C12": c12, "C18": c18, "C19": c19, "C20": c20, "C21": c21, "C22": c22, "C23": c23, "C24": c24, "C25": c25},
    figures={
        "case_study_shear_distribution": (
            "Fig 2.14: largest shear resultant over height and radius, 1 to 15 g, against the capacity",
            of_the_case_study(plot_shear_distribution),
        ),
        "case_study_root_section": (
            "Fig 2.15: both shear components on the root section at 15 g, and 1 % of the length up",
            of_the_case_study(plot_root_sections),
        ),
        "case_study_slip_zone": (
            "Where the coil of the case study slips, level by level",
            of_the_case_study(plot_slip_zone),
        ),
    },
    tables={
        "Slip of the case study on other meshes": meshes,
        "Slip of the case study with fewer and more modes (harmonics)": truncation,
        "Inputs that change the onset of slip (harmonics, finest mesh, unless stated otherwise)": inputs,
    },
)
