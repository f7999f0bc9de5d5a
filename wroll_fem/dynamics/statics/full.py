"""Static equilibrium of the full model with friction, by sparse Newton steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp

from wroll_fem.dynamics.statics.contact_state import LEAST_TANGENT, ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.linear import factorise
from wroll_fem.numerics.newton import STATIC_RENEWAL, best_of_halvings, damped_newton, gradient_slope
from wroll_fem.typing import FloatArray


class _WholeStructure:
    """Equilibrium K u + G^T W t(u) = force as a `NewtonProblem` for the displacement u (n_dofs,); t: tractions."""

    def __init__(self, system: System, force: FloatArray, state: ContactState, tolerance: float):
        self.system, self.force, self.state, self.tolerance = system, force, state, tolerance
        self.trial = TrialContact(system)
        self.floor = LEAST_TANGENT * float(system.laws.kn.max(initial=0.0))

    def residual(self, u: FloatArray) -> tuple[FloatArray, float]:
        """Unbalanced force (n_dofs,), N, and its norm relative to the sum of the norms of all forces."""
        system = self.system
        internal = system.stiffness @ u
        contact = system.contact_force(self.trial(system.jump @ u, self.state))
        scale = np.linalg.norm(self.force) + np.linalg.norm(contact) + np.linalg.norm(internal)
        r = internal + contact - self.force
        return r, float(np.linalg.norm(r) / scale) if scale > 0 else 0.0

    def linearise(self, u: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """Function that solves the linearised equations for a given residual, with the consistent tangent at ``u``."""
        system = self.system
        tangent = self.trial.stiffness(system.jump @ u, self.state, self.floor)
        matrix = system.stiffness + system.jump.T @ sp.diags(system.weights) @ tangent @ system.jump
        return factorise(matrix).solve

    def converged(self, size: float, previous: float) -> bool:
        """Whether the relative unbalanced force is within the tolerance."""
        return size <= self.tolerance


def solve_static(
    system: System,
    force: FloatArray,
    state: ContactState,
    *,
    tolerance: float = 1e-9,
    max_iterations: int = 40,
    load_factor: float = 1.0,
) -> ContactState:
    """Contact state in the equilibrium K u + G^T W t(u) = force (t: tractions); friction starts from ``state``.

    The equations are solved by Newton's method with the consistent tangent and a backtracking line search. If this
    stalls, the line search uses the potential of the step, which is convex at fixed pressure (`newton.zero_slope`). A
    body that is not yet held (no pressure, hence no stick stiffness) gets a small stiffness in the tangent, but not in
    the residual.

    Raises
    ------
    ConvergenceError
        If Newton's method does not converge; the message states ``load_factor``.
    """
    problem = _WholeStructure(system, force, state, tolerance)
    u, history = damped_newton(
        problem, state.displacement.copy(), max_iterations=max_iterations, search=best_of_halvings,
        renewal=STATIC_RENEWAL, slope=gradient_slope,
    )  # fmt: skip
    if u is None:
        raise unconverged(load_factor, max_iterations, history)
    return problem.trial.committed(u, system.jump @ u)


def unconverged(load_factor: float, iterations: int, history: list[float]) -> ConvergenceError:
    """Error for a static step that did not converge."""
    return ConvergenceError(
        f"static step did not converge (load factor {load_factor:.4g})",
        time_s=None,
        iterations=iterations,
        residual_history=history,
        advice="raise preload.steps, or check that friction or a support holds every body",
    )
