"""Convergence of the solid coil's bending frequency, and against other models; writes docs/tables/coil_mesh.md.

`.venv/bin/python tools/coil_table.py`, about three minutes on one core.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.bodies.mode_shapes import classify_mode, effective_mass_fractions, main_bending
from wroll_fem.case import Case, load_case
from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs
from wroll_fem.progress import SilentProgress

ROOT = Path(__file__).resolve().parents[1]
ROLLS = {
    "G_r = 1 GPa": ("coiled_stiff", []),
    "1 MPa": ("coiled_stiff", ["coil.material.G_r_theta=1e6"]),
    "10 kPa": ("coiled_stiff", ["coil.material.G_r_theta=1e4"]),
    "Kapton roll, 1.48 GPa": ("kapton_roll", []),
    "Kapton roll, 1 MPa": ("kapton_roll", ["coil.material.G_r_theta=1e6"]),
}
#: Elements around, along and through the coil (thick coil, thin coil); the case files have the bold one.
MESHES = [((12, 8, 2), (12, 8, 1)), ((16, 16, 3), (20, 12, 1)), ((20, 24, 4), (24, 20, 1)), ((24, 32, 6), (32, 32, 2))]
OWN = 1
VARIANTS = {"around doubled": (2, 1, 1), "along doubled": (1, 2, 1), "through doubled": (1, 1, 2)}


def case_of(roll: str, *overrides: str) -> Case:
    name, words = ROLLS[roll]
    return load_case(ROOT / "configs" / f"{name}.yaml", [*words, *overrides])


def meshed(around: int, along: int, through: int) -> list[str]:
    return [f"mesh.circumferential={around}", f"mesh.axial={along}", f"mesh.radial={through}"]


def bending(case: Case, count: int = 5) -> tuple[float, int]:
    """Bending frequency in Hz from half of the roll, and its number of unknowns."""
    bodies = build_bodies(case, symmetric=True)
    system = build_system(case, bodies)
    pairs = solve_pairs(system.stiffness, system.mass, count, sigma=DEFAULT_SHIFT)
    influence = np.vstack([body.influence for body in bodies])
    share = effective_mass_fractions(system.mass, influence, pairs.vectors, sum(body.mass_total for body in bodies))
    index = main_bending([classify_mode(bodies, v).kind for v in pairs.vectors.T], share)
    if index is None:
        raise RuntimeError(f"no bending mode among {count}")
    return float(np.sqrt(pairs.values[index])) / (2 * np.pi), system.n_dofs


def fourier(case: Case) -> float:
    """Bending frequency in Hz of the independent model in harmonics around the axis."""
    data = run_analysis(case, progress=SilentProgress())
    index = main_bending(data["mode_kind"].values.tolist(), data["effective_mass_fraction"].values)
    assert index is not None
    return float(data["mode_frequency"].values[index])


def convergence() -> list[str]:
    head = ["cells around x along x through (thick; thin coil)", "unknowns, half roll", "CPU s", *ROLLS]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    finest = {}
    for number, (thick, thin) in reversed(list(enumerate(MESHES))):
        cells = [" x ".join(map(str, mesh)) for mesh in (thick, thin)]
        start, found, dofs = time.process_time(), [], 0
        for roll in ROLLS:
            f, n = bending(case_of(roll, *meshed(*(thin if roll.startswith("Kapton") else thick))))
            dofs = max(dofs, n)
            found.append(f"{f:.2f} Hz ({100 * (f / finest.setdefault(roll, f) - 1):+.2f} %)")
        seconds = (time.process_time() - start) / len(ROLLS)
        name = "; ".join(cells)
        name = f"**{name}**" if number == OWN else name
        lines.insert(2, "| " + " | ".join([name, str(dofs), f"{seconds:.1f}", *found]) + " |")
        print(lines[2], flush=True)
    for text, factors in VARIANTS.items():
        start, found, dofs = time.process_time(), [], 0
        for roll in ROLLS:
            own = MESHES[OWN][1 if roll.startswith("Kapton") else 0]
            f, n = bending(case_of(roll, *meshed(*(a * b for a, b in zip(own, factors, strict=True)))))
            dofs = max(dofs, n)
            found.append(f"{f:.2f} Hz ({100 * (f / finest[roll] - 1):+.2f} %)")
        seconds = (time.process_time() - start) / len(ROLLS)
        lines.append("| " + " | ".join([f"bold, {text}", str(dofs), f"{seconds:.1f}", *found]) + " |")
        print(lines[-1], flush=True)
    other = []
    for roll in ROLLS:
        f = fourier(case_of(roll, "mesh.discretisation=fourier"))
        other.append(f"{f:.2f} Hz ({100 * (f / finest[roll] - 1):+.2f} %)")
    return [*lines, "| " + " | ".join(["Fourier elements (solid mandrel)", "", "", *other]) + " |"]


def limits() -> list[str]:
    """Thin isotropic coil against the bonded layer of shells."""
    lines = ["| base of the coil | cells | solid coil | bonded layer (shells) | difference |", "|---|---|---|---|---|"]
    for base in ("clamped", "free"):
        for mesh in ((20, 12, 1), (40, 40, 1)):
            words = [
                *meshed(*mesh),
                f"coil.base={base}",
                "mesh.grading=10",
                "coil.material={E: 4e9, nu: 0.35, rho: 1400}",
            ]
            solid = case_of("Kapton roll, 1 MPa", *words)
            data = solid.resolved()
            layer = Case.model_validate(data | {"coil": data["coil"] | {"model": "bonded"}})
            ours = bending(solid)[0]
            shells = run_analysis(layer, progress=SilentProgress())
            index = main_bending(shells["mode_kind"].values.tolist(), shells["effective_mass_fraction"].values)
            other = float(shells["mode_frequency"].values[index])
            cells = " x ".join(map(str, mesh))
            lines.append(f"| {base} | {cells} | {ours:.2f} Hz | {other:.2f} Hz | {100 * (ours / other - 1):+.2f} % |")
            print(lines[-1], flush=True)
    return lines


def main() -> None:
    text = [
        "Bending frequency of the solid coil, difference from the finest mesh in brackets; CPU seconds per frequency.",
        "The mesh in bold is that of the case files `configs/coiled_stiff.yaml` and `configs/kapton_roll.yaml`.",
        "Computed by `.venv/bin/python tools/coil_table.py`.",
        "",
        *convergence(),
        "",
        "Thin isotropic coil (1.25 mm, 4 GPa) on the Kapton roll's mandrel, as hexes and as a layer of shells tied at",
        "points (`coil.model: bonded`). Tied at points, a layer with a free base holds on to the base a little less.",
        "",
        *limits(),
        "",
    ]
    (ROOT / "docs" / "tables" / "coil_mesh.md").write_text("\n".join(text), encoding="utf-8")


if __name__ == "__main__":
    main()
