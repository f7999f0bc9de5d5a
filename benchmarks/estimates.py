"""Measure the estimates of `wroll run --dry-run`: CPU time of every case in configs/, against its estimate.

    .venv/bin/python benchmarks/estimates.py            # table on the screen
    .venv/bin/python benchmarks/estimates.py --write    # and docs/tables/estimates.md

The CPU time is that of the whole command, figures included, on one core; the case of two masses uses all cores, and its
estimate is a wall time.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WALL = ("two_dof",)
"""Cases whose estimate is a wall time."""


def run(*words: str) -> str:
    """Output of a `wroll` command."""
    command = [sys.executable, "-m", "wroll_fem.cli", *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout


def measured(case: Path, folder: Path) -> tuple[float | None, float]:
    """Estimate and measured time of a case, s."""
    found = re.search(r"estimated seconds +(\S+)", run("run", str(case), "--dry-run"))
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    run("run", str(case), "--out", str(folder / case.stem))
    after, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - started
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return None if found is None else float(found[1]), wall if case.stem.startswith(WALL) else cpu


def main() -> None:
    """Print the table, and write it on request."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write docs/tables/estimates.md")
    write = parser.parse_args().write
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    rows = ["| case | estimate, s | measured, s | measured / estimate |", "|---|---|---|---|"]
    print(*rows, sep="\n", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for case in sorted((ROOT / "configs").glob("*.yaml")):
            estimate, seconds = measured(case, Path(folder))
            if estimate is None:
                continue
            rows.append(f"| {case.stem} | {estimate:.1f} | {seconds:.1f} | {seconds / estimate:.2f} |")
            print(rows[-1], flush=True)
    if write:
        title = (
            "# Estimates of `--dry-run`, measured\n\n`.venv/bin/python benchmarks/estimates.py --write`, one core.\n"
        )
        (ROOT / "docs" / "tables" / "estimates.md").write_text(title + "\n" + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
