r"""Time integration with exact condensation on the contact degrees of freedom.

With a fixed step the HHT matrix S is constant and the jump is linear in the interface traction,

.. math:: g_{n+1} = \hat g_{n+1} - F\, s(g_{n+1}), \qquad F = (1+\alpha)\, G S^{-1} G^T W,

where :math:`\hat g` is the jump without the traction correction s. Only a dense system of interface size is nonlinear.
It is kept small and fast as follows:

* The sticking interface of the preload state (springs :math:`D_0`) is part of the linear structure. The traction
  correction :math:`s = t(g) - t_0 - D_0 (g - g_0)` vanishes where a point sticks at its preload pressure. Newton's
  matrix is formed only for points that slip or open, or whose pressure has changed. Where many points have opened, it
  starts from a compliance without tangential springs, beside which an open point has one active component, not three.
* The structure is represented by all its modes, without truncation. K and M of a roll with rotational symmetry fall
  into circumferential blocks (`cyclic_blocks`), so that all modes can be computed and used at low cost.
* F is applied for one circumferential block after the other.

A structure without rotational symmetry and with more than `DENSE_LIMIT` DOFs is instead projected on the low modes and
on static and dynamic attachment vectors of every interface component. This is not exact: the error is about 1e-4 of the
largest displacement, and `Condensation.exact` is False.

References
----------
Rubin (1975), AIAA J. 13, 995, doi:10.2514/3.60497 (attachment modes).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wroll_fem.dynamics.reduction.condensation import Condensation, condense
from wroll_fem.dynamics.reduction.interface_operator import Compliance, InterfaceOperator
from wroll_fem.dynamics.reduction.modal_step import inverse_blocks, modal_step
from wroll_fem.dynamics.reduction.newton_matrix import no_factors
from wroll_fem.dynamics.statics.contact_springs import reference_stiffness
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed_kernel import CondensedState, advance_steps
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.modal_kernel import correction
from wroll_fem.dynamics.time_stepping.state import ContactMemory, Modal, Motion, Newton, Reference
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.dynamics.time_stepping.uniqueness import check_step_uniqueness
from wroll_fem.typing import FloatArray

LEAST_OPEN = 0.02
"""Share of the points that have been open, above which Newton's matrix may start without tangential springs."""

_NOTHING = Compliance(np.zeros((0, 0, 0)), np.zeros((0, 0), np.float32))


class CondensedStepper(Stepper):
    """Time stepping with condensation on the contact degrees of freedom; see `Stepper`.

    With ``keep_factors`` the factors of Newton's matrix are kept between calls of `try_steps`, for short calls. The
    motion then depends, within the tolerance, on the steps before the last `restore`.
    """

    name = "condensed"
    state: CondensedState

    def __init__(
        self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float,
        condensation: Condensation | None = None, keep_factors: bool = False,
    ):  # fmt: skip
        super().__init__(system, preload, scheme, options)
        check_step_uniqueness(system, preload, scheme, dt)
        c = condensation or condense(system, reference_stiffness(system, preload, dt), scheme, dt)
        if c.moments:  # single precision saves a fifth of a step that sticks; its error is below that of such modes
            c = replace(c, jump=[block.astype(np.float32).astype(np.float64) for block in c.jump])
        precision = np.float32 if c.moments else np.float64
        self._modal_jump = np.concatenate([block.ravel() for block in c.jump]).astype(precision)
        self.condensation = c
        self.reference = Reference(preload.jump, preload.elastic_slip, preload.traction, c.springs)
        self.state = CondensedState(
            Motion.zeros(len(c.eigenvalues)), ContactMemory.of(preload), jump_before=preload.jump.copy()
        )
        self._keep_factors, self._kept = keep_factors, (dt, no_factors())
        self._operators: dict[float, tuple[Modal, InterfaceOperator]] = {}

    def displacement(self) -> FloatArray:
        """(n_dofs,) displacement relative to the preload state, m."""
        return self.condensation.displacement(self.state.motion.q)

    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector i (r,) and M i (r,) in modal coordinates; they are equal because the modal masses are 1."""
        return self.condensation.base, self.condensation.base

    def start_from(self, displacement: FloatArray) -> None:
        """Start from rest at ``displacement`` (n_dofs,), m, relative to the preload state."""
        c, system = self.condensation, self.system
        motion, contact = self.state.motion, self.state.contact
        motion.q[:] = c.coordinates(system.mass @ displacement)
        trial = TrialContact(system)
        jump = self.preload.jump + system.jump @ displacement
        contact.jump[:] = self.state.jump_before[:] = jump
        contact.traction[:] = trial(jump, self.preload)
        contact.elastic_slip[:] = trial.elastic_slip
        s = np.zeros_like(jump)
        correction(jump, contact.traction, self.reference, s)
        force = system.contact_force(s)
        motion.residual[:] = c.eigenvalues * motion.q + np.concatenate([r.T @ (b.T @ force) for b, r in c.vectors])
        motion.a[:] = -motion.residual

    def _operator(self, dt: float) -> tuple[Modal, InterfaceOperator]:
        """Operators of the structure and of the interfaces for steps of ``dt`` (s)."""
        if dt not in self._operators:
            c, s = self.condensation, self.scheme
            modal = modal_step(c, c.damping, s, dt)
            scaled = [(1.0 + s.alpha) * part for part in inverse_blocks(modal, c.blocks)]
            blocks, compliance = c.compliance(scaled, self.system.laws.area)
            profiles = np.ascontiguousarray(c.profiles.reshape(-1, 3, c.n_theta).transpose(1, 0, 2))
            sticking = Compliance(blocks, compliance.astype(np.float32))
            interface = InterfaceOperator(c.blocks, self._modal_jump, profiles, sticking, _NOTHING)
            self._operators[dt] = modal, interface
        modal, interface = self._operators[dt]
        if self._opens and not len(interface.sliding.dense):
            blocks, compliance = self.condensation.sliding_compliance(interface.sticking.blocks, self.system.laws.area)
            interface = interface._replace(sliding=Compliance(blocks, compliance.astype(np.float32)))
            self._operators[dt] = modal, interface
        return modal, interface

    @property
    def _opens(self) -> bool:
        """Whether enough points have been open for Newton's matrix to be smaller without tangential springs."""
        return bool(np.mean(self.accumulated.opening.open_time > 0.0) > LEAST_OPEN) if self.system.n_points else False

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance in the compiled loop; see `Stepper.try_steps`."""
        modal, interface = self._operator(dt)
        newton = Newton(self.residual_limit, self.options.max_iterations, np.zeros(self.options.max_iterations + 1))
        kept, factors = self._kept
        done, factors = advance_steps(
            np.ascontiguousarray(acceleration), self.step(dt), modal, interface, self.reference, self.system.laws,
            self.state, newton, self.accumulated, records, factors if kept == dt else no_factors(),
        )  # fmt: skip
        if self._keep_factors:
            self._kept = dt, factors
        if done < len(acceleration) - 1:
            self.last_history = [float(h) for h in newton.history if h > 0.0]
        return int(done)
