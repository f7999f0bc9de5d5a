"""Runs and batches that are killed, or whose disk is full, at random file operations, and are continued.

    PYTHONPATH=.:tests python -m tests.fuzz.faults --count 200 --seed 1

Each fault hits a run of the oscillator by `reduced` or `condensed` with a checkpoint after every chunk, or a batch of
two cases without a time history. The continued run must begin at the last complete checkpoint and have the results of
an undisturbed one, bit by bit.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import resource
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from support.faults import KILLED, with_fault

from tests.fuzz.case_files import RAM_DISK, requests_to_stop
from wroll_fem import analyses
from wroll_fem.cli.app import app
from wroll_fem.dynamics.time_stepping import simulate
from wroll_fem.results import provenance
from wroll_fem.results.dataset import load_dataset

ROOT = Path(__file__).resolve().parents[2]
WORDS = [
    "run", str(ROOT / "configs" / "oscillator.yaml"), "--set", "analysis=dwell", "--set", "output.figures=false",
    "--set",
    "excitation={kind: dwell, amplitude: 6.0, frequency: 11.0, cycles: 4, ramp_cycles: 1}",
    "--set", "solver.checkpoint_seconds=1e-9",
    "--set", "contact.friction={law: penalty_coulomb, mu: 0.3, elastic_slip: 1.0e-5}",
]  # fmt: skip
GRID = f"""base: {ROOT / "configs" / "two_dof.yaml"}
grid: {{two_dof.friction_capacity: [[3], [5]], two_dof.omega.points: [20], output.figures: [false]}}
"""


def command(words: list[str]) -> None:
    """Run a command in this process; it ends with SystemExit."""
    app(words, prog_name="wroll")


def quietly(words: list[str]) -> int:
    """Exit code of a command in this process."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        try:
            command(words)
        except SystemExit as end:
            return end.code if isinstance(end.code, int) else 1
    return 0


def numbers(folder: Path) -> list[xr.Dataset]:
    return [load_dataset(path).drop_attrs() for path in sorted(folder.rglob("results.nc"))]


class Steps:
    """Steps that checkpoints contain: written by a child that is disturbed, read and written by the continued run."""

    def __init__(self, note: Path):
        self.note, self.read, self.written = note, list[int](), list[int]()
        save, load = simulate._Run.save, simulate._Run.load

        def saved(progress: Any, *arguments: Any) -> None:
            save(progress, *arguments)
            self.written.append(progress.done)
            with self.note.open("a") as file:
                file.write(f"{progress.done}\n")

        def loaded(progress: Any, *arguments: Any) -> None:
            load(progress, *arguments)
            self.read.append(progress.done)

        simulate._Run.save, simulate._Run.load = saved, loaded  # type: ignore[method-assign]

    def begin(self) -> None:
        self.note.write_text("")
        self.read.clear()
        self.written.clear()

    def lost(self, before: int) -> int:
        """Steps that the continued run computed although a complete checkpoint contained them."""
        start = self.read[-1] if self.read else 0 if self.written else before
        return max(before - start, 0)  # a child may be killed between its last checkpoint and the note of it


def disturbed(words: list[str], out: Path, fault: Any, at: int, once: bool, steps: Steps) -> tuple[bool, str]:
    """Whether the fault happened, and the class of the defect that it shows, or ""."""
    steps.begin()
    ended = with_fault(lambda: command(words), out, fault, at, once=once)
    before = max(map(int, steps.note.read_text().split()), default=0)
    steps.begin()
    allowed = {KILLED} if fault == "kill" else {0, 4}
    if ended.reached and ended.code not in allowed:
        return True, f"exit code {ended.code}: {ended.errors[-300:]}"
    if fault == "full" and ended.code == 4 and "Traceback" in ended.errors:
        return True, f"{ended.errors[-300:]}"
    if quietly(words) != 0:
        return ended.reached, "cannot be continued"
    if steps.lost(before):
        return ended.reached, f"{steps.lost(before)} steps of a checkpoint are lost"
    return ended.reached, ""


def main() -> None:
    """Apply the faults; print every class of defects with its first number."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20, help="faults that happen; every second one is a full disk")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1e9, help="stop after this CPU time")
    chosen = parser.parse_args()
    simulate.CHUNK = 40
    outcomes: Counter[str] = Counter()
    defects: dict[str, int] = {}
    asked, revision = requests_to_stop(), provenance.git_revision()
    provenance.git_revision = lambda folder=None: revision  # three processes per run
    assert analyses.case_warnings
    with tempfile.TemporaryDirectory(dir=RAM_DISK if RAM_DISK.is_dir() else None) as place:
        scratch = Path(place)
        steps = Steps(scratch / "steps.txt")
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
        most = dict.fromkeys(kinds, 200)
        number, done = 0, 0
        while done < chosen.count and not asked and cpu() < chosen.seconds:
            chance = random.Random(f"{chosen.seed}:{number}")
            kind, fault = chance.choice(list(kinds)), ("kill", "full")[done % 2]
            once, at = chance.random() < 0.5, chance.randrange(1, most[kind])
            out = scratch / f"out_{number}"
            words = [*kinds[kind], "--out", str(out)]
            reached, problem = disturbed(words, out, fault, at, once, steps)
            if not problem and (not all(map(same, numbers(out), whole[kind])) or len(numbers(out)) != len(whole[kind])):
                problem = "other numbers"
            if reached:
                done += 1
                outcomes[f"{kind} {fault}"] += 1
            else:
                most[kind] = max(2, min(most[kind], at))  # the run has fewer operations
            problem = problem and f"{kind}, {fault}: {problem}"
            if problem and problem not in defects:
                defects[problem] = number
                print(f"--- number {number}, operation {at}: {problem}", flush=True)
            number += 1
            shutil.rmtree(out, ignore_errors=True)
    counts = {name: outcomes[name] for name in sorted(outcomes)}
    print(f"seed {chosen.seed}: {done} faults {counts}, {cpu():.0f} s of CPU; operations below {most}")
    print(f"{len(defects)} classes of defects: {list(defects)}")
    sys.stdout.flush()
    os._exit(bool(defects))


def cpu() -> float:
    """CPU seconds of this process and of its children."""
    both = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in both)


def same(one: xr.Dataset, other: xr.Dataset) -> bool:
    """Whether all variables are equal bit by bit."""
    return set(one.variables) == set(other.variables) and all(
        np.array_equal(one[name].values, other[name].values, equal_nan=one[name].dtype.kind == "f")
        for name in one.variables
    )


if __name__ == "__main__":
    main()
