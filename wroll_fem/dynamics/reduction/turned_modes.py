r"""Modes of a structure with other springs in its interfaces, from modes that are known for one set of springs.

The span of a block in `condensation` contains the responses to forces at all of its rows of contact points. By the
Woodbury identity, :math:`(K + J^T E J)^{-1} x` lies in the span of :math:`K^{-1} x` and :math:`K^{-1} J^T`. The series
:math:`K^{-1} L, K^{-1} M K^{-1} L, \ldots` with :math:`J^T` among the loads L therefore spans the same space for all
springs. In the known modes the stiffness becomes :math:`\Lambda + J^T E J` (E: change of the springs), and the new
modes follow from one small eigenproblem per block. What rounding takes from the span is checked (`missed`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg as la

from wroll_fem.contact.point import normals, tangentials
from wroll_fem.dynamics.reduction.condensation import Condensation, modal_losses, viscous_damping
from wroll_fem.dynamics.reduction.cyclic_blocks import level_springs
from wroll_fem.dynamics.system.system import System
from wroll_fem.numerics.linear import factorise
from wroll_fem.typing import FloatArray

COMPONENTS = 3
"""Hoop, axial and normal jump of a row of contact points."""


def turned(system: System, known: Condensation, springs: FloatArray) -> Condensation:
    """Modes with ``springs`` (3 n_points,), Pa/m, from the modes ``known`` of the same structure.

    Parameters
    ----------
    known
        Modes in circumferential blocks (`condense_cyclic`); matrices and interfaces are those of ``system``.
    springs
        They are made uniform around each row of contact points (`level_springs`).
    """
    springs = level_springs(system, springs, known.n_theta)
    change = _weighted(system, known, springs - known.springs)
    values, rotations = [], []
    for block, (jump, start) in enumerate(zip(known.jump, known.blocks[:-1], strict=True)):
        own = known.eigenvalues[start : start + jump.shape[1]]
        stiffness = np.diag(own) + jump.T @ (change[block] @ jump)
        new, rotation = la.eigh(0.5 * (stiffness + stiffness.T), overwrite_a=True, check_finite=False)
        values.append(new)
        rotations.append(rotation)
    eigenvalues = np.concatenate(values)
    vectors = [(basis, ritz @ turn) for (basis, ritz), turn in zip(known.vectors, rotations, strict=True)]
    coupled, losses = [], []
    for basis, ritz in vectors:
        losses.append(modal_losses(system, basis, ritz))
        if system.damping is not None:
            shapes = basis @ ritz
            coupled.append(shapes.T @ (system.damping @ shapes))
    cuts = known.blocks[1:-1]
    return replace(
        known,
        eigenvalues=eigenvalues,
        vectors=vectors,
        jump=[np.ascontiguousarray(j @ turn) for j, turn in zip(known.jump, rotations, strict=True)],
        base=_turn(known.base, rotations, cuts),
        tip=_turn(known.tip, rotations, cuts),
        probes=np.array([_turn(row, rotations, cuts) for row in known.probes]).reshape(known.probes.shape),
        springs=springs,
        damping=viscous_damping(system, eigenvalues, [len(v) for v in values], coupled, np.concatenate(losses)),
    )


def missed(system: System, modes: Condensation) -> float:
    """Largest relative error of the static compliance of ``modes`` under loads of the base, the tip and the interfaces.

    The loads act on the block that the base excites most; there the stiffness of ``system`` with the springs of the
    modes is factorised.
    """
    share = [np.abs(part).max(initial=0.0) for part in np.split(modes.base, modes.blocks[1:-1])]
    block = int(np.argmax(share))
    basis, ritz = modes.vectors[block]
    parts = (system.stiffness, system.interface_springs(modes.springs))
    stiffness = sum((basis.T @ part) @ basis for part in parts)
    contact = system.contact_force(np.random.default_rng(0).standard_normal(system.n_points * COMPONENTS))
    loads = basis.T @ np.column_stack([system.mass @ system.influence, system.probes["tip"], contact])
    exact = np.einsum("ij,ij->j", loads, factorise(stiffness.tocsc()).solve(np.ascontiguousarray(loads)))
    start, end = modes.blocks[block : block + 2]
    found = ((ritz.T @ loads) ** 2 / modes.eigenvalues[start:end, None]).sum(axis=0)
    return float(np.abs(found / exact - 1.0).max())


def _turn(values: FloatArray, rotations: list[FloatArray], cuts: np.ndarray) -> FloatArray:
    """(r,) values of the new modes from those of the known ones."""
    return np.concatenate([turn.T @ part for part, turn in zip(np.split(values, cuts), rotations, strict=True)])


def _weighted(system: System, known: Condensation, springs: FloatArray) -> list[FloatArray]:
    """Stiffness (n_waves 3 n_rows, n_waves 3 n_rows) of uniform ``springs``, N/m, of each block, per jump amplitude."""
    n_theta = known.n_theta
    area = system.laws.area.reshape(-1, n_theta)
    by_row = [tangentials(springs)[::n_theta, 0], tangentials(springs)[::n_theta, 1], normals(springs)[::n_theta]]
    found = []
    for profiles in known.profiles:
        waves, rows = len(profiles), len(area)
        whole = np.zeros((waves, COMPONENTS, rows, waves, COMPONENTS, rows))
        for one in range(waves):
            for other in range(waves):
                for c in range(COMPONENTS):
                    weight = by_row[c] * (area @ (profiles[one, c] * profiles[other, c]))
                    whole[one, c, range(rows), other, c, range(rows)] = weight
        found.append(whole.reshape(2 * (waves * COMPONENTS * rows,)))
    return found
