"""Base class of the time steppers: running totals, cutting of steps, snapshots."""

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
    OpeningRecord,
    SlipRecord,
    Step,
    named_arrays,
)
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray

RIGID = 1e-5
"""Elastic slip, relative to the largest displacement, below which a point changes between stick and slip in a small
part of any step; Newton's method then goes back and forth between both."""


@dataclass(frozen=True)
class NewtonOptions:
    """Controls of the nonlinear solution of a time step.

    Attributes
    ----------
    tolerance
        Largest interface residual of a converged step, relative to the smallest gamma* of all points.
    max_iterations
        Largest number of Newton iterations; a step that needs more is cut.
    max_cuts
        Largest number of times that a step is halved before a `ConvergenceError`.
    """

    tolerance: float = 1e-8
    max_iterations: int = 30
    max_cuts: int = 6


class CommonState(Protocol):
    """Fields that the state of every stepper has; the state is a named tuple of arrays."""

    @property
    def motion(self) -> Motion:
        """Motion in the coordinates of the stepper."""
        ...

    @property
    def contact(self) -> ContactMemory:
        """Committed state of the contact."""
        ...


class BetweenSteps(Protocol):
    """Base motion that has an acceleration at any time."""

    def acceleration(self, time: FloatArray) -> FloatArray:
        """Base acceleration in m/s^2 at ``time`` (n,) in s."""
        ...


class Stepper(ABC):
    """Base class of methods that advance a system step by step from its preload state.

    Motions are relative to the base and to the preload state. Subclasses keep all data that depend on the history in
    the arrays of `state`, so that a run can be continued bit by bit from a checkpoint.
    """

    name: ClassVar[str]
    """Value of `solver.method` that selects this stepper."""

    state: Any
    """Named tuple of arrays with the fields of `CommonState`; its arrays are updated in place."""

    def __init__(self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions):
        self.system, self.preload, self.scheme, self.options = system, preload, scheme, options
        self.accumulated = Accumulated.zeros(system.n_points)
        self.cuts = 0
        self.motion: BetweenSteps | None = None
        self.base_acceleration = np.zeros(())  # m/s^2, with which the committed acceleration is in balance
        gamma = system.laws.gamma
        self.residual_limit = options.tolerance * (float(gamma.min()) if gamma.size else 1.0)
        self.last_history: list[float] = []

    @property
    def common(self) -> CommonState:
        """`state`, typed with the fields that every stepper has."""
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
        """Slip of the contact points since the start of the run."""
        return self.accumulated.slip

    @property
    def opening(self) -> OpeningRecord:
        """Opening of the contact points since the start of the run."""
        return self.accumulated.opening

    @property
    def record_size(self) -> int:
        """Number of columns of a step record."""
        return record_size(len(self.system.output_rows))

    def follow(self, motion: BetweenSteps) -> None:
        """Let a scheme that uses the base acceleration within the steps take it from ``motion``."""
        self.motion = motion

    def step(self, dt: float) -> Step:
        """Time step ``dt`` (s) and parameters of the integration scheme, for compiled code."""
        return Step(dt, self.scheme.alpha, self.scheme.beta, self.scheme.gamma)

    @abstractmethod
    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance through base accelerations (k + 1,), m/s^2, of which the first belongs to the current time.

        Fills ``records`` (k, record_size) and returns the number of completed steps. The number is smaller than k if a
        step fails; `last_history` then holds the residuals of this step.
        """

    @abstractmethod
    def base_motion(self) -> tuple[FloatArray, FloatArray]:
        """Influence vector i, and M i, the inertia force per unit base acceleration, in the stepper's coordinates."""

    @abstractmethod
    def displacement(self) -> FloatArray:
        """(n_dofs,) displacement relative to the preload state, m."""

    def advance(self, acceleration: FloatArray, dt: float, time: float) -> FloatArray:
        """Advance k steps of size ``dt``; steps that do not converge are cut.

        Parameters
        ----------
        acceleration
            (k + 1,) base acceleration at the ends of the steps, m/s^2, the first at the current time.
        dt
            Time step, s.
        time
            Current time, s, for messages.

        Returns
        -------
        (k, record_size) array: the columns of `RECORDS`, then those of the probes

        Notes
        -----
        The base acceleration may jump before the first step, for example at the start of a record. Displacement and
        velocity are then unchanged. The acceleration a changes by -i times the jump, so that M a + r = 0 again.
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
        """Compute one nominal step in 2, 4, ... substeps; the base acceleration is linear within the step."""
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
            advice=f"the step was cut {self.options.max_cuts} times; {self._remedy()}",
        )

    def _remedy(self) -> str:
        """What helps a step that does not converge: contact that is nearly rigid is not cured by smaller steps."""
        gamma = float(self.system.laws.gamma.min(initial=np.inf))
        motions = (self.displacement(), self.preload.displacement)
        largest = max(float(np.abs(u).max(initial=0.0)) for u in motions)
        if gamma < RIGID * largest:
            return (
                f"the elastic slip of {gamma:.2g} m is {gamma / largest:.1g} of the displacement: "
                "raise contact.friction.elastic_slip"
            )
        return "raise integrator.steps_per_cycle or solver.max_cuts"

    def report(self) -> dict[str, float]:
        """Numbers that describe the stepper, for the attributes of the results."""
        return {}

    def _arrays(self) -> Iterator[tuple[str, np.ndarray]]:
        """Arrays needed to continue the run, with their names."""
        yield from named_arrays(self.state)
        yield from named_arrays(self.accumulated)
        yield "base_acceleration", self.base_acceleration

    def snapshot(self) -> dict[str, np.ndarray]:
        """Copy of the state needed to continue the run."""
        return {name: array.copy() for name, array in self._arrays()} | {"cuts": np.array(self.cuts)}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Return to the state of a `snapshot`."""
        for name, array in self._arrays():
            array[...] = state[name]
        self.cuts = int(state["cuts"])
