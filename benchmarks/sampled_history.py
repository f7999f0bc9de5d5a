"""Chirp of the lab roll on all contact points and on a subset: readings, errors and CPU time, in a table.

Usage: python benchmarks/sampled_history.py [--condensed]

Mesh of 32 x 16 graded cells. All runs are made in one process, on one core, one after the other; compilation is not
counted. `integration` is the CPU time of the steps, with the checks of the basis and with the points that follow a
subset; `in all` adds mesh, preload, modes and training. The history error is the largest difference of the tip
displacement from the one with all points and 160 trigonometric steps per cycle, relative to the largest displacement.
With `--condensed` a run by `condensed` with HHT and 160 steps per cycle is added, which takes five minutes.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
import xarray as xr

from wroll_fem import load_case
from wroll_fem.analyses import run_analysis
from wroll_fem.progress import SilentProgress

CASE = Path(__file__).parents[1] / "configs" / "lab_sweep.yaml"
MESH, RATE = "mesh={circumferential: 32, axial: 16, grading: 40}", "excitation.rate_oct_per_min=2"
FINE, EQUAL, CONDENSED = 160, 260, 160
"""Steps per cycle of the history that counts as exact, of HHT by `reduced` with many steps, and of `condensed`."""

RUNS = (("trigonometric", 40, True), ("trigonometric", 40, False), ("hht", 40, True), ("hht", 40, False),
        ("hht", EQUAL, False))  # fmt: skip


def solved(scheme: str, steps: int, *, subset: bool, method: str = "reduced") -> tuple[xr.Dataset, float]:
    """Dataset of the chirp, and CPU time in all, s."""
    began = time.process_time()
    alpha = ", alpha: -0.05" if scheme == "hht" else ""
    case = load_case(CASE, [
        MESH, RATE, f"integrator={{scheme: {scheme}, steps_per_cycle: {steps}{alpha}}}", "output.figures=false",
        f"solver={{method: {method}, hyper_reduction: {str(subset).lower()}}}",
    ])  # fmt: skip
    found = run_analysis(case, progress=SilentProgress())
    return found, time.process_time() - began


def apart(found: xr.Dataset, right: xr.Dataset) -> float:
    """Largest difference of the tip displacement at the times of ``found``, relative to the largest displacement."""
    tip = right["tip_displacement"].values
    there = np.interp(found["time"].values, right["time"].values, tip)
    return float(np.abs(found["tip_displacement"].values - there).max() / np.abs(tip).max())


def row(found: xr.Dataset, seconds: float, right: xr.Dataset, name: str) -> str:
    """Row of the table."""
    a = found.attrs
    points, of = a.get("sampled_points", a["interface_points"]), a["interface_points"]
    errors = f"{100 * a['reduction_error_estimate']:.2f}" if "reduction_error_estimate" in a else "-"
    errors += f", {100 * a['sampling_work_error']:.2f}" if "sampling_work_error" in a else ""
    return (
        f"| {name}, {a['steps_per_cycle']:.0f} | {points} of {of} | {a.get('reduced_coordinates', '-')} | "
        f"{a['f_n_hz']:.3f} | {a['peak_transmissibility']:.3f} | {100 * a['zeta']:.4f} | "
        f"{float(found['friction_energy'][-1]):.5f} | {100 * apart(found, right):.2f} | {errors} | "
        f"{a['solver_time_s']:.1f} | {seconds:.1f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--condensed", action="store_true", help="add a run by `condensed`")
    asked = parser.parse_args()
    for scheme in ("trigonometric", "hht"):  # compiles
        for subset in (True, False):
            solved(scheme, 40, subset=subset)
    right, _ = solved("trigonometric", FINE, subset=False)
    lines = [
        "| scheme, steps per cycle | points | basis | f_n, Hz | peak | zeta, % | friction work, J | history error, % | "
        "stated: basis, work, % | integration, CPU s | in all, CPU s |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for scheme, steps, subset in RUNS:
        lines.append(row(*solved(scheme, steps, subset=subset), right, scheme))
        print(lines[-1], flush=True)
    if asked.condensed:
        lines.append(row(*solved("hht", CONDENSED, subset=False, method="condensed"), right, "hht, condensed"))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
