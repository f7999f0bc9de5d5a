r"""Step uniqueness: condition for a single solution of an implicit step with velocity-weakening friction.

Where the friction coefficient falls with the slip rate, friction acts in a step of size h like a spring of negative
stiffness, of magnitude :math:`p |\mu'| / h`. The solution is unique if the structure with its inertia is stiffer:

.. math:: (1 + \alpha)\, \lambda_{max}\!\left( C^{1/2} G S^{-1} G^T C^{1/2} \right) < 1, \qquad
          C = W p |\mu'|_{max} / h, \quad S = M / (\beta h^2) + (1 + \alpha) K

with the normal contact of closed points in K. Inertia dominates S, so the left side grows with h. The condition is
derived in docs/theory.md.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from wroll_fem.contact.point import per_dof
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.errors import InputError
from wroll_fem.numerics.linear import factorise
from wroll_fem.typing import FloatArray

FEW = 40
"""Largest number of contact degrees of freedom for which the largest eigenvalue is computed by a dense eigensolver."""

MOST_STEPS = 1024
"""Largest factor on the number of steps per cycle that the error message can recommend."""


def uniqueness_ratio(system: System, state: ContactState, scheme: Scheme, dt: float) -> float:
    """Uniqueness ratio at the pressures of ``state``; a step ``dt`` (s) has a single solution if the ratio is below 1.

    The ratio is the left side of the condition in the docstring of this module.
    """
    negative = state.pressure * system.laws.weakening / dt
    dofs = np.flatnonzero(np.repeat(negative, 2) > 0.0)
    if dofs.size == 0:
        return 0.0
    law = system.laws
    closed = np.where((state.pressure > 0.0) | ~law.separation, law.kn, 0.0)
    stiffness = system.with_interface_springs(per_dof(np.zeros(law.n), closed))
    factor = factorise(sp.csr_matrix(system.mass / (scheme.beta * dt**2) + (1.0 + scheme.alpha) * stiffness))
    root = np.sqrt(system.weights[dofs] * np.repeat(negative, 2)[dofs])
    operator = sp.diags(root) @ system.jump[dofs]

    def apply(x: FloatArray) -> FloatArray:
        return np.asarray(operator @ factor.solve(operator.T @ np.ravel(x)))

    if dofs.size <= FEW:
        largest = np.linalg.eigvalsh(np.column_stack([apply(e) for e in np.eye(dofs.size)]))[-1]
    else:
        linear = spla.LinearOperator((dofs.size, dofs.size), matvec=apply, dtype=float)
        start = np.random.default_rng(2).standard_normal(dofs.size)
        largest = spla.eigsh(linear, 1, which="LA", v0=start, tol=1e-3, return_eigenvectors=False)[0]
    return float((1.0 + scheme.alpha) * largest)


def check_step_uniqueness(system: System, state: ContactState, scheme: Scheme, dt: float) -> None:
    """Raise an error if velocity-weakening friction allows more than one solution of a step of ``dt`` (s).

    Raises
    ------
    InputError
        If the condition is not met; the remedy names the required factor on the number of steps per cycle.
    """
    value = uniqueness_ratio(system, state, scheme, dt)
    if value < 1.0:
        return
    factor = 2
    while factor < MOST_STEPS and uniqueness_ratio(system, state, scheme, dt / factor) >= 1.0:
        factor *= 2
    fall = float(system.laws.weakening.max())
    raise InputError(
        f"the friction coefficient falls by up to {fall:.3g} per m/s, so that a step of {dt:.3g} s may have more than "
        f"one solution (uniqueness ratio {value:.3g}, must be below 1)",
        key="contact.friction.rate_table",
        remedy=f"use {factor} times the integrator.steps_per_cycle, or a table with a smaller negative slope",
    )
