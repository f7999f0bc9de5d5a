"""Reduced against condensed at low preload, for 1 and 5 layers; writes docs/tables/low_pressure.md.

`.venv/bin/python tools/low_pressure_table.py`, about five minutes. Dwell of six cycles on the coarse mesh of
configs/tiny.yaml, at a moderate and a strong level.
"""

from __future__ import annotations

import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.case import Case, load_case
from wroll_fem.progress import SilentProgress

ROOT = Path(__file__).resolve().parents[1]
PRESSURES = (0.0, 1.0, 10.0, 100.0, 1000.0)
LEVELS = {1: (0.5, 5.0, 20.0), 5: (0.5, 5.0)}
"""Layers -> base accelerations, m/s^2."""

HEADS = (
    "layers", "pressure", "base", "condensed: friction work, points that open", "reduced runs as", "error of the tip",
    "error of the input work", "error estimate",
)  # fmt: skip


def dwell(layers: int, pressure: float, level: float, method: str) -> Case:
    """Dwell of the table."""
    words = [
        f"coil.layers={layers}", f"preload.pressure={[pressure] * layers}", f"excitation.amplitude={level}",
        f"solver.method={method}", "output={fields: none, figures: false}",
    ]  # fmt: skip
    return load_case(ROOT / "configs" / "tiny.yaml", words)


def row(layers: int, pressure: float, level: float) -> str:
    """One line of the table."""
    exact, reduced = (
        run_analysis(dwell(layers, pressure, level, method), progress=SilentProgress())
        for method in ("condensed", "reduced")
    )
    right, found = summarise(exact), summarise(reduced)
    tip, true = reduced["tip_displacement"].values, exact["tip_displacement"].values
    error, work = np.abs(tip - true).max() / np.abs(true).max(), abs(found["input_work_j"] / right["input_work_j"] - 1)
    estimate = found.get("reduction_error_estimate")
    cells = (
        f"{layers}", f"{pressure:g} Pa", f"{level:g} m/s²",
        f"{right['friction_energy_j']:.3g} J, {100 * float(exact['open_fraction'].max()):.1f} %", found["method"],
        f"{100 * error:.3f} %", f"{100 * work:.3f} %", "" if estimate is None else f"{100 * estimate:.2f} %",
    )  # fmt: skip
    line = f"| {' | '.join(cells)} |"
    print(line, flush=True)
    return line


def main() -> None:
    """Run and write."""
    text = """Six cycles at 150 Hz, mesh of configs/tiny.yaml; `reduced` against `condensed`, which is exact. Where the
estimate exceeds 1 %, the run falls back to `condensed`. Computed by `.venv/bin/python tools/low_pressure_table.py`.
"""
    lines = [*text.splitlines(), "", f"| {' | '.join(HEADS)} |", "|" + "---|" * len(HEADS)]
    lines += [row(layers, p, level) for layers, levels in LEVELS.items() for p in PRESSURES for level in levels]
    (ROOT / "docs" / "tables" / "low_pressure.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
