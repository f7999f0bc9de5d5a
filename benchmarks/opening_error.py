"""Error of `reduced` where contact points open, against its estimate: random rolls, docs/tables/opening_error.md.

Usage: python benchmarks/opening_error.py [--count N] [--first I] [--page FILE]

The rolls are those of `random_rolls` from number 2000 on, which no other table uses, on a mesh of 12 x 6 cells, in a
dwell of 15 cycles whose acceleration is multiplied by a log-uniform random factor of 3 to 15 (seed `SEED`, number); the
rolls at low pressure are configs/tiny.yaml, six cycles. `condensed` is exact. About ten minutes on one core.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
import xarray as xr
from random_rolls import random_case

import wroll_fem.analyses.history as history
from wroll_fem.analyses import run_analysis
from wroll_fem.case import Case, load_case
from wroll_fem.case.loader import build_case
from wroll_fem.dynamics.reduction.error_estimate import CLOSED_PART, OPENED_PART, OPENING
from wroll_fem.errors import ConvergenceError
from wroll_fem.progress import SilentProgress

ROOT = Path(__file__).resolve().parents[1]
SEED, FIRST, COUNT = 77, 2000, 60
LOW = ((1, 30, 0.5), (1, 100, 0.5), (1, 100, 5.0), (1, 1000, 5.0), (1, 1000, 20.0), (1, 3000, 20.0), (1, 3000, 60.0),
       (1, 10000, 60.0), (5, 100, 5.0), (5, 1000, 20.0))  # fmt: skip
"""Number of layers, pressure in Pa, base acceleration in m/s^2."""

HEADS = (
    "roll",
    "layers",
    "points that open",
    "error of the tip",
    "error of the input work",
    "estimate",
    "without opening",
)


def random_dwell(index: int, method: str) -> Case:
    """Dwell of random roll ``index``, more strongly shaken."""
    case = random_case(index, "dwell")
    scale = np.exp(np.random.default_rng([SEED, index]).uniform(np.log(3.0), np.log(15.0)))
    case["excitation"] |= {"cycles": 15, "ramp_cycles": 5, "amplitude": case["excitation"]["amplitude"] * float(scale)}
    return build_case(case | {"solver": {"method": method}, "mesh": {"circumferential": 12, "axial": 6, "grading": 2}})


def low_dwell(layers: int, pressure: float, level: float, method: str) -> Case:
    """Dwell of the coarse roll at a low pressure."""
    words = [
        f"coil.layers={layers}", f"preload.pressure={[float(pressure)] * layers}", f"excitation.amplitude={level}",
        f"solver.method={method}", "output={fields: none, figures: false}",
    ]  # fmt: skip
    return load_case(ROOT / "configs" / "tiny.yaml", words)


def errors(exact: xr.Dataset, reduced: xr.Dataset) -> tuple[float, float]:
    """Root mean square error of the tip motion and largest error of the input work, relative to the exact ones."""
    right, found = exact["tip_displacement"].values, reduced["tip_displacement"].values
    work = exact["input_work"].values
    change = np.abs(work - reduced["input_work"].values).max() / np.abs(work).max()
    return float(np.sqrt(np.mean((found - right) ** 2) / np.mean(right**2))), float(change)


def row(name: str, layers: int, exact: xr.Dataset, reduced: xr.Dataset) -> str | None:
    """Line of the table; None for a roll that stays closed."""
    fraction = reduced["open_fraction"].values
    opened = float(np.abs(fraction - fraction[0]).max())
    if opened == 0.0:
        return None
    tip, work = errors(exact, reduced)
    estimate = float(reduced.attrs["reduction_error_estimate"])
    closed = max(estimate / OPENING, (estimate - OPENED_PART * opened) / CLOSED_PART)  # the smaller of two rising
    cells = (name, f"{layers}", *(f"{100 * share:.2g} %" for share in (opened, tip, work, estimate, closed)))
    mark = "" if max(tip, work) <= estimate else " **below the error**"
    return f"| {' | '.join(cells)}{mark} |"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--first", type=int, default=FIRST)
    parser.add_argument("--page", type=Path, help="page to write (Markdown)")
    asked = parser.parse_args()
    history.FALLBACK_SIZE = -1  # no fallback: its error is what is measured
    planned = [(f"{p} Pa, {a} m/s²", n, lambda m, n=n, p=p, a=a: low_dwell(n, p, a, m)) for n, p, a in LOW]
    for index in range(asked.first, asked.first + asked.count):
        layers = int(random_case(index, "dwell")["coil"]["layers"])
        planned.append((f"random {index}", layers, lambda m, i=index: random_dwell(i, m)))
    lines = []
    for name, layers, case in planned:
        try:
            reduced, exact = (run_analysis(case(m), progress=SilentProgress()) for m in ("reduced", "condensed"))
        except ConvergenceError as error:
            print(f"{name}: {error.problem}", flush=True)
            continue
        line = row(name, layers, exact, reduced)
        if line:
            lines.append(line)
            print(line, flush=True)
    head = [
        f"`reduced` against `condensed`, which is exact; {len(planned)} rolls, of which the {len(lines)} that open are",
        "listed. Errors: root mean square of the tip, largest of the input work. Computed by",
        f"`.venv/bin/python benchmarks/opening_error.py --count {asked.count} --page docs/tables/opening_error.md`.",
        "", f"| {' | '.join(HEADS)} |", "|" + "---|" * len(HEADS), *lines,
    ]  # fmt: skip
    if asked.page:
        asked.page.write_text("\n".join(head) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
