"""Matrix files (.npz or .mat) of a `System` and its preload state; the content is checked when a file is read.

Field names, units, signs and orders are documented in docs/matrices.md. In short:

=============================== ======================================================================================
``K``, ``M``, ``C``             (n, n) symmetric; N/m, kg, N s/m; C is optional
``damping_...``                 ``ratios``, ``table`` or ``loss``: damping of the modes (`damping_fields`); optional
``influence``                   (n,) displacement of the DOFs under a unit base translation along the excitation
``force_<h>_cos``, ``_sin``       (n,) further forces at harmonic h of the excitation (harmonic balance)
``force``                       (n,) instead: force in N that excites the structure, per unit of the excitation
``probe_<name>``                (n,) row that gives a displacement in m; "tip" is required
``base_<probe>``                displacement of a probe under a unit base translation, where its row does not give it
``load_<name>``                 (n,) force in N; "preload" is applied before the motion
``interface_<k>_operator``      (3 n_k, n), row 3 i + c: component c of (normal, hoop, axial) of outer minus inner body
``interface_<k>_area``          (n_k,) m^2 per point
``interface_<k>_points``        (n_k, 3) theta rad, z m, r m; optional
``interface_<k>_friction_...``  law and parameters; with ``_friction_index`` (n_k,) the law ``_friction_<j>_...`` of
                                each point, j from 1
``interface_<k>_normal_...``    ``stiffness`` Pa/m and ``separation``, one value or (n_k,)
``interface_<k>_preload_...``   preload state (jump, traction, elastic_slip, status), or the pressure alone
``subspaces_...``               invariant subspaces of a roll (see `cyclic_symmetry`), written by `save_system`
=============================== ======================================================================================

Interfaces are numbered from 1, inner first. Every vector of an interface is in the order of the rows of its operator:
all components of point 1, then all of point 2.
"""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact.interface import Interface, NormalPenalty
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.point import NORMAL, contact_dofs
from wroll_fem.contact.pointwise import PointwiseFriction
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.array_file import ArrayFile, write_arrays
from wroll_fem.dynamics.system.cyclic_symmetry import Subspace
from wroll_fem.dynamics.system.damping_fields import DAMPING_FIELDS, damping_content, read_damping
from wroll_fem.dynamics.system.harmonic_force import force_content, is_force_field, read_forces
from wroll_fem.dynamics.system.law_fields import FRICTION_LAWS, law_field_names, law_fields, read_laws
from wroll_fem.dynamics.system.matrix_checks import is_singular, negative_problem, symmetry_problem
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray, IntArray

__all__ = ["FRICTION_LAWS", "load_system", "save_system", "system_size"]

VERSION = 1
"""Version of the file format; files of a newer version are refused."""

INFLUENCE = "displacement of each DOF under a unit base translation; or give force"
"""Meaning of the field `influence` in messages."""

CONSISTENT = 1e-6
"""Largest accepted relative error of the tractions of a preload state, and of its equilibrium with load_preload."""

_OWN = "user_"
_GENERAL = (
    "wroll_format", "K", "M", "C", *DAMPING_FIELDS, "influence", "force", "preload_displacement",
    "subspaces_basis", "subspaces_harmonic", "subspaces_even", "subspaces_columns",
)  # fmt: skip
_MEANT = {"stiffness": "K", "mass": "M", "damping": "C", "k": "K", "m": "M", "c": "C", "D": "C", "r": "influence"}
_OF_INTERFACE = (
    "name", "operator", "area", "points",
    "preload_pressure", "preload_jump", "preload_traction", "preload_elastic_slip", "preload_status",
)  # fmt: skip


# ---- save ------------------------------------------------------------------------------------------------------------


def save_system(system: System, path: str | os.PathLike[str], *, preload: ContactState | None = None) -> Path:
    """Write a system, and its preload state if given, to a .npz or .mat file.

    Returns
    -------
    Path
        Path of the file. `load_system` returns the same numbers bit by bit.

    Raises
    ------
    InputError
        If the path has another ending, or the name of a probe or load is not allowed in a field name.
    """
    content: dict[str, Any] = {"wroll_format": VERSION, "K": system.stiffness, "M": system.mass}
    if system.damping is not None:
        content["C"] = sp.csr_matrix(system.damping)
    if system.modal_damping is not None:
        content |= damping_content(system.modal_damping)
    if system.force is None:
        content["influence"] = system.influence
    else:
        content["force"] = system.force
    for kind, vectors in (("probe", system.probes), ("load", system.loads)):
        for name, vector in vectors.items():
            if not re.fullmatch(r"\w{1,40}", name, re.ASCII):
                raise InputError(
                    f"{kind} {name!r} has a name that is not allowed in a file",
                    remedy="use up to 40 letters, digits and underscores",
                )
            content[f"{kind}_{name}"] = vector
    content |= force_content(system.harmonic_forces)
    content |= {f"base_{name}": np.array([motion]) for name, motion in system.probe_base.items()}
    for number, interface in enumerate(system.interfaces, start=1):
        content |= {f"interface_{number}_{key}": value for key, value in _interface_content(interface).items()}
    if preload is not None:
        content |= _state_content(system, preload)
    if system.subspaces:
        content |= _subspace_content(system.subspaces)
    return write_arrays(path, content)


def _interface_content(interface: Interface) -> dict[str, Any]:
    content: dict[str, Any] = {"name": interface.name, "operator": interface.operator, "area": interface.areas}
    if np.isfinite(interface.points).all():
        content["points"] = interface.points
    content |= law_fields(interface)
    return content


def _dofs(system: System) -> list[tuple[IntArray, IntArray]]:
    """Contact degrees of freedom of each interface, with n_k points: hoop and axial (n_k, 2), and normal (n_k,)."""
    if not system.interfaces:
        return []
    ends = np.cumsum([interface.n_points for interface in system.interfaces])[:-1]
    return [(part[:, :NORMAL], part[:, NORMAL]) for part in np.split(contact_dofs(system.n_points), ends)]


def _state_content(system: System, state: ContactState) -> dict[str, Any]:
    content: dict[str, Any] = {"preload_displacement": state.displacement}
    for number, (tangential, normal) in enumerate(_dofs(system), start=1):
        rows = np.column_stack([normal, tangential])
        content |= {
            f"interface_{number}_preload_jump": state.jump[rows].ravel(),
            f"interface_{number}_preload_traction": state.traction[rows].ravel(),
            f"interface_{number}_preload_elastic_slip": state.elastic_slip[tangential].ravel(),
            f"interface_{number}_preload_status": state.status[tangential[:, 0] // 2].astype(float),
        }
    return content


def _subspace_content(subspaces: Sequence[Subspace]) -> dict[str, Any]:
    return {
        "subspaces_basis": sp.hstack([s.basis for s in subspaces], format="csc"),
        "subspaces_harmonic": np.array([s.harmonic for s in subspaces], float),
        "subspaces_even": np.array([s.even for s in subspaces], float),
        "subspaces_columns": np.array([s.basis.shape[1] for s in subspaces], float),
    }


# ---- load ------------------------------------------------------------------------------------------------------------


def load_system(
    path: str | os.PathLike[str],
    *,
    friction: FrictionLaw | None = None,
    normal_stiffness: float | None = None,
    separation: bool | None = None,
) -> tuple[System, ContactState | None]:
    """Read and check a matrix file that `save_system` or another program wrote.

    Parameters
    ----------
    friction, normal_stiffness, separation
        They replace the laws of all interfaces in the file, where these may then be missing. If they differ from the
        laws in the file and the file holds the load "preload", a preload state in the file is ignored.

    Returns
    -------
    System, ContactState or None
        System, and its state at the start of the motion. The state is None if the file gives none;
        `preload.solve_preload` computes it then.

    Raises
    ------
    InputError
        If the file is invalid: one line with file, field, problem and remedy.
    """
    file = ArrayFile(path)
    version = file.number("wroll_format", "format, 1") if "wroll_format" in file else VERSION
    if version > VERSION:
        raise file.error(f"has format {version:g}", key="wroll_format", remedy="read it with a newer wroll_fem")
    count = _check_names(file)
    n = file.matrix("K", (None, None), "stiffness matrix, N/m").shape[0]
    laws = [read_laws(file, k, friction, normal_stiffness, separation) for k in range(1, count + 1)]
    system = System(
        stiffness=_square(file, "K", n, "stiffness matrix, N/m"),
        mass=_square(file, "M", n, "mass matrix, kg"),
        damping=_square(file, "C", n, "damping matrix, N s/m") if "C" in file else None,
        modal_damping=read_damping(file, n),
        influence=np.zeros(n) if "force" in file else file.vector("influence", n, INFLUENCE),
        interfaces=tuple(_interface(file, k, n, *laws[k - 1][:2]) for k in range(1, count + 1)),
        probes=_vectors(file, "probe", n, "row that gives a displacement in m"),
        probe_base={name: float(value[0]) for name, value in _vectors(file, "base", 1, "motion with the base").items()},
        loads=_vectors(file, "load", n, "static force, N"),
        subspaces=_subspaces(file, n) if not any(map(is_force_field, file.names)) else (),
        harmonic_forces=read_forces(file, n),
    )
    if "tip" not in system.probes:
        remedy = "add it (row that gives the displacement to follow, along the excitation)"
        raise file.error("required field is missing", key="probe_tip", remedy=remedy)
    if "force" in file:
        system = _forced(file, system)
    stale = any(changed for *_, changed in laws) and np.any(system.loads.get("preload", 0.0))
    return system, None if stale else _state(file, system)


def system_size(path: str | os.PathLike[str]) -> tuple[int, int]:
    """Number of DOFs and number of contact points of a matrix file."""
    file = ArrayFile(path)
    n = file.matrix("K", (None, None), "stiffness matrix, N/m").shape[0]
    areas = [name for name in file.names if re.fullmatch(r"interface_\d+_area", name)]
    return int(n), sum(file.vector(name, None, "area of each point, m^2").size for name in areas)


def _forced(file: ArrayFile, system: System) -> System:
    """System excited by the force in the file."""
    if "influence" in file:
        raise file.error("is given with influence", key="force", remedy="keep one: a force, or the motion of the base")
    if is_singular(sp.csr_matrix(system.mass)):
        raise file.error("needs a regular mass matrix", key="force", remedy="give every degree of freedom a mass")
    return system.excited_by(file.vector("force", system.n_dofs, "force on each DOF, N"))


def _check_names(file: ArrayFile) -> int:
    """Number of interfaces in the file; an unknown field is an error, so that no misspelt field is silently ignored."""
    numbers = {int(m[1]) for name in file.names if (m := re.match(r"interface_(\d+)_", name))}
    known = [
        *_GENERAL,
        *(f"interface_{k}_{key}" for k in sorted(numbers) for key in (*_OF_INTERFACE, *law_field_names(file))),
    ]
    for name in file.names:
        if name in known or is_force_field(name) or name.startswith(("probe_", "base_", "load_", _OWN)):
            continue
        near = [_MEANT[name]] if name in _MEANT else difflib.get_close_matches(name, [*known, "probe_tip"], n=1)
        meant = f"did you mean {near[0]}? " if near else ""
        raise file.error("unknown field", key=name, remedy=f"{meant}(fields of your own begin with {_OWN})")
    if numbers != set(range(1, len(numbers) + 1)):
        have = ", ".join(map(str, sorted(numbers)))
        raise file.error(f"has the interfaces {have}", remedy="number them 1, 2, ... from the inside, without gaps")
    return len(numbers)


def _square(file: ArrayFile, name: str, n: int, meaning: str) -> sp.csr_matrix:
    """Matrix (n, n) from the file, checked to be symmetric and positive semi-definite."""
    matrix = file.matrix(name, (n, n), meaning)
    problem, remedy = symmetry_problem(matrix)
    if problem:
        raise file.error(problem, key=name, remedy=remedy)
    # contact may support what the stiffness alone does not: its diagonal is checked, not its pivots
    problem = negative_problem(matrix, pivots=name != "K")
    if problem:
        raise file.error(f"is not positive semi-definite: {problem}", key=name, remedy=f"check the {meaning}")
    return matrix


def _vectors(file: ArrayFile, kind: str, n: int, meaning: str) -> dict[str, FloatArray]:
    start = f"{kind}_"
    return {name[len(start) :]: file.vector(name, n, meaning) for name in file.names if name.startswith(start)}


def _interface(
    file: ArrayFile, number: int, n: int, friction: FrictionLaw | PointwiseFriction, normal: NormalPenalty
) -> Interface:
    own = f"interface_{number}_"
    area = file.vector(f"{own}area", None, "area of each point, m^2")
    if area.size == 0 or area.min() <= 0.0:
        least = f"area {int(np.argmin(area))}, counted from 0, is {area.min():g} m^2" if area.size else "is empty"
        raise file.error(least, key=f"{own}area", remedy="give every point a positive area")
    meaning = "operator with rows (normal, hoop, axial) of every point"
    operator = file.matrix(f"{own}operator", (3 * area.size, n), meaning)
    silent = np.flatnonzero(np.asarray(abs(operator[::3]).sum(axis=1)).ravel() == 0.0)
    pressed = f"{own}preload_pressure" in file or f"{own}preload_traction" in file  # constant, where the row is zero
    if silent.size and not pressed:
        problem = f"the normal row of point {silent[0]}, counted from 0, is zero"
        remedy = (
            "rows 0, 3, 6, ... give the normal displacement of the outer body relative to the inner body; "
            f"for a constant normal force give {own}preload_pressure"
        )
        raise file.error(problem, key=f"{own}operator", remedy=remedy)
    points = np.full((area.size, 3), np.nan)
    if f"{own}points" in file:
        points = file.table(f"{own}points", (area.size, 3), "theta (rad), z (m), r (m) of each point")
    name = file.text(f"{own}name", "name of the interface") if f"{own}name" in file else f"contact {number}"
    return Interface(name, operator, area, points, friction, normal)


def _subspaces(file: ArrayFile, n: int) -> tuple[Subspace, ...]:
    if "subspaces_basis" not in file:
        return ()
    width = file.vector("subspaces_columns", None, "columns of each subspace").astype(int)
    harmonic = file.vector("subspaces_harmonic", width.size, "circumferential wave number of each subspace").astype(int)
    even = file.vector("subspaces_even", width.size, "1: even, 0: odd, of each subspace").astype(bool)
    basis = sp.csc_matrix(file.matrix("subspaces_basis", (n, n), "bases of all subspaces side by side"))
    if width.sum() != n or width.min(initial=1) < 1:
        remedy = "give each subspace its columns of subspaces_basis"
        raise file.error(f"adds up to {width.sum()}, not {n}", key="subspaces_columns", remedy=remedy)
    ends = np.cumsum(width)
    parts = (basis[:, a - w : a] for a, w in zip(ends, width, strict=True))
    return tuple(Subspace(int(h), bool(e), part) for h, e, part in zip(harmonic, even, parts, strict=True))


def _state(file: ArrayFile, system: System) -> ContactState | None:
    """Preload state of the file, checked against laws and load; None if the file holds none."""
    given = [name for name in file.names if "_preload_" in name]
    if not given and "preload_displacement" not in file:
        return None
    state = ContactState.unloaded(system)
    jump, traction, slip, status = state.jump, state.traction, state.elastic_slip, state.status
    whole = False
    for number, ((tangential, normal), interface) in enumerate(
        zip(_dofs(system), system.interfaces, strict=True), start=1
    ):
        own, count = f"interface_{number}_preload_", interface.n_points
        rows = np.column_stack([normal, tangential])
        if f"{own}pressure" in file:
            if len([name for name in given if name.startswith(own)]) > 1:
                raise file.error("is given with other fields of a preload state", key=f"{own}pressure",
                                 remedy="give the pressure alone, or jump, traction and elastic_slip")  # fmt: skip
            pressure = file.vector(f"{own}pressure", count, "contact pressure of each point, Pa")
            if pressure.min() < 0.0:
                raise file.error(f"is {pressure.min():g} Pa at one point", key=f"{own}pressure",
                                 remedy="pressure is positive in compression")  # fmt: skip
            jump[normal], traction[normal] = -pressure / interface.normal.stiffness, -pressure
            continue
        whole = True
        jump[rows] = file.vector(f"{own}jump", 3 * count, "relative displacement, m").reshape(count, 3)
        traction[rows] = file.vector(f"{own}traction", 3 * count, "traction, Pa").reshape(count, 3)
        slip[tangential] = file.vector(f"{own}elastic_slip", 2 * count, "elastic slip, m").reshape(count, 2)
        if f"{own}status" in file:
            status[tangential[:, 0] // 2] = file.vector(f"{own}status", count, "status").astype(np.int64)
    if "preload_displacement" in file:
        state.displacement[:] = file.vector("preload_displacement", system.n_dofs, "displacement, m")
    _check_state(file, system, state, balanced=whole and "preload_displacement" in file)
    return state


def _check_state(file: ArrayFile, system: System, state: ContactState, *, balanced: bool) -> None:
    """Raise an error if the tractions of a state do not follow from its laws or do not balance the load "preload"."""
    if not system.interfaces:
        return
    traction = TrialContact(system)(state.jump, state)
    error, scale = float(np.abs(traction - state.traction).max()), float(np.abs(state.traction).max())
    if error > CONSISTENT * scale:
        raise file.error(
            f"the preload state does not follow from its laws: tractions differ by up to {error:.3g} Pa "
            f"(largest traction {scale:.3g} Pa)",
            remedy="give load_preload in place of the state (normal traction is negative in compression), or compute "
            "the preload state with these laws",
        )
    force = system.loads.get("preload")
    if force is None or not balanced or not np.any(force):
        return
    if not state.pressure.any():
        remedy = "normal traction is negative in compression; a normal row is outer minus inner body, positive outwards"
        raise file.error("no contact point is under pressure in the preload state", remedy=remedy)
    contact = system.contact_force(state.traction)
    internal = system.stiffness @ state.displacement
    scale = float(np.linalg.norm(force) + np.linalg.norm(contact) + np.linalg.norm(internal))
    off = float(np.linalg.norm(internal + contact - force))
    if off > CONSISTENT * scale:
        raise file.error(
            f"the preload state does not balance load_preload (relative error {off / scale:.2g})",
            remedy="leave one of them out, or check units and order of the state's fields",
        )
