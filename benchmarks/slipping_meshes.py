"""Coils whose wraps slide on two meshes: frequency and damping at levels of the base: docs/tables/slipping_mesh.md.

Usage: python benchmarks/slipping_meshes.py [--only NAME...] [--page FILE]

Each case of `slip_damping` is computed on its own mesh and on a finer one. The table has the values on the finer mesh,
the differences of the own mesh from it, and whether they are within 0.2 % (frequency) and 1 % (damping ratio). Ten
minutes of CPU on one core in all; with --only the lines of the other cases on the page stay.
"""

from __future__ import annotations

import argparse
import os
import time
import warnings
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")

import wroll_fem as wf  # isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

CONFIGS = Path(__file__).resolve().parents[1] / "configs"
FREQUENCY, DAMPING = 2e-3, 1e-2
"""Largest relative differences of frequency and damping ratio between the two meshes."""

OWN = {
    "slipping_coil": (16, 16, 40, 4, 10),
    "slipping_flight": (16, 12, 20, 9, 100),
    "slipping_kapton": (16, 16, 40, 4, 20),
}
"""Mesh of the case files: around, along, grading along, through, grading through."""


class Row(NamedTuple):
    """Case file, overrides, levels (g), finer mesh, own mesh (None: that of the file) and `excitation.mode`."""

    file: str
    overrides: tuple[str, ...]
    levels: tuple[float, ...]
    finer: tuple[int, int, float, int, float]
    own: tuple[int, int, float, int, float] | None = None
    mode: str = "bending"


FINE = (24, 24, 60, 5, 10)
WRAPS = "coil.wrap_interfaces={elastic_slip: 1.0e-6, radial_modulus: winding}"
ROWS = {
    "case study": Row("slipping_coil", (), (1, 5, 15), FINE),
    "case study, clamped base": Row("slipping_coil", ("coil.base=clamped",), (1, 5, 15), FINE),
    "case study, wrap_interfaces": Row("slipping_coil", (WRAPS,), (1, 5, 15), FINE),
    "case study, torsion": Row("slipping_coil", (), (1, 5, 15), (20, 24, 60, 5, 10), mode="torsion"),
    "case study, axial": Row("slipping_coil", (), (5, 15, 50), FINE, mode="axial"),
    "case study, varying pressure": Row(
        "slipping_coil", ("coil.pressure=varying",), (1, 5, 15), OWN["slipping_coil"], (12, 12, 30, 3, 10)
    ),
    "Kapton roll": Row("slipping_kapton", (), (1, 5, 15), FINE),
    "SSPP-like roll": Row("slipping_flight", (), (1, 3, 5), (20, 18, 30, 12, 150)),
    "SSPP-like roll, wrap_interfaces": Row("slipping_flight", (WRAPS,), (1, 3, 5), (20, 18, 30, 12, 150)),
}
"""Name -> row. With varying pressure the finer mesh is that of the case file: each amplitude is a whole cycle."""


def computed(row: Row, mesh: tuple[int, int, float, int, float]) -> tuple[xr.Dataset, float]:
    """Result of a row on a mesh, and its CPU time in s."""
    started = time.process_time()
    around, along, grading, radial, radial_grading = mesh
    cells = f"circumferential: {around}, axial: {along}, grading: {grading}, radial: {radial}"
    overrides = [*row.overrides, f"mesh={{{cells}, radial_grading: {radial_grading}}}"]
    motion = f"amplitude_g: {list(row.levels)}, mode: {row.mode}" + ", direction: x" * (row.mode == "bending")
    overrides.append(f"excitation={{kind: sine, frequency: resonance, {motion}}}")
    with warnings.catch_warnings(), threadpool_limits(1):
        warnings.simplefilter("ignore")
        found = wf.run(wf.load_case(CONFIGS / f"{row.file}.yaml", overrides), progress=False)
    return found, time.process_time() - started


def named(mesh: tuple[int, int, float, int, float]) -> str:
    """Elements around, along and through the coil."""
    return f"{mesh[0]} x {mesh[1]} x {mesh[3]}"


def difference(ours: float, finer: float) -> float:
    """Relative difference; 0 where both are 0, and infinite where only the finer one is."""
    return ours / finer - 1.0 if finer else np.inf * (ours != 0.0) or 0.0


def lines(name: str, row: Row) -> list[str]:
    """Lines of the table, one per level."""
    mesh = row.own or OWN[row.file]
    (own, fast), (fine, slow) = computed(row, mesh), computed(row, row.finer)
    found = []
    for number, level in enumerate(row.levels):
        a, b = (data.isel(amplitude_g=number) for data in (own, fine))
        f, total, rub, tip = (
            difference(float(a[key]), float(b[key]))
            for key in ("frequency_at_level", "damping_at_level", "friction_damping_at_level", "tip_at_level")
        )
        values = (float(b["frequency_at_level"]), 1e2 * float(b["damping_at_level"]))
        slips = float(b["friction_damping_at_level"]) > 0.0 or float(a["friction_damping_at_level"]) > 0.0
        met = "no result" if np.isnan(f) else "yes" if abs(f) <= FREQUENCY and abs(total) <= DAMPING else "**no**"
        cells = (
            name * (not number), f"{named(mesh)} ({fast:.0f} s), {named(row.finer)} ({slow:.0f} s)" * (not number),
            f"{level:g} g", f"{values[0]:.2f} Hz", f"{100 * f:+.2f} %", f"{values[1]:.2f} %", f"{100 * total:+.2f} %",
            f"{100 * rub:+.2f} %" if slips else "no slip", f"{100 * tip:+.2f} %", met,
        )  # fmt: skip
        found.append(f"| {' | '.join(cells)} |")
    return found


def kept(page: Path | None) -> dict[str, list[str]]:
    """Lines of a page by case."""
    found: dict[str, list[str]] = {}
    name = ""
    for line in page.read_text(encoding="utf-8").splitlines() if page is not None and page.is_file() else ():
        name = line.split("|")[1].strip() or name if line.startswith("|") else ""
        if name in ROWS:
            found.setdefault(name, []).append(line)
    return found


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=ROWS, default=list(ROWS), help="cases", metavar="NAME")
    parser.add_argument("--page", type=Path, help="page to write (Markdown)")
    asked = parser.parse_args()
    heads = ("case", "meshes: own and finer (CPU)", "level", "frequency", "own mesh", "damping", "own mesh",
             "by friction alone", "tip", f"f {100 * FREQUENCY:g} %, ζ {100 * DAMPING:g} %")  # fmt: skip
    page = [
        "# Meshes of slipping coils", "",
        "Frequency and damping ratio of `slip_damping` on a finer mesh, and the differences of the mesh of the case",
        "file from it (damping: with the 2 % without slip, and by friction alone). Elements around, along and through",
        "the coil. The last column: whether frequency and damping ratio are within the limits in its head. Computed",
        "by `.venv/bin/python benchmarks/slipping_meshes.py --page docs/tables/slipping_mesh.md`.",
        "", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads),
    ]  # fmt: skip
    table = kept(asked.page)
    for name in asked.only:
        table[name] = lines(name, ROWS[name])
        print(*table[name], sep="\n", flush=True)
        if asked.page:
            rows = [line for known in ROWS for line in table.get(known, ())]
            asked.page.write_text("\n".join([*page, *rows]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
