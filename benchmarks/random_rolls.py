"""Random rolls through every vibration analysis: seconds, outcome and cause of each, in a table.

Usage: python benchmarks/random_rolls.py [--count N] [--first I] [--analyses harmonic ...] [--limit S] [--out FILE]
       python benchmarks/random_rolls.py --page docs/tables/random_rolls.md --read FILE [FILE ...]

Roll I is the same in every run and on every machine: its numbers come from the generator seeded with (SEED, I). Each
case runs in a process of its own, on one core, and is stopped at a limit of CPU seconds. Seconds include mesh, preload
and modes, not the imports. Outcomes:

* `curve`: a result within the limit;
* `told`: no result, and a message that names the cause within `TOLD` seconds;
* `late`: such a message after that;
* `stopped`: a message without a cause;
* `limit`: stopped at the limit; `crash`: any other end.

`slow` is a sweep over the resonance of the roll's harmonic curve, at a fifth of the rate that ISO 7626-2 allows for its
zeta and at two fifths of the rate for its steeper flank, whichever is lower, and at most `SLOW_CYCLES` long. It runs
where `harmonic` found both half-power points. `roll_agreement` compares all with `harmonic`.

Lengths, thicknesses, moduli, tip mass, gamma*, pressure, friction and excitation are log-uniform in the ranges below;
the band of frequencies covers the estimates of the frictionless and the bonded resonance.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
from roll_agreement import agreement_lines, outcome_lines, quality_lines

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.analyses.forecasts.slip import slip_warnings
from wroll_fem.case.loader import build_case
from wroll_fem.case.roll import RollSections
from wroll_fem.errors import WrollError
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.base_motion import sweep_rate_limit

SEED = 12
LIMIT, TOLD = 60.0, 15.0
"""CPU seconds after which a case is stopped, and within which the cause of a failure has to be told."""

ANALYSES = ("harmonic", "backbone", "sweep", "dwell", "slow")
NAMED = ("surfaces open at", "undetermined", "unbounded", "internal resonance")
"""Words of the messages that name the cause why there is no result."""

TARGET = 200
QUICK = 10  # a roll whose analyses take a second each
EARTH = 9.80665  # m/s^2
SWEPT_CYCLES, DWELL_CYCLES, SLOW_CYCLES = 600, 100, 6000
SLOW_SHARE, SLOW_FLANK, SLOW_WIDTHS = 0.2, 0.4, 2.5
"""Rate of a slow sweep over that of ISO 7626-2, and how far it reaches from the resonance, in half-power distances."""

READINGS = (
    "f_n_hz", "zeta_apparent", "peak_transmissibility", "zeta_max", "zeta_spread", "stuck_resonance_hz",
    "tip_participation", "steady_magnitude", "energy_balance_error",
    "reduction_error_estimate", "time_step_error", "half_power_low_hz", "half_power_high_hz", "frequency_hz", "steps",
)  # fmt: skip


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


def slow_sweep(harmonic: dict[str, Any]) -> dict[str, Any] | None:
    """Excitation of a slow sweep over the resonance that a harmonic curve has found; None without one."""
    low, f_n, high, zeta = (
        harmonic.get(key, np.nan) for key in ("half_power_low_hz", "f_n_hz", "half_power_high_hz", "zeta_apparent")
    )
    if not np.isfinite([low, f_n, high, zeta]).all():
        return None
    width, flank = high - low, min(f_n - low, high - f_n) / f_n
    start, end = max(f_n - SLOW_WIDTHS * width, 0.3 * f_n), f_n + SLOW_WIDTHS * width
    octaves = float(np.log2(end / start))
    fewest = 60.0 * octaves * f_n / SLOW_CYCLES  # oct/min
    slow = min(SLOW_SHARE * sweep_rate_limit(f_n, zeta), SLOW_FLANK * sweep_rate_limit(f_n, flank))
    rate = max(slow, fewest)
    return {
        "kind": "chirp", "f_start": round(start, 3), "f_end": round(end, 3), "rate_oct_per_min": float(f"{rate:.3g}"),
        "ramp_cycles": 10,
    }  # fmt: skip


def random_case(index: int, analysis: str, harmonic: dict[str, Any] | None = None) -> dict[str, Any]:
    """Content of the case file of roll ``index`` for an analysis; a slow sweep needs the report of `harmonic`."""
    case = random_roll(index)
    motion = case["excitation"]
    sections = ("geometry", "mandrel", "coil", "mesh")
    roll = RollSections(**{name: case[name] for name in sections})
    low, high = beam_frequency(roll, bonded=False), beam_frequency(roll, bonded=True)
    band = {"f_start": round(0.75 * low, 2), "f_end": round(1.15 * max(low, high), 2)}
    if analysis == "slow":
        motion |= slow_sweep(harmonic or {}) or {}
        return case | {"analysis": "sweep"}
    if analysis == "dwell":
        place = np.random.default_rng([SEED, index, 1]).uniform(low, max(low, high))
        motion |= {"kind": "dwell", "frequency": round(place, 2), "cycles": DWELL_CYCLES, "ramp_cycles": 20}
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


def solve(index: int, analysis: str, harmonic: dict[str, Any] | None) -> dict[str, Any]:
    """Run one case in this process: outcome, cause, stages, readings."""
    told, started = Told(), time.process_time()
    report: dict[str, Any] = {"outcome": "curve", "cause": ""}
    try:
        dataset = run_analysis(build_case(random_case(index, analysis, harmonic)), progress=told)
        report |= {key: float(dataset.attrs[key]) for key in READINGS if key in dataset.attrs}
        report |= {key: str(dataset.attrs[key]) for key in ("zeta_quality", "zeta_doubts") if key in dataset.attrs}
        told.warnings = [text for text in str(dataset.attrs.get("warnings", "")).split("\n") if text]
        if analysis == "harmonic":
            size = np.hypot(dataset["transmissibility_real"].values, dataset["transmissibility_imag"].values)
            report |= {"curve_hz": dataset["frequency"].values.tolist(), "curve_magnitude": size.tolist()}
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


def in_child(index: int, analysis: str, limit: float, harmonic: dict[str, Any] | None = None) -> dict[str, Any]:
    """Run one case in a child process with a limit of CPU time."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        soft = int(np.ceil(limit + time.process_time()))
        resource.setrlimit(resource.RLIMIT_CPU, (soft, soft + 5))
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        with os.fdopen(writing, "w") as pipe:
            json.dump(solve(index, analysis, harmonic), pipe)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        text = pipe.read()
    _, status = os.waitpid(child, 0)
    if text:
        return json.loads(text)
    cut = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU
    cause = f"not finished in {limit:.0f} CPU s" if cut else f"status {status}"
    return {"outcome": "limit" if cut else "crash", "cause": cause, "seconds": limit}


def row(report: dict[str, Any]) -> str:
    """Line of the table."""
    parts = report["cause"].replace("|", "/").split("; ")
    short = parts[1].split(":")[0] if len(parts) > 1 and report["outcome"] in ("told", "late") else parts[0]
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
    parser.add_argument("--read", nargs="+", type=Path, default=[], help="further files of reports, for the tables")
    parser.add_argument("--page", type=Path, help="write the tables of the reports to this page; no run")
    parser.add_argument("--print-case", action="store_true", help="print the case of --first as JSON (YAML), no run")
    chosen = parser.parse_args()
    if chosen.print_case:
        print(json.dumps(random_case(chosen.first, chosen.analyses[0]), indent=1))
        return
    reports = [r for path in [*chosen.read, chosen.out] if path and path.is_file() for r in read_reports(path)]
    if chosen.page:
        chosen.page.write_text("\n".join(page(reports)) + "\n", encoding="utf-8")
        return
    for analysis in ANALYSES[:4]:  # compilation caches and imports, once for all children
        run_analysis(build_case(random_case(QUICK, analysis)), progress=Told())
    exact = random_case(QUICK, "dwell") | {"solver": {"method": "condensed"}}  # the method that `reduced` falls back to
    run_analysis(build_case(exact), progress=Told())
    found = {(r["roll"], r["analysis"]): r for r in reports}
    print("| roll | analysis | CPU s | outcome | cause, or readings |\n|---|---|---|---|---|")
    for index in range(chosen.first, chosen.first + chosen.count):
        for analysis in chosen.analyses:
            harmonic = found.get((index, "harmonic"))
            if (index, analysis) in found or (analysis == "slow" and slow_sweep(harmonic or {}) is None):
                continue
            report = {"roll": index, "analysis": analysis} | in_child(index, analysis, chosen.limit, harmonic)
            print(row(report), flush=True)
            found[index, analysis] = report
            if chosen.out:
                with chosen.out.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(report) + "\n")
    print("\n".join([*outcome_lines(found.values(), ANALYSES), "", *agreement_lines(found.values())]))
    print("\n".join(["", *quality_lines(found.values())]))


def forecast_lines(reports: list[dict[str, Any]]) -> list[str]:
    """Table of the forecast of slip that a run prints before it starts, against what harmonic balance found."""
    kinds = {"clamped": "clamped at the base", "hardly": "will hardly slip", "gross": "expect gross slip", "": "none"}
    found = {kind: dict.fromkeys(("bounded", "unbounded", "opens or slides"), 0) for kind in kinds}
    for report in reports:
        if report["analysis"] != "harmonic":
            continue
        texts = "\n".join(slip_warnings(build_case(random_case(report["roll"], "harmonic"))))
        kind = next(kind for kind, words in kinds.items() if words in texts or not kind)
        unbounded = "grows beyond" in "\n".join([*report.get("warnings", ()), report["cause"]])
        curve = "bounded" if report["outcome"] == "curve" else "opens or slides"
        found[kind]["unbounded" if unbounded else curve] += 1
    head = [
        "| forecast of slip | bounded resonance | beyond 500 times the base | no motion found |",
        "|---|---|---|---|",
    ]
    return head + [f"| {words} | " + " | ".join(map(str, found[kind].values())) + " |" for kind, words in kinds.items()]


def read_reports(path: Path) -> list[dict[str, Any]]:
    """Reports of a file of JSON lines."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def ranges(numbers: set[int]) -> str:
    """Numbers as ranges, "0-11, 45"."""
    first = sorted(n for n in numbers if n - 1 not in numbers)
    last = sorted(n for n in numbers if n + 1 not in numbers)
    return ", ".join(f"{a}" if a == b else f"{a}-{b}" for a, b in zip(first, last, strict=True))


def page(reports: list[dict[str, Any]]) -> list[str]:
    """Lines of the page: what was run, outcomes, agreement, and the causes of cases without a result."""
    rolls = {r["roll"] for r in reports}
    slow = {r["roll"] for r in reports if r["analysis"] == "slow"}
    readable = {r["roll"] for r in reports if r["analysis"] == "harmonic" and slow_sweep(r) is not None}
    failed = sorted((r for r in reports if r["outcome"] != "curve"), key=lambda r: (r["roll"], r["analysis"]))
    return [
        f"{len(rolls)} random valid rolls (numbers {ranges(rolls)}), of {TARGET} from the generator (seed {SEED}):",
        "1 to 4 layers, all bases and tips, 5 to 200 kPa, friction 0.05 to 1, 0.05 to 3 g, 14 x 7 cells.",
        "Limit of 60 CPU s per case (slow sweeps: `--limit 600`),",
        "mesh, preload and modes included; `told` is a failure whose cause was printed within 15 CPU s, `late` one",
        "whose cause came after that, `stopped` one without. Computed by",
        "`.venv/bin/python benchmarks/random_rolls.py --out FILE`, and this page from FILE by",
        "`.venv/bin/python benchmarks/random_rolls.py --page docs/tables/random_rolls.md --read FILE`.",
        "",
        *outcome_lines(reports, ANALYSES),
        "",
        "Sweep and harmonic agree when f_n differs by at most 1 % and the peak by at most 5 %, dwell and harmonic",
        "when the magnitude at the dwell's frequency differs by at most 5 %. A slow sweep runs at a fifth of the rate",
        "of ISO 7626-2 for the zeta of the harmonic curve and at two fifths of the rate for its steeper flank,",
        f"whichever is lower, or as fast as {SLOW_CYCLES} cycles ask for; it was run for {len(slow)} of the",
        f"{len(readable)} rolls that have such a curve (numbers {ranges(slow)}).",
        "",
        *agreement_lines(reports),
        "",
        "Quality of zeta (`zeta_quality`), and how far the sweeps differ from harmonic balance. Both ok: at most 10 %.",
        "",
        *quality_lines(reports),
        "",
        "Forecast of slip, as `wroll validate` prints it, and what harmonic balance found:",
        "",
        *forecast_lines(reports),
        "",
        "Cases without a curve:",
        "",
        "| roll | analysis | CPU s | outcome | cause |",
        "|---|---|---|---|---|",
        *(row(report) for report in failed),
    ]


if __name__ == "__main__":
    main()
