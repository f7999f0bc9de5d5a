"""Shear tests: capacity, stiffness and modulus, hysteresis loops, coefficient over slip rate (thesis, appendix E)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wroll_fem.lab.kinds import Figure, Kind
from wroll_fem.lab.result import LabResult
from wroll_fem.lab.shear.dataset import record_dataset, shear_summary
from wroll_fem.lab.shear.evaluation import measured
from wroll_fem.lab.shear.reading import read_all
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.lab.shear.settings import ShearSettings
from wroll_fem.progress import Progress

DRAW = "wroll_fem.plotting.laboratory.shear"


def shear(files: Sequence[Path], settings: ShearSettings, progress: Progress) -> LabResult:
    """Evaluate records of shear tests; each file is one trial."""
    reads, fixture = read_all(files, settings, progress)
    found = []
    with progress.stage("evaluation", len(reads)) as stage:
        for k, read in enumerate(reads, start=1):
            found.append(measured(read, fixture, settings))
            for text in found[-1].doubts:
                progress.warning(text)
            stage.update(k)
    data = record_dataset(found, settings.area, settings.thickness)
    return LabResult(shear_summary(found, settings.area, settings.thickness), data)


def write_csv(path: Path, record: ShearRecord) -> Path:
    """Write a record as CSV: time in s, displacement in um, force in N."""
    columns = np.column_stack([record.time, 1e6 * record.displacement, record.force])
    np.savetxt(path, columns, delimiter=",", header="time,displacement,force", comments="", fmt="%.9g")
    return path


def example(folder: Path) -> list[Path]:
    """Write two ramps of 4 layers at two preloads, loops of one interface, and velocity steps.

    Truth: mu = 0.25, gamma* = 1 um in the ramps; fixture of 2e7 N/m in the ramps, with the record of a rigid specimen.
    """
    from wroll_fem.lab.shear.simulated import ramp, rigid, sine_loops, velocity_steps
    from wroll_fem.tribology import RateAndState, ShearTest

    rng = np.random.default_rng(1)
    tests = [ShearTest(interfaces=5, normal_force=force) for force in (100.0, 200.0)]
    files = [write_csv(folder / "rigid.csv", rigid(2e7, rng))]
    files += [
        write_csv(folder / f"ramp_{t.normal_force:.0f}N.csv", ramp(t, rng, fixture=2e7, drop=drop))
        for t, drop in zip(tests, (0.0, 4.0), strict=True)
    ]
    files.append(write_csv(folder / "loops.csv", sine_loops(lambda speed: 0.25 + 0.0 * speed, rng, fixture=2e7)))
    files.append(write_csv(folder / "steps.csv", velocity_steps(RateAndState(), rng, fixture=2e7)))
    text = (
        "units: {displacement: um, force: N}\n"
        "normal_force: [100, 200, 200, 200] # N\n"
        "rigid: rigid.csv\n"
        f"area: {tests[0].area} # m^2\n"
        f"thickness: {tests[0].thickness} # m, 4 layers and half of each film on platen and piston\n"
        "skip: 0.5e-3 # m\n"
    )
    (folder / "settings.yaml").write_text(text, encoding="utf-8")
    return files[1:]


KIND = Kind(
    settings=ShearSettings,
    evaluate=shear,
    files="One record per file (CSV, .npz, .mat, UFF 58) with columns of time, displacement of the platen, and force.",
    figures={
        "force_displacement": Figure(f"{DRAW}:plot_curves", "curve_force"),
        "capacity": Figure(f"{DRAW}:plot_capacity", "shear_capacity"),
        "coefficient": Figure(f"{DRAW}:plot_points", "point_coefficient"),
    },
    variables={
        "test_record": ("shear_capacity", "shear_stiffness", "shear_modulus", "shear_modulus_one_stack", "loop_energy"),
        "point": ("point_slip_rate", "point_coefficient"),
        "test_record, sample": ("curve_displacement", "curve_force"),
    },
    example=example,
)
