"""Random shaking and a shock by exact propagation of the modes, against HHT with four times the steps."""

from __future__ import annotations

import numpy as np
import pytest
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis
from wroll_fem.case import load_case
from wroll_fem.progress import SilentProgress
from wroll_fem.results.energy import energy_balance_error

MOTIONS = {
    "random": "{kind: random, psd: {frequency: [50, 300], g2_per_hz: 0.05}, duration: 0.7}",
    "shock": "{kind: half_sine, amplitude_g: 20, duration: 0.003, decay: 0.08}",
}


@pytest.mark.parametrize(("analysis", "error"), [pytest.param("random", 0.01, marks=pytest.mark.slow), ("shock", 1e-3)])
def test_forty_steps_have_the_peak_and_the_work_of_a_hundred_and_sixty(analysis: str, error: float) -> None:
    """HHT with 40 steps is off by 2 % in the peak of the random motion; its error falls with the square of the step."""
    mesh = "mesh={circumferential: 8, axial: 3, grading: 1}"
    words = [f"analysis={analysis}", f"excitation={MOTIONS[analysis]}", mesh, "output.figures=false"]
    words += ["solver.method=reduced"]
    found = []
    for scheme, steps in (("trigonometric", 40), ("transient_fidelity", 160)):
        integrator = f"integrator={{scheme: {scheme}, steps_per_cycle: {steps}}}"
        found.append(run_analysis(load_case(CONFIGS / "tiny.yaml", [*words, integrator]), progress=SilentProgress()))
    assert energy_balance_error(found[0]) < 1e-6
    peaks = [float(np.abs(data["tip_displacement"]).max()) for data in found]
    work = [float(data["friction_energy"][-1]) for data in found]
    assert peaks[0] == pytest.approx(peaks[1], rel=error)
    assert work[0] == pytest.approx(work[1], rel=5e-3)
    assert work[0] > 0.005
