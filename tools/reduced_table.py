"""Reduced against condensed, preload by preload; writes docs/tables/reduced.md.

`.venv/bin/python tools/reduced_table.py`, about two minutes. The lab chirp on the thesis's mesh (30 x 10 cells) at its
density of 47 400 steps (19 per cycle at 175 Hz; the thesis has 21.7 per cycle at 150 Hz). CPU seconds on one core.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
import xarray as xr

from wroll_fem.analyses import run_analysis
from wroll_fem.case import Case, load_case
from wroll_fem.progress import SilentProgress

ROOT = Path(__file__).resolve().parents[1]
PRESSURES = {"10 kPa": 1.0e4, "30 kPa": 3.0e4, "100 kPa": 1.0e5, "300 kPa": 3.0e5}
SOURCE = [
    "mesh={circumferential: 30, axial: 10}", "integrator.steps_per_cycle=19", "solver.allow_coarse=true",
    "output.figures=false",
]  # fmt: skip


def lab_chirp(pressure: float, method: str, *overrides: str) -> Case:
    """The lab chirp at one preload; the low preload needs a band that starts lower."""
    band = ["excitation.f_start=110", "excitation.f_end=154"] if pressure < 2.0e4 else []
    words = [*SOURCE, f"preload.pressure={pressure}", f"solver.method={method}", *band, *overrides]
    return load_case(ROOT / "configs" / "lab_sweep.yaml", words)


def timed(case: Case) -> tuple[xr.Dataset, float]:
    """Results, and CPU seconds from case to results."""
    start = time.process_time()
    result = run_analysis(case, progress=SilentProgress())
    return result, time.process_time() - start


def row(label: str, pressure: float) -> str:
    """One line of the table."""
    exact, exact_seconds = timed(lab_chirp(pressure, "condensed"))
    reduced, seconds = timed(lab_chirp(pressure, "reduced"))
    training = reduced.attrs["training_time_s"]
    tip, right = reduced["tip_displacement"].values, exact["tip_displacement"].values
    error = np.abs(tip - right).max() / np.abs(right).max()
    change = {
        key: 100 * abs(reduced.attrs[key] / exact.attrs[key] - 1) for key in ("f_n_hz", "peak_transmissibility", "zeta")
    }
    work = 100 * abs(float(reduced["friction_energy"][-1] / exact["friction_energy"][-1]) - 1)
    print(f"{label}: tip {100 * error:.3f} %, loop {reduced.attrs['solver_time_s']:.1f} s", flush=True)
    return (
        f"| {label} | {exact.attrs['f_n_hz']:.2f} Hz | {exact.attrs['solver_time_s']:.1f} s, {exact_seconds:.1f} s "
        f"| {reduced.attrs['solver_time_s'] - training:.1f} s, {training:.1f} s, {seconds:.1f} s "
        f"| {reduced.attrs['reduced_coordinates']} "
        f"| {100 * error:.3f} % | {change['f_n_hz']:.4f} % | {change['peak_transmissibility']:.3f} % "
        f"| {change['zeta']:.3f} % | {work:.4f} % | {100 * reduced.attrs['reduction_error_estimate']:.2f} % |"
    )


def main() -> None:
    """Warm the compiled loops up, run, write."""
    for method in ("condensed", "reduced"):
        run_analysis(lab_chirp(1.0e5, method, "excitation.f_start=174"), progress=SilentProgress())
    steps = run_steps(lab_chirp(1.0e5, "reduced"))
    heads = (
        "preload", "f_n", "condensed: loop, all", "reduced: loop, training, all", "basis vectors",
        "tip", "f_n", "peak", "zeta", "friction work", "error estimate",
    )  # fmt: skip
    text = f"""Lab chirp, 30 x 10 cells, {steps} steps (10 kPa: band 110 to 154 Hz), one core. CPU seconds: time loop;
training (residual checks, enrichment, repeated steps); all, from case file to results.
Differences from `condensed`, which is exact. Computed by `.venv/bin/python tools/reduced_table.py`.
"""
    lines = [*text.splitlines(), "", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    lines += [row(label, pressure) for label, pressure in PRESSURES.items()]
    (ROOT / "docs" / "tables" / "reduced.md").write_text("\n".join(lines) + "\n")


def run_steps(case: Case) -> int:
    """Steps of a case."""
    from wroll_fem.analyses import estimate

    return int(estimate(case)["steps"])


if __name__ == "__main__":
    main()
