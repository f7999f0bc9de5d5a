"""Static equilibrium of the whole structure with friction, by sparse Newton steps."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from wroll_fem.dynamics.statics.contact_state import LEAST_TANGENT, ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.linear import Factorisation, factorise
from wroll_fem.typing import FloatArray

KEEP_RATE = 0.1
"""A factorisation is kept while each iteration reduces the residual by this."""


def solve_static(
    system: System,
    force: FloatArray,
    state: ContactState,
    *,
    tolerance: float = 1e-9,
    max_iterations: int = 40,
    load_factor: float = 1.0,
) -> ContactState:
    """Equilibrium K u + G^T W t(u) = force, friction starting from ``state``.

    Newton's method with the consistent tangent and a backtracking line search. Where nothing yet
    holds a body (no pressure, hence no stick stiffness) the tangent alone, never the residual,
    gets a small stiffness.

    Raises
    ------
    ConvergenceError
        With ``load_factor`` in place of the time.
    """
    trial, jump_operator, weights = TrialContact(system), system.jump, system.weights
    u = state.displacement.copy()
    history: list[float] = []
    floor = LEAST_TANGENT * float(system.laws.kn.max(initial=0.0))

    def residual(u: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        jump = jump_operator @ u
        internal = system.stiffness @ u
        contact = jump_operator.T @ (weights * trial(jump, state))
        scale = np.linalg.norm(force) + np.linalg.norm(contact) + np.linalg.norm(internal)
        r = internal + contact - force
        return r, jump, float(np.linalg.norm(r) / scale) if scale > 0 else 0.0

    r, jump, size = residual(u)
    factor: Factorisation | None = None
    for _ in range(max_iterations):
        history.append(size)
        if size <= tolerance:
            return trial.committed(u, jump)
        fresh = factor is None
        if factor is None:
            tangent = trial.stiffness(jump, state, floor)
            factor = factorise(system.stiffness + jump_operator.T @ sp.diags(weights) @ tangent @ jump_operator)
        step = factor.solve(r)
        damping, best = 1.0, (np.inf, 0.0)
        for _ in range(8):
            size_new = residual(u - damping * step)[2]
            if size_new < best[0]:
                best = (size_new, damping)
            if size_new < (1.0 - 0.1 * damping) * size or not fresh:
                break
            damping *= 0.5
        if best[0] > KEEP_RATE * size:
            factor = None
            if not fresh and best[0] >= size:
                r, jump, size = residual(u)
                continue
        u = u - best[1] * step
        r, jump, size = residual(u)
    raise unconverged(load_factor, max_iterations, history)


def unconverged(load_factor: float, iterations: int, history: list[float]) -> ConvergenceError:
    """Error of a static step, at ``load_factor`` in place of the time."""
    return ConvergenceError(
        f"static step did not converge (load factor {load_factor:.4g})",
        time_s=load_factor,
        iterations=iterations,
        residual_history=history,
        advice="raise preload.steps, or check that friction or a support holds every body",
    )
