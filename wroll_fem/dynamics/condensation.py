"""Modes of a structure with its interfaces held by springs, block by circumferential block.

They carry the interior exactly (no truncation) and give the compliance of the interfaces, for statics and for steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from ..body import FloatArray
from .hht import Scheme
from .linear import factorise
from .system import System

DENSE_LIMIT = 2500
"""Without rotational symmetry all modes are kept up to this many DOFs."""

LOW_MODES = 120
"""Low modes kept by the projection of a larger structure without rotational symmetry."""

DECOUPLING = 1e-9
"""Largest relative coupling between harmonics that still counts as none (rounding leaves 1e-15)."""


@dataclass(frozen=True)
class Condensation:
    """Modes of the structure with its sticking interface, block by block; modal mass is one.

    Attributes
    ----------
    eigenvalues : (r,) rad^2/s^2, block after block
    blocks : (n_blocks + 1,) first mode of each block
    vectors : one (n_dofs, r_b) per block, sparse basis times dense Ritz vectors kept as a pair
    jump : one (3 n_rows, r_b) per block: amplitude of the hoop, axial, normal jump in each row of points
    profiles : (n_blocks, 3, n_theta) shape of these components around a row
    base : (r,) inertia force per unit base acceleration, kg^(1/2)
    tip : (r,) tip displacement
    springs : (3 n_points,) D_0, Pa/m
    exact : False when a large structure without symmetry was projected
    """

    eigenvalues: FloatArray
    blocks: np.ndarray
    vectors: list[tuple[sp.csc_matrix, FloatArray]]
    jump: list[FloatArray]
    profiles: FloatArray
    base: FloatArray
    tip: FloatArray
    springs: FloatArray
    exact: bool

    @property
    def n_theta(self) -> int:
        """Points per row."""
        return int(self.profiles.shape[2])

    def displacement(self, q: FloatArray) -> FloatArray:
        """(n_dofs,) displacement of modal coordinates (r,)."""
        parts = np.split(q, self.blocks[1:-1])
        return np.sum([basis @ (ritz @ part) for (basis, ritz), part in zip(self.vectors, parts, strict=True)], axis=0)

    def compliance(self, inverse: FloatArray, area: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Jump per traction, G V diag(inverse) V^T G^T W, block by block and as a whole.

        Parameters
        ----------
        inverse : (r,) factor of each mode, s^2 (1/eigenvalue for statics)
        area : (n_points,) m^2

        Returns
        -------
        blocks : (n_blocks, 3 n_rows, 3 n_rows) amplitude per amplitude of force, m/N
        dense : (3 n_points, 3 n_points) in slot order, m/Pa
        """
        n, n_theta = len(area), self.n_theta
        rows = n // n_theta
        parts = np.split(inverse, self.blocks[1:-1])
        blocks = np.array([(j * p) @ j.T for j, p in zip(self.jump, parts, strict=True)])
        split = blocks.reshape(len(blocks), 3, rows, 3, rows)
        whole = np.empty((3, rows, n_theta, 3, rows, n_theta))
        for i in range(3):
            for k in range(3):
                whole[i, :, :, k] = np.einsum(
                    "bt,brs,bu->rtsu", self.profiles[:, i], split[:, i, :, k], self.profiles[:, k], optimize=True
                )
        slots = _by_component(n)
        dense = np.empty((3 * n, 3 * n))
        dense[np.ix_(slots, slots)] = whole.reshape(3 * n, 3 * n) * np.tile(area, 3)
        return blocks, dense

    def coordinates(self, momentum: FloatArray) -> FloatArray:
        """(r,) modal coordinates of a displacement u, from M u (n_dofs,)."""
        return np.concatenate([ritz.T @ (basis.T @ momentum) for basis, ritz in self.vectors])


def condense_cyclic(system: System, springs: FloatArray) -> Condensation | None:
    """Exact modes of a roll with rotational symmetry; None for a structure without it.

    Parameters
    ----------
    springs
        (3 n_points,) interface springs per slot, Pa/m; they are levelled around each row of points.
    """
    n_theta = _points_per_row(system)
    if not system.subspaces or (n_theta == 1 and system.interfaces):
        return None
    level = _level_springs(system, springs, n_theta)
    stiffness = system.with_interface_springs(level)
    if not _decoupled(system, stiffness):
        return None
    return _condense_blocks(system, stiffness, level, n_theta)


def condense(system: System, springs: FloatArray, scheme: Scheme, dt: float) -> Condensation:
    """Modes and interface amplitudes of ``system`` with ``springs`` (3 n_points,) in its interfaces.

    Parameters
    ----------
    scheme, dt
        Used by the projection of a large structure without rotational symmetry only.
    """
    cyclic = condense_cyclic(system, springs)
    if cyclic is not None:
        return cyclic
    stiffness = system.with_interface_springs(springs)
    exact = system.n_dofs <= DENSE_LIMIT
    if exact:
        values, vectors = la.eigh(stiffness.toarray(), system.mass.toarray())
    else:
        values, vectors = _attachment_projection(system, stiffness, scheme, dt)
    return Condensation(
        eigenvalues=values,
        blocks=np.array([0, len(values)]),
        vectors=[(sp.identity(system.n_dofs, format="csc"), vectors)],
        jump=[np.ascontiguousarray((system.jump @ vectors)[_by_component(system.n_points)])],
        profiles=np.ones((1, 3, 1)),
        base=vectors.T @ (system.mass @ system.influence),
        tip=vectors.T @ system.probes["tip"],
        springs=springs,
        exact=exact,
    )


def _by_component(n: int) -> np.ndarray:
    """Slots of n points ordered hoop, axial, normal."""
    k = np.arange(n)
    return np.concatenate([2 * k, 2 * k + 1, 2 * n + k])


def _level_springs(system: System, springs: FloatArray, n_theta: int) -> FloatArray:
    """Springs (3 n_points,) that are the same all around each row of points: means, or none where a point is open."""
    n = system.n_points
    tangential = springs[: 2 * n].reshape(-1, 2 * n_theta).mean(axis=1)
    closed = (springs[2 * n :] > 0).reshape(-1, n_theta).all(axis=1)
    return np.concatenate(
        [np.repeat(tangential, 2 * n_theta), np.repeat(np.where(closed, system.laws.kn[::n_theta], 0.0), n_theta)]
    )


def _points_per_row(system: System) -> int:
    """Points per height when all interfaces share one set of angles at every height, else 1."""
    theta = np.concatenate([i.points[:, 0] for i in system.interfaces] or [np.zeros(0)])
    if theta.size == 0:
        return 1
    count = int(np.argmax(np.diff(theta) < 0)) + 1 if np.any(np.diff(theta) < 0) else len(theta)
    if len(theta) % count or np.ptp(theta.reshape(-1, count), axis=0).max() > 1e-7:
        return 1
    return count


def _decoupled(system: System, stiffness: sp.spmatrix) -> bool:
    """Whether harmonics really do not couple, checked on random motions of every subspace."""
    rng = np.random.default_rng(0)
    for matrix in (stiffness, system.mass):
        motions = np.column_stack([s.basis @ rng.standard_normal(s.basis.shape[1]) for s in system.subspaces])
        energy = motions.T @ (matrix @ motions)
        scale = np.sqrt(np.outer(np.diag(energy), np.diag(energy)))
        if np.abs(energy / scale - np.eye(len(energy))).max() > DECOUPLING:
            return False
    return True


def _condense_blocks(system: System, stiffness: sp.spmatrix, springs: FloatArray, n_theta: int) -> Condensation:
    n, inertia, tip = system.n_points, system.mass @ system.influence, system.probes["tip"]
    theta = system.interfaces[0].points[:n_theta, 0] if n else np.zeros(1)
    area = system.laws.area.reshape(-1, n_theta)
    values, vectors, jumps, profiles, base, probe = [], [], [], [], [], []
    for space in system.subspaces:
        basis: sp.csc_matrix = space.basis
        block = [np.asarray((basis.T @ matrix @ basis).todense()) for matrix in (stiffness, system.mass)]
        eigenvalues, ritz = la.eigh(*block)
        profile = space.profile(theta)
        slot_jump = np.asarray((system.jump @ basis).todense()) @ ritz
        values.append(eigenvalues)
        vectors.append((basis, ritz))
        jumps.append(_amplitudes(slot_jump, profile, area, n))
        profiles.append(profile)
        base.append(ritz.T @ (basis.T @ inertia))
        probe.append(ritz.T @ (basis.T @ tip))
    return Condensation(
        eigenvalues=np.concatenate(values),
        blocks=np.concatenate([[0], np.cumsum([len(v) for v in values])]),
        vectors=vectors,
        jump=jumps,
        profiles=np.array(profiles),
        base=np.concatenate(base),
        tip=np.concatenate(probe),
        springs=springs,
        exact=True,
    )


def _amplitudes(slot_jump: FloatArray, profile: FloatArray, area: FloatArray, n: int) -> FloatArray:
    """(3 n_rows, r) amplitudes of a jump (3 n, r) that follows ``profile`` around every row."""
    rows, n_theta = area.shape
    r = slot_jump.shape[1]
    tangential = slot_jump[: 2 * n].reshape(rows, n_theta, 2, r)
    parts = []
    for c, values in enumerate(
        (tangential[:, :, 0], tangential[:, :, 1], slot_jump[2 * n :].reshape(rows, n_theta, r))
    ):
        norm = area @ profile[c] ** 2
        projected = np.einsum("ij,j,ijk->ik", area, profile[c], values)
        parts.append(projected / np.where(norm > 1e-12 * norm.max(initial=1e-300), norm, np.inf)[:, None])
    return np.ascontiguousarray(np.concatenate(parts))


def _attachment_projection(
    system: System, stiffness: sp.spmatrix, scheme: Scheme, dt: float
) -> tuple[FloatArray, FloatArray]:
    """Rayleigh-Ritz values and vectors (n_dofs, r) on attachment vectors and low modes."""
    loads = np.column_stack([system.jump.T.toarray(), system.mass @ system.influence, system.probes["tip"]])
    static = factorise(stiffness)
    dynamic = factorise(system.mass / (scheme.beta * dt**2) + (1.0 + scheme.alpha) * stiffness)
    start = np.random.default_rng(1).standard_normal(system.n_dofs)
    inverse = spla.LinearOperator(stiffness.shape, matvec=static.solve)
    modes = spla.eigsh(stiffness, LOW_MODES, system.mass, sigma=0.0, OPinv=inverse, v0=start)[1]
    attachments = dynamic.solve(loads)
    span = np.column_stack([modes, static.solve(loads), attachments, dynamic.solve(system.mass @ attachments)])
    scale = np.sqrt(np.einsum("ij,ij->j", span, system.mass @ span))
    span = span[:, scale > 0.0] / scale[scale > 0.0]  # hoop motion vanishes on a symmetry plane
    gram = span.T @ (system.mass @ span)
    weight, rotation = la.eigh(0.5 * (gram + gram.T))
    keep = weight > 1e-11 * weight[-1]
    basis = span @ (rotation[:, keep] / np.sqrt(weight[keep]))
    values, ritz = la.eigh(basis.T @ (stiffness @ basis), basis.T @ (system.mass @ basis))
    return values, basis @ ritz
