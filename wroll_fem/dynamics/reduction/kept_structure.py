"""Structure of a series: bodies and modes are computed once and used again for other preloads, laws and excitations.

Outside `keeping_structure` nothing is kept, and every run is independent of the runs before it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body
from wroll_fem.case.roll import RollSections
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.turned_modes import missed, turned
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

MISSED = 1e-6
"""Largest relative error of the compliance up to which turned modes are used."""


@dataclass
class _Kept:
    """Bodies with the sections they belong to, and modes with the fingerprint of their system."""

    sections: str = ""
    bodies: list[Body] | None = None
    system: bytes = b""
    modes: Condensation | None = None


_kept: ContextVar[_Kept | None] = ContextVar("kept structure", default=None)


@contextmanager
def keeping_structure() -> Iterator[None]:
    """Context manager for a series of runs: the last structure is kept until it ends."""
    token = _kept.set(_Kept())
    try:
        yield
    finally:
        _kept.reset(token)


def kept_bodies(roll: RollSections, half: bool, build: Callable[[], list[Body]]) -> list[Body]:
    """Bodies of a roll from ``build``, or those that are kept for the same sections; `half`: of half the roll."""
    kept = _kept.get()
    if kept is None:
        return build()
    parts = (roll.geometry, roll.mandrel, roll.coil, roll.mesh)
    sections = f"{half} " + " ".join(part.model_dump_json() for part in parts)
    if kept.bodies is None or kept.sections != sections:
        kept.bodies, kept.sections = build(), sections
    return kept.bodies


def kept_modes(system: System, springs: FloatArray, moments: int, compute: Callable[[], Condensation]) -> Condensation:
    """Modes from ``compute``, or those that are kept for the same matrices, turned to other springs (`turned_modes`).

    ``springs`` (3 n_points,) are those of the interfaces, Pa/m; for ``moments`` see `condense`. Modes of whole
    structures, in place of circumferential blocks, are always computed.
    """
    kept = _kept.get()
    if kept is None:
        return compute()
    fingerprint = _fingerprint(system)
    known = kept.modes if kept.system == fingerprint else None
    if known is not None and known.moments == moments:
        modes = turned(system, known, springs)
        if missed(system, modes) <= MISSED:
            return modes
    modes = compute()
    if modes.n_theta > 1:
        kept.modes, kept.system = modes, fingerprint
    return modes


def _fingerprint(system: System) -> bytes:
    """Hash of the matrices and rows that the modes depend on; damping ratios of modes are applied after turning."""
    found = hashlib.sha256()
    rows = [system.influence, system.output_rows, *system.probes.values(), system.weights, system.laws.kn]
    for matrix in (system.stiffness, system.mass, system.jump, system.damping):
        if matrix is not None:
            csr = sp.csr_matrix(matrix)
            rows += [csr.data, csr.indices, csr.indptr]
    for values in rows:
        found.update(np.ascontiguousarray(values).tobytes())
    return found.digest()
