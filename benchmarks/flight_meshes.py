"""Flight rolls on two meshes: f_n, peak and damping at low, middle and high preload: docs/tables/flight_mesh.md.

Usage: python benchmarks/flight_meshes.py --out FILE [--rolls NAME ...] [--base KIND ...]
       python benchmarks/flight_meshes.py --page docs/tables/flight_mesh.md --read FILE [FILE ...]

Each case is computed on the mesh of its case file and with twice as many elements in every direction, those next to a
clamped annulus included. Every run has a process of its own, on one core, whose CPU time and largest memory are
measured. Runs that FILE contains are skipped. The preloads are the lowest, middle and highest ones (of 10, 20, 50, 100,
200, 500, 1000 and 2000 kPa) at which the case has a curve; the middle is where the damping is largest, or next to it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

from job import peak_memory_mb

import wroll_fem as wf
from wroll_fem.analyses import run_analysis
from wroll_fem.case.roll import RollSections
from wroll_fem.errors import ConvergenceError
from wroll_fem.progress import SilentProgress

CONFIGS = Path(__file__).resolve().parents[1] / "configs"
TOLERANCE = "harmonic.reduction_tolerance=3e-3"
LIMITS = {"f_n_hz": 0.5, "peak_transmissibility": 5.0, "zeta_apparent": 5.0}
"""Largest changes between the two meshes, %."""

PRELOADS = {
    "free": {"irosa": (5e4, 2e5, 2e6), "sspp": (1e5, 5e5, 2e6), "habex": (5e4, 1e5, 2e5, 2e6)},
    "inner_edge": {"irosa": (2e5, 5e5, 2e6), "sspp": (1e4, 1e5, 5e5, 2e6), "habex": (2e5, 5e5, 2e6)},
}
"""Base of the coil -> roll -> external pressures, Pa."""

COLUMNS = (
    "roll", "coil.base", "external pressure, kPa", "f_n, Hz", "peak", "zeta, %", "f_n: change, %", "peak: change, %",
    "zeta: change, %", "within the limits", "finer mesh: CPU, s", "memory, GB",
)  # fmt: skip

NAMES = {"irosa": "iROSA", "sspp": "SSPP", "habex": "HabEx"}
DIRECTIONS = "circumferential", "axial", "radial"


def overrides(roll: str, base: str, pressure: float, factor: int) -> list[str]:
    """Overrides of the case file for a base, a pressure (Pa) and a mesh refined by a factor."""
    mesh = wf.load_case(CONFIGS / f"{roll}_friction.yaml").expect(RollSections).mesh
    cells = [f"mesh.{name}={factor * getattr(mesh, name)}" for name in DIRECTIONS]
    return [f"coil.base={base}", f"preload.pressure={pressure:.4g}", TOLERANCE, "output.figures=false", *cells]


def computed(roll: str, base: str, pressure: float, factor: int) -> dict[str, Any]:
    """Report of one run in this process: readings or cause, CPU seconds, largest memory."""
    case = wf.load_case(CONFIGS / f"{roll}_friction.yaml", overrides(roll, base, pressure, factor))
    report: dict[str, Any] = {"roll": roll, "base": base, "pressure": pressure, "factor": factor, "cause": ""}
    progress = SilentProgress()
    try:
        found = run_analysis(case, progress=progress)
        report |= {name: float(found.attrs[name]) for name in LIMITS}
        report |= {"dofs": int(found.attrs["dofs"]), "zeta_quality": str(found.attrs["zeta_quality"])}
    except ConvergenceError as error:
        report["cause"] = str(error)
    return report | {"cpu_s": time.process_time(), "memory_mb": peak_memory_mb(), "warnings": progress.warnings}


def in_child(*words: object) -> dict[str, Any]:
    """Report of `computed` from a process of its own."""
    command = [sys.executable, __file__, "--one", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, words))}: {done.stderr.strip().splitlines()[-1]}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def row(own: dict[str, Any], fine: dict[str, Any]) -> str:
    """Line of the table."""
    place = f"| {NAMES[own['roll']]} | {own['base']} | {own['pressure'] / 1e3:g} | "
    cost = f"{fine['cpu_s']:.0f} | {fine['memory_mb'] / 1024:.1f} |"
    if own["cause"] or fine["cause"]:
        where = "both meshes" if own["cause"] and fine["cause"] else "this mesh" if own["cause"] else "the finer mesh"
        return f"{place}no curve on {where} | | | | | | {cost}"
    changes = {name: 100.0 * (fine[name] / own[name] - 1.0) for name in LIMITS}
    within = all(abs(change) <= LIMITS[name] for name, change in changes.items())
    doubtful = "" if own["zeta_quality"] == "ok" else f" ({own['zeta_quality']})"
    return (
        f"{place}{own['f_n_hz']:.2f} | {own['peak_transmissibility']:.2f} | {100 * own['zeta_apparent']:.2f}{doubtful} "
        f"| {' | '.join(f'{change:+.2f}' for change in changes.values())} | {'yes' if within else 'no'} | {cost}"
    )


def page(reports: Sequence[dict[str, Any]]) -> str:
    """Page with the table."""
    by_run = {(r["roll"], r["base"], r["pressure"], r["factor"]): r for r in reports}
    rows = []
    for base, rolls in PRELOADS.items():
        for roll, pressures in rolls.items():
            for pressure in pressures:
                pair = [by_run.get((roll, base, pressure, factor)) for factor in (1, 2)]
                if pair[0] is not None and pair[1] is not None:
                    rows.append(row(pair[0], pair[1]))
    largest = max((r["memory_mb"] for r in reports if r["factor"] == 1), default=0.0) / 1024
    slowest = max((r["cpu_s"] for r in reports if r["factor"] == 1), default=0.0)
    return f"""# Meshes of the flight rolls

Rolls of [chapter 6](../chapter6.md) on the meshes of their case files, and the changes with twice as many elements in
every direction ({TOLERANCE}). Limits: 0.5 % (f_n), 5 % (peak, zeta). The runs on the meshes of the
case files take at most {slowest:.0f} s of CPU and {largest:.1f} GB. Computed
by `.venv/bin/python benchmarks/flight_meshes.py --out FILE`, and this page from FILE
by `.venv/bin/python benchmarks/flight_meshes.py --page docs/tables/flight_mesh.md --read FILE`.

| {" | ".join(COLUMNS)} |
{"|---" * len(COLUMNS)}|
{chr(10).join(rows)}
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rolls", nargs="+", choices=sorted(NAMES), default=[*NAMES])
    parser.add_argument("--base", nargs="+", choices=[*PRELOADS], default=[*PRELOADS])
    parser.add_argument("--out", type=Path, help="file for one JSON report per line; finished runs are skipped")
    parser.add_argument("--read", nargs="+", type=Path, default=[], help="files of reports, for the page")
    parser.add_argument("--page", type=Path, help="write the table to this page; no run")
    parser.add_argument("--one", nargs=4, metavar=("ROLL", "BASE", "PRESSURE", "FACTOR"), help="one run, as JSON")
    asked = parser.parse_args()
    if asked.one:
        roll, base, pressure, factor = asked.one
        print(json.dumps(computed(roll, base, float(pressure), int(factor))))
        return
    files = [*asked.read, *([asked.out] if asked.out and asked.out.exists() else [])]
    reports = [json.loads(line) for file in files for line in file.read_text(encoding="utf-8").splitlines()]
    if asked.page:
        asked.page.write_text(page(reports), encoding="utf-8")
        return
    if asked.out is None:
        parser.error("give --out FILE for the runs, or --page FILE with --read")
    done = {(r["roll"], r["base"], r["pressure"], r["factor"]) for r in reports}
    for base in asked.base:
        for roll in asked.rolls:
            for pressure in PRELOADS[base][roll]:
                for factor in (1, 2):
                    if (roll, base, pressure, factor) in done:
                        continue
                    report = in_child(roll, base, pressure, factor)
                    with asked.out.open("a", encoding="utf-8") as file:
                        file.write(json.dumps(report) + "\n")
                    words = report["cause"][:80] or ", ".join(f"{report[name]:.4g}" for name in LIMITS)
                    print(f"{roll} {base} {pressure:g} Pa x{factor}: {words}; {report['cpu_s']:.0f} s", flush=True)


if __name__ == "__main__":
    main()
