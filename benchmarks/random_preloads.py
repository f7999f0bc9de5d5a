"""Random coils that rub on their mandrel, preloaded in three steps: interface equations against the whole structure.

Usage: python benchmarks/random_preloads.py [--count N] [--seed S]

Drawn are roll, base of the coil, modulus, pressure, friction and a coarse mesh. Each row gives the CPU seconds of both
solvers and the difference of the tractions, relative to the largest one.
"""

from __future__ import annotations

import argparse
import logging
import os
import time
import warnings
from collections.abc import Callable
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np

from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.case import load_case
from wroll_fem.dynamics.statics.condensed import CondensedStatic
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.full import solve_static
from wroll_fem.errors import ConvergenceError

CONFIGS = Path(__file__).parents[1] / "configs"
STEPS = 0.2, 0.6, 1.0
Solver = Callable[[np.ndarray, ContactState], ContactState]


def drawn(rng: np.random.Generator) -> tuple[str, dict[str, object]]:
    """Name of a shipped roll, and the values of keys of its case."""
    roll = str(rng.choice(["irosa", "sspp", "habex"]))
    keys = {
        "coil.material.E": 10.0 ** rng.uniform(8.0, 10.0), "preload.pressure": 10.0 ** rng.uniform(4.0, 6.7),
        "contact.friction.mu": 10.0 ** rng.uniform(-1.3, 0.0), "coil.base": rng.choice(["free", "inner_edge"]),
        "mesh.circumferential": rng.choice([8, 12]), "mesh.axial": rng.integers(4, 9),
        "mesh.radial": rng.integers(2, 4), "mesh.grading": rng.integers(5, 40),
    }  # fmt: skip
    return roll, keys


def preloaded(solve: Solver, force: np.ndarray, start: ContactState) -> tuple[ContactState | None, float]:
    """State at the end of the steps, None without convergence, and CPU seconds."""
    began, state = time.process_time(), start
    try:
        for share in STEPS:
            state = solve(share * force, state)
    except ConvergenceError:
        return None, time.process_time() - began
    return state, time.process_time() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=24)
    parser.add_argument("--seed", type=int, default=7)
    chosen = parser.parse_args()
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    rng, ended, most = np.random.default_rng(chosen.seed), 0, 0.0
    print("| roll | drawn | interface, CPU s | whole, CPU s | difference |")
    print("|---|---|---|---|---|")
    for _ in range(chosen.count):
        roll, keys = drawn(rng)
        case = load_case(CONFIGS / f"{roll}_friction.yaml", [f"{key}={value}" for key, value in keys.items()])
        system = build_system(case, build_bodies(case, symmetric=True))
        solver, start = CondensedStatic.of(system, 5e4), ContactState.unloaded(system)
        assert solver is not None
        found, seconds = preloaded(solver, system.loads["preload"], start)
        whole, longer = preloaded(
            lambda force, state, system=system: solve_static(system, force, state), system.loads["preload"], start
        )
        apart = np.nan
        if found is not None and whole is not None:
            ended += 1
            apart = float(np.abs(found.traction - whole.traction).max() / np.abs(whole.traction).max())
            most = max(most, apart)
        values = (f"{value:.2g}" if isinstance(value, float) else value for value in keys.values())
        said = ", ".join(f"{key.rsplit('.', 1)[-1]} {value}" for key, value in zip(keys, values, strict=True))
        print(f"| {roll} | {said} | {seconds:.2f} | {longer:.1f} | {apart:.0e} |", flush=True)
    print(f"{ended} of {chosen.count} converge in both, with tractions that differ by at most {most:.0e}")


if __name__ == "__main__":
    main()
