"""One case in a process of its own: CPU seconds by stage, peak memory, and what the comparison needs.

Usage: python benchmarks/job.py CASE STEM [KEY=VALUE ...]; it writes STEM.json and, for a time history, STEM.npz.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np

from wroll_fem import load_case
from wroll_fem.analyses import run_analysis
from wroll_fem.progress import SilentProgress

SET_UP = ("mesh and matrices", "matrices", "preload", "condensation", "modes", "set-up")
READINGS = ("f_n_hz", "zeta", "peak_transmissibility", "steps", "dofs", "interface_points", "reduction_error_estimate")


class StageClock(SilentProgress):
    """Progress that keeps the CPU seconds of each stage."""

    def __init__(self) -> None:
        super().__init__()
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str, total: float, unit: str = "") -> Iterator[StageClock]:
        started = time.process_time()
        try:
            yield self
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - started

    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        """Nothing is shown."""


def peak_memory_mb() -> float:
    """Largest resident memory of this program, MB.

    `getrusage` would not do: its figure survives the exec, so it contains the memory of the parent process.
    """
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM:"))
    return float(line.split()[1]) / 1024


def main() -> None:
    case_file, stem, *overrides = sys.argv[1:]
    case = load_case(case_file, overrides)
    clock = StageClock()
    dataset = run_analysis(case, progress=clock)
    loop = sum(seconds for name, seconds in clock.seconds.items() if name not in SET_UP)
    total = time.process_time()
    report = {
        "overrides": overrides,
        "stages_cpu_s": clock.seconds,
        "loop_cpu_s": loop,
        "set_up_cpu_s": total - loop,  # imports, set-up stages and the reading of the curves
        "total_cpu_s": total,
        "peak_memory_mb": peak_memory_mb(),
        "warnings": clock.warnings,
    }
    report |= {key: float(dataset.attrs[key]) for key in READINGS if key in dataset.attrs}
    if "time" in dataset.dims:
        np.savez(f"{stem}.npz", tip=dataset["tip_displacement"].values, friction=dataset["friction_energy"].values)
    Path(f"{stem}.json").write_text(json.dumps(report, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
