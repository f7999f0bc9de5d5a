"""Averaged random response of the lab roll against its time histories, at four levels and two preloads.

Usage: python benchmarks/random_response.py [--page docs/tables/random_response.md]

Both analyses take the shipped cases on the same 12 x 4 cells; their own meshes differ. The time history is one record
of 30 s (seed 1) for all levels, so the differences of the levels are not independent. f_n and zeta are read by the
rational fraction.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import wroll_fem as wf
from wroll_fem.progress import SilentProgress

CONFIGS = Path(__file__).parents[1] / "configs"
SHARED = ["mesh={circumferential: 12, axial: 4, grading: 40}", "damping.modal=0.003"]
AVERAGED = ["output.damping=rational_fraction", "backbone.tip_largest=1.5e-3", "random_response={}"]
PRESSURES, LEVELS = (1e5, 3e4), (-10.0, 0.0, 5.0, 10.0)  # Pa, dB

HEAD = """# Averaged random response against time histories

Lab roll on 12 x 4 cells with 0.3 % of modal damping: `analysis: random_response` against one record of 30 s (seed 1)
of `analysis: random` by HHT. The period error of the time steps makes f_n of the histories 0.16 % too low.
Computed by `.venv/bin/python benchmarks/random_response.py --page docs/tables/random_response.md`.

"""
COLUMNS = (
    "preload, kPa", "level, dB", "tip displacement, rms: time, averaged", "difference",
    "standard error of the record", "f_n, Hz: time, averaged", "difference", "zeta, %: time, averaged", "difference",
)  # fmt: skip


def row(pressure: float, level: float) -> str:
    """Row of the table for a preload, Pa, and a level, dB."""
    given = [*SHARED, f"preload.pressure={pressure}", f"excitation.level_db={level}"]
    found = wf.run(wf.load_case(CONFIGS / "lab_random_response.yaml", [*given, *AVERAGED]), progress=SilentProgress())
    timed = wf.run(
        wf.load_case(CONFIGS / "lab_random.yaml", [*given, "excitation.duration=30"]), progress=SilentProgress()
    )
    a, t = wf.summarise(found), wf.summarise(timed)
    apart = {name: 100.0 * (a[name] / t[name] - 1.0) for name in ("tip_displacement_rms_m", "f_n_hz", "zeta")}
    error = 100.0 * t["tip_rms_error"]
    return (
        f"| {1e-3 * pressure:g} | {level:g} | {1e6 * t['tip_displacement_rms_m']:.1f}, "
        f"{1e6 * a['tip_displacement_rms_m']:.1f} µm | {apart['tip_displacement_rms_m']:+.1f} % | {error:.1f} % | "
        f"{t['f_n_hz']:.2f}, {a['f_n_hz']:.2f} | {apart['f_n_hz']:+.2f} % | {100.0 * t['zeta']:.2f}, "
        f"{100.0 * a['zeta']:.2f} | {apart['zeta']:+.1f} % |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--page", type=Path, help="page that receives the table")
    page, rows = parser.parse_args().page, []
    for pressure in PRESSURES:
        for level in LEVELS:
            rows.append(row(pressure, level))
            print(rows[-1], flush=True)
    if page is not None:
        table = [f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|", *rows]
        page.write_text(HEAD + "\n".join(table) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
