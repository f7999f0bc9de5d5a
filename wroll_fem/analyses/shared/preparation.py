"""System of a case in its static preload state: a meshed roll, or matrices from a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.shared.material_damping import with_damping
from wroll_fem.analyses.shared.prestress import add_geometric_stiffness, contact_state, prestressed_roll
from wroll_fem.analyses.shared.resolution import edge_remark, system_remark
from wroll_fem.bodies.body import Body
from wroll_fem.bodies.stress import ShellStress
from wroll_fem.case.contact import friction_law
from wroll_fem.case.kinds_history import HistoryCase
from wroll_fem.case.structural import OnRoll, OnStructure, StructuralCase
from wroll_fem.dynamics.reduction.kept_structure import kept_stresses
from wroll_fem.dynamics.statics.contact_state import LEAST_TANGENT, ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.io import load_system
from wroll_fem.dynamics.system.matrix_checks import is_singular, massless_dofs
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.numerics.linear import factorise

if TYPE_CHECKING:
    from wroll_fem.progress import Progress


LEAST_STIFFNESS = 1e-13
"""Stiffness against a random load, relative to the mean diagonal of K, below which a structure has a free motion."""


def prepare(case: StructuralCase, progress: Progress) -> tuple[System, ContactState]:
    """Return the system of a case and its preload state; report the interface pressure.

    Used by every analysis that starts from the preloaded system, whether the case describes a roll
    (mesh, assemble, preload) or matrices from a file (`structure`). With `coil.model: bonded` the layers are
    bonded by springs in the stiffness matrix, and the system has no interfaces.

    Raises
    ------
    InputError
        If the case or its file of matrices is invalid.
    ConvergenceError
        If the preload does not converge.
    """
    if isinstance(case, OnRoll) and case.coil.slips:
        from wroll_fem.analyses.slip_structure import slipping_roll

        return slipping_roll(case, progress)
    if isinstance(case, OnRoll):
        with progress.stage("mesh and matrices", 2) as stage:
            bodies = build_bodies(case)
            roll = prestressed_roll(case, bodies)
            bodies = bodies if roll is None else roll.bodies
            stage.update(1, "bodies assembled")
            system = with_damping(case, build_system(case, bodies), bodies)
            system = replace(system, shell_stress=partial(_shell_stresses, case, bodies))
            stage.update(2, f"{system.n_dofs} DOFs, {system.n_points} contact points")
        bonded = case.coil.model == "bonded"
        for remark in (system_remark(case, system.bonded() if bonded else system), edge_remark(case, system)):
            if remark:
                progress.warning(remark)
        state, steps = None, case.preload_steps
        if roll is not None and (not system.interfaces or case.contact is None or bonded):
            system, state = contact_state(case, roll, system)
        elif bonded:
            system = system.bonded()
    elif isinstance(case, OnStructure):
        with progress.stage("matrices", 1) as stage:
            system, state = read_structure(case)
            system = with_damping(case, system)
            stage.update(1, f"{system.n_dofs} DOFs, {system.n_points} contact points")
        steps = case.preload_steps
    else:
        raise TypeError(f"a {type(case).__name__} has neither a roll nor matrices")
    if state is None:
        with progress.stage("preload", steps, "load steps") as stage:
            state = solve_preload(system, steps=steps, progress=lambda done: stage.update(done))
    for name, mean, low, high in _pressures(system, state):
        progress.info(
            f"interface {name}: pressure {mean / 1e3:.4g} kPa (mean), {low / 1e3:.4g} to {high / 1e3:.4g} kPa"
        )
    if isinstance(case, OnRoll) and roll is not None:
        with progress.stage("geometric stiffness", 1) as stage:
            springs = system.tie_springs if bonded and system.interfaces else None
            system, factor = add_geometric_stiffness(case, roll, system, state, springs)
            stage.update(1, f"buckling load: {factor:.4g} x preload")
        if bonded:
            system = system.bonded()
            state = replace(ContactState.unloaded(system), displacement=state.displacement)
    return system, state


def _shell_stresses(case: OnRoll, bodies: Sequence[Body]) -> tuple[ShellStress, ...]:
    from wroll_fem.fem.shell_stress import shell_stresses

    return kept_stresses(bodies, lambda: shell_stresses(case, bodies))


def _pressures(system: System, state: ContactState) -> list[tuple[str, float, float, float]]:
    rows, start = [], 0
    for interface in system.interfaces:
        part = state.pressure[start : start + interface.n_points]
        mean = float(part @ interface.areas / interface.areas.sum())
        rows.append((interface.name, mean, float(part.min()) + 0.0, float(part.max())))  # no -0
        start += interface.n_points
    return rows


def read_structure(case: OnStructure) -> tuple[System, ContactState | None]:
    """System of `structure.file` and its preload state; laws in the case section `contact` replace laws in the file.

    The state is None if it has to be computed. This is so if the file contains no state, or if `contact` changes a law
    and the file also contains the load.

    Raises
    ------
    InputError
        From `load_system`; for a preload that opens every contact point; and for a singular mass matrix with a
        method that needs its inverse; for a structure on a shaken base that nothing holds.
    """
    path = case.structure.file
    contact = case.contact
    if contact is None:
        system, state = load_system(path)
    else:
        normal = contact.normal if "normal" in contact.model_fields_set else None
        stiffness = None if normal is None or isinstance(normal.penalty, str) else normal.penalty
        separation = None if normal is None else normal.separation
        system, state = load_system(
            path, friction=friction_law(contact.friction), normal_stiffness=stiffness, separation=separation
        )
    if state is None:
        _check_pressing(system, str(path))
    _check_mass(case, system)
    if system.harmonic_forces and isinstance(case, HistoryCase):
        raise InputError(
            f"analysis {case.analysis} has one force pattern, cos(wt)", key="force", file=str(path),
            remedy="leave out forces with a phase or a harmonic, or use harmonic",
        )  # fmt: skip
    if case.analysis not in ("modal", "preload") and system.force is None:
        _check_held(system, str(path))
    return system.with_base_loads(), state


def _check_pressing(system: System, file: str) -> None:
    """Refuse a preload that opens every contact point; the check assumes bilateral contact and negligible friction."""
    force = system.loads.get("preload", np.zeros(system.n_dofs))
    if not system.interfaces or not force.any():
        return
    kn = system.laws.kn
    springs = np.concatenate([np.repeat(LEAST_TANGENT * kn, 2), kn])
    try:
        jump = system.jump @ factorise(system.with_interface_springs(springs)).solve(force)
    except RuntimeError:  # SuperLU: exactly singular
        jump = np.full(1, np.nan)
    if not np.isfinite(jump).all():
        raise InputError(
            "is singular, although the interfaces have normal and tangential springs", key="K", file=file,
            remedy="constrain every body by a support or an interface",
        )  # fmt: skip
    if np.all(jump[2 * system.n_points :] >= 0.0):
        raise InputError(
            "the preload opens every contact point", key="load_preload", file=file,
            remedy="reverse the sign of the load, or of the normal rows of the interface operators "
            "(a normal row is outer minus inner body, positive outwards)",
        )  # fmt: skip


def _check_held(system: System, file: str) -> None:
    """Refuse a structure on a shaken base that neither supports nor interfaces hold to it.

    Every interface gets springs in all directions; a matrix that is still singular has a rigid motion.
    """
    diagonal = system.stiffness.diagonal()
    typical = float(diagonal[diagonal > 0.0].mean()) if (diagonal > 0.0).any() else 1.0
    springs = np.full(3 * system.n_points, typical) / np.where(system.weights > 0.0, system.weights, 1.0)
    matrix = system.with_interface_springs(springs)
    load = np.random.default_rng(0).standard_normal(system.n_dofs)
    try:
        moved = factorise(matrix).solve(load)
    except RuntimeError:  # SuperLU: exactly singular
        moved = np.full(1, np.nan)
    softest = float(np.linalg.norm(load)) / float(np.linalg.norm(moved)) if np.isfinite(moved).all() else 0.0
    if softest > LEAST_STIFFNESS * typical:
        return
    raise InputError(
        "leaves a motion free that needs no force: nothing holds the structure to its base", key="K", file=file,
        remedy="eliminate the supports from K and M; for a free structure give force in place of influence",
    )  # fmt: skip


def _check_mass(case: OnStructure, system: System) -> None:
    """Refuse a singular mass matrix, unless the analysis is preload or solver.method is full."""
    if case.analysis == "preload" or case.solver.method == "full" or not is_singular(sp.csr_matrix(system.mass)):
        return
    count = massless_dofs(sp.csr_matrix(system.mass))
    raise InputError(
        f"is singular: {count} DOFs carry no mass" if count else "is singular", key="M",
        file=str(case.structure.file),
        remedy="eliminate these DOFs (Guyan condensation), give them a small mass, or use solver.method: full",
    )  # fmt: skip
