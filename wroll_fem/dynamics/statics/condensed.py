r"""Static equilibrium of a roll with rotational symmetry, solved for the interface unknowns alone.

The solution is exact and much faster than on the full model. With springs D in the interfaces,
:math:`u = (K + G^T W D G)^{-1} (f - G^T W s)` and s = t(g) - D g. The jump g follows from g = g_f - F s, a dense system
of interface size. Here g_f is the jump due to f if s = 0, and F is the interface compliance. K falls into
circumferential blocks (`cyclic_blocks`). A block is factorised when a load first acts on it.

If the load is uniform around the circumference (a pressure), so is the state. One point then represents its row, and
only the blocks of circumferential harmonic 0 are used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from wroll_fem.contact.laws import PointLaws
from wroll_fem.contact.point import EVERY, per_dof, stick_stiffness
from wroll_fem.dynamics.reduction.cyclic_blocks import Blocks, spread
from wroll_fem.dynamics.statics.contact_state import LEAST_TANGENT, ContactState, TrialContact
from wroll_fem.dynamics.statics.full import unconverged
from wroll_fem.dynamics.system.system import System
from wroll_fem.numerics.linear import Factorisation, factorise
from wroll_fem.numerics.newton import NO_RENEWAL, damped_newton, first_decrease
from wroll_fem.typing import FloatArray

ROUNDING = 1e3
"""Largest residual, relative to the tolerance, at which a condensed static step is accepted if Newton's method no
longer halves the residual."""

NO_LOAD = 1e-12
"""Load on a circumferential block, relative to the total load, below which it counts as rounding error."""


@dataclass(frozen=True)
class _Unknowns:
    """Interface unknowns of a static solution: the jump at all points, or at one point of each circumferential row.

    One point represents its row if the solution is uniform around the circumference.
    """

    laws: PointLaws
    springs: FloatArray
    compliance: FloatArray

    @cached_property
    def stiffness(self) -> FloatArray:
        """(3 n, 3 n) pseudo-inverse of the compliance per force, N/m; components that cannot move have none."""
        per_force = self.compliance / per_dof(self.laws.area, self.laws.area)
        return np.asarray(la.pinvh(0.5 * (per_force + per_force.T), check_finite=False))


class _InterfaceProblem:
    """Equation g - g_f + F s(g) = 0 for the jump g (3 n,), as a `NewtonProblem`; see the module for the symbols."""

    def __init__(self, unknowns: _Unknowns, g_free: FloatArray, start: ContactState, tolerance: float):
        self.unknowns, self.g_free, self.start = unknowns, g_free, start
        self.trial = TrialContact(unknowns)
        self.floor = LEAST_TANGENT * float(unknowns.laws.kn.max())
        self.limit = tolerance * max(float(np.abs(g_free).max(initial=0.0)), float(unknowns.laws.gamma.min()))
        self.correction = np.zeros_like(g_free)

    def residual(self, g: FloatArray) -> tuple[FloatArray, float]:
        """Residual (3 n,) of the equation for the jump ``g`` (3 n,), m, and its largest magnitude."""
        self.correction = self.trial(g, self.start) - self.unknowns.springs * g
        rho = g - self.g_free + self.unknowns.compliance @ self.correction
        return rho, float(np.abs(rho).max())

    def linearise(self, g: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """Function that solves the linearised equations for a given residual, with the consistent tangent at ``g``."""
        change = self.trial.stiffness(g, self.start, self.floor) - sp.diags(self.unknowns.springs)
        matrix = np.eye(len(g)) + self.unknowns.compliance @ change
        return lambda rho: np.asarray(la.solve(matrix, rho, overwrite_a=True, check_finite=False))

    def slope(self, step: FloatArray, rho: FloatArray) -> float:
        """Slope of the potential of the load step against ``step`` (3 n,), J, at the residual ``rho`` (3 n,), m."""
        return float(step @ self.unknowns.stiffness @ rho)

    def converged(self, size: float, previous: float) -> bool:
        """Whether the residual is within the limit, or is no longer halved and is within `ROUNDING` times the limit."""
        return size <= self.limit or (not size < 0.5 * previous and size <= ROUNDING * self.limit)


class CondensedStatic:
    """Static solver of one system for its interface unknowns alone; a call does the same as `solve_static`."""

    @classmethod
    def of(cls, system: System, traction_scale: float) -> CondensedStatic | None:
        """Solver for ``system``; None if it has no interfaces or no rotational symmetry.

        ``traction_scale`` is the pressure in Pa for which the springs of the solver are chosen. Any positive value
        gives the same solution.
        """
        law = system.laws
        if not system.interfaces:
            return None
        stick = np.maximum(stick_stiffness(EVERY, traction_scale, law), LEAST_TANGENT * law.kn)
        blocks = Blocks.of(system, per_dof(stick, law.kn))
        return None if blocks is None else cls(blocks)

    def __init__(self, blocks: Blocks):
        self.system, self.blocks = blocks.system, blocks
        self._factors: dict[int, Factorisation] = {}
        self._compliances: dict[int, FloatArray] = {}

    def __call__(
        self,
        force: FloatArray,
        state: ContactState,
        *,
        tolerance: float = 1e-9,
        max_iterations: int = 40,
        load_factor: float = 1.0,
    ) -> ContactState:
        """Contact state in equilibrium with ``force`` (n_dofs,), N; arguments and errors as for `solve_static`."""
        system = self.system
        free = self._displacement(force)
        g_free, start = system.jump @ free, state
        even = self._even_around if self._is_even(force, state) else None
        unknowns = even or self._points
        if even is not None:
            g_free, start = self._rows(g_free), self._row_state(state)
        problem = _InterfaceProblem(unknowns, g_free, start, tolerance)
        g, history = damped_newton(
            problem, start.jump.copy(), max_iterations=max_iterations, search=first_decrease, renewal=NO_RENEWAL,
            slope=problem.slope,
        )  # fmt: skip
        if g is None:
            raise unconverged(load_factor, max_iterations, history)
        reached, s = problem.trial.committed(start.displacement, g), problem.correction
        if even is not None:
            reached, s = self._all_around(reached), self._repeat(s)
        load = force - system.contact_force(s)
        return replace(reached, displacement=self._displacement(load))

    # ---- linear structure ----------------------------------------------------------------------------------------

    def _factor(self, block: int) -> Factorisation:
        if block not in self._factors:
            self._factors[block] = factorise(self.blocks.stiffness(block))
        return self._factors[block]

    def _compliance(self, block: int) -> FloatArray:
        """Compliance of a block: jump amplitude per unit amplitude of the contact force, m/N (see `spread`)."""
        if block not in self._compliances:
            jump = self.blocks.jump(block).toarray()
            self._compliances[block] = jump @ self._factor(block).solve(np.ascontiguousarray(jump.T))
        return self._compliances[block]

    def _loads(self, force: FloatArray) -> dict[int, FloatArray]:
        """Load on each circumferential block, by block index; blocks on which ``force`` does not act are left out."""
        parts = {b: self.blocks.basis(b).T @ force for b in range(len(self.blocks))}
        least = NO_LOAD * np.linalg.norm(force)
        return {b: part for b, part in parts.items() if np.linalg.norm(part) > least}

    def _displacement(self, force: FloatArray) -> FloatArray:
        """(n_dofs,) displacement under ``force`` of the structure with springs in its interfaces."""
        u = np.zeros(self.system.n_dofs)
        for block, load in self._loads(force).items():
            u += self.blocks.basis(block) @ self._factor(block).solve(load)
        return u

    # ---- unknowns ------------------------------------------------------------------------------------------------

    @cached_property
    def _points(self) -> _Unknowns:
        """Unknowns at all contact points."""
        blocks = np.array([self._compliance(b) for b in range(len(self.blocks))])
        laws = self.system.laws
        return _Unknowns(laws, self.blocks.springs, spread(blocks, self.blocks.profiles, laws.area))

    @cached_property
    def _even_around(self) -> _Unknowns | None:
        """Unknowns at one contact point of each circumferential row; None if the contact laws vary around a row."""
        laws, (rows, n_theta) = self.system.laws, self.blocks.area.shape
        first = laws.take(n_theta * np.arange(rows))
        around = first.take(np.repeat(np.arange(rows), n_theta))._replace(area=laws.area)
        if not all(np.array_equal(a, b) for a, b in zip(around, laws, strict=True)):
            return None
        area = self.blocks.area.sum(axis=1)
        ring = [b for b in range(len(self.blocks)) if self.blocks.harmonic(b) == 0]
        blocks = np.array([self._compliance(b) for b in ring])
        # a profile of harmonic 0 is 1 or 0 all around: the same for the one point that stands for a row
        compliance = spread(blocks, self.blocks.profiles[ring][..., :1], area)
        return _Unknowns(first._replace(area=area), self._rows(self.blocks.springs), compliance)

    def _is_even(self, force: FloatArray, state: ContactState) -> bool:
        """Whether load and state are uniform around the circumference."""
        ring = all(self.blocks.harmonic(b) == 0 for b in self._loads(force))
        return ring and all(
            np.array_equal(self._repeat(self._rows(values)), values) for values in (state.jump, state.elastic_slip)
        )

    def _rows(self, values: FloatArray) -> FloatArray:
        """Entries of ``values`` at the first point of each circumferential row.

        ``values`` contains the tangential components at all points, or these and then the normal components.
        """
        rows, n_theta = self.blocks.area.shape
        n = rows * n_theta
        tangential, normal = values[: 2 * n], values[2 * n :]
        return np.concatenate([tangential.reshape(rows, n_theta, 2)[:, 0].ravel(), normal.reshape(-1, n_theta)[:, 0]])

    def _repeat(self, values: FloatArray) -> FloatArray:
        """Vector over the contact degrees of freedom of all points; the points of a row get the same values."""
        rows, n_theta = self.blocks.area.shape
        tangential = np.repeat(values[: 2 * rows].reshape(rows, 2), n_theta, axis=0).ravel()
        return np.concatenate([tangential, np.repeat(values[2 * rows :], n_theta)])

    def _row_state(self, state: ContactState) -> ContactState:
        status = state.status.reshape(self.blocks.area.shape)[:, 0]
        parts = {name: self._rows(getattr(state, name)) for name in ("jump", "elastic_slip", "traction")}
        return replace(state, status=status, **parts)

    def _all_around(self, state: ContactState) -> ContactState:
        status = np.repeat(state.status, self.blocks.area.shape[1])
        parts = {name: self._repeat(getattr(state, name)) for name in ("jump", "elastic_slip", "traction")}
        return replace(state, status=status, **parts)
