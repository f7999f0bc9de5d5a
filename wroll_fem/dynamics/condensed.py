r"""Exact condensation on the interfaces.

With a fixed step the HHT matrix is constant and the jump is linear in the interface traction,

.. math:: g_{n+1} = \hat g_{n+1} - F\, s(g_{n+1}), \qquad F = (1+\alpha)\, G S^{-1} G^T W,

so only a dense system of interface size is nonlinear. Two things make it small and fast:

* The sticking interface of the preload state (springs :math:`D_0`) is part of the linear structure.
  The correction :math:`s = t(g) - t_0 - D_0 (g - g_0)` vanishes where a point sticks at its preload
  pressure; Newton's matrix is formed only for points that slip, open or changed their pressure.
* The interior follows in the coordinates that diagonalise (K, M) on the space spanned by the attachment
  vectors :math:`S^{-1} G^T` of *all* interface components (which make F exact) and the low modes (which carry the history).

References
----------
Rubin (1975), AIAA J. 13, 995, doi:10.2514/3.60497 (attachment modes with residual dynamics).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse.linalg as spla

from ..body import FloatArray
from .condensed_kernel import advance_steps
from .hht import Scheme
from .linear import factorise
from .static import ContactState
from .stepper import RECORDS, NewtonOptions, Stepper
from .system import System

DENSE_LIMIT = 1200
"""Up to this many DOFs all modes are kept: no truncation at all."""


@dataclass(frozen=True)
class Condensation:
    """Diagonal coordinates q of the structure with its sticking interface; u = vectors q, mass = identity.

    Attributes
    ----------
    eigenvalues : (r,) rad^2/s^2
    vectors : (n_dofs, r)
    jump : (3 n_points, r) relative displacement of the coordinates, slot order
    base : (r,) inertia force per unit base acceleration, kg^(1/2)
    tip : (r,) tip displacement
    springs : (3 n_points,) D_0, Pa/m
    """

    eigenvalues: FloatArray
    vectors: FloatArray
    jump: FloatArray
    base: FloatArray
    tip: FloatArray
    springs: FloatArray


def stick_springs(system: System, state: ContactState) -> FloatArray:
    """(3 n_points,) stiffness per slot of the contact that sticks at ``state``, Pa/m; open points have none."""
    law, pressure = system.laws, state.pressure
    closed = (pressure > 0) | ~law.separation
    return np.concatenate([np.repeat(law.mu * pressure / law.gamma, 2), np.where(closed, law.kn, 0.0)])


def low_modes(stiffness: object, mass: object, cutoff_hz: float, limit: int) -> FloatArray:
    """M-normalised modes (n, k) of sparse (K, M) up to ``cutoff_hz``, at most ``limit``; reproducible start vector."""
    n = stiffness.shape[0]
    lu = factorise(stiffness)
    inverse = spla.LinearOperator((n, n), matvec=lu.solve)
    start = np.random.default_rng(1).standard_normal(n)
    count = min(64, limit)
    while True:
        values, vectors = spla.eigsh(stiffness, count, mass, sigma=0.0, OPinv=inverse, v0=start)
        if np.sqrt(values.max()) >= 2 * np.pi * cutoff_hz or count == limit:
            keep = values <= (2 * np.pi * cutoff_hz) ** 2
            return vectors[:, keep]
        count = min(2 * count, limit)


def condense(
    system: System, state: ContactState, scheme: Scheme, dt: float, *, cutoff_hz: float
) -> Condensation:
    """Diagonal coordinates that reproduce the interface compliance of a step exactly.

    Parameters
    ----------
    dt
        Nominal step in s; F is exact for it (cut steps reuse the coordinates).
    cutoff_hz
        Modes up to here carry the history of the interior.
    """
    springs = stick_springs(system, state)
    stiffness = system.with_interface_springs(springs)
    n = system.n_dofs
    if n <= DENSE_LIMIT:
        values, vectors = la.eigh(stiffness.toarray(), system.mass.toarray())
    else:
        dynamic = factorise(system.mass / (scheme.beta * dt**2) + (1.0 + scheme.alpha) * stiffness)
        modes = low_modes(stiffness, system.mass, cutoff_hz, limit=n // 2)
        tip = system.probes["tip"]
        loads = np.column_stack([system.jump.T.toarray(), system.mass @ system.influence, tip])
        import os
        blocks=[modes, dynamic.solve(loads)]
        k=os.environ.get("KRY","")
        if "s" in k: blocks.append(factorise(stiffness).solve(loads))
        if "m" in k: blocks.append(dynamic.solve(system.mass @ blocks[1]))
        if "2" in k: blocks.append(dynamic.solve(system.mass @ blocks[-1]))
        values, vectors = _diagonalise(stiffness, system.mass, np.column_stack(blocks))
    return Condensation(
        eigenvalues=values,
        vectors=vectors,
        jump=np.ascontiguousarray(system.jump @ vectors),
        base=vectors.T @ (system.mass @ system.influence),
        tip=vectors.T @ system.probes["tip"],
        springs=springs,
    )


def _diagonalise(stiffness: object, mass: object, span: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rayleigh-Ritz values and vectors of (K, M) on the columns of ``span`` (n, k); dependent columns are dropped.

    Zero columns are normal: hoop motion vanishes on a symmetry plane.
    """
    scale = np.sqrt(np.einsum("ij,ij->j", span, mass @ span))
    span = span[:, scale > 0.0] / scale[scale > 0.0]
    gram = span.T @ (mass @ span)
    weight, rotation = la.eigh(0.5 * (gram + gram.T))
    keep = weight > 1e-11 * weight[-1]
    basis = span @ (rotation[:, keep] / np.sqrt(weight[keep]))
    values, ritz = la.eigh(basis.T @ (stiffness @ basis), basis.T @ (mass @ basis))
    return values, basis @ ritz


class CondensedStepper(Stepper):
    """Time stepping in condensed coordinates; state attributes are documented in `condensed_kernel`."""

    state_names = ("q", "v", "a", "residual", "residual_change", "jump", "jump_before", "elastic_slip", "traction")

    def __init__(
        self,
        system: System,
        preload: ContactState,
        scheme: Scheme,
        options: NewtonOptions,
        *,
        dt: float,
        cutoff_hz: float,
    ):
        super().__init__(system, preload, scheme, options)
        self.condensation = condense(system, preload, scheme, dt, cutoff_hz=cutoff_hz)
        r = len(self.condensation.eigenvalues)
        self.q, self.v, self.a = np.zeros(r), np.zeros(r), np.zeros(r)
        self.residual, self.residual_change = np.zeros(r), np.zeros(r)
        self.jump, self.jump_before = preload.jump.copy(), preload.jump.copy()
        self.elastic_slip, self.traction = preload.elastic_slip.copy(), preload.traction.copy()
        self._operators: dict[float, tuple[FloatArray, FloatArray, FloatArray]] = {}
        self.last_history = []

    def displacement(self) -> FloatArray:
        """(n_dofs,) displacement relative to the preload state, m."""
        return self.condensation.vectors @ self.q

    def start_from(self, displacement: FloatArray) -> None:
        """Release from rest at ``displacement`` (n_dofs,) in m, on top of the preload state."""
        from .static import TrialContact

        c = self.condensation
        self.q[:] = c.vectors.T @ (self.system.mass @ displacement)
        trial = TrialContact(self.system)
        jump = self.preload.jump + c.jump @ self.q
        traction = trial(jump, self.preload)
        correction = traction - self.preload.traction - c.springs * (jump - self.preload.jump)
        self.jump[:] = self.jump_before[:] = jump
        self.elastic_slip[:], self.traction[:] = trial.elastic_slip, traction
        self.residual[:] = c.eigenvalues * self.q + c.jump.T @ (self.system.weights * correction)
        self.a[:] = -self.residual

    def _operator(self, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Modal factor 1/S (r,), interface compliance F (3 n, 3 n) and its tangential columns, of a step ``dt``."""
        if dt not in self._operators:
            c, s = self.condensation, self.scheme
            inverse = 1.0 / (1.0 / (s.beta * dt**2) + (1.0 + s.alpha) * c.eigenvalues)
            compliance = (1.0 + s.alpha) * (c.jump * inverse) @ c.jump.T * self.system.weights
            tangential = compliance[:, : 2 * self.system.n_points]
            self._operators[dt] = inverse, np.ascontiguousarray(compliance), np.ascontiguousarray(tangential)
        return self._operators[dt]

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        law, c, s = self.system.laws, self.condensation, self.scheme
        inverse, compliance, tangential = self._operator(dt)
        history = np.zeros(self.options.max_iterations + 1)
        done = advance_steps(
            np.ascontiguousarray(acceleration), dt, s.alpha, s.beta, s.gamma,
            c.eigenvalues, c.jump, c.base, c.tip, c.springs, inverse, compliance, tangential,
            self.preload.jump, self.preload.traction, self.preload.elastic_slip,
            law.area, law.kn, law.separation, law.mu, law.gamma,
            self.q, self.v, self.a, self.residual, self.residual_change,
            self.jump, self.jump_before, self.elastic_slip, self.traction,
            self.totals, self.flows, self.slip.path, self.slip.peak, self.slip.peak_vector,
            self.residual_limit, self.options.max_iterations, history, records,
        )  # fmt: skip
        if done < len(acceleration) - 1:
            self.last_history = [float(h) for h in history if h > 0.0]
        return int(done)


__all__ = ["Condensation", "CondensedStepper", "RECORDS", "condense", "stick_springs"]
