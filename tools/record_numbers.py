"""Record of the numbers: run fixed coarse cases, keep every number, and compare two records.

    .venv/bin/python tools/record_numbers.py run RECORD.json [--code CHECKOUT] [--workers 2] [--only NAME ...]
    .venv/bin/python tools/record_numbers.py compare BEFORE.json AFTER.json [--tolerance 1e-12]

One case per analysis, solver method, friction law, coil model and way of reading damping. The cases go through the
command line and the case file alone, so a record of any checkout can be taken (`--code`). A record holds every entry
of summary.json and, for each variable and number attribute of results.nc, a checksum and four sums. `compare` counts
the values and lists those that differ by more than the tolerance, relative to the entry's size.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]

QUIET = "output.figures=false"
COARSE = ["mesh.circumferential=12", "mesh.axial=6", "mesh.grading=2", QUIET]
CHIRP = ["excitation.f_start=148", "excitation.f_end=158", "excitation.rate_oct_per_min=20", "excitation.ramp_cycles=5"]
DWELL = ["excitation.cycles=8", "excitation.ramp_cycles=2", "excitation.amplitude=20"]
FULL = ["solver.method=full", "excitation.cycles=3", "mesh.axial=4"]
LOW = ["excitation.amplitude=9.8", "preload.pressure=1.0e3"]
SHORT = [*COARSE, *CHIRP]
PERIODIC = [*COARSE, "harmonic.harmonics=3", "excitation.f_start=140", "excitation.f_end=165"]
COIL = ["mesh.circumferential=12", "mesh.axial=6", "mesh.radial=2", QUIET]
_TABLE = "{slip_rate: [0, 1.0e-3], mu: [0.25, 0.35]}"
RATE = [f"contact.friction={{law: rate_coulomb, elastic_slip: 1.0e-6, rate_table: {_TABLE}}}"]
SMOOTH = ["contact.friction={law: smoothed_coulomb, mu: 0.25, reference_speed: 1.0e-3}"]

CASES: dict[str, tuple[str, list[str]]] = {
    "sweep_reduced": ("lab_sweep", SHORT),
    "sweep_condensed": ("lab_sweep", [*SHORT, "solver.method=condensed"]),
    "sweep_clamped": ("lab_sweep_clamped", SHORT),
    "sweep_rate": ("lab_sweep_rate", SHORT),
    "sweep_dissipative": ("lab_integrators", [*SHORT, "integrator.steps_per_cycle=22"]),
    "sweep_gaussian": ("lab_sweep", [*SHORT, "output.damping=gaussian_fit"]),
    "sweep_bonded": ("lab_sweep", [*SHORT, "coil.model=bonded"]),
    "sweep_mass": ("lab_sweep", [*SHORT, "coil.model=nonstructural_mass"]),
    "sweep_winding": ("winding_sweep", SHORT),
    "sweep_structure": ("oscillator", [QUIET]),
    "dwell_full": ("lab_dwell", [*COARSE, *DWELL, *FULL, "excitation.cycles=4"]),
    "dwell_condensed": ("lab_dwell", [*COARSE, *DWELL, "solver.method=condensed", "output.every=80"]),
    "dwell_reduced": ("lab_dwell", [*COARSE, *DWELL]),
    "dwell_whole_roll": ("lab_dwell", [*COARSE, *DWELL, "excitation.direction=y", "solver.method=condensed"]),
    "dwell_smoothed": ("lab_dwell", [*COARSE, *DWELL, *SMOOTH, "solver.method=condensed"]),
    "dwell_smoothed_full": ("lab_dwell", [*COARSE, *DWELL, *SMOOTH, *FULL]),
    "dwell_rate_full": ("lab_dwell", [*COARSE, *DWELL, *RATE, *FULL]),
    "dwell_opening": ("lab_dwell_layers", [*COARSE, *DWELL, "solver.method=condensed", "excitation.amplitude=9.8"]),
    "dwell_opening_reduced": ("lab_dwell_layers", [*COARSE, *DWELL, *LOW]),
    "harmonic": ("lab_harmonic", PERIODIC),
    "harmonic_rate": ("lab_harmonic", [*PERIODIC, *RATE]),
    "harmonic_smoothed": ("oscillator", ["analysis=harmonic", "excitation.amplitude=3", QUIET, *SMOOTH]),
    "harmonic_rational": ("lab_harmonic", [*PERIODIC, "output.damping=rational_fraction"]),
    "backbone": ("lab_backbone", COARSE),
    "modal_bonded": ("lab_modal", COARSE),
    "modal_stuck": ("lab_modal", [*COARSE, "modal.interface=stuck"]),
    "modal_frictionless": ("lab_modal", [*COARSE, "modal.interface=frictionless"]),
    "modal_mandrel": ("lab_mandrel", COARSE),
    "modal_solid": ("coiled_stiff", COIL),
    "modal_fourier": ("coiled_stiff", [*COIL, "mesh.discretisation=fourier"]),
    "modal_transient": ("case_study", COIL),
    "modal_transient_fourier": ("case_study", [*COIL, "mesh.discretisation=fourier"]),
    "preload": ("lab_dwell", [*COARSE, "analysis=preload"]),
    "preload_layers": ("lab_dwell_layers", [*COARSE, "analysis=preload"]),
    "preload_winding": ("winding_sweep", [*COARSE, "analysis=preload"]),
    "winding": ("winding_case_study", [QUIET]),
    "winding_newton": ("winding_lab", [QUIET]),
    "design_map": (
        "design_map",
        ["design_map.mandrel_radius=[0.03, 0.04]", "design_map.mandrel_thickness=[1.5e-3, 2.0e-3]", QUIET],
    ),
    "two_dof": ("two_dof", ["two_dof.omega.points=60", QUIET]),
    "two_dof_space": (
        "two_dof_design_space",
        ["two_dof.omega.points=40", "two_dof.design_space.m2.points=3", "two_dof.design_space.k2.points=3", QUIET],
    ),
}  # fmt: skip
"""Name of a record's entry -> case file in configs/ and its overrides."""

CLOCKS = ("wall_time_s", "solver_time_s", "setup_time_s", "training_time_s")
"""Entries that depend on the machine."""
NOT_NUMBERS = {"provenance", "case_yaml", "case_hash"}
PROGRAM = "from wroll_fem.cli import main; main()"


def run_one(name: str, code: Path, folder: Path) -> dict[str, Any]:
    """Run a case in its own process; its summary and results, or how it failed."""
    config, overrides = CASES[name]
    command = [sys.executable, "-c", PROGRAM, "run", f"configs/{config}.yaml", "--out", str(folder / name)]
    command += [word for text in overrides for word in ("--set", text)]
    environment = os.environ | {"PYTHONPATH": str(code), "OMP_NUM_THREADS": "1", "TERM": "dumb"}
    done = subprocess.run(command, cwd=code, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        return {"exit": done.returncode, "error": done.stderr.strip().splitlines()[-1:]}
    summary = json.loads((folder / name / "summary.json").read_text())
    fields = sorted((folder / name / "fields").glob("*"))
    return {
        "exit": 0,
        "summary": {key: value for key, value in summary.items() if key not in CLOCKS},
        "results": digest(folder / name / "results.nc"),
        "fields": [path.name for path in fields],
    }


def digest(path: Path) -> dict[str, Any]:
    """Checksum and sums of every variable and number attribute."""
    import numpy as np
    import xarray as xr

    found: dict[str, Any] = {}
    with xr.open_dataset(path, engine="h5netcdf") as data:
        for name in sorted(map(str, data.variables)):
            values = np.ascontiguousarray(data[name].values)
            entry: dict[str, Any] = {
                "shape": list(values.shape),
                "sha256": hashlib.sha256(values.tobytes()).hexdigest(),
            }
            if values.dtype.kind in "fiub" and values.size:
                x = np.nan_to_num(values.astype(float).ravel())
                weight = np.cos(np.arange(x.size))
                entry["sums"] = [
                    float(np.abs(x).sum()),
                    float(np.abs(x).max()),
                    float(x @ x),
                    float(np.abs(x) @ weight),
                ]
            elif values.dtype.kind == "O":
                entry["sha256"] = hashlib.sha256(repr(values.tolist()).encode()).hexdigest()
            found[name] = entry
        attributes = {k: v for k, v in data.attrs.items() if k not in NOT_NUMBERS and k not in CLOCKS}
        for key, value in sorted(attributes.items()):
            found[f"@{key}"] = np.asarray(value).tolist()
    return found


def difference(before: Any, after: Any, where: str, tolerance: float, told: list[str]) -> int:
    """Count the values compared; what differs goes to ``told``."""
    if isinstance(before, dict) and isinstance(after, dict):
        if "sha256" in before and before["sha256"] == after.get("sha256"):
            return 1
        count = 0
        for key in sorted(before.keys() | after.keys()):
            if key == "sha256" and "sums" in before and "sums" in after:
                continue
            if key not in before or key not in after:
                told.append(f"{where}.{key}: only {'after' if key not in before else 'before'}")
            else:
                count += difference(before[key], after[key], f"{where}.{key}", tolerance, told)
        return count
    if isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        return sum(
            difference(a, b, f"{where}[{k}]", tolerance, told)
            for k, (a, b) in enumerate(zip(before, after, strict=True))
        )
    numbers = isinstance(before, int | float) and isinstance(after, int | float)
    if numbers and not isinstance(before, bool):
        if not (math.isclose(before, after, rel_tol=tolerance) or (math.isnan(before) and math.isnan(after))):
            told.append(f"{where}: {before!r} -> {after!r}")
    elif before != after:
        told.append(f"{where}: {before!r} -> {after!r}")
    return 1


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="take a record")
    run.add_argument("record", type=Path)
    run.add_argument("--code", type=Path, default=ROOT, help="checkout to run; default: this one")
    run.add_argument("--workers", type=int, default=2)
    run.add_argument("--only", nargs="*", default=list(CASES), choices=list(CASES))
    run.add_argument("--folder", type=Path, help="keep the run folders here")
    compare = commands.add_parser("compare", help="compare two records")
    compare.add_argument("before", type=Path)
    compare.add_argument("after", type=Path)
    compare.add_argument("--tolerance", type=float, default=1e-12)
    asked = parser.parse_args()
    if asked.command == "run":
        with tempfile.TemporaryDirectory() as spare, ThreadPoolExecutor(asked.workers) as pool:
            folder = (asked.folder or Path(spare)).resolve()
            code = asked.code.resolve()
            entries = list(pool.map(lambda name: run_one(name, code, folder), asked.only))
        record = dict(zip(asked.only, entries, strict=True))
        asked.record.write_text(json.dumps(record, indent=1, sort_keys=True))
        failed = {name: entry for name, entry in record.items() if entry["exit"]}
        for name, entry in failed.items():
            print(f"{name}: exit {entry['exit']}: {' '.join(entry['error'])}")
        print(f"{asked.record}: {len(record)} cases, {len(failed)} failed")
        return
    before, after = (json.loads(path.read_text()) for path in (asked.before, asked.after))
    common = [name for name in before if name in after]
    told: list[str] = []
    count = sum(difference(before[name], after[name], name, asked.tolerance, told) for name in common)
    for line in told:
        print(line)
    print(f"{len(common)} cases, {count} values compared, {len(told)} differ (tolerance {asked.tolerance:g})")
    raise SystemExit(bool(told))


if __name__ == "__main__":
    main()
