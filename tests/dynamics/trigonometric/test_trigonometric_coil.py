"""Coil whose wraps slide: the modes of its path are propagated exactly."""

from __future__ import annotations

import numpy as np
import xarray as xr
from support.paths import CONFIGS

from wroll_fem.analyses.history import SharedStructure, time_history
from wroll_fem.case import load_case
from wroll_fem.progress import SilentProgress
from wroll_fem.results.energy import energy_balance_error

WORDS = (
    "mesh={circumferential: 8, axial: 4, grading: 10, radial: 2}", "analysis=dwell",
    "excitation={kind: dwell, frequency: 88, amplitude_g: 10, cycles: 6, ramp_cycles: 2}",
)  # fmt: skip


def test_a_slipping_coil_is_followed_with_few_steps() -> None:
    found: dict[int, xr.Dataset] = {}
    shared = None
    for steps in (40, 160):
        words = [*WORDS, f"integrator={{scheme: trigonometric, steps_per_cycle: {steps}}}"]
        case = load_case(CONFIGS / "slipping_harmonic.yaml", words)
        shared = shared or SharedStructure(case, SilentProgress())
        shared.basis = None
        found[steps] = time_history(case, progress=SilentProgress(), shared=shared)
    tip, right = found[40]["tip_displacement"].values, found[160]["tip_displacement"].values[::4]
    assert np.abs(tip - right).max() < 1.5e-2 * np.abs(right).max()
    assert float(found[40]["friction_energy"][-1]) > 0.1 * float(found[40]["input_work"][-1])
    assert 0.0 < found[40].attrs["span_error_estimate"] < 2e-2
    for history in found.values():
        assert energy_balance_error(history) < 1e-6
