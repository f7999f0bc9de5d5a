"""CPU time and memory of whole jobs against what they may take: docs/tables/time_limits.md.

Usage: python benchmarks/time_limits.py [NAME ...] [--check] [--page FILE]

Each job is a case in a process of its own, on one core, with warm compilation caches: imports, mesh, preload, analysis
and reading are counted; figures are not. With `--check` the exit code is 1 where a job exceeds its time or memory.
Five minutes of CPU on a processor of 2024.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from wroll_fem.blas import first_processor

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Job:
    """Case with its changes, and what it may take."""

    what: str
    case: str
    changes: tuple[str, ...]
    seconds: float
    megabytes: float


JOBS = {
    "case_study": Job(
        "slipping coil of the case study, 13 amplitudes, 24 x 24 x 5", "slipping_coil",
        ("mesh={circumferential: 24, axial: 24, grading: 60, radial: 5, radial_grading: 10}",
         "excitation.amplitude_g=[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 13.5, 15]"), 30.0, 2000.0,
    ),
    "slipping_curve": Job("the same coil shaken, harmonic curve at 15 g", "slipping_harmonic", (), 60.0, 2000.0),
    "slipping_flight": Job("slipping coil of the size of SSPP", "slipping_flight", (), 120.0, 2000.0),
    "irosa": Job("coil that rubs, harmonic curve, iROSA", "irosa_friction", (), 60.0, 4000.0),
    "sspp": Job("the same, SSPP", "sspp_friction", (), 60.0, 4000.0),
    "habex": Job("the same, HabEx", "habex_friction", (), 60.0, 4000.0),
    "shock": Job(
        "shock of 0.5 s on the lab roll, spectrum of 13 rows up to 5 kHz, shipped steps", "lab_shock",
        ("excitation={kind: srs, srs: {frequency: [100, 150, 200, 300, 400, 600, 800, 1000, 1500, 2000, 3000, 4000, "
         "5000], acceleration_g: [10, 18, 26, 42, 60, 95, 120, 120, 120, 120, 120, 120, 120]}, decay: 0.475}",),
        60.0, 2000.0,
    ),
    "random": Job("60 s of random motion of the lab roll", "lab_random", ("excitation.duration=60",), 180.0, 2000.0),
}  # fmt: skip


def measured(job: Job, folder: Path) -> dict[str, float]:
    """Report of `job.py` on a job."""
    stem = folder / job.case
    words = [str(ROOT / "benchmarks" / "job.py"), str(ROOT / "configs" / f"{job.case}.yaml"), str(stem)]
    subprocess.run([sys.executable, *words, *job.changes, "output.figures=false"], check=True, cwd=ROOT)
    return dict(json.loads(stem.with_suffix(".json").read_text(encoding="utf-8")))


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", default=list(JOBS), help=f"jobs: {', '.join(JOBS)}")
    parser.add_argument("--check", action="store_true", help="exit code 1 where a job exceeds its time or memory")
    parser.add_argument("--page", type=Path, help="page to write (Markdown)")
    asked = parser.parse_args()
    heads = ("job", "CPU, s", "of it set-up", "limit, s", "peak memory, MB", "limit, MB")
    lines, beyond = [], False
    with tempfile.TemporaryDirectory() as folder:
        for name in asked.names:
            job = JOBS[name]
            found = measured(job, Path(folder))
            seconds, memory = found["total_cpu_s"], found["peak_memory_mb"]
            beyond |= seconds > job.seconds or memory > job.megabytes
            cells = (job.what, f"{seconds:.1f}", f"{found['set_up_cpu_s']:.1f}", f"{job.seconds:g}",
                     f"{memory:.0f}", f"{job.megabytes:g}")  # fmt: skip
            lines.append(f"| {' | '.join(cells)} |")
            print(lines[-1], flush=True)
    if asked.page:
        page = [
            "# Time and memory of whole jobs", "",
            f"CPU seconds of one core of an {first_processor().get('model name', 'unknown processor')}, imports to",
            "reading, without figures. Computed by",
            "`.venv/bin/python benchmarks/time_limits.py --page docs/tables/time_limits.md`; `--check` compares with",
            "the limits.", "", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads), *lines,
        ]  # fmt: skip
        asked.page.write_text("\n".join(page) + "\n", encoding="utf-8")
    sys.exit(int(asked.check and beyond))


if __name__ == "__main__":
    main()
