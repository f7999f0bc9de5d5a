"""Runs and batches that are killed, or whose disk is full, at random file operations, and are continued.

    PYTHONPATH=.:tests python -m tests.fuzz.faults --count 200 --seed 1

Each fault hits a run of the oscillator by `reduced` or `condensed` with a checkpoint after every chunk; every tenth one
a batch of two cases without a time history. The continued run must have the results of an undisturbed one, bit by bit.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
import xarray as xr
from support.faults import KILLED, with_fault

from wroll_fem import analyses
from wroll_fem.cli.app import app
from wroll_fem.dynamics.time_stepping import simulate
from wroll_fem.results.dataset import load_dataset

ROOT = Path(__file__).resolve().parents[2]
WORDS = [
    "run", str(ROOT / "configs" / "oscillator.yaml"), "--set", "analysis=dwell", "--set", "output.figures=false",
    "--set",
    "excitation={kind: dwell, amplitude: 6.0, frequency: 11.0, cycles: 8}", "--set", "solver.checkpoint_seconds=1e-9",
    "--set", "contact.friction={law: penalty_coulomb, mu: 0.3, elastic_slip: 1.0e-5}",
]  # fmt: skip
GRID = f"""base: {ROOT / "configs" / "two_dof.yaml"}
grid: {{two_dof.friction_capacity: [[3], [5]], two_dof.omega.points: [20], output.figures: [false]}}
"""


def command(words: list[str]) -> int:
    """Exit code of a command in this process."""
    try:
        app(words, prog_name="wroll")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 1
    return 0


def quietly(words: list[str]) -> int:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        return command(words)


def numbers(folder: Path) -> list[xr.Dataset]:
    return [load_dataset(path).drop_attrs() for path in sorted(folder.rglob("results.nc"))]


def main() -> None:
    """Apply the faults; print every class of defects with its first number."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1e9, help="stop after this wall time")
    chosen = parser.parse_args()
    simulate.CHUNK = 40
    outcomes: Counter[str] = Counter()
    defects: dict[str, int] = {}
    begun = time.monotonic()
    assert analyses.case_warnings
    memory = Path("/dev/shm")  # synchronising costs nothing there
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as place:
        scratch = Path(place)
        (scratch / "grid.yaml").write_text(GRID)
        kinds = {
            "reduced": [*WORDS, "--set", "solver.method=reduced", "--resume"],
            "condensed": [*WORDS, "--set", "solver.method=condensed", "--resume"],
            "batch": ["batch", str(scratch / "grid.yaml")],
        }
        whole: dict[str, list[xr.Dataset]] = {}
        for kind, words in kinds.items():
            assert quietly([*words, "--out", str(scratch / kind)]) == 0
            whole[kind] = numbers(scratch / kind)
        for number in range(chosen.count):
            chance = random.Random(f"{chosen.seed}:{number}")
            kind = "batch" if number % 10 == 9 else chance.choice(("reduced", "condensed"))
            fault, once, at = chance.choice(("kill", "full")), chance.random() < 0.5, chance.randrange(1, 130)
            out = scratch / f"out_{number}"
            words = [*kinds[kind], "--out", str(out)]
            ended = with_fault(lambda words=words: command(words), out, fault, at, once=once)  # type: ignore[arg-type]
            allowed = {KILLED} if fault == "kill" else {0, 4}
            problem = ""
            if ended.reached and ended.code not in allowed:
                problem = f"{kind}, {fault}: exit code {ended.code}: {ended.errors[-300:]}"
            elif fault == "full" and ended.code == 4 and "Traceback" in ended.errors:
                problem = f"{kind}: {ended.errors[-300:]}"
            elif quietly(words) != 0:
                problem = f"{kind}, {fault}: cannot be continued"
            elif not all(map(same, numbers(out), whole[kind])) or len(numbers(out)) != len(whole[kind]):
                problem = f"{kind}, {fault}: other numbers"
            outcomes[f"{kind} {fault} {'reached' if ended.reached else 'after its end'}"] += 1
            if problem and problem not in defects:
                defects[problem] = number
                print(f"--- number {number}, operation {at}: {problem}", flush=True)
            shutil.rmtree(out, ignore_errors=True)
            if time.monotonic() - begun > chosen.seconds:
                break
    print(f"seed {chosen.seed}: {dict(outcomes)}, {len(defects)} classes of defects")
    sys.stdout.flush()
    os._exit(bool(defects))


def same(one: xr.Dataset, other: xr.Dataset) -> bool:
    """Whether all variables are equal bit by bit."""
    return set(one.variables) == set(other.variables) and all(
        np.array_equal(one[name].values, other[name].values, equal_nan=one[name].dtype.kind == "f")
        for name in one.variables
    )


if __name__ == "__main__":
    main()
