"""Case of a mandrel with a thick coil that rubs on it."""

from __future__ import annotations

from wroll_fem.case import build_case
from wroll_fem.case.case import Case

SECTIONS = {
    "geometry": {"length": 0.3, "mandrel_outer_diameter": 0.08, "mandrel_thickness": 1.5e-3},
    "mandrel": {"material": {"E": 2.7e9, "nu": 0.35, "rho": 1200.0}, "tip_mass": 0.05, "tip": "rigid"},
    "coil": {
        "model": "solid", "interface": "friction", "total_thickness": 10e-3,
        "material": {"E": 0.5e9, "nu": 0.3, "rho": 500.0},
    },
    "contact": {"friction": {"law": "penalty_coulomb", "mu": 0.25, "elastic_slip": 1e-6}},
    "preload": {"kind": "external_pressure", "pressure": 1e5},
    "excitation": {"kind": "chirp", "amplitude": 5.0, "f_start": 100, "f_end": 250, "rate_oct_per_min": 2},
    "mesh": {"circumferential": 12, "axial": 6, "radial": 2, "grading": 4},
    "output": {"figures": False},
}  # fmt: skip


def roll(analysis: str = "harmonic", **changed: dict[str, object]) -> Case:
    """Case of a mandrel with a thick coil; ``changed`` holds the keys of sections that differ, and further sections."""
    sections = {name: {**SECTIONS.get(name, {}), **changed.get(name, {})} for name in {**SECTIONS, **changed}}
    if analysis in ("modal", "preload"):
        sections.pop("excitation")
    return build_case({"analysis": analysis, **sections})
