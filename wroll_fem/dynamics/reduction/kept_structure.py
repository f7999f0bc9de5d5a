"""Structure of a series: bodies and modes are computed once and used again for other preloads, laws and excitations.

Nothing is kept outside `keeping_structure`. The modes are computed with the same springs either way, so that a run has
the same results in a series and on its own.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body
from wroll_fem.bodies.stress import ShellStress
from wroll_fem.case.roll import RollSections
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.turned_modes import COMPONENTS, missed, turned
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

MISSED = 1e-6
"""Largest relative error of the compliance up to which turned modes are used."""


@dataclass
class _Structure:
    """Bodies of a roll, and the recovery of the stress of its shells once it was needed."""

    bodies: list[Body]
    stresses: tuple[ShellStress, ...] | None = None


@dataclass
class _Kept:
    """Structures of the last ``rolls`` by their sections, and modes with the fingerprint of their system."""

    rolls: int = 1
    bodies_alone: bool = False
    structures: dict[str, _Structure] = field(default_factory=dict)
    modes: Condensation | None = None
    system: bytes = b""


_kept: ContextVar[_Kept | None] = ContextVar("kept structure", default=None)


@contextmanager
def keeping_structure(rolls: int = 1, *, bodies_alone: bool = False) -> Iterator[None]:
    """Context manager for a series of runs: the structures of the last ``rolls`` are kept until it ends.

    With ``bodies_alone`` the modes are not kept, nor bodies of a mesh file, which may change between unrelated runs.
    """
    token = _kept.set(_Kept(rolls, bodies_alone))
    try:
        yield
    finally:
        _kept.reset(token)


def kept_bodies(roll: RollSections, half: bool, build: Callable[[], list[Body]]) -> list[Body]:
    """Bodies of a roll from ``build``, or those that are kept for the same sections; `half`: of half the roll."""
    kept = _kept.get()
    if kept is None or (kept.bodies_alone and roll.mesh.file is not None):
        return build()
    sections = f"{half} {roll.structure_text}"
    structure = kept.structures.pop(sections, None) or _Structure(build())
    kept.structures[sections] = structure  # the latest last
    if len(kept.structures) > kept.rolls:
        del kept.structures[next(iter(kept.structures))]
    return structure.bodies


def kept_stresses(bodies: Sequence[Body], compute: Callable[[], tuple[ShellStress, ...]]) -> tuple[ShellStress, ...]:
    """Recovery of the shell stresses of ``bodies`` from ``compute``, or that which is kept with these bodies."""
    kept = _kept.get()
    structures = [] if kept is None else list(kept.structures.values())
    own = next((structure for structure in structures if structure.bodies is bodies), None)
    if own is None:
        return compute()
    if own.stresses is None:
        own.stresses = compute()
    return own.stresses


def kept_modes(
    system: System, springs: FloatArray, moments: int, compute: Callable[[FloatArray], Condensation]
) -> Condensation:
    """Modes with ``springs`` (3 n_points,), Pa/m, turned from modes that depend on the structure alone.

    These have the normal penalty as spring in all directions (`turned_modes`); in a series they are computed once.
    ``compute`` returns the modes for given springs. It is called with ``springs`` themselves where modes cannot be
    turned: if all modes are wanted (``moments`` 0, see `condense`), without circumferential blocks, and if turned modes
    lack accuracy.
    """
    if not moments or not system.subspaces or not system.n_points:
        return compute(springs)
    kept = _kept.get()
    if kept is None or kept.bodies_alone:
        kept = _Kept()
    fingerprint = _fingerprint(system)
    if kept.modes is None or (kept.system, kept.modes.moments) != (fingerprint, moments):
        kept.modes, kept.system = compute(np.repeat(system.laws.kn, COMPONENTS)), fingerprint
    if kept.modes.n_theta == 1:
        return compute(springs)
    modes = turned(system, kept.modes, springs)
    return modes if missed(system, modes) <= MISSED else compute(springs)


def _fingerprint(system: System) -> bytes:
    """Hash of the matrices and rows that the modes depend on; damping ratios of modes are applied after turning."""
    found = hashlib.sha256()
    rows = [system.influence, system.output_rows, *system.probes.values(), system.weights, system.laws.kn]
    for matrix in (system.stiffness, system.mass, system.jump, system.damping):
        if matrix is not None:
            csr = sp.csr_matrix(matrix)
            rows += [csr.data, csr.indices, csr.indptr]
    for values in rows:
        found.update(np.ascontiguousarray(values).data)
    return found.digest()
