"""Which pressure counts beside a winding, and the tension of the last turn."""

from __future__ import annotations

import numpy as np
import pytest
from support.paths import CONFIGS

from wroll_fem.case import load_case
from wroll_fem.winding.interface import prescribed_pressures
from wroll_fem.winding.stress import tension_stress, wound_roll


def test_a_given_pressure_counts_although_the_winding_is_known() -> None:
    words = ["preload.kind=interface_pressure", "preload.pressure=1234"]
    case = load_case(CONFIGS / "winding_sweep.yaml", words)
    assert case.preload is not None
    assert prescribed_pressures(case, case.preload, case.wound).tolist() == [1234.0]
    winding = load_case(CONFIGS / "winding_sweep.yaml")
    assert winding.preload is not None
    assert prescribed_pressures(winding, winding.preload, winding.wound)[0] > 1e4


def test_the_last_turn_of_a_growing_roll_keeps_its_tension_alone() -> None:
    section = load_case(CONFIGS / "winding_lab.yaml", ["winding.growth=continuous"]).wound
    assert section is not None
    roll = wound_roll(section)
    tension = tension_stress(section, roll.radius)
    assert roll.hoop_stress[-1] == pytest.approx(tension[-1], rel=1e-12)
    assert not np.isclose(roll.hoop_stress[1], tension[-1], rtol=1e-3)
