r"""Exact condensation on the interfaces.

With a fixed step the HHT matrix S is constant and the jump is linear in the interface traction,

.. math:: g_{n+1} = \hat g_{n+1} - F\, s(g_{n+1}), \qquad F = (1+\alpha)\, G S^{-1} G^T W,

so only a dense system of interface size is nonlinear. Three things make it small and fast:

* The sticking interface of the preload state (springs :math:`D_0`) is part of the linear structure.
  The correction :math:`s = t(g) - t_0 - D_0 (g - g_0)` vanishes where a point sticks at its preload
  pressure; Newton's matrix is formed only for points that slip, open or changed their pressure.
* The structure moves in its modes, all of them: no truncation. K and M of a roll with rotational symmetry
  fall into blocks, one per circumferential harmonic (`cyclic`), so that all modes are cheap to find and to carry.
* F is applied harmonic by harmonic.

A structure without rotational symmetry and with more than `DENSE_LIMIT` DOFs is projected on static and
dynamic attachment vectors of every interface component and the low modes instead. That is accurate to about 1e-4
of the largest displacement, not exact, and `Condensation.exact` says so.

References
----------
Rubin (1975), AIAA J. 13, 995, doi:10.2514/3.60497 (attachment modes).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from ..body import FloatArray
from .condensed_kernel import advance_steps
from .cyclic import Subspace
from .hht import Scheme
from .linear import factorise
from .static import ContactState, TrialContact
from .stepper import NewtonOptions, Stepper
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

    def coordinates(self, momentum: FloatArray) -> FloatArray:
        """(r,) modal coordinates of a displacement u, from M u (n_dofs,)."""
        return np.concatenate([ritz.T @ (basis.T @ momentum) for basis, ritz in self.vectors])


def stick_springs(system: System, state: ContactState) -> FloatArray:
    """(3 n_points,) stiffness per slot of the contact that sticks at ``state``, Pa/m; open points have none."""
    law, pressure = system.laws, state.pressure
    closed = (pressure > 0) | ~law.separation
    return np.concatenate([np.repeat(law.mu * pressure / law.gamma, 2), np.where(closed, law.kn, 0.0)])


def condense(system: System, state: ContactState, scheme: Scheme, dt: float) -> Condensation:
    """Modes and interface amplitudes of ``system`` linearised with its points sticking at ``state``.

    Parameters
    ----------
    scheme, dt
        Used by the projection of a large structure without rotational symmetry only.
    """
    springs = stick_springs(system, state)
    n_theta = _points_per_row(system)
    if system.subspaces and (n_theta > 1 or not system.interfaces):
        level = _level_springs(system, springs, n_theta)
        stiffness = system.with_interface_springs(level)
        if _decoupled(system, stiffness):
            return _condense_cyclic(system, stiffness, level, n_theta)
    stiffness = system.with_interface_springs(springs)
    exact = system.n_dofs <= DENSE_LIMIT
    if exact:
        values, vectors = la.eigh(stiffness.toarray(), system.mass.toarray())
    else:
        values, vectors = _attachment_projection(system, stiffness, scheme, dt)
    n = system.n_points
    slots = np.concatenate([2 * np.arange(n), 2 * np.arange(n) + 1, 2 * n + np.arange(n)])
    return Condensation(
        eigenvalues=values,
        blocks=np.array([0, len(values)]),
        vectors=[(sp.identity(system.n_dofs, format="csc"), vectors)],
        jump=[np.ascontiguousarray((system.jump @ vectors)[slots])],
        profiles=np.ones((1, 3, 1)),
        base=vectors.T @ (system.mass @ system.influence),
        tip=vectors.T @ system.probes["tip"],
        springs=springs,
        exact=exact,
    )


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


def _condense_cyclic(system: System, stiffness: sp.spmatrix, springs: FloatArray, n_theta: int) -> Condensation:
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
    for c, values in enumerate((tangential[:, :, 0], tangential[:, :, 1], slot_jump[2 * n :].reshape(rows, n_theta, r))):
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


class CondensedStepper(Stepper):
    """Time stepping in condensed coordinates; state attributes are documented in `condensed_kernel`."""

    state_names = ("q", "v", "a", "residual", "residual_change", "jump", "jump_before", "elastic_slip", "traction")

    def __init__(
        self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float
    ):
        super().__init__(system, preload, scheme, options)
        self.condensation = condense(system, preload, scheme, dt)
        r = len(self.condensation.eigenvalues)
        self.q, self.v, self.a = np.zeros(r), np.zeros(r), np.zeros(r)
        self.residual, self.residual_change = np.zeros(r), np.zeros(r)
        self.jump, self.jump_before = preload.jump.copy(), preload.jump.copy()
        self.elastic_slip, self.traction = preload.elastic_slip.copy(), preload.traction.copy()
        self._modal_jump = np.concatenate([block.ravel() for block in self.condensation.jump])
        self._operators: dict[float, tuple[FloatArray, FloatArray, FloatArray]] = {}
        self.last_history = []

    def displacement(self) -> FloatArray:
        """(n_dofs,) displacement relative to the preload state, m."""
        return self.condensation.displacement(self.q)

    def start_from(self, displacement: FloatArray) -> None:
        """Release from rest at ``displacement`` (n_dofs,) in m, on top of the preload state."""
        c, system = self.condensation, self.system
        self.q[:] = c.coordinates(system.mass @ displacement)
        trial = TrialContact(system)
        jump = self.preload.jump + system.jump @ displacement
        traction = trial(jump, self.preload)
        correction = traction - self.preload.traction - c.springs * (jump - self.preload.jump)
        self.jump[:] = self.jump_before[:] = jump
        self.elastic_slip[:], self.traction[:] = trial.elastic_slip, traction
        force = system.jump.T @ (system.weights * correction)
        self.residual[:] = c.eigenvalues * self.q + np.concatenate([r.T @ (b.T @ force) for b, r in c.vectors])
        self.a[:] = -self.residual

    def _operator(self, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Modal factor 1/S (r,), compliance per block (n_blocks, 3 n_rows, 3 n_rows) and dense F (3 n, 3 n)."""
        if dt not in self._operators:
            c, s, n = self.condensation, self.scheme, self.system.n_points
            inverse = 1.0 / (1.0 / (s.beta * dt**2) + (1.0 + s.alpha) * c.eigenvalues)
            parts = np.split(inverse, c.blocks[1:-1])
            blocks = np.array([(1.0 + s.alpha) * (j * p) @ j.T for j, p in zip(c.jump, parts, strict=True)])
            rows, n_theta = n // c.n_theta if n else 0, c.n_theta
            split = blocks.reshape(len(blocks), 3, rows, 3, rows)
            dense = np.empty((3, rows, n_theta, 3, rows, n_theta))
            for i in range(3):
                for j in range(3):
                    dense[i, :, :, j] = np.einsum(
                        "bt,brs,bu->rtsu", c.profiles[:, i], split[:, i, :, j], c.profiles[:, j], optimize=True
                    )
            k = np.arange(n)
            slots = np.concatenate([2 * k, 2 * k + 1, 2 * n + k])
            compliance = np.empty((3 * n, 3 * n))
            compliance[np.ix_(slots, slots)] = dense.reshape(3 * n, 3 * n) * np.tile(self.system.laws.area, 3)
            self._operators[dt] = inverse, blocks, compliance
        return self._operators[dt]

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        law, c, s = self.system.laws, self.condensation, self.scheme
        inverse, blocks, compliance = self._operator(dt)
        history = np.zeros(self.options.max_iterations + 1)
        done = advance_steps(
            np.ascontiguousarray(acceleration), dt, s.alpha, s.beta, s.gamma,
            c.eigenvalues, c.blocks, self._modal_jump, np.ascontiguousarray(c.profiles.transpose(1, 0, 2)),
            c.base, c.tip, c.springs, inverse, blocks, compliance,
            self.preload.jump, self.preload.traction,
            law.area, law.kn, law.separation, law.mu, law.gamma,
            self.q, self.v, self.a, self.residual, self.residual_change,
            self.jump, self.jump_before, self.elastic_slip, self.traction,
            self.totals, self.flows, self.slip.path, self.slip.peak, self.slip.peak_vector,
            self.residual_limit, self.options.max_iterations, history, records,
        )  # fmt: skip
        if done < len(acceleration) - 1:
            self.last_history = [float(h) for h in history if h > 0.0]
        return int(done)


__all__ = ["Condensation", "CondensedStepper", "Subspace", "condense", "stick_springs"]
