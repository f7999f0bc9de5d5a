"""What every time stepper shares: record columns, slip accumulators, step cutting."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields

import numpy as np

from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray

RECORDS = (
    "tip_displacement",
    "tip_velocity",
    "tip_acceleration",
    "input_work",
    "kinetic_energy",
    "strain_energy",
    "contact_energy",
    "friction_energy",
    "pressure_modulation_work",
    "numerical_dissipation",
    "interface_work",
    "newton_iterations",
    "open_fraction",
    "slipping_fraction",
    "viscous_energy",
    "impact_dissipation",
)
"""Columns of a step record; energies in J since the start of the run."""
(
    INPUT, KINETIC, STRAIN, CONTACT, FRICTION, MODULATION, NUMERICAL, INTERFACE, ITERATIONS, OPEN, SLIPPING, VISCOUS,
    IMPACT,
) = range(3, 16)  # fmt: skip


@dataclass
class SlipRecord:
    """Slip accumulated since the start, per interface point.

    Attributes
    ----------
    path : (n,) length of the plastic slip path, m
    peak : (n,) largest tangential displacement relative to the preload state, m
    peak_vector : (2 n,) its hoop and axial components, m
    """

    path: FloatArray
    peak: FloatArray
    peak_vector: FloatArray

    @classmethod
    def zeros(cls, n: int) -> SlipRecord:
        """No slip yet at ``n`` points."""
        return cls(np.zeros(n), np.zeros(n), np.zeros(2 * n))


@dataclass(frozen=True)
class NewtonOptions:
    """Controls of the nonlinear solve of a step.

    Attributes
    ----------
    tolerance
        Largest interface residual relative to the smallest elastic slip.
    max_iterations
        Newton iterations before a step is cut.
    max_cuts
        Halvings of a step before `ConvergenceError`.
    """

    tolerance: float = 1e-8
    max_iterations: int = 30
    max_cuts: int = 6


class Stepper(ABC):
    """Advances a system step by step from its preload state.

    Motions are relative to the base and to the preload state. Subclasses keep the whole
    history-dependent state in attributes named by ``state_names`` (arrays), so that a checkpoint
    restores a run bit by bit.
    """

    state_names: tuple[str, ...] = ()

    def __init__(self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions):
        self.system, self.preload, self.scheme, self.options = system, preload, scheme, options
        self.slip = SlipRecord.zeros(system.n_points)
        self.totals = np.zeros(5)  # friction, contact, modulation, interface work, impact
        self.flows = np.zeros(3)  # input work, numerical dissipation, viscous work
        self.cuts = 0
        self.base_acceleration = np.zeros(())  # m/s^2, that the committed acceleration is in balance with
        gamma = system.laws.gamma
        self.residual_limit = options.tolerance * (float(gamma.min()) if gamma.size else 1.0)

    @abstractmethod
    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance through ``acceleration`` (k + 1,) in m/s^2, first entry the current time's.

        Fills ``records`` (k, len(RECORDS)) and returns the number of steps done; fewer than k when a
        step failed (`last_history` then holds its residuals).
        """

    @abstractmethod
    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector i and inertia force M i of a unit base acceleration, in the coordinates of the state."""

    last_history: list[float]
    a: FloatArray
    """Acceleration in the coordinates of the state; ``residual`` is r = K u + G^T W t - f in the same."""
    residual: FloatArray
    jump: FloatArray
    """(3 n_points,) total relative displacement in slot order, m."""

    def advance(self, acceleration: FloatArray, dt: float, time: float) -> FloatArray:
        """Advance k steps of size ``dt``, cutting those that do not converge.

        Parameters
        ----------
        acceleration
            (k + 1,) base acceleration at the step ends, m/s^2, the first at the current time.
        dt
            Step in s.
        time
            Current time in s, for messages.

        Returns
        -------
        (k, len(RECORDS)) array

        Notes
        -----
        Where ``acceleration`` does not go on from its last value (a record that starts with a step, above all),
        displacement and velocity stay and a jumps by -i times the jump, so that M a + r balances again.
        """
        k = len(acceleration) - 1
        jump = float(acceleration[0] - self.base_acceleration)
        if jump != 0.0:
            influence, inertia = self.base_motion()
            self.a -= jump * influence
            self.residual += jump * inertia
            self.base_acceleration[...] = acceleration[0]
        records = np.zeros((k, len(RECORDS)))
        done = 0
        while done < k:
            done += self.try_steps(acceleration[done:], dt, records[done:])
            self.base_acceleration[...] = acceleration[done]
            if done < k:
                self._cut_step(acceleration[done : done + 2], dt, time + done * dt, records[done : done + 1])
                done += 1
                self.base_acceleration[...] = acceleration[done]
        return records

    def _cut_step(self, ends: FloatArray, dt: float, time: float, record: FloatArray) -> None:
        """One nominal step in 2, 4, ... substeps; base acceleration is linear within it."""
        start, history = self.snapshot(), self.last_history
        for cut in range(1, self.options.max_cuts + 1):
            parts = 2**cut
            sub = np.zeros((parts, len(RECORDS)))
            inner = np.linspace(ends[0], ends[1], parts + 1)
            if self.try_steps(inner, dt / parts, sub) == parts:
                record[0] = sub[-1]
                record[0, ITERATIONS] = sub[:, ITERATIONS].sum()
                self.cuts += 1
                return
            history = self.last_history
            self.restore(start)
        raise ConvergenceError(
            "time step did not converge",
            time_s=time,
            iterations=self.options.max_iterations,
            residual_history=history,
            advice=f"the step was cut {self.options.max_cuts} times; raise integrator.steps_per_cycle or the preload, "
            "or lower the excitation",
        )

    def report(self) -> dict[str, float]:
        """What a stepper has to say of itself, for the attributes of the results."""
        return {}

    def snapshot(self) -> dict[str, np.ndarray]:
        """Copy of everything the future depends on."""
        state = {
            name: np.array(getattr(self, name))
            for name in (*self.state_names, "totals", "flows", "base_acceleration", "cuts")
        }
        state |= {f"slip_{f.name}": np.array(getattr(self.slip, f.name)) for f in fields(SlipRecord)}
        return state

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Return to a `snapshot`."""
        for name in (*self.state_names, "totals", "flows", "base_acceleration"):
            getattr(self, name)[...] = state[name]
        self.cuts = int(state["cuts"])
        for f in fields(SlipRecord):
            getattr(self.slip, f.name)[...] = state[f"slip_{f.name}"]
