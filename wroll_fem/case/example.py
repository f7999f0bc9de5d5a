"""A tiny valid case for docs, tests and bug reports."""

from __future__ import annotations

from wroll_fem.case.kinds_history import RollDwellCase


def example_case() -> RollDwellCase:
    """Dwell of the lab roll with one layer on a very coarse mesh; it runs in seconds and is not accurate."""
    return RollDwellCase.model_validate(
        {
            "analysis": "dwell",
            "geometry": {"length": 0.300, "mandrel_outer_diameter": 0.080, "mandrel_thickness": 1.5e-3},
            "mandrel": {"material": {"E": 2.7e9, "nu": 0.35, "rho": 1200.0}, "tip_mass": 0.05},
            "coil": {
                "model": "layers",
                "total_thickness": 1.25e-3,
                "material": {"E": 2.8e9, "nu": 0.35, "rho": 2000.0},
            },
            "contact": {"friction": {"mu": 0.25, "elastic_slip": 1.0e-6}},
            "preload": {"pressure": 1.0e5},
            "excitation": {"kind": "dwell", "amplitude": 5.0, "frequency": 150.0, "cycles": 4.0, "ramp_cycles": 2.0},
            "integrator": {"steps_per_cycle": 40},
            "mesh": {"circumferential": 12, "axial": 4, "grading": 1},
        }
    )
