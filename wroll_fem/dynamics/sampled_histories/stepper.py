r"""Time stepping in a trained basis with the friction of a weighted subset of the contact points.

Basis and subset come from the motions of a response curve (`training.history_points`). The steps need the contact
forces of the subset only. All points follow the motion in the same steps, so that slip and opening are known
everywhere, and so is the friction work without the subset. Where the motion has grown, the forces of all points are
put into the equation of motion of the whole structure. The residual has a part outside the basis, which is the
projection error of `reduced`, and a part in the basis, which is the error of the subset.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wroll_fem.contact import kernels
from wroll_fem.dynamics.reduction.error_estimate import estimate
from wroll_fem.dynamics.reduction.evaluated_points import EvaluatedPoints
from wroll_fem.dynamics.reduction.trained_subset import TrainedSubset
from wroll_fem.dynamics.sampled_histories.following import Followers, follow
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.modal_kernel import correction
from wroll_fem.dynamics.time_stepping.records import OPEN, SLIPPING
from wroll_fem.dynamics.time_stepping.reduced import BLOCK, ReducedStepper
from wroll_fem.dynamics.time_stepping.state import OpeningRecord, SlipRecord, named_arrays
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions, Stepper
from wroll_fem.dynamics.trigonometric.stepper import TrigonometricStepper
from wroll_fem.typing import FloatArray

LOOK_EVERY, LARGER = BLOCK, 1.1
"""Number of steps after which the whole structure may be evaluated again, and growth of the energy norm of the motion
since the last time from which it is."""

NOTHING = 0.1
"""Friction work, relative to the largest strain energy of the motion, below which it counts as nearly nothing."""


class SampledStepper(ReducedStepper):
    """`ReducedStepper` in a fixed basis, with the laws evaluated at a weighted subset of the points.

    With `TrigonometricStepper` as second base class (`sampled_stepper`) the modes are propagated exactly.

    Parameters
    ----------
    trained
        Reduced model of the whole structure, and subset of its contact points. While the motion is smaller than the
        largest one of the training, the errors that stop a run are relative to the latter: the basis, which does not
        grow, is for this motion and not for its beginning.
    largest_error
        Error estimate above which a run stops with `ReductionError`; not checked by default.

    Attributes
    ----------
    all, followers : laws and preload state, and state, of all contact points
    training_seconds : CPU time in which basis and subset were trained, s
    looked : (3,) largest squared energy norms, J, of the motions that were checked, of their parts outside the basis,
        and of the static answer to what the forces of the subset lack
    """

    block, check_every = 200, 1

    def __init__(
        self, system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float,
        trained: TrainedSubset, largest_error: float = np.inf,
    ):  # fmt: skip
        model = trained.model
        super().__init__(
            system, preload, scheme, options, dt=dt, largest_error=largest_error, condensation=model.condensation
        )
        self.all, self.followers = self.points, Followers.of(preload)
        self.looked, self.training_seconds, self._expected = np.zeros(3), 0.0, trained.largest
        self.evaluate(EvaluatedPoints.of(system.laws, preload, model.springs, trained.sample))
        self.adopt(model)

    @property
    def jump(self) -> FloatArray:
        """(3 n_points,) total relative displacement of all points, m."""
        return self.followers.contact.jump

    @property
    def elastic_slip(self) -> FloatArray:
        """(2 n_points,) elastic slip of all points, m."""
        return self.followers.contact.elastic_slip

    @property
    def traction(self) -> FloatArray:
        """(3 n_points,) traction of all points, Pa."""
        return self.followers.contact.traction

    @property
    def slip(self) -> SlipRecord:
        """Slip of all points since the start of the run."""
        return self.followers.accumulated.slip

    @property
    def opening(self) -> OpeningRecord:
        """Opening of all points since the start of the run."""
        return self.followers.accumulated.opening

    def _arrays(self) -> Iterator[tuple[str, np.ndarray]]:
        yield from super()._arrays()
        yield from named_arrays(self.followers, "followers_")
        yield "looked", self.looked

    def try_steps(self, acceleration: FloatArray, dt: float, records: FloatArray) -> int:
        """Advance on the subset, then let all points follow; see `Stepper.try_steps`.

        At every `LOOK_EVERY`-th step the whole structure is evaluated, if the motion has grown since the last time.
        """
        done = super().try_steps(acceleration, dt, records)
        rows, start = self._checked.pop()[:done], 0
        motion = rows[:, : self.model.size]
        jumps, squares = self.model.jump @ motion.T, motion**2 @ self.model.eigenvalues
        turning, ends = self.scheme.exact_modes, np.unique([*range(LOOK_EVERY, done, LOOK_EVERY), done])
        for end in ends:
            grown = end > 0 and float(squares[end - 1]) > LARGER**2 * self.looked[0]
            if grown or end == done:
                shares = follow(jumps[:, start:end], self.all, dt, self.followers, to_turning_points=turning)
                records[start:end, OPEN], records[start:end, SLIPPING] = shares.T
                start = end
            if grown:
                self._look(rows[end - 1])
        return done

    def _advance_block(self, acceleration: FloatArray, dt: float, time: float) -> FloatArray:
        records = Stepper.advance(self, acceleration, dt, time)
        self._accept(records, time)
        return records

    def _look(self, row: FloatArray) -> None:
        """Evaluate the whole structure with the forces of all points in a step; ``row``: see `ResidualChecks`."""
        m, values = self.model.size, self.model.eigenvalues
        (q, a, v), some, base = row[: 3 * m].reshape(3, m), row[3 * m : -1], row[-1:]
        contact, every = self.followers.contact, np.zeros_like(self.followers.contact.jump)
        correction(contact.jump, contact.traction, self.all.reference, every)
        response = self._static_response(a[:, None], v[:, None], every[:, None], base)
        force = self.model.jump.T @ (self.all.weights * every)
        inside = force + a + self.model.base * base
        if self.model.damping is not None:
            inside += self.model.damping @ v
        beyond = float(self.model.energy_norm(response)[0] ** 2 - np.sum(inside**2 / values))
        wrong = force - self._interface.force @ some
        self.looked[:] = np.maximum(self.looked, [values @ q**2, beyond, np.sum(wrong**2 / values)])

    @property
    def error_estimate(self) -> float:
        """Largest projection error of the motions that were checked, relative to the largest of these motions.

        See `reduction.error_estimate` for points that open.
        """
        return estimate(float(self.looked[1]), float(self.looked[0]), float(self.state.opened[0]))

    @property
    def stopping_error(self) -> float:
        """`error_estimate` relative to the expected motion, or to the motion itself once it is larger."""
        return estimate(float(self.looked[1]), max(float(self.looked[0]), self._expected), float(self.state.opened[0]))

    @property
    def work_error(self) -> float:
        """Friction work of the subset minus that of all points in the same motion, relative to the latter.

        Where nearly nothing slips, it is relative to `NOTHING` times the largest energy of the motion.
        """
        some, every = (float(one.work[kernels.FRICTION]) for one in (self.accumulated, self.followers.accumulated))
        size = max(every, NOTHING * 0.5 * float(self.looked[0]))
        return (some - every) / size if size > 0.0 else 0.0

    def report(self) -> dict[str, float]:
        """Numbers of `ReducedStepper`, and the errors of the subset."""
        return super().report() | {
            "training_time_s": self.training_seconds,
            "sampled_points": self.points.n,
            "sampling_work_error": abs(self.work_error),
            "sampling_motion_error": float(np.sqrt(self.looked[2] / max(self.looked[0], 1e-300))),
        }


class TrigonometricSampledStepper(SampledStepper, TrigonometricStepper):
    """`SampledStepper` whose modes are propagated exactly."""


def sampled_stepper(
    system: System, preload: ContactState, scheme: Scheme, options: NewtonOptions, *, dt: float,
    trained: TrainedSubset, largest_error: float = np.inf,
) -> SampledStepper:  # fmt: skip
    """`SampledStepper` for the ``scheme``."""
    kind = TrigonometricSampledStepper if scheme.exact_modes else SampledStepper
    return kind(system, preload, scheme, options, dt=dt, trained=trained, largest_error=largest_error)
