"""Problem size and approximate computing time of a run, for ``--dry-run``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wroll_fem.case.structural import OnRoll, OnStructure, StructuralCase

if TYPE_CHECKING:
    from wroll_fem.case import DwellCase, RollSections, SweepCase

SECONDS_PER_UNIT = {"reduced": 4.0e-7, "condensed": 3.0e-8, "full": 1.2e-5}
"""Method -> computing time of a time step on a 2.5 GHz core, s, divided by the size of the problem. The size is the
number of contact points (reduced), contact points times modes per circumferential wave number (condensed), or
DOFs (full)."""

SECONDS_PER_EIGENPROBLEM = 2.2e-10
"""Time to compute the modes of one circumferential wave number, divided by the cube of its number of DOFs, s, on a
2.5 GHz core."""

SECONDS_PER_SOLID_DOF = 3.5e-4
"""Time per DOF to assemble a solid coil and to compute ten modes, s, on a 2.5 GHz core."""

SECONDS_PER_FOURIER_DOF = 3.0e-5
"""Time per DOF to solve one eigenproblem of one circumferential wave number, s, on a 2.5 GHz core."""


def estimate_roll(case: StructuralCase) -> dict[str, Any]:
    """Numbers of DOFs and contact points, and computing time, of an analysis that can use the symmetry plane."""
    half = case.solver.symmetry and case.direction == "x" and case.solver.method != "full"
    return _estimate(case, half=half)


def estimate_modes(case: StructuralCase) -> dict[str, Any]:
    """Numbers of DOFs and contact points, and computing time, of an eigenvalue analysis of the whole roll."""
    if isinstance(case, OnRoll) and case.mesh.discretisation == "fourier":
        dofs = fourier_dofs(case)
        seconds = 2.0 + 12 * SECONDS_PER_FOURIER_DOF * dofs
        return {"dofs": dofs, "interface_points": 0, "estimated_seconds": seconds}
    return _estimate(case, half=False)


def estimate_history(case: SweepCase | DwellCase) -> dict[str, Any]:
    """As `estimate_roll`, plus number of steps, time step (s) and duration (s) of the time history."""
    from wroll_fem.analyses.shared.time_step import time_step
    from wroll_fem.signals.base_motion import base_motion

    found = estimate_roll(case)
    seconds = found.pop("estimated_seconds", None)
    duration = base_motion(case.excitation).duration
    dt = time_step(case)
    steps = math.ceil(duration / dt - 1e-9)
    found |= {"steps": steps, "time_step_s": dt, "duration_s": duration}
    if seconds is None or not isinstance(case, OnRoll):
        return found
    around, method = case.mesh.circumferential, case.solver.method
    per_harmonic = 2.0 * found["dofs"] / around
    if method != "full":
        half = case.solver.symmetry and case.direction == "x"
        blocks, size = (0.5 * around, per_harmonic) if half else (around, 0.5 * per_harmonic)
        seconds += SECONDS_PER_EIGENPROBLEM * blocks * size**3
    points = found["interface_points"]
    unit = {"reduced": points, "condensed": points * per_harmonic, "full": found["dofs"]}[method]
    seconds += steps * max(1e-4, SECONDS_PER_UNIT[method] * unit)
    return found | {"estimated_seconds": seconds}


def fourier_dofs(roll: RollSections) -> int:
    """Number of DOFs of one circumferential wave number."""
    from wroll_fem.mesh.axisymmetric import refined_mesh

    n_r, n_z = refined_mesh(roll).shape
    return int(3 * (3 * n_r + 1) * (3 * n_z + 1))


def _estimate(case: StructuralCase, *, half: bool) -> dict[str, Any]:
    """Problem size and, for a roll, the time for mesh, assembly and linear solutions."""
    if isinstance(case, OnStructure):
        from wroll_fem.dynamics.system.io import system_size

        dofs, points = system_size(case.structure.file)
        return {"dofs": dofs, "interface_points": points}
    roll = case.expect(OnRoll)
    model = roll.coil.model
    shells = 1 + (roll.coil.layers if model in ("layers", "bonded") else 0)
    around, along = roll.mesh.circumferential, roll.mesh.axial
    columns = around // 2 + 1 if half else around
    nodes = (around + 1 if half else 2 * around) * (2 * along + 1)
    dofs = 6 * nodes * shells + (6 * nodes * roll.mesh.radial if model == "solid" else 0)
    points = columns * 2 * along * (shells - 1) if model == "layers" else 0
    seconds = 4.0 + (SECONDS_PER_SOLID_DOF if model == "solid" else 7e-5) * dofs
    return {"dofs": dofs, "interface_points": points, "estimated_seconds": seconds}
