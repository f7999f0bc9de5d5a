"""Claims on the design map (section 2.5, Fig 2.16), C26 and C27, and the effect of inputs that the thesis omits."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from reproduction.claim_group import ClaimGroup
from reproduction.evidence import Evidence
from reproduction.verdict import Verdict
from reproduction.words import numbers, table
from wroll_fem.plotting.design_map import plot_design_map
from wroll_fem.typing import FloatArray

MAP = "design_map"
NINE = (
    MAP,
    "design_map.mandrel_radius=[0.020, 0.035, 0.050]",
    "design_map.mandrel_thickness=[1.0e-3, 2.0e-3, 3.2e-3]",
)
"""Overrides for 3 x 3 mandrels, the grid of the checklist."""

ALUMINIUM = ("mandrel.material.E=70.0e9", "mandrel.material.nu=0.33", "mandrel.material.rho=2700")
SOFT = tuple(
    f"coil.material.{key}={value}"
    for key, value in (
        ("E_theta", 2.5e9), ("E_z", 2.5e9), ("G_z_theta", 0.9259e9), ("G_r_theta", 0.9259e9), ("G_r_z", 0.9259e9),
    )
)  # fmt: skip
OTHERS: dict[str, tuple[str, ...]] = {
    "as shipped": (),
    "tip mass of 0.05 kg": ("mandrel.tip_mass=0.05",),
    "Kapton of 2.5 GPa": SOFT,
    "coil clamped at its base": ("coil.base=clamped",),
    "softest coil of 10 kPa everywhere": ("design_map.loosest=1.0e4",),
    "softest coil of 1 MPa everywhere": ("design_map.loosest=1.0e6",),
    "finer (axial 16, radial 3)": ("mesh.axial=16", "mesh.radial=3"),
    "aluminium mandrel": ALUMINIUM,
}
"""Description -> overrides of the map."""


def disparity(data: xr.Dataset) -> FloatArray:
    """Frequency disparity (radii, walls), Hz."""
    return np.asarray(data["frequency_disparity"].transpose("mandrel_radius", "mandrel_thickness").values)


def own_disparity(data: xr.Dataset) -> float:
    """Disparity of the mandrel that was built, Hz."""
    return float(data.attrs["own_frequency_tightest"] - data.attrs["own_frequency_loosest"])


def grows(values: FloatArray) -> tuple[bool, bool]:
    """Whether the disparity grows with the radius and with a thinner wall; false if a mandrel has none."""
    return bool((np.diff(values, axis=0) > 0).all()), bool((np.diff(values, axis=1) < 0).all())


def rows_of(values: FloatArray) -> str:
    """Array as text in one line."""
    return " / ".join(numbers(row, ".1f") for row in values)


def c26(evidence: Evidence) -> Verdict:
    whole, nine = evidence.results([(MAP,), NINE])
    values, small = disparity(whole), disparity(nine)
    said = (
        f"{' x '.join(map(str, values.shape))}: {values.min():.1f} to {values.max():.1f} Hz; the mandrel that was "
        f"built (40 mm, 1.6 mm) {own_disparity(whole):.1f} Hz; 3 x 3: {rows_of(small)} Hz (radius 20 / 35 / 50 mm; "
        "wall 1, 2, 3.2 mm)"
    )
    return Verdict(said, all(grows(small)) and all(grows(values)))


def c27(evidence: Evidence) -> Verdict:
    mandrels = ("polycarbonate", "aluminium")
    results = evidence.results([NINE, (*NINE, *ALUMINIUM)])
    relative = {
        name: disparity(data) / data["frequency_mandrel"].transpose("mandrel_radius", "mandrel_thickness").values
        for name, data in zip(mandrels, results, strict=True)
    }
    said = "; ".join(f"{name} {rows_of(100 * values)} %" for name, values in relative.items())
    lower = bool((relative["polycarbonate"] > relative["aluminium"]).all())
    thinner = all(grows(values)[1] for values in relative.values())
    return Verdict(f"disparity over mandrel frequency, same grid: {said}", lower and thinner)


def variants(evidence: Evidence) -> str:
    """Table of the disparity with other inputs, for 3 x 3 mandrels and for the mandrel that was built."""
    rows = []
    for words, data in zip(OTHERS, evidence.results([(*NINE, *sets) for sets in OTHERS.values()]), strict=True):
        values = disparity(data)
        some = (values[0, 2], values[1, 1], values[2, 0], own_disparity(data))
        trend = "; ".join("yes" if one else "no" for one in grows(values))
        rows.append((words, *(f"{v:.1f}" if np.isfinite(v) else "none" for v in some), trend))
    head = (
        "inputs", "disparity, Hz: radius 20 mm, wall 3.2 mm", "35 mm, 2 mm", "50 mm, 1 mm", "40 mm, 1.6 mm",
        "grows with radius; thinner wall",
    )  # fmt: skip
    return table(head, rows)


def map_figure(evidence: Evidence) -> Axes:
    """Draw Fig 2.16."""
    return plot_design_map(evidence.result(MAP))


GROUP = ClaimGroup(
    {"C26": c26, "C27": c27},
    figures={"design_map": ("Fig 2.16: frequency disparity over radius and wall of the mandrel", map_figure)},
    tables={"Disparity with inputs that the thesis does not state": variants},
)
