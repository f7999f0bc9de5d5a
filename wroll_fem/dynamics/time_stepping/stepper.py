"""Base class of the time steppers: running totals, step cutting, snapshots."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, cast

import numpy as np

from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import ITERATIONS, record_size
from wroll_fem.dynamics.time_stepping.state import (
    Accumulated,
    ContactMemory,
    Motion,
    SlipRecord,
    Step,
    named_arrays,
)
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray


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


class CommonState(Protocol):
    """Fields that the state of every stepper has; it is a named tuple of arrays."""

    @property
    def motion(self) -> Motion:
        """Motion in the coordinates of the stepper."""
        ...

    @property
    def contact(self) -> ContactMemory:
        """Committed contact."""
        ...


class Stepper(ABC):
    """Advances a system step by step from its preload state.

    Motions are relative to the base and to the preload state. Subclasses keep everything that depends on the history
    in the arrays of `state`, so that a checkpoint restores a run bit by bit.
    """

    name: ClassVar[str]
    """Value of `solver.method` that chooses it."""

    state: Any
    """Named tuple of arrays with the fields of `CommonState`; its arrays are updated in place."""

    def __init__(self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions):
        self.system, self.preload, self.scheme, self.options = system, preload, scheme, options
        self.accumulated = Accumulated.zeros(system.n_points)
        self.cuts = 0
        self.base_acceleration = np.zeros(())  # m/s^2, with which the committed acceleration is in balance
        gamma = system.laws.gamma
        self.residual_limit = options.tolerance * (float(gamma.min()) if gamma.size else 1.0)
        self.last_history: list[float] = []

    @property
    def common(self) -> CommonState:
        """State with its type."""
        return cast(CommonState, self.state)

    @property
    def jump(self) -> FloatArray:
        """(3 n_points,) total relative displacement, m, in the order of `contact.point`."""
        return self.common.contact.jump

    @property
    def elastic_slip(self) -> FloatArray:
        """(2 n_points,) elastic slip, m."""
        return self.common.contact.elastic_slip

    @property
    def traction(self) -> FloatArray:
        """(3 n_points,) traction, Pa."""
        return self.common.contact.traction

    @property
    def slip(self) -> SlipRecord:
        """Slip of the points since the start."""
        return self.accumulated.slip

    @property
    def record_size(self) -> int:
        """Columns of a step record."""
        return record_size(len(self.system.named_probes))

    def step(self, dt: float) -> Step:
        """Step of ``dt`` (s) with the parameters of the scheme, for compiled code."""
        return Step(dt, self.scheme.alpha, self.scheme.beta, self.scheme.gamma)

    @abstractmethod
    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance through ``acceleration`` (k + 1,) in m/s^2, first entry the current time's.

        Fills ``records`` (k, record_size) and returns the number of steps done; fewer than k when a
        step failed (`last_history` then holds its residuals).
        """

    @abstractmethod
    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector i and inertia force M i of a unit base acceleration, in the coordinates of the state."""

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
        (k, record_size) array: the columns of `RECORDS`, then those of the probes

        Notes
        -----
        Where ``acceleration`` does not go on from its last value (a record that starts with a step, above all),
        displacement and velocity stay and a jumps by -i times the jump, so that M a + r balances again.
        """
        k = len(acceleration) - 1
        jump = float(acceleration[0] - self.base_acceleration)
        if jump != 0.0:
            influence, inertia = self.base_motion()
            motion = self.common.motion
            motion.a[:] -= jump * influence
            motion.residual[:] += jump * inertia
            self.base_acceleration[...] = acceleration[0]
        records = np.zeros((k, self.record_size))
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
            sub = np.zeros((parts, self.record_size))
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
        """Figures about the stepper itself, for the attributes of the results."""
        return {}

    def _arrays(self) -> Iterator[tuple[str, np.ndarray]]:
        """Arrays on which the future depends, by name."""
        yield from named_arrays(self.state)
        yield from named_arrays(self.accumulated)
        yield "base_acceleration", self.base_acceleration

    def snapshot(self) -> dict[str, np.ndarray]:
        """Copy of everything the future depends on."""
        return {name: array.copy() for name, array in self._arrays()} | {"cuts": np.array(self.cuts)}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Return to a `snapshot`."""
        for name, array in self._arrays():
            array[...] = state[name]
        self.cuts = int(state["cuts"])
