r"""Whether an implicit step with falling friction has one solution (derived in docs/theory.md).

Where the coefficient falls with the slip rate, a point that slides faster is held less: in a step of size h it acts as
the negative spring :math:`p |\mu'| / h`. The step is unambiguous while the structure with its inertia is stiffer:

.. math:: (1 + \alpha)\, \lambda_{max}\!\left( C^{1/2} G S^{-1} G^T C^{1/2} \right) < 1, \qquad
          C = W p |\mu'|_{max} / h, \quad S = M / (\beta h^2) + (1 + \alpha) K

with the normal contact of closed points in K. Inertia dominates S, so the left side grows with h.
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
"""Slots up to which the largest eigenvalue is found densely."""

MOST_STEPS = 1024
"""Factor of steps per cycle beyond which none is advised any more."""


def ambiguity(system: System, state: ContactState, scheme: Scheme, dt: float) -> float:
    """Left side of the condition at the pressures of ``state``: below 1, steps of ``dt`` (s) have one solution."""
    negative = state.pressure * system.laws.weakening / dt
    slots = np.flatnonzero(np.repeat(negative, 2) > 0.0)
    if slots.size == 0:
        return 0.0
    law = system.laws
    closed = np.where((state.pressure > 0.0) | ~law.separation, law.kn, 0.0)
    stiffness = system.with_interface_springs(per_dof(np.zeros(law.n), closed))
    factor = factorise(sp.csr_matrix(system.mass / (scheme.beta * dt**2) + (1.0 + scheme.alpha) * stiffness))
    root = np.sqrt(system.weights[slots] * np.repeat(negative, 2)[slots])
    operator = sp.diags(root) @ system.jump[slots]

    def apply(x: FloatArray) -> FloatArray:
        return np.asarray(operator @ factor.solve(operator.T @ np.ravel(x)))

    if slots.size <= FEW:
        largest = np.linalg.eigvalsh(np.column_stack([apply(e) for e in np.eye(slots.size)]))[-1]
    else:
        linear = spla.LinearOperator((slots.size, slots.size), matvec=apply, dtype=float)
        start = np.random.default_rng(2).standard_normal(slots.size)
        largest = spla.eigsh(linear, 1, which="LA", v0=start, tol=1e-3, return_eigenvectors=False)[0]
    return float((1.0 + scheme.alpha) * largest)


def check_unambiguous(system: System, state: ContactState, scheme: Scheme, dt: float) -> None:
    """Refuse steps of ``dt`` (s) in which falling friction allows more than one solution.

    Raises
    ------
    InputError
        With the number of steps per cycle that it takes.
    """
    value = ambiguity(system, state, scheme, dt)
    if value < 1.0:
        return
    factor = 2
    while factor < MOST_STEPS and ambiguity(system, state, scheme, dt / factor) >= 1.0:
        factor *= 2
    fall = float(system.laws.weakening.max())
    raise InputError(
        f"the coefficient falls by up to {fall:.3g} per m/s, so fast that steps of {dt:.3g} s may have more than one "
        f"solution ({value:.3g}, must be below 1)",
        key="contact.friction.rate_table",
        remedy=f"use {factor} times the integrator.steps_per_cycle, or a table that falls more gently",
    )
