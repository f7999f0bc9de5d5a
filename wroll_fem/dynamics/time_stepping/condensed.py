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

import numpy as np

from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.statics.contact_springs import reference_stiffness
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed_kernel import advance_steps
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.dynamics.time_stepping.uniqueness import check_unambiguous
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray


class CondensedStepper(Stepper):
    """Time stepping in condensed coordinates; state attributes are documented in `condensed_kernel`."""

    state_names = ("q", "v", "a", "residual", "residual_change", "jump", "jump_before", "elastic_slip", "traction")

    def __init__(self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float):
        if system.damping is not None:
            raise InputError(
                "condensed time stepping has no viscous damping", key="solver.method", remedy="use full, or harmonic"
            )
        super().__init__(system, preload, scheme, options)
        check_unambiguous(system, preload, scheme, dt)
        self.condensation = condense(system, reference_stiffness(system, preload, dt), scheme, dt)
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

    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector and inertia force (r,) of a unit base acceleration: the modal mass is 1."""
        return self.condensation.base, self.condensation.base

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
            s = self.scheme
            inverse = 1.0 / (1.0 / (s.beta * dt**2) + (1.0 + s.alpha) * self.condensation.eigenvalues)
            compliance = self.condensation.compliance((1.0 + s.alpha) * inverse, self.system.laws.area)
            self._operators[dt] = inverse, *compliance
        return self._operators[dt]

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance in the compiled loop; see `Stepper.try_steps`."""
        c, s = self.condensation, self.scheme
        inverse, blocks, compliance = self._operator(dt)
        history = np.zeros(self.options.max_iterations + 1)
        done = advance_steps(
            np.ascontiguousarray(acceleration), dt, s.alpha, s.beta, s.gamma,
            c.eigenvalues, c.blocks, self._modal_jump, np.ascontiguousarray(c.profiles.transpose(1, 0, 2)),
            c.base, c.tip, c.springs, inverse, blocks, compliance,
            self.preload.jump, self.preload.traction,
            self.system.laws,
            self.q, self.v, self.a, self.residual, self.residual_change,
            self.jump, self.jump_before, self.elastic_slip, self.traction,
            self.totals, self.flows, self.slip.path, self.slip.peak, self.slip.peak_vector,
            self.residual_limit, self.options.max_iterations, history, records,
        )  # fmt: skip
        if done < len(acceleration) - 1:
            self.last_history = [float(h) for h in history if h > 0.0]
        return int(done)
