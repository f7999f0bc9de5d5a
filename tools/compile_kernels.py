"""Compile the kernels once, before the first run has to wait for them.

`.venv/bin/python tools/compile_kernels.py`; `make setup` runs it in a new environment, one to three minutes. Short runs
on coarse meshes call every loop that takes long to compile; numba keeps the code in `__pycache__`, and a kernel whose
source changes is compiled again where it is used.
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.case import load_case
from wroll_fem.dynamics.reduction import stuck_modes
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.errors import WrollError
from wroll_fem.progress import SilentProgress

CONFIGS = Path(__file__).resolve().parents[1] / "configs"
COARSE = ["mesh={circumferential: 8, axial: 2}", "output={fields: none, figures: false}"]
SHORT = [*COARSE, "excitation.cycles=3", "excitation.ramp_cycles=1", "integrator.steps_per_cycle=20"]
PERIODIC = [*COARSE, "harmonic={harmonics: 1, samples: 32, reduction_tolerance: 0.1}"]
SAMPLED = [
    "mesh={circumferential: 12, axial: 6, grading: 10}", "output={fields: none, figures: false}",
    "solver.hyper_reduction=true", "excitation.cycles=20", "harmonic.reduction_tolerance=0.1",
]  # fmt: skip
RUNS: list[tuple[str, list[str]]] = [
    ("lab_dwell", [*SHORT, "solver.method=condensed"]),
    ("lab_dwell", [*SHORT, "solver.method=reduced"]),
    ("lab_dwell", [*SHORT, "solver.method=reduced", "integrator={scheme: trigonometric, steps_per_cycle: 20}"]),
    ("lab_dwell", [*SHORT, "solver.method=full"]),
    ("lab_harmonic", [*PERIODIC, "excitation.f_start=150", "excitation.f_end=152"]),
    ("lab_backbone", [*PERIODIC, "backbone.tip_largest=3e-5"]),
    ("lab_dwell", [*SAMPLED, "integrator={scheme: hht, alpha: -0.05, steps_per_cycle: 20}"]),
    ("lab_dwell", [*SAMPLED, "integrator={scheme: trigonometric, steps_per_cycle: 20}"]),
    ("winding_lab", ["output={figures: false}"]),
    ("two_dof", ["two_dof.omega.points=20", "two_dof.friction_capacity=[5, 20]"]),
]
"""Case file and overrides."""


def step_large_coil() -> None:
    """Time steps of a solid coil whose modes are not complete; their jumps are in single precision.

    Only coils with many DOFs have such modes, so the limit is set to zero here.
    """
    stuck_modes.MANY_DOFS = 0
    mesh = "mesh={circumferential: 8, axial: 2, radial: 1, grading: 10}"
    system, state = prepare(load_case(CONFIGS / "irosa_friction.yaml", [mesh]), SilentProgress())
    scheme, dt = Scheme.hht(-0.05), 1e-3
    modes = stuck_modes.modes_to_reduce(system, state, scheme, dt)
    stepper = CondensedStepper(system, state, scheme, NewtonOptions(), dt=dt, condensation=modes)
    stepper.advance(np.zeros(3), dt, 0.0)


def main() -> None:
    """Run every case; its result does not matter here."""
    warnings.simplefilter("ignore")
    for name, overrides in RUNS:
        try:
            run_analysis(load_case(CONFIGS / f"{name}.yaml", overrides), progress=SilentProgress())
        except WrollError as error:
            print(f"{name}: {error}")
    step_large_coil()


if __name__ == "__main__":
    main()
