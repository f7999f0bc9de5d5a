"""Points that slip, and points that stick, in the results of a time history."""

from __future__ import annotations

import pytest
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.progress import SilentProgress


@pytest.mark.parametrize(("amplitude", "slips"), [(1e-3, False), (6.0, True)])
def test_a_point_has_slipped_where_its_path_has_a_length(amplitude: float, slips: bool) -> None:
    dwell = f"{{kind: dwell, amplitude: {amplitude}, frequency: 11.0, cycles: 3, ramp_cycles: 1}}"
    friction = "{law: penalty_coulomb, mu: 0.3, elastic_slip: 1.0e-5}"
    words = ["analysis=dwell", f"excitation={dwell}", f"contact.friction={friction}"]
    progress = SilentProgress()
    data = wf.run(wf.load_case(CONFIGS / "oscillator.yaml", words), progress=progress)
    assert bool(data["slipped"].any()) == slips
    assert bool((data["cumulative_slip"] > 0.0).any()) == slips
    assert any(text.startswith("resonance of the sticking roll: ") for text in progress.infos)
