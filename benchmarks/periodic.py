"""Seconds of harmonic curve and backbone of the lab roll as shipped, against the time they may take.

Usage: python benchmarks/periodic.py [--repeats N] [--check] [KEY=VALUE ...]; the overrides change both cases.

Counted are the CPU seconds of one core after set-up, the least of several solves in one process with warm compilation
caches: everything that depends on excitation or amplitude, the training of the basis included. Mesh, matrices, preload
and modes are set-up; so is the reading of a finished curve. With `--check` the exit code is 1 where a solve takes
longer than its limit.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"


from wroll_fem import load_case
from wroll_fem.analyses.harmonic import condensed_structure
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.blas import one_thread
from wroll_fem.dynamics.training.enrichment import trained_backbone, trained_response
from wroll_fem.dynamics.training.training import Trained
from wroll_fem.progress import SilentProgress

CONFIGS = Path(__file__).parents[1] / "configs"
LIMITS = {"lab_harmonic": 1.5, "lab_backbone": 2.5}
"""CPU seconds that each case may take after set-up, on one core of a desktop computer."""

REPEATS = 3


def solver(name: str, overrides: list[str]) -> Callable[[], Trained[Any]]:
    """Function that solves a shipped case; mesh, preload and modes are done before it is returned."""
    case, silent = load_case(CONFIGS / f"{name}.yaml", overrides), SilentProgress()
    system, state = prepare(case, silent)
    condensation = condensed_structure(case, system, state, silent)
    chosen = case.harmonic
    settings = {
        "harmonics": chosen.harmonics, "samples": chosen.samples, "max_periods": chosen.max_periods,
        "tolerance": chosen.reduction_tolerance,
    }  # fmt: skip
    if case.analysis == "backbone":
        reach = (case.backbone.tip_smallest, case.backbone.tip_largest)
        return lambda: trained_backbone(condensation, state, system.laws, tip_amplitudes=reach, **settings)
    shaken = {
        "amplitude": case.excitation.amplitude, "frequencies": (case.excitation.f_start, case.excitation.f_end)
    }  # fmt: skip
    return lambda: trained_response(condensation, state, system.laws, **shaken, **settings)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE", help="changes of both cases")
    parser.add_argument("--repeats", type=int, default=REPEATS, help="solves of each case; the shortest counts")
    parser.add_argument("--check", action="store_true", help="exit code 1 where a solve takes longer than its limit")
    chosen = parser.parse_args()
    late = False
    print("| case | CPU s | limit, s | curves | points | basis | error estimate |\n|---|---|---|---|---|---|---|")
    for name, limit in LIMITS.items():
        solve, seconds = solver(name, chosen.overrides), []
        for _ in range(chosen.repeats):
            started = time.process_time()
            with one_thread():
                trained = solve()
            seconds.append(time.process_time() - started)
        late |= min(seconds) > limit
        curve = trained.curve
        print(
            f"| {name} | {min(seconds):.2f} | {limit:.1f} | {trained.rounds} | {len(curve.frequencies)} | "
            f"{curve.balance.model.size} | {trained.energy_error:.1e} |",
            flush=True,
        )
    sys.exit(1 if chosen.check and late else 0)


if __name__ == "__main__":
    main()
