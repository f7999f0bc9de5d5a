"""Harmonic balance against slow chirps; writes docs/tables/harmonic.md: `.venv/bin/python tools/harmonic_table.py`.

The lab roll on the thesis's mesh (30 x 10 cells), 40 steps per cycle. A chirp approaches the steady state as its
rate falls; the last lines of each preload show how far it has come.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import xarray as xr

from wroll_fem.analyses import run_analysis
from wroll_fem.case import load_case
from wroll_fem.progress import SilentProgress

ROOT = Path(__file__).resolve().parents[1]
BANDS = {1.0e4: (120, 150), 3.0e4: (134, 158), 1.0e5: (144, 164), 3.0e5: (150, 166)}  # preload in Pa -> Hz
RATES = (2.0, 0.5, 0.125)  # oct/min
READINGS = ("f_n_hz", "peak_transmissibility", "zeta")


def run(pressure: float, *overrides: str) -> tuple[xr.Dataset, float]:
    """Results of the lab roll at one preload, and CPU seconds from case to results."""
    low, high = BANDS[pressure]
    words = [
        "mesh={circumferential: 30, axial: 10}", f"preload.pressure={pressure}", "output.figures=false",
        f"excitation.f_start={low}", f"excitation.f_end={high}", *overrides,
    ]  # fmt: skip
    start = time.process_time()
    result = run_analysis(load_case(ROOT / "configs" / "lab_sweep.yaml", words), progress=SilentProgress())
    return result, time.process_time() - start


def line(name: str, label: str, result: xr.Dataset, seconds: float, right: xr.Dataset) -> str:
    """One line: readings and their differences from the steady state."""
    f_n, peak, zeta = (result.attrs[key] for key in READINGS)
    change = [100 * (result.attrs[key] / right.attrs[key] - 1) for key in READINGS]
    print(name, label, f"{f_n:.2f} Hz, {peak:.2f}, {100 * zeta:.2f} %", [f"{c:+.2f} %" for c in change], flush=True)
    return (
        f"| {name} | {label} | {f_n:.2f} Hz ({change[0]:+.2f} %) | {peak:.2f} ({change[1]:+.1f} %) "
        f"| {100 * zeta:.3f} % ({change[2]:+.1f} %) | {seconds:.1f} s |"
    )


def main() -> None:
    """Run all, write the table."""
    lines = [
        "Lab roll, 30 x 10 cells. In brackets: difference from harmonic balance with five harmonics, the steady state.",
        "CPU seconds from case file to results. Computed by `.venv/bin/python tools/harmonic_table.py`.",
        "",
        "| preload | method | f_n | peak T | zeta | CPU |",
        "|---|---|---|---|---|---|",
    ]
    for pressure in BANDS:
        name = f"{pressure / 1e3:.0f} kPa"
        steady, seconds = run(pressure, "analysis=harmonic", "harmonic.harmonics=5")
        lines.append(line(name, "harmonic balance, 5", steady, seconds, steady))
        lines.append(
            line(name, "harmonic balance, 3", *run(pressure, "analysis=harmonic", "harmonic.harmonics=3"), steady)
        )
        for rate in RATES:
            chirp = run(pressure, f"excitation.rate_oct_per_min={rate}")
            lines.append(line(name, f"chirp, {rate:g} oct/min", *chirp, steady))
    (ROOT / "docs" / "tables" / "harmonic.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
