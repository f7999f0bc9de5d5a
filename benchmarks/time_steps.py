"""Error of every integration scheme against the steps per cycle, on a slipping lab roll: docs/tables/time_steps.md.

Usage: python benchmarks/time_steps.py [--page FILE]

The roll of configs/lab_sweep.yaml on 12 x 6 cells in a dwell of twelve cycles. The reference is `condensed` without
numerical damping (no_damping) with 640 steps per cycle. About a minute of CPU on one core.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
import xarray as xr

from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.case import load_case
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.simulate import make_stepper, simulate
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.base_motion import Dwell

ROOT = Path(__file__).resolve().parents[1]
SCHEMES = ("trigonometric", "no_damping", "transient_fidelity", "moderate_dissipation", "quasi_static")
STEPS, FINEST = (10, 20, 40, 80, 160), 640
FREQUENCY, CYCLES = 150.0, 12.0
LEVELS = (5.0, 30.0)
"""Base acceleration, m/s^2."""


def computed(level: float, scheme: str, steps: int, method: str = "reduced") -> xr.Dataset:
    """History of the roll."""
    case = load_case(ROOT / "configs" / "lab_sweep.yaml", ["mesh={circumferential: 12, axial: 6, grading: 2}"])
    system, state = prepare(case, SilentProgress())
    dt, given = 1.0 / (FREQUENCY * steps), Scheme.named(scheme)
    run = make_stepper(system, state, method=method, scheme=given, options=NewtonOptions(), dt=dt,
                       reduction_tolerance=1e-3)  # fmt: skip
    motion = Dwell(level, FREQUENCY, CYCLES, ramp_cycles=4.0)
    return simulate(system, state, motion, dt=dt, scheme=given, stepper=run)


def row(level: float, scheme: str, steps: int, right: xr.Dataset) -> str:
    """Line of the table."""
    found = computed(level, scheme, steps)
    every = FINEST // steps
    a, b = found["tip_displacement"].values, right["tip_displacement"].values[::every]
    error = np.abs(a - b[: len(a)]).max() / np.abs(b).max()
    work = float(found["friction_energy"][-1] / right["friction_energy"][-1]) - 1.0
    lost = float(found["numerical_dissipation"][-1] / found["input_work"][-1])
    seconds = found.attrs["solver_time_s"] - found.attrs["training_time_s"]
    cells = (f"{level:g}", scheme, f"{steps}", f"{100 * error:.2g} %", f"{100 * work:+.2g} %", f"{100 * lost:.2g} %",
             f"{found.attrs['newton_iterations_mean']:.1f}", f"{1e6 * seconds / found.attrs['steps']:.0f}")  # fmt: skip
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--page", type=Path, help="page to write (Markdown)")
    asked = parser.parse_args()
    lines = []
    for level in LEVELS:
        right = computed(level, "no_damping", FINEST, "condensed")
        for scheme in SCHEMES:
            for steps in STEPS:
                lines.append(row(level, scheme, steps, right))
                print(lines[-1], flush=True)
    heads = ("base, m/s²", "scheme", "steps per cycle", "error of the tip", "error of the friction work",
             "numerical dissipation / input", "iterations", "µs of CPU per step")  # fmt: skip
    page = [
        "# Error of the integration schemes", "",
        "Lab roll on 12 x 6 cells, dwell of twelve cycles at 150 Hz, `solver.reduction_tolerance: 1e-3`, against",
        f"`condensed` with no_damping and {FINEST} steps per cycle. Errors: largest one of the tip history, and the",
        "friction work at the end. The CPU time of a step leaves out the training of the basis. Computed by",
        "`.venv/bin/python benchmarks/time_steps.py --page docs/tables/time_steps.md`.",
        "", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads), *lines,
    ]  # fmt: skip
    if asked.page:
        asked.page.write_text("\n".join(page) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
