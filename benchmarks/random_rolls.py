"""Random rolls through every vibration analysis: seconds, outcome and cause of each, in a table.

Usage: python benchmarks/random_rolls.py [--count N] [--first I] [--analyses harmonic ...] [--limit S] [--out FILE]

Roll I is the same in every run and on every machine: its numbers come from the generator seeded with (SEED, I). Each
case runs in a process of its own, on one core, and is stopped at a limit of CPU seconds. Seconds include mesh, preload
and modes, not the imports. Outcomes:

* `curve`: a result within the limit;
* `told`: no result, and a message that names the cause within `TOLD` seconds;
* `late`: such a message after that;
* `stopped`: a message without a cause;
* `limit`: stopped at the limit; `crash`: any other end.

Lengths, thicknesses, moduli, tip mass, gamma*, pressure, friction and excitation are log-uniform in the ranges below;
the band of frequencies covers the estimates of the frictionless and the bonded resonance.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from wroll_fem import load_case
from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.shared.preflight import beam_frequency
from wroll_fem.case.loader import build_case
from wroll_fem.case.roll import RollSections
from wroll_fem.errors import WrollError
from wroll_fem.progress import SilentProgress

SEED = 12
LIMIT, TOLD = 60.0, 15.0
"""CPU seconds after which a case is stopped, and within which the cause of a failure has to be told."""

ANALYSES = ("harmonic", "backbone", "sweep", "dwell")
NAMED = ("surfaces open", "undetermined", "unbounded", "internal resonance")
"""Words of the messages that name the cause why there is no result."""

EARTH = 9.80665  # m/s^2
SWEPT_CYCLES, DWELL_CYCLES = 600, 60
READINGS = ("f_n_hz", "zeta", "peak_transmissibility", "zeta_max", "energy_balance_error", "reduction_error_estimate")


def random_roll(index: int) -> dict[str, Any]:
    """Sections of a valid roll without the analysis: 1 to 4 layers, 5 to 200 kPa, mu 0.05 to 1, 0.05 to 3 g."""
    rng = np.random.default_rng([SEED, index])

    def between(low: float, high: float) -> float:
        return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.4g}")

    diameter = between(0.05, 0.15)
    return {
        "geometry": {
            "length": between(0.2, 0.6), "mandrel_outer_diameter": diameter,
            "mandrel_thickness": between(0.01, 0.04) * diameter,
        },
        "mandrel": {
            "material": {"E": between(2e9, 7e10), "nu": 0.33, "rho": between(1000, 3000)},
            "tip_mass": between(0.01, 0.3), "tip": str(rng.choice(["rigid", "free"])), "base": "clamped",
        },
        "coil": {
            "model": "layers", "layers": int(rng.integers(1, 5)), "total_thickness": between(0.01, 0.04) * diameter,
            "material": {"E": between(2e9, 1e10), "nu": 0.33, "rho": between(1000, 2500)},
            "base": str(rng.choice(["free", "clamped", "inner_edge"])),
        },
        "contact": {
            "friction": {"law": "penalty_coulomb", "mu": between(0.05, 1.0), "elastic_slip": between(3e-7, 5e-6)},
            "normal": {"penalty": "auto", "separation": True},
        },
        "preload": {"kind": "external_pressure", "pressure": between(5e3, 2e5)},
        "mesh": {"circumferential": 14, "axial": 7, "grading": 2},
        "excitation": {"amplitude": between(0.05, 3.0) * EARTH, "direction": "x"},
        "output": {"figures": False},
    }  # fmt: skip


def random_case(index: int, analysis: str) -> dict[str, Any]:
    """Content of the case file of roll ``index`` for an analysis."""
    case = random_roll(index)
    motion = case["excitation"]
    sections = ("geometry", "mandrel", "coil", "mesh")
    roll = RollSections(**{name: case[name] for name in sections})
    low, high = beam_frequency(roll, bonded=False), beam_frequency(roll, bonded=True)
    band = {"f_start": round(0.75 * low, 2), "f_end": round(1.15 * max(low, high), 2)}
    if analysis == "dwell":
        place = np.random.default_rng([SEED, index, 1]).uniform(low, max(low, high))
        motion |= {"kind": "dwell", "frequency": round(place, 2), "cycles": DWELL_CYCLES}
    elif analysis == "backbone":
        del case["excitation"]
        case["backbone"] = {"tip_smallest": 1e-7, "tip_largest": 5e-4}
    else:
        octaves = np.log2(band["f_end"] / band["f_start"])
        seconds = SWEPT_CYCLES / np.sqrt(band["f_start"] * band["f_end"])
        motion |= {"kind": "chirp", **band, "rate_oct_per_min": round(60.0 * octaves / seconds, 3), "ramp_cycles": 10}
    return case | {"analysis": analysis}


class Told(SilentProgress):
    """Progress that keeps the CPU seconds of each stage, messages and warnings."""

    def __init__(self) -> None:
        super().__init__()
        self.seconds: dict[str, float] = {}
        self.lines: list[str] = []

    @contextmanager
    def stage(self, name: str, total: float, unit: str = "") -> Iterator[Told]:
        started = time.process_time()
        try:
            yield self
        finally:
            self.seconds[name] = round(self.seconds.get(name, 0.0) + time.process_time() - started, 2)

    def update(self, done: float, note: str = "", left: float | None = None) -> None:
        """Nothing is shown."""

    def info(self, text: str) -> None:
        """Keep the message."""
        self.lines.append(text)


def solve(index: int, analysis: str) -> dict[str, Any]:
    """Run one case in this process: outcome, cause, stages, readings."""
    told, started = Told(), time.process_time()
    report: dict[str, Any] = {"outcome": "curve", "cause": ""}
    try:
        dataset = run_analysis(build_case(random_case(index, analysis)), progress=told)
        report |= {key: float(dataset.attrs[key]) for key in READINGS if key in dataset.attrs}
    except WrollError as error:
        report |= {"outcome": "told", "cause": str(error), "partial": error.__dict__.get("partial") is not None}
    except Exception as error:  # anything else is a defect, and the table has to show it
        report |= {"outcome": "crash", "cause": f"{type(error).__name__}: {error}"}
    seconds = time.process_time() - started
    if report["outcome"] == "told":
        named = any(words in report["cause"] for words in NAMED)
        report["outcome"] = "stopped" if not named else "told" if seconds <= TOLD else "late"
    return report | {
        "seconds": round(seconds, 2), "stages": told.seconds, "lines": told.lines, "warnings": told.warnings,
    }  # fmt: skip


def in_child(index: int, analysis: str, limit: float) -> dict[str, Any]:
    """Run one case in a child process with a limit of CPU time."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        soft = int(np.ceil(limit + time.process_time()))
        resource.setrlimit(resource.RLIMIT_CPU, (soft, soft + 5))
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        with os.fdopen(writing, "w") as pipe:
            json.dump(solve(index, analysis), pipe)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        text = pipe.read()
    _, status = os.waitpid(child, 0)
    if text:
        return json.loads(text)
    cut = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU
    return {"outcome": "limit" if cut else "crash", "cause": f"status {status}", "seconds": limit}


def row(report: dict[str, Any]) -> str:
    """Line of the table."""
    short = report["cause"].split(";")[0].replace("|", "/")
    return (
        f"| {report['roll']} | {report['analysis']} | {report['seconds']:.1f} | {report['outcome']} | "
        f"{short or ', '.join(f'{k} {report[k]:.4g}' for k in READINGS[:4] if k in report)} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=200, help="number of rolls")
    parser.add_argument("--first", type=int, default=0, help="first roll")
    parser.add_argument("--analyses", nargs="+", choices=ANALYSES, default=list(ANALYSES))
    parser.add_argument("--limit", type=float, default=LIMIT, help="CPU seconds per case")
    parser.add_argument("--out", type=Path, help="file for one JSON report per line; finished cases are skipped")
    parser.add_argument("--print-case", action="store_true", help="print the case of --first as JSON (YAML), no run")
    chosen = parser.parse_args()
    if chosen.print_case:
        print(json.dumps(random_case(chosen.first, chosen.analyses[0]), indent=1))
        return
    warm = load_case(
        Path(__file__).parents[1] / "configs" / "lab_harmonic.yaml", ["mesh={circumferential: 8, axial: 2}"]
    )
    run_analysis(warm, progress=SilentProgress())  # compilation caches and imports, once for all children
    reports = []
    if chosen.out and chosen.out.is_file():
        reports = [json.loads(line) for line in chosen.out.read_text(encoding="utf-8").splitlines()]
    done = {(r["roll"], r["analysis"]) for r in reports}
    print("| roll | analysis | CPU s | outcome | cause, or readings |\n|---|---|---|---|---|")
    for index in range(chosen.first, chosen.first + chosen.count):
        for analysis in chosen.analyses:
            if (index, analysis) in done:
                continue
            report = {"roll": index, "analysis": analysis} | in_child(index, analysis, chosen.limit)
            print(row(report), flush=True)
            reports.append(report)
            if chosen.out:
                with chosen.out.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(report) + "\n")
    for analysis in chosen.analyses:
        outcomes = [r["outcome"] for r in reports if r["analysis"] == analysis]
        counts = ", ".join(f"{outcomes.count(name)} {name}" for name in sorted(set(outcomes)))
        good = sum(name in ("curve", "told") for name in outcomes) / max(len(outcomes), 1)
        print(f"{analysis}: {len(outcomes)} cases, {counts}; {100 * good:.1f} % end well")
    sys.exit(0)


if __name__ == "__main__":
    main()
