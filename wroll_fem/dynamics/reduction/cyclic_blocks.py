"""Circumferential blocks of a roll with rotational symmetry and interface springs; a check that they are uncoupled.

A block holds the motions of one circumferential harmonic and one parity. A wall that couples stretch and shear, or
bending and twist (plies at an angle), has no plane of symmetry: the two parities of a harmonic are coupled. They then
form one block with two waves, the motions of both parities.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact.point import contact_dofs, normals, per_dof, tangentials
from wroll_fem.dynamics.system.cyclic_symmetry import Subspace
from wroll_fem.dynamics.system.system import System
from wroll_fem.typing import FloatArray

DECOUPLING = 1e-9
"""Largest relative coupling between circumferential harmonics that counts as zero; rounding causes about 1e-15."""


class Blocks:
    """Stiffness, mass and jump of the motions in each circumferential block of a roll.

    Attributes
    ----------
    system
        The roll.
    spaces
        The invariant subspaces (`cyclic_symmetry`) of each block: one, or both parities of a harmonic.
    springs
        (3 n_points,) springs in the interfaces, uniform around each row of contact points, Pa/m.
    area
        (n_rows, n_theta) area of the contact points, m^2.
    profiles
        (n_blocks, n_waves, 3, n_theta) shape of the hoop, axial and normal jump of each wave around a row.
    """

    @classmethod
    def of(cls, system: System, springs: FloatArray) -> Blocks | None:
        """Blocks of ``system``; None if they are coupled or if the interfaces have no common rows of contact points.

        ``springs`` (3 n_points,), Pa/m, are made uniform around each row (`level_springs`).
        """
        n_theta = points_per_row(system)
        if not system.subspaces or (n_theta == 1 and system.interfaces):
            return None
        springs = level_springs(system, springs, n_theta)
        for spaces in ([(space,) for space in system.subspaces], _both_parities(system.subspaces)):
            blocks = cls(system, spaces, springs, n_theta)
            if spaces and blocks._decoupled():
                return blocks
        return None

    def __init__(self, system: System, spaces: Sequence[tuple[Subspace, ...]], springs: FloatArray, n_theta: int):
        self.system, self.spaces, self.springs = system, spaces, springs
        self.area = system.laws.area.reshape(-1, n_theta)
        theta = system.interfaces[0].points[:n_theta, 0] if system.interfaces else np.zeros(1)
        self.profiles = np.array([[space.profile(theta) for space in block] for block in spaces])
        self._springs = system.interface_springs(springs)

    def __len__(self) -> int:
        return len(self.spaces)

    def harmonic(self, block: int) -> int:
        """Circumferential wave number of a block."""
        return self.spaces[block][0].harmonic

    def basis(self, block: int) -> sp.csc_matrix:
        """(n_dofs, k) basis of the k independent motions of a block."""
        bases = [space.basis for space in self.spaces[block]]
        return bases[0] if len(bases) == 1 else sp.hstack(bases, format="csc")

    def stiffness(self, block: int) -> sp.csr_matrix:
        """(k, k) stiffness matrix of a block; it includes the interface springs."""
        return self._projected(self.system.stiffness, block) + self._projected(self._springs, block)

    def mass(self, block: int) -> sp.csr_matrix:
        """(k, k) mass matrix of a block."""
        return self._projected(self.system.mass, block)

    def damping(self, block: int) -> sp.csr_matrix | None:
        """(k, k) viscous damping matrix of a block; None without damping."""
        return None if self.system.damping is None else self._projected(self.system.damping, block)

    def jump(self, block: int) -> sp.csr_matrix:
        """(n_waves 3 n_rows, k) amplitudes of the jump in each row of points, per unit motion of a block.

        They are sorted by wave, then by component (hoop, axial, normal), then by row.
        """
        return (amplitudes(self.profiles[block], self.area) @ self.system.jump) @ self.basis(block).tocsr()

    def _projected(self, matrix: sp.csr_matrix, block: int) -> sp.csr_matrix:
        basis = self.basis(block)
        return (basis.T @ matrix) @ basis.tocsr()

    def _decoupled(self) -> bool:
        """Whether the blocks are uncoupled, tested with one random motion of every subspace."""
        rng = np.random.default_rng(0)
        system = self.system
        for matrices in ((system.stiffness, self._springs), (system.mass,), (system.damping,)):
            present = [matrix for matrix in matrices if matrix is not None and matrix.nnz]
            if not present:
                continue
            bases = [self.basis(b) for b in range(len(self))]
            motions = np.column_stack([basis @ rng.standard_normal(basis.shape[1]) for basis in bases])
            energy = np.sum([motions.T @ (matrix @ motions) for matrix in present], axis=0)
            own = np.diag(energy)
            scale = np.sqrt(np.outer(own, own))
            if present[0] is system.damping:  # the dashpots may be local, and damp some blocks only
                scale = np.maximum(scale, own.max())
            if np.abs((energy - np.diag(own)) / scale).max() > DECOUPLING:
                return False
        return True


def _both_parities(subspaces: Sequence[Subspace]) -> list[tuple[Subspace, ...]]:
    """The subspaces of both parities of each harmonic, in pairs; empty if a harmonic lacks one of them."""
    by_harmonic: dict[int, list[Subspace]] = {}
    for space in subspaces:
        by_harmonic.setdefault(space.harmonic, []).append(space)
    pairs = [tuple(spaces) for spaces in by_harmonic.values()]
    return pairs if all(len({s.even for s in pair}) == len(pair) == 2 for pair in pairs) else []


def by_component(n: int) -> np.ndarray:
    """(3 n,) contact degrees of freedom of n points: all hoop, then all axial, then all normal components."""
    return contact_dofs(n).T.ravel()


def amplitudes(profiles: FloatArray, area: FloatArray) -> sp.csr_matrix:
    """(n_waves 3 n_rows, 3 n_points) matrix that gives the jump amplitudes in each row from the jump at all points.

    The amplitudes multiply ``profiles`` (n_waves, 3, n_theta), the shape of the hoop, axial and normal components of
    each wave around a row.
    """
    # a sine can vanish at all points up to rounding; with one wave the jump vanishes there as well
    if len(profiles) == 1:
        return _amplitudes(profiles[0], area, np.zeros((len(area), 1)))
    least = 1e-12 * area.sum(axis=1, keepdims=True)
    return sp.vstack([_amplitudes(profile, area, least) for profile in profiles], format="csr")


def _amplitudes(profile: FloatArray, area: FloatArray, least: FloatArray) -> sp.csr_matrix:
    """(3 n_rows, 3 n_points) `amplitudes` of the wave with ``profile`` (3, n_theta).

    Amplitudes of components whose squared shape has an integral below ``least`` (n_rows, 1), m^2, are zero.
    """
    rows, n = len(area), area.size
    norm = area @ (profile**2).T
    norm = np.where(norm > np.maximum(least, 1e-12 * norm.max(axis=0, initial=1e-300)), norm, np.inf)  # (n_rows, 3)
    share = area[:, :, None] * profile.T / norm[:, None, :]
    row = np.arange(rows)[:, None, None] + rows * np.arange(3)
    data, index = share.transpose(2, 0, 1).ravel(), np.broadcast_to(row, share.shape).transpose(2, 0, 1).ravel()
    return sp.csr_matrix((data, (index, by_component(n))), shape=(3 * rows, 3 * n))


def spread(blocks: FloatArray, profiles: FloatArray, area: FloatArray) -> FloatArray:
    """(3 n_points, 3 n_points) interface compliance, jump per unit traction, assembled from its blocks, m/Pa.

    Parameters
    ----------
    blocks : (n_blocks, n_waves 3 n_rows, n_waves 3 n_rows) amplitude of the jump per unit amplitude of the force, m/N
    profiles : (n_blocks, n_waves, 3, n_theta) shape of the hoop, axial and normal components of a wave around a row
    area : (n_points,) area of the contact points, m^2
    """
    n, (waves, n_theta) = len(area), (profiles.shape[1], profiles.shape[3])
    rows = n // n_theta
    split = blocks.reshape(len(blocks), waves, 3, rows, waves, 3, rows)
    whole = np.zeros((3, rows, n_theta, 3, rows, n_theta))
    for wave, other, i, k in itertools.product(range(waves), range(waves), range(3), range(3)):
        part = split[:, wave, i, :, other, k]
        whole[i, :, :, k] += np.einsum(
            "bt,brs,bu->rtsu", profiles[:, wave, i], part, profiles[:, other, k], optimize=True
        )
    dofs = by_component(n)
    dense = np.empty((3 * n, 3 * n))
    dense[np.ix_(dofs, dofs)] = whole.reshape(3 * n, 3 * n) * np.tile(area, 3)
    return dense


def without_tangential_springs(
    blocks: FloatArray, profiles: FloatArray, springs: FloatArray, area: FloatArray
) -> FloatArray:
    """Blocks of the interface compliance, m/N, after the tangential springs in the interfaces are taken away.

    ``blocks``, ``profiles`` and ``area`` are those of `spread`; ``springs`` (3 n_points,), Pa/m, are uniform around
    each row of contact points.
    """
    waves, n_theta = profiles.shape[1], profiles.shape[3]
    rows = len(area) // n_theta
    stiffness = tangentials(springs).reshape(rows, n_theta, 2)[:, 0]
    shares = np.einsum("rt,bwct,bvct->bwvcr", area.reshape(rows, n_theta), profiles, profiles, optimize=True)
    taken = np.zeros((len(blocks), waves, 3, rows, waves, 3, rows))
    for c, row in itertools.product(range(2), range(rows)):
        taken[:, :, c, row, :, c, row] = stiffness[row, c] * shares[:, :, :, c, row]
    size = blocks.shape[1]
    return np.linalg.solve(np.eye(size) - blocks @ taken.reshape(-1, size, size), blocks)


def level_springs(system: System, springs: FloatArray, n_theta: int) -> FloatArray:
    """Springs (3 n_points,), Pa/m, made uniform around each row of contact points.

    Tangential springs are the mean of the row. Normal springs are the normal penalty; they are zero if any point of the
    row is open.
    """
    tangential = tangentials(springs).reshape(-1, 2 * n_theta).mean(axis=1)
    closed = (normals(springs) > 0).reshape(-1, n_theta).all(axis=1)
    normal = np.where(closed, system.laws.kn[::n_theta], 0.0)
    return per_dof(np.repeat(tangential, n_theta), np.repeat(normal, n_theta))


def points_per_row(system: System) -> int:
    """Number of contact points per circumferential row if the points of all rows have the same angles; otherwise 1."""
    theta = np.concatenate([i.points[:, 0] for i in system.interfaces] or [np.zeros(0)])
    if theta.size == 0:
        return 1
    count = int(np.argmax(np.diff(theta) < 0)) + 1 if np.any(np.diff(theta) < 0) else len(theta)
    if len(theta) % count or np.ptp(theta.reshape(-1, count), axis=0).max() > 1e-7:
        return 1
    return count
