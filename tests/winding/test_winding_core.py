"""Hoop stress of a wound roll where it lies on the mandrel."""

from __future__ import annotations

import pytest

from wroll_fem.case.winding import Winding
from wroll_fem.winding import wound_roll


@pytest.mark.parametrize("growth", ["continuous", "wraps"])
def test_the_innermost_wrap_contracts_with_the_mandrel_from_its_own_tension(growth: str) -> None:
    """Its strain changes by -P/K_m, hence its stress by -(E_theta/K_m + nu) P: from the tension at the mandrel, which
    the taper reduces further out. With wraps, the pressure T h/r of the first wrap itself does not relax it."""
    tension, E, nu, stiffness, h, inner = 40.0e6, 10.0e9, 0.3, 2.0e9, 5.0e-5, 0.010
    found = wound_roll(
        Winding.model_validate({
            "tension_stress": tension, "wraps": 60, "wrap_thickness": h, "growth": growth,
            "tension_profile": {"kind": "taper", "taper": 0.9},
            "mandrel": {"outer_radius": inner, "stiffness": stiffness},
            "web": {"E_theta": E, "nu_theta": nu, "radial_modulus": {"law": "constant", "E_r": 1.0e8}},
        })
    )  # fmt: skip
    own = tension * h / inner if growth == "wraps" else 0.0
    expected = tension - (E / stiffness + nu) * (found.pressure[0] - own)
    assert found.hoop_stress[0] == pytest.approx(expected, rel=1e-9)
