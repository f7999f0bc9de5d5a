"""Time every method on the lab chirp, compare their results, and write docs/tables/benchmark.md: `make bench`.

Each method runs in a fresh process on one core with warm compilation caches (a tiny run of each comes first).

* Whole chirp, 14.56 s at the thesis's density of steps: `condensed`, `reduced`, `harmonic`; errors against `condensed`.
* `full` solves the whole structure in every step and would take hours: it runs a window, a dwell at resonance of a few
  hundred steps, which the others run too for their errors against it. Its time for the chirp is the measured time per
  step x number of steps, and is called that.
* The same chirp with the program's default steps, and on a mesh that resolves the shear lag.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
CASE = ROOT / "configs" / "lab_sweep.yaml"
SOURCE_HOURS = (50.0, 100.0)
"""CPU hours of one sweep that the thesis states, on a server of its own."""

AROUND, ALONG = 30, 10
"""Elements of the lab job, around and along the height; each row of elements has two rows of contact points."""

MESH = f"mesh={{circumferential: {AROUND}, axial: {ALONG}, grading: 3}}"
FINE = "mesh={circumferential: 60, axial: 30, grading: 3}"
SOURCE_STEPS = ("integrator.steps_per_cycle=19", "solver.allow_coarse=true")  # 21.8 at 153 Hz, as the thesis
WINDOW_CYCLES = 10
METHODS = ("full", "condensed", "reduced", "harmonic")


@dataclass(frozen=True)
class Job:
    """One process: name of its files, method, and changes of the case."""

    name: str
    method: str
    changes: tuple[str, ...]

    @property
    def words(self) -> list[str]:
        """Overrides of the case file."""
        chosen = "analysis=harmonic" if self.method == "harmonic" else f"solver.method={self.method}"
        return [chosen, *self.changes]


def window(cycles: int) -> tuple[str, ...]:
    """Dwell at the resonance of the lab chirp, 22 steps per cycle: the steps of the chirp."""
    dwell = f"{{kind: dwell, amplitude: 5.0, frequency: 153, cycles: {cycles}, ramp_cycles: 2}}"
    return ("analysis=dwell", f"excitation={dwell}", "integrator.steps_per_cycle=22", MESH)


def jobs(cycles: int, methods: list[str]) -> list[Job]:
    """Everything that is timed, in order."""
    chirp = (*SOURCE_STEPS, MESH)
    planned = [Job(f"window-{m}", m, window(cycles)) for m in ("full", "condensed", "reduced")]
    planned += [Job(f"chirp-{m}", m, chirp) for m in ("condensed", "reduced", "harmonic")]
    planned += [Job(f"default-{m}", m, (MESH,)) for m in ("condensed", "reduced")]
    planned += [Job(f"fine-{m}", m, (*SOURCE_STEPS, FINE)) for m in ("reduced", "harmonic")]
    return [job for job in planned if job.method in methods]


def warm_up(methods: list[str]) -> list[Job]:
    """Tiny runs that fill the caches of compiled forms and loops."""
    small = "mesh={circumferential: 12, axial: 4}"
    dwell = ("analysis=dwell", "excitation={kind: dwell, amplitude: 5.0, frequency: 150, cycles: 3, ramp_cycles: 1}")
    return [Job(f"warm-{m}", m, (small,) if m == "harmonic" else (*dwell, small)) for m in methods]


def run(job: Job, folder: Path) -> dict | None:
    """Report of a job's process; None (and a line) when it failed."""
    stem = folder / job.name
    stem.with_suffix(".json").unlink(missing_ok=True)
    command = [sys.executable, str(Path(__file__).with_name("job.py")), str(CASE), str(stem), *job.words]
    started = time.monotonic()
    done = subprocess.run(
        command, env=os.environ | {"OMP_NUM_THREADS": "1"}, capture_output=True, text=True, check=False
    )
    if done.returncode:
        reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
        print(f"{job.name:<18} failed: {reason}", flush=True)
        return None
    report = json.loads(stem.with_suffix(".json").read_text(encoding="utf-8"))
    wall = time.monotonic() - started
    print(
        f"{job.name:<18} set-up {report['set_up_cpu_s']:6.1f} s  loop {report['loop_cpu_s']:7.1f} s CPU  "
        f"{report['peak_memory_mb']:5.0f} MB  (wall {wall:.0f} s)", flush=True,
    )  # fmt: skip
    return report


# ---- the table ------------------------------------------------------------------------------------------------------


def percent(value: float | None) -> str:
    """Relative error in per cent with two digits; a dash for none."""
    if value is None:
        return "–"
    return "0" if value == 0.0 else f"{100 * value:.2g} %"


def history_errors(folder: Path, name: str, reference: str) -> tuple[float | None, float | None]:
    """Largest difference of the tip over its largest displacement, and relative difference of the friction work."""
    import numpy as np

    files = [folder / f"{stem}.npz" for stem in (name, reference)]
    if name == reference or not all(file.is_file() for file in files):
        return None, None
    one, other = (np.load(file) for file in files)
    tip = float(np.abs(one["tip"] - other["tip"]).max() / np.abs(other["tip"]).max())
    return tip, abs(float(one["friction"][-1] / other["friction"][-1]) - 1.0)


def reading_errors(report: dict, reference: dict | None) -> list[str]:
    """Relative differences of f_n, peak and zeta."""
    keys = ("f_n_hz", "peak_transmissibility", "zeta")
    if reference is None or reference is report:
        return ["–"] * 3
    return [percent(abs(report[k] / reference[k] - 1.0)) if k in report and k in reference else "–" for k in keys]


def hours(seconds: float) -> str:
    """Time in s, min or h."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"


def against_source(seconds: float) -> str:
    """How many times less than the thesis's hours."""
    return " to ".join(f"{three(3600 * stated / seconds)}" for stated in SOURCE_HOURS)


def three(value: float) -> str:
    """Three digits, thousands apart."""
    return f"{float(f'{value:.3g}'):,.0f}" if value >= 100 else f"{value:.3g}"


def cost_row(label: str, report: dict, full: float | None) -> str:
    """Line of the first table."""
    steps = report.get("steps")
    total = report["total_cpu_s"]
    cells = [
        label, f"{report['set_up_cpu_s']:.1f} s", f"{report['loop_cpu_s']:.1f} s", f"{total:.1f} s",
        three(steps / report["loop_cpu_s"]) if steps else "–", f"{report['peak_memory_mb']:.0f} MB",
        three(full / total) if full else "–", against_source(total),
    ]  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def tables(reports: dict[str, dict], folder: Path) -> str:
    """Text of docs/tables/benchmark.md."""
    chirp, window_full = reports.get("chirp-condensed"), reports.get("window-full")
    steps = next((r["steps"] for name, r in reports.items() if name.startswith("chirp") and "steps" in r), None)
    full = None
    if window_full and steps:
        per_step = window_full["loop_cpu_s"] / window_full["steps"]
        full = window_full["set_up_cpu_s"] + per_step * steps
    lines = [
        f"CPU seconds on one core ({machine()}); each method in a fresh process, compilation caches warm.",
        "Set-up includes imports, mesh, matrices, preload, condensation and the damping estimate; the loop of",
        "`reduced` and `harmonic` includes their training. The last column compares with the 50 to 100 CPU hours that",
        "the thesis states for one sweep **on another machine with another program**: an order of magnitude, no more.",
        "",
        "| method | set-up | loop | total | steps/s | peak memory | faster than full by | faster than the thesis by |",
        "|---|---|---|---|---|---|---|---|",
    ]
    if full is not None:
        n = int(window_full["steps"])
        cells = [
            "`full`, extrapolated*", f"{window_full['set_up_cpu_s']:.1f} s", f"*{hours(full)}*", f"*{hours(full)}*",
            f"{window_full['steps'] / window_full['loop_cpu_s']:,.1f}", f"{window_full['peak_memory_mb']:.0f} MB", "1",
            against_source(full),
        ]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    names = {
        "chirp-condensed": "`condensed`", "chirp-reduced": "`reduced`", "chirp-harmonic": "`harmonic`",
        "default-condensed": "`condensed`, default steps", "default-reduced": "`reduced`, default steps",
        "fine-reduced": "`reduced`, 60 x 30 mesh", "fine-harmonic": "`harmonic`, 60 x 30 mesh",
    }  # fmt: skip
    for name, label in names.items():
        if name in reports:
            lines.append(cost_row(label, reports[name], full if name.startswith("chirp") else None))
    if full is None:
        lines += ["", "`full` was not timed in this run: its columns are empty."]
    if full is not None:
        lines += [
            "",
            f"\\* {n} steps of a dwell at resonance were measured, {1e3 * per_step:.0f} ms each; the chirp is that",
            f"times {int(steps):,} steps. `full` solves the whole circumference, the others use the symmetry plane.",
        ]
    if chirp:
        half = int(chirp["interface_points"])
        lines += [
            "",
            f"Lab roll of `configs/lab_sweep.yaml` on a {AROUND} x {ALONG} mesh ({2 * AROUND * ALONG} contact points",
            f"around, {half} with the symmetry plane), {int(chirp['steps']):,} steps as dense as in the thesis; the",
            "default integrator takes 40 steps per cycle at 175 Hz. Errors, each relative to the reference:",
        ]
    lines += [
        "",
        "| method | tip, window, against full | friction work, window | tip, chirp, against condensed | friction work |"
        " f_n | peak | zeta |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, label in list(names.items())[:5]:
        if name not in reports:
            continue
        kind, method = name.split("-")
        window = history_errors(folder, f"window-{method}", "window-full") if kind == "chirp" else (None, None)
        near = [percent(error) for error in window]
        reference = f"{kind}-condensed"
        whole = [percent(e) for e in history_errors(folder, name, reference)]
        cells = [label, *near, *whole, *reading_errors(reports[name], reports.get(reference))]
        lines.append("| " + " | ".join(cells) + " |")
    if "chirp-harmonic" in reports:
        cells = reading_errors(reports["chirp-harmonic"], reports.get("default-condensed"))
        lines += [
            "| `harmonic`, against the default steps | " + " | ".join(["–"] * 4 + cells) + " |",
            "",
            "`harmonic` is the steady state; a chirp differs by its rate and by the integrator, whose steps, when as",
            "dense as in the thesis, lengthen the period.",
        ]
    return "\n".join(lines) + "\n"


def machine() -> str:
    """Processor, Python, date."""
    model = platform.processor()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        found = [
            line.split(":", 1)[1].strip() for line in cpuinfo.read_text().splitlines() if line.startswith("model name")
        ]
        model = found[0] if found else model
    return f"{model or platform.machine()}, Python {platform.python_version()}, {time.strftime('%Y-%m-%d')}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "tables" / "benchmark.md", help="table to write")
    parser.add_argument(
        "--work", type=Path, default=ROOT / "runs" / "benchmark", help="folder for reports and histories"
    )
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    parser.add_argument("--window-cycles", type=int, default=WINDOW_CYCLES, help="length of the dwell that full runs")
    parser.add_argument("--table-only", action="store_true", help="write the table again from the reports in --work")
    chosen = parser.parse_args()
    chosen.work.mkdir(parents=True, exist_ok=True)
    planned = jobs(chosen.window_cycles, chosen.methods)
    if chosen.table_only:
        found = {job.name: chosen.work / f"{job.name}.json" for job in planned}
        reports = {name: json.loads(file.read_text()) for name, file in found.items() if file.is_file()}
    else:
        for job in warm_up(chosen.methods):
            run(job, chosen.work)
        reports = {job.name: report for job in planned if (report := run(job, chosen.work)) is not None}
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    chosen.out.write_text(tables(reports, chosen.work), encoding="utf-8")
    print(chosen.out)
    if len(reports) < len(planned):
        sys.exit(f"{len(planned) - len(reports)} of {len(planned)} jobs failed or are missing")


if __name__ == "__main__":
    main()
