r"""Reduced models of the structure, their projection error, and maps between modes and contact points.

The reduced equation of motion in mass-orthonormal coordinates q, relative to the preload state,

.. math:: \ddot q + \Lambda q + C q' + (G \Phi)^T W\,[t(g) - t_0 - D_0 (g - g_0)] = -b\,a_g, \qquad g = g_0 + G \Phi q

is the exact equation of `condensed` with the basis :math:`\Phi` in place of all modes. The projection is the only
approximation. The part of the motion outside the basis is therefore found from the residual of the full model
(`ReducedModel.projection_error`), and can be added to the basis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from wroll_fem.contact.point import contact_dofs
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.errors import ConvergenceError, InputError
from wroll_fem.typing import FloatArray

DEPENDENT = 1e-7
"""Tolerance of linear dependence. A vector is dropped if its component orthogonal to the vectors already kept is
smaller than this fraction of the vector, both in the energy norm."""


@dataclass(frozen=True)
class ReducedModel:
    """Structure with its interfaces stuck, in m reduced coordinates; the mass matrix is the identity.

    Attributes
    ----------
    eigenvalues : (m,) rad^2/s^2
    jump : (3 n_points, m) relative displacement per unit coordinate
    base : (m,) participation factors; the load is -base per unit base acceleration, kg^(1/2)
    tip : (m,) tip displacement per unit coordinate
    probes : (p, m) displacement at the other probes and rows of the loads at the base, per unit coordinate
    springs : (3 n_points,) reference contact stiffness D_0, which the structure includes, Pa/m
    vectors : (r, m) basis vectors in modal coordinates of ``condensation``
    condensation : all modes of the structure
    damping : (m, m) viscous damping, 1/s; None without damping
    """

    eigenvalues: FloatArray
    jump: FloatArray
    base: FloatArray
    tip: FloatArray
    probes: FloatArray
    springs: FloatArray
    vectors: FloatArray
    condensation: Condensation
    damping: FloatArray | None = None

    @property
    def size(self) -> int:
        """Number of reduced coordinates."""
        return len(self.eigenvalues)

    @property
    def main_mode(self) -> int:
        """Index of the mode with the largest static tip displacement per unit base acceleration."""
        return int(np.argmax(np.abs(self.base * self.tip) / np.maximum(self.eigenvalues, 1e-300)))

    @classmethod
    def complete(cls, condensation: Condensation) -> ReducedModel:
        """Exact model that keeps every mode, for small systems."""
        return cls.on(condensation, np.eye(len(condensation.eigenvalues)), condensation.eigenvalues)

    @classmethod
    def of_vectors(cls, condensation: Condensation, vectors: FloatArray) -> ReducedModel:
        """Model whose basis spans ``vectors`` (r, k), in modal coordinates; linearly dependent vectors are dropped.

        Raises
        ------
        InputError
            If no vector is left.
        """
        return cls.on(condensation, *ritz_vectors(condensation, vectors))

    @classmethod
    def on(cls, condensation: Condensation, vectors: FloatArray, values: FloatArray) -> ReducedModel:
        """Model with the mass-orthonormal basis ``vectors`` (r, m), in which the stiffness is diag(``values``)."""
        return cls(
            eigenvalues=np.ascontiguousarray(values),
            jump=contact_jump(condensation, vectors),
            base=vectors.T @ condensation.base,
            tip=vectors.T @ condensation.tip,
            probes=condensation.probes @ vectors,
            springs=condensation.springs,
            vectors=vectors,
            condensation=condensation,
            damping=vectors.T @ condensation.viscous_force(vectors) if condensation.damping else None,
        )

    def enriched(self, vectors: FloatArray) -> ReducedModel:
        """Model whose basis also contains ``vectors`` (r, k)."""
        return ReducedModel.of_vectors(self.condensation, np.column_stack([self.vectors, vectors]))

    def projection_error(self, response: FloatArray, inside: FloatArray) -> FloatArray:
        """Displacement (r, k) outside the span of the basis, estimated from the residual force of the full model.

        Motion outside the basis is quasi-static because the modes that it needs lie far above the excitation. It is
        therefore the static ``response`` (r, k) to the residual force minus the part of this response in the basis.
        ``inside`` (m, k) is the residual force in reduced coordinates. Displacements are in modal coordinates.
        """
        return np.asarray(response - self.vectors @ (inside / self.eigenvalues[:, None]))

    def energy_norm(self, displacement: FloatArray) -> FloatArray:
        """Square root of twice the strain energy of modal displacements (r, ...) with the interface stuck, J^(1/2)."""
        values = self.condensation.eigenvalues.reshape(-1, *[1] * (displacement.ndim - 1))
        return np.sqrt(np.sum(values * displacement**2, axis=0))


def ritz_vectors(condensation: Condensation, vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mass-orthonormal basis (r, m) of the span of ``vectors`` (r, k) with a diagonal stiffness, and its diagonal (m,).

    Linearly dependent vectors are dropped.

    Raises
    ------
    InputError
        If no vector is left.
    ConvergenceError
        If a vector has no stiffness.
    """
    basis = _orthonormal(vectors, condensation.eigenvalues)
    if basis.shape[1] == 0:
        raise InputError("a reduced model needs at least one basis vector that is not zero")
    stiffness = basis.T @ (condensation.eigenvalues[:, None] * basis)
    values, ritz = la.eigh(0.5 * (stiffness + stiffness.T))
    return basis @ ritz, values


def contact_jump(condensation: Condensation, vectors: FloatArray) -> FloatArray:
    """(3 n_points, k) jump at the contact points from k displacements ``vectors`` (r, k) in modal coordinates."""
    amplitudes = [j @ part for j, part in zip(condensation.jump, _parts(condensation, vectors), strict=True)]
    profiles = _by_wave(condensation)
    rows, k = amplitudes[0].shape[0] * len(amplitudes) // (3 * len(profiles)), vectors.shape[1]
    stacked = np.array(amplitudes).reshape(len(profiles), 3, rows * k)
    n = rows * condensation.n_theta
    out = np.empty((3 * n, k))
    for component, dofs in enumerate(contact_dofs(n).T):
        around = profiles[:, component].T @ stacked[:, component]  # (n_theta, rows k)
        out[dofs] = around.reshape(condensation.n_theta, rows, k).transpose(1, 0, 2).reshape(n, k)
    return out


def modal_force(condensation: Condensation, force: FloatArray) -> FloatArray:
    """(r, k) modal forces V^T G^T f (V: mode shapes) due to the contact forces f (3 n_points, k), N."""
    k, n_theta = force.shape[1], condensation.n_theta
    n = force.shape[0] // 3
    rows = n // n_theta
    profiles = _by_wave(condensation)
    amplitudes = np.empty((len(profiles), 3, rows * k))
    for component, dofs in enumerate(contact_dofs(n).T):
        around = force[dofs].reshape(rows, n_theta, k).transpose(1, 0, 2).reshape(n_theta, rows * k)
        amplitudes[:, component] = profiles[:, component] @ around
    flat = amplitudes.reshape(len(condensation.jump), -1, k)
    return np.concatenate([j.T @ part for j, part in zip(condensation.jump, flat, strict=True)])


def _by_wave(condensation: Condensation) -> FloatArray:
    """(n_blocks n_waves, 3, n_theta) profiles of the waves, block after block."""
    return condensation.profiles.reshape(-1, 3, condensation.n_theta)


def _parts(condensation: Condensation, vectors: FloatArray) -> list[FloatArray]:
    return np.split(vectors, condensation.blocks[1:-1])


def _orthonormal(vectors: FloatArray, eigenvalues: FloatArray) -> FloatArray:
    """Mass-orthonormal basis of the span of ``vectors``.

    Dependent vectors are found in the energy norm, which weighs local interface shapes as much as modes.
    """
    moves = vectors.any(axis=1)
    if not moves.all():  # modes in which no vector has a component are left out
        part = _orthonormal(vectors[moves], eigenvalues[moves])
        whole = np.zeros((len(vectors), part.shape[1]))
        whole[moves] = part
        return whole
    root = np.sqrt(np.maximum(eigenvalues, 0.0))[:, None]
    energy = root * vectors
    size = np.linalg.norm(energy, axis=0)
    unit = vectors[:, size > 0.0] / size[size > 0.0]
    if unit.shape[1] == 0:
        return unit
    _, triangle, order = la.qr(root * unit, mode="economic", pivoting=True)
    rank = int(np.sum(np.abs(np.diag(triangle)) > DEPENDENT))
    kept = unit[:, order[:rank]]
    # solve for the energy-orthonormal combination, then make it mass-orthonormal
    kept = la.solve_triangular(triangle[:rank, :rank], kept.T, trans="T").T
    gram = kept.T @ kept
    weight, rotation = la.eigh(0.5 * (gram + gram.T))
    if not weight.min() > 0.0:
        raise _without_stiffness()
    basis = kept @ (rotation / np.sqrt(weight))
    again = basis.T @ basis  # one more pass takes the rounding of small weights out
    try:
        factor = la.cholesky(0.5 * (again + again.T))
    except la.LinAlgError:
        raise _without_stiffness() from None
    return np.asarray(la.solve_triangular(factor, basis.T, trans="T").T)


def _without_stiffness() -> ConvergenceError:
    """Error of a motion whose energy vanishes beside its mass, so that rounding leaves nothing of the other motions."""
    return ConvergenceError(
        "no reduced model found for a motion without stiffness", time_s=None, iterations=0, residual_history=[],
        advice="hold every body by a support, a spring, or a contact that sticks at rest",
    )  # fmt: skip
