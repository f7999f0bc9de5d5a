"""Damaged measurements: each is refused in one line, or evaluated, within 5 s of CPU time.

    python -m tests.fuzz.laboratory_files --count 10000 --seed 1 [--readers tension slip]

Every reader of the laboratory gets `count` files: records of shaker, shear and winding tests (CSV, npz, mat, UFF), the
table of targets (CSV), frames (PNG folder, TIFF, raw video), and results of `transmissibility` (for `fit`). Columns,
cells, frames and bytes are changed, and some settings. Results are saved, and every hundredth is drawn.
"""

from __future__ import annotations

import argparse
import contextlib
import random
import shutil
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from tests.fuzz.damaged_files import told
from tests.fuzz.laboratory_originals import ORIGINALS, Original
from wroll_fem.lab.evaluation import evaluate_with
from wroll_fem.lab.kinds import find_kind
from wroll_fem.lab.settings import read_settings
from wroll_fem.results.dataset import save_dataset

SECONDS = 5.0
"""CPU time of an evaluation above which it counts as hanging."""

DRAWN = 0.01
"""Share of the results whose figures are drawn."""

WHOLE = 0.03
"""Share of the copies that are evaluated where the reader alone is tried (table of targets, fit)."""


class Hangs(BaseException):
    """The time is up; no handler of errors may take it."""


def _stop(number: int, frame: FrameType | None) -> None:
    raise Hangs


def outcome(original: Original, chance: random.Random, place: Path) -> str:
    """ "read", "refused", or the name of a defect, for one damaged copy of a measurement."""
    files, settings = original.damaged(place, chance)
    draw = chance.random() < DRAWN
    whole = chance.random() < WHOLE

    def use() -> None:
        if not whole and original.read_alone(files, settings):
            return
        model = find_kind(original.kind).settings
        result = evaluate_with(original.kind, files, read_settings(model, values=settings))
        save_dataset(result.data, place / "results.nc")
        if draw:
            import matplotlib.pyplot as plt

            result.write_figures(place / "figures")
            plt.close("all")

    signal.signal(signal.SIGVTALRM, _stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return told(use)
    except Hangs:
        return f"hangs: {original.kind} {settings}"
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


def run(
    readers: list[str], count: int, seed: int, *, first: int = 0, report: Callable[[str], Any] = print
) -> tuple[Counter[tuple[str, str]], dict[str, str], float]:
    """Outcomes of ``count`` damaged copies for each reader; defects with their first case; longest CPU time."""
    outcomes: Counter[tuple[str, str]] = Counter()
    defects: dict[str, str] = {}
    slowest = 0.0
    memory = Path("/dev/shm")
    with contextlib.ExitStack() as stack:
        scratch = Path(
            stack.enter_context(tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None))  # type: ignore[arg-type]
        )
        for name in readers:
            original = ORIGINALS[name]()
            for number in range(first, first + count):
                place = scratch / name
                shutil.rmtree(place, ignore_errors=True)
                place.mkdir()
                begun = time.process_time()
                answer = outcome(original, random.Random(f"{seed}:{name}:{number}"), place)
                if number > first:  # the first one compiles and imports
                    slowest = max(slowest, time.process_time() - begun)
                outcomes[name, answer if answer in ("read", "refused") else "defect"] += 1
                if answer not in ("read", "refused") and answer not in defects:
                    defects[answer] = f"{name}, number {number}"
                    report(f"--- {defects[answer]}: {answer}")
    return outcomes, defects, slowest


def main() -> None:
    """Damage the measurements; print every class of defects with its first number."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--readers", nargs="*", default=list(ORIGINALS))
    chosen = parser.parse_args()
    if find_spec("pyuff") is None and "shaker uff" in chosen.readers:
        print("pyuff is not installed: no universal files")
        chosen.readers.remove("shaker uff")
    import matplotlib

    matplotlib.use("Agg")
    np.seterr(all="ignore")
    begun = time.process_time()
    outcomes, defects, slowest = run(chosen.readers, chosen.count, chosen.seed, first=chosen.first)
    for (name, answer), count in sorted(outcomes.items()):
        print(f"{name:<22} {answer:<8} {count}")
    spent = time.process_time() - begun
    print(f"seed {chosen.seed}: {sum(outcomes.values())} files, {len(defects)} classes of defects, "
          f"{spent:.0f} s of CPU, slowest {slowest:.2f} s")  # fmt: skip
    sys.exit(bool(defects))


if __name__ == "__main__":
    main()
