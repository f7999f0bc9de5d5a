"""Problem size and approximate computing time of a run, for ``--dry-run``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wroll_fem.analyses.forecasts.closed_forms import interface_pressures
from wroll_fem.analyses.forecasts.slip import layers_clamped
from wroll_fem.analyses.shared.assembly import is_mirrored, uses_symmetry
from wroll_fem.case.structural import OnRoll, OnStructure, StructuralCase

if TYPE_CHECKING:
    from wroll_fem.case import HistoryCase, RollSections

SECONDS_PER_UNIT = {"reduced": 4.0e-7, "condensed": 5.0e-9, "full": 1.2e-5}
"""Method -> computing time of a time step on a 2.5 GHz core, s, divided by the size of the problem. The size is the
number of contact points (reduced), contact points times modes per circumferential wave number (condensed), or
DOFs (full)."""

SECONDS_PER_EIGENPROBLEM = 2.2e-10
"""Time to compute the modes of one circumferential wave number, divided by the cube of its number of DOFs, s, on a
2.5 GHz core."""

SECONDS_OF_A_RUN = 4.5
"""Time to start, to mesh and to draw the figures, s, on a 2.5 GHz core."""

SECONDS_PER_DOF, SECONDS_PER_DOF_OF_MODES = 7.0e-5, 3.5e-4
"""Time per DOF, s, on a 2.5 GHz core: to assemble and solve; and, for ten modes or a solid coil, in their place."""

SECONDS_PER_CURVE_POINT = 6.0e-3
"""Time of a response curve or a backbone for each contact point, s, on a 2.5 GHz core."""

SECONDS_WITHOUT_SYMMETRY = 2.2e-9
"""Time to reduce a roll without cyclic symmetry, divided by the cube of the size of its projection basis, s, on a
2.5 GHz core."""

PRESSURE_OF_OPENING = 2e3
"""Interface pressure, Pa, below which large areas open and a time history by `reduced` falls back to `condensed`."""

SECONDS_PER_FOURIER_DOF = 3.0e-5
"""Time per DOF to solve one eigenproblem of one circumferential wave number, s, on a 2.5 GHz core."""


def estimate_roll(case: StructuralCase) -> dict[str, Any]:
    """Numbers of DOFs and contact points, and computing time, of an analysis that can use the symmetry plane."""
    return _estimate(case, half=uses_symmetry(case))


def estimate_curve(case: StructuralCase) -> dict[str, Any]:
    """As `estimate_roll`, for harmonic and backbone."""
    found = estimate_roll(case)
    if "estimated_seconds" in found and isinstance(case, OnRoll):
        points = found["interface_points"]
        found["estimated_seconds"] += SECONDS_PER_CURVE_POINT * points
        if not is_mirrored(case):
            found["estimated_seconds"] += SECONDS_WITHOUT_SYMMETRY * (3.0 * 3.0 * points) ** 3
    return found


def estimate_modes(case: StructuralCase) -> dict[str, Any]:
    """Numbers of DOFs and contact points, and computing time, of an eigenvalue analysis of the whole roll."""
    if isinstance(case, OnRoll) and case.mesh.discretisation == "fourier":
        dofs = fourier_dofs(case)
        seconds = 2.0 + 12 * SECONDS_PER_FOURIER_DOF * dofs
        return {"dofs": dofs, "interface_points": 0, "estimated_seconds": seconds}
    found = _estimate(case, half=False)
    if "estimated_seconds" in found and isinstance(case, OnRoll) and case.coil.model != "solid":
        found["estimated_seconds"] += (SECONDS_PER_DOF_OF_MODES - SECONDS_PER_DOF) * found["dofs"]
    return found


def estimate_history(case: HistoryCase) -> dict[str, Any]:
    """As `estimate_roll`, plus number of steps, time step (s) and duration (s) of the time history."""
    from wroll_fem.analyses.shared.time_step import time_grid, time_step
    from wroll_fem.signals.motions import base_motion

    found = estimate_roll(case)
    seconds = found.pop("estimated_seconds", None)
    duration = base_motion(case.excitation).duration
    dt = time_step(case)
    grid = time_grid(case, None)
    steps = math.ceil(duration / dt - 1e-9) if grid is None else grid.count
    found |= {"steps": steps, "time_step_s": dt, "duration_s": duration}
    if seconds is None or not isinstance(case, OnRoll):
        return found
    around, method = case.mesh.circumferential, _method(case)
    per_harmonic = 2.0 * found["dofs"] / around
    if method != "full":
        blocks, size = (0.5 * around, per_harmonic) if uses_symmetry(case) else (around, 0.5 * per_harmonic)
        seconds += SECONDS_PER_EIGENPROBLEM * blocks * size**3
    points = found["interface_points"]
    unit = {"reduced": points, "condensed": points * per_harmonic, "full": found["dofs"]}[method]
    seconds += steps * max(1e-4, SECONDS_PER_UNIT[method] * unit)
    return found | {"estimated_seconds": seconds}


def _method(case: HistoryCase) -> str:
    """Method by which a time history ends: `reduced` falls back where layers open, or slip a little everywhere."""
    if case.solver.method != "reduced" or not isinstance(case, OnRoll) or case.coil.model != "layers":
        return case.solver.method
    opens = case.preload is not None and min(interface_pressures(case)) < PRESSURE_OF_OPENING
    return "condensed" if opens or layers_clamped(case) else "reduced"


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
    interfaces = 1 if roll.coil.rubs else shells - 1 if model == "layers" else 0
    points = columns * 2 * along * interfaces
    seconds = SECONDS_OF_A_RUN + (SECONDS_PER_DOF_OF_MODES if model == "solid" else SECONDS_PER_DOF) * dofs
    return {"dofs": dofs, "interface_points": points, "estimated_seconds": seconds}
