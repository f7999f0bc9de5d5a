"""Five layers of 200 Pa: the reduced method against the exact one, where layers rattle.

`.venv/bin/python tools/layers_table.py` writes docs/tables/layers.md (about five minutes).
The case is configs/lab_dwell_layers.yaml on a coarse mesh and for 12 of its 60 cycles, where `condensed` is quick.
"""

from __future__ import annotations

import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
import xarray as xr

from wroll_fem.analyses import history, run_analysis
from wroll_fem.case import load_case
from wroll_fem.progress import SilentProgress
from wroll_fem.results.interface_slip import slipping_area_fraction

ROOT = Path(__file__).resolve().parents[1]
LEVELS = (9.80665, 19.6133, 29.41995)
COARSE = ["mesh={circumferential: 12, axial: 6, grading: 3}", "excitation.cycles=12", "output.figures=false"]
VARIANTS = [(level, 40, 2e-3) for level in LEVELS] + [(LEVELS[0], 80, 2e-3), (LEVELS[2], 40, 1e-3)]
"""Level in m/s^2, steps per cycle, reduction tolerance."""


def run(method: str, level: float, steps: int, tolerance: float) -> xr.Dataset:
    """History of one variant."""
    sets = [f"solver.method={method}", f"excitation.amplitude={level}", f"integrator.steps_per_cycle={steps}"]
    tighter = [f"solver.reduction_tolerance={tolerance}"] if method == "reduced" else []
    case = load_case(ROOT / "configs" / "lab_dwell_layers.yaml", [*COARSE, *sets, *tighter])
    history.FALLBACK_SIZE = 0  # the reduced model is looked at here
    return run_analysis(case, progress=SilentProgress())


def row(level: float, steps: int, tolerance: float) -> str:
    """One line of the table."""
    exact, reduced = (run(method, level, steps, tolerance) for method in ("condensed", "reduced"))
    tip = exact["tip_displacement"].values
    error = np.abs(reduced["tip_displacement"].values - tip).max() / np.abs(tip).max()
    work = [float(h["friction_energy"][-1]) for h in (exact, reduced)]
    area = [float(slipping_area_fraction(h)[0]) for h in (exact, reduced)]
    differs = np.mean(reduced["slipped"].values != exact["slipped"].values)
    seconds = [h.attrs["solver_time_s"] for h in (exact, reduced)]
    slip = float(reduced["max_slip"].max() / exact["max_slip"].max()) - 1
    impact = float(exact["impact_dissipation"][-1]) / work[0]
    return (
        f"| {level / 9.80665:.0f} | {steps} | {tolerance:g} | {float(exact['open_fraction'].max()):.2f} "
        f"| {error:.1%} ({reduced.attrs['reduction_error_estimate']:.1%}) | {1e3 * work[0]:.3f} "
        f"| {work[1] / work[0] - 1:+.1%} | {area[0]:.3f} | {area[1]:.3f} | {differs:.1%} | {slip:+.1%} "
        f"| {impact:.1%} | {exact.attrs['step_cuts']} | {seconds[0]:.0f} | {seconds[1]:.0f} |"
    )


def main() -> None:
    """Run all variants and write the table."""
    head = (
        "level, g | steps per cycle | reduction tolerance | largest open fraction "
        "| tip: largest difference (error estimate) | friction work, condensed (mJ) | reduced "
        "| slipping area, inner interface, condensed | reduced "
        "| points that slip in one only | largest slip | impact over friction work | cuts | CPU s, condensed | reduced"
    )
    lines = [
        "# Five layers of 200 Pa at 150 Hz: `reduced` against `condensed`",
        "",
        "`.venv/bin/python tools/layers_table.py`: configs/lab_dwell_layers.yaml on 12 x 6 elements, 12 cycles.",
        "",
        f"| {head} |",
        "|" + "---|" * (head.count("|") + 1),
    ]
    for variant in VARIANTS:
        lines.append(row(*variant))
        print(lines[-1], flush=True)
    (ROOT / "docs" / "tables" / "layers.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
