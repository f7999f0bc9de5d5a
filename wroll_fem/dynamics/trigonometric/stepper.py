r"""Trigonometric integration: modes of the sticking structure are exact, friction's correction is linear in a step.

In reduced coordinates q of the structure with sticking interfaces (`reduced_model`),

.. math:: \ddot q + C \dot q + \Lambda q = -b\,a_g(t) + F(t), \qquad F = -(G \Phi)^T W\, s(q)

with friction's correction s, which is zero while everything sticks. The linear part of a step is exact (`propagation`).
Modes with :math:`\omega h < 1` are driven by the correction, linear in time and filtered (Gautschi); the others answer
to it by the implicit midpoint rule. With :math:`q_{n+1} = \hat q_{n+1} + A F_{n+1}` and :math:`x = \omega^2 A`,

.. math:: x = 1 - \mathrm{sinc}^2(\omega h / 2) \;\; (\omega h < 1), \qquad
          x = \frac{(w \omega h)^2}{1 + (w \omega h)^2} \;\; (\omega h \ge 1, w = 0.55)

for modes without damping: the correction is explicit in slow modes up to :math:`(\omega h)^2 / 12` and implicit in fast
ones, where sticking friction and closed contact are stiffer than the inertia in a step. The same Newton iteration as
for HHT solves this equation. Derivation, stability and energies: docs/trigonometric.md.

References
----------
Gautschi (1961), Numer. Math. 3, 381, doi:10.1007/BF01386037.
Deuflhard (1979), ZAMP 30, 177, doi:10.1007/BF01601932.
Hochbruck, Lubich (1999), Numer. Math. 83, 403, doi:10.1007/s002110050456 (filter functions).
Hairer, Lubich, Wanner (2006), Geometric Numerical Integration, chapter XIII, doi:10.1007/3-540-30666-8.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.modal_kernel import correction
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper, empty_matrix
from wroll_fem.dynamics.time_stepping.reduced_kernel import ResidualChecks, sum_up
from wroll_fem.dynamics.time_stepping.state import ContactMemory, Dashpots, Modal, Motion, Newton
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.dynamics.trigonometric.kernel import TrigonometricState, advance_trigonometric
from wroll_fem.dynamics.trigonometric.propagation import NODES, Propagation, force_answer, propagation
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

LOOSER = 1e5
"""Residual of a converged step relative to that of the implicit schemes (`solver.tolerance`): a thousandth of the
elastic slip by default. It is the distance between the place of the contact and the one at which its law is evaluated.
It does not grow, because the free motion of the modes does not contain it, and its work is part of the energy ledger as
numerical dissipation. With 1e3 the lab roll has the same tip displacement to 4e-5 and friction work to 1e-4."""


class TrigonometricStepper(ReducedStepper):
    """`ReducedStepper` whose modes are propagated exactly; see the docstring of this module."""

    remedy = "use integrator.scheme: hht, for which the run falls back to solver.method: condensed"
    state: TrigonometricState  # type: ignore[assignment]  # with the fields of `ReducedState` that the base class uses

    def __init__(
        self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float,
        tolerance: float = 2e-3, largest_error: float = np.inf, condensation: Condensation | None = None,
    ):  # fmt: skip
        check_laws(system.laws)
        super().__init__(
            system, preload, scheme, options, dt=dt, tolerance=tolerance, largest_error=largest_error,
            condensation=condensation,
        )  # fmt: skip
        self.residual_limit *= LOOSER

    def _empty_state(self, m: int, contact: ContactMemory) -> TrigonometricState:  # type: ignore[override]
        matrix, none, moved = empty_matrix(m, contact), np.zeros((7, m)), np.zeros_like(contact.elastic_slip)
        one, sliding = np.zeros((7, 1)), np.zeros(len(moved) // 2)
        return TrigonometricState(Motion.zeros(m), contact, *none, moved, sliding, one[0], matrix, *one[1:])  # type: ignore[call-arg]

    def _turned(self, turn: FloatArray) -> TrigonometricState:  # type: ignore[override]
        state, m = self.state, len(turn)
        new = self._empty_state(m, state.contact)
        kept = new.kept._replace(tangents=state.kept.tangents, renewals=state.kept.renewals)
        if turn.shape[1]:
            new.motion.q[:], new.motion.v[:], new.motion.a[:] = (turn @ part for part in state.motion[:3])
            new = new._replace(
                free=turn @ state.free, free_rate=turn @ state.free_rate, known=turn @ state.force,
                mismatch=turn @ state.mismatch,
            )  # fmt: skip
        return state._replace(
            motion=new.motion, free=new.free, free_rate=new.free_rate, force=new.force, force_before=new.force_before,
            force_earlier=new.force_earlier, known=new.known, mismatch=new.mismatch, kept=kept,
        )  # fmt: skip

    def _use(self, model: ReducedModel) -> None:
        super()._use(model)
        self._propagations: dict[float, Propagation] = {}
        force = self._force()
        self.state.force[:] = force
        self.state.force_before[:] = force
        self.state.force_earlier[:] = force

    def _force(self) -> FloatArray:
        """(m,) reduced force of friction's correction in the committed state of the contact."""
        contact, s = self.state.contact, np.zeros_like(self.state.contact.jump)
        correction(contact.jump, contact.traction, self.points.reference, s)
        return -(self._interface.force @ s)

    def _prepare(self, dt: float) -> Modal:
        """Matrices of steps of ``dt`` (s); the state is split into free motion and static answer once they change."""
        model, state = self.model, self.state
        if dt not in self._steps:
            self._steps[dt], self._propagations[dt] = _step(model, dt)
        modal = self._steps[dt]
        if state.time_step[0] != dt:
            # modes that are resolved have no answer p; modes beyond half a cycle have the static response to the base
            steps, q, v = self._propagations[dt], state.motion.q, state.motion.v
            state.free[steps.resolved] = (q - steps.shift * state.known)[steps.resolved]
            state.free_rate[steps.resolved] = v[steps.resolved]
            fast = steps.eigenvalues * dt**2 > np.pi**2
            state.free[fast] = -model.base[fast] / model.eigenvalues[fast] * self.base_acceleration
            state.free_rate[fast] = 0.0
            # a turning point is found from steps of one size; a new basis sets the size to 0, and loses one such step
            state.moved[:] = 0.0
            sum_up(
                state.kept, self.points.reference.springs, self._interface.jump, self.points.laws.area, 1.0, modal
            )  # fmt: skip
            state.kept.inverse[:] = la.inv(state.kept.matrix)
            state.time_step[0] = dt
        return modal

    def _nodes(self, acceleration: FloatArray, dt: float) -> FloatArray:
        """(k, len(NODES)) base acceleration in the steps, m/s^2; without a motion linear between their ends."""
        if self.motion is None:
            return acceleration[:-1, None] + np.diff(acceleration)[:, None] * NODES
        start = self.state.clock[0] + dt * np.arange(len(acceleration) - 1)
        times = start[:, None] + dt * NODES
        return np.asarray(self.motion.acceleration(times.ravel())).reshape(times.shape)

    def _run_loop(
        self, acceleration: FloatArray, dt: float, modal: Modal, newton: Newton, checks: ResidualChecks,
        records: FloatArray,
    ) -> int:  # fmt: skip
        return advance_trigonometric(
            self._nodes(acceleration, dt), self.step(dt), self._propagations[dt], modal, self._interface,
            self.points.reference, self.points.laws, self.state, newton, self.accumulated, checks, records,
        )  # fmt: skip


def check_laws(laws: PointLaws) -> None:
    """Refuse friction that sticks nowhere, and friction that falls with the slip rate.

    Raises
    ------
    InputError
        If there is such a law.
    """
    if not (laws.stores_slip | laws.elastic).all():
        problem = "friction without memory sticks nowhere, so that there are no sticking modes to propagate"
    elif laws.weakening.any():
        problem = "friction that falls with the slip rate may have several solutions of a trigonometric step"
    else:
        return
    remedy = "use hht, or contact.friction.law: penalty_coulomb"
    raise InputError(problem, key="integrator.scheme", remedy=remedy)


def _step(model: ReducedModel, dt: float) -> tuple[Modal, Propagation]:
    """Linear structure for Newton's method, and coefficients, of steps of ``dt`` (s)."""
    none = np.zeros(0)
    given = model.eigenvalues, model.base, model.tip, model.probes
    if model.damping is None:
        steps = propagation(model.eigenvalues, (), model.base, dt)
        inverse = np.concatenate([part.ravel() for part in force_answer(steps)])
        return Modal(*given, inverse, Dashpots(none, np.zeros(1, np.int64), none, none, none)), steps
    rates = np.diag(model.damping).copy()
    if not np.count_nonzero(model.damping - np.diag(rates)):
        steps = propagation(model.eigenvalues, [rates], model.base, dt)
        inverse = np.concatenate([part.ravel() for part in force_answer(steps)])
        return Modal(*given, inverse, Dashpots(rates, np.array([0, model.size]), none, none, none)), steps
    steps = propagation(model.eigenvalues, [model.damping], model.base, dt)
    [answer] = force_answer(steps)
    flat = (np.ascontiguousarray(part).ravel() for part in (model.damping, la.inv(answer), answer))
    return Modal(*given, none, Dashpots(none, np.array([0, model.size]), *flat)), steps
