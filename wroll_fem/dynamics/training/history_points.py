"""Basis and subset of contact points for time histories, trained on the motions of a response curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy.linalg as la

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.aft.harmonic_contact import MAX_PERIODS
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.point_sample import Motions, sampled
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.evaluated_points import EvaluatedPoints
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.reduction.stuck_modes import most_excited
from wroll_fem.dynamics.reduction.trained_subset import TrainedSubset
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.training.enrichment import checked_points, trained_response
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.errors import ConvergenceError

HARMONICS, SAMPLES = 5, 64
"""Number of harmonics of the motions, and of friction samples per period."""

MOTIONS = 10
"""Number of evenly spaced points of the curve for whose motions the subset is chosen, with the points at which the
basis was checked."""

NEARLY, MOST_POINTS, MOST_VECTORS = 5.0, 250, 100
"""A training stops where a curve after the first one leaves an error above ``NEARLY`` times the tolerance, where its
curves have more than ``MOST_POINTS`` points, or its basis more than ``MOST_VECTORS`` vectors: layers open widely, or
the resonance has nearly no damping. The lab roll takes three curves, a hundred points and 50 vectors."""

COMPRESSION = 0.5
"""Largest change of the motions of the curve, relative to the tolerance, when their principal shapes replace the basis.
The training adds shapes frequency by frequency, and keeps more of them than these motions need together."""

MODES = 4
"""Number of modes that stay in the basis: those that the base excites most. A history may contain their free motion."""


class _Stopped(Exception):
    """A training stops."""


class _Watch:
    """Stops a training that takes too long."""

    def __init__(
        self, tolerance: float, on_round: Callable[[int, ReducedModel, float], None] | None,
        on_point: Callable[[float, int], None] | None,
    ):  # fmt: skip
        self._tolerance, self._on_round, self._on_point = tolerance, on_round, on_point
        self._points = 0

    def after_curve(self, number: int, model: ReducedModel, error: float) -> None:
        if self._on_round is not None:
            self._on_round(number, model, error)
        if number > 1 and error > NEARLY * self._tolerance:
            raise _Stopped(f"curve {number} leaves an error of {100 * error:.2g} %")

    def at_point(self, hertz: float, count: int) -> None:
        if self._on_point is not None:
            self._on_point(hertz, count)
        self._points += 1
        if self._points > MOST_POINTS:
            raise _Stopped(f"its curves have more than {MOST_POINTS} points")


def history_points(
    condensation: Condensation, preload: ContactState, laws: PointLaws, *, amplitude: float,
    frequencies: tuple[float, float], tolerance: float,
    on_round: Callable[[int, ReducedModel, float], None] | None = None,
    on_point: Callable[[float, int], None] | None = None,
) -> TrainedSubset | None:  # fmt: skip
    """Reduced model and subset of the contact points for the motions of a response curve; None if nothing slips.

    The subset has both points of each pair with half-period symmetry, since a history has this symmetry at no instant.
    Arguments as for `trained_response`.

    Raises
    ------
    ConvergenceError
        If the curve cannot be computed, or its training takes too long, or the subset is unstable (`stable`).
    """
    watch = _Watch(tolerance, on_round, on_point)
    try:
        found = trained_response(
            condensation, preload, laws, amplitude=amplitude, frequencies=frequencies, harmonics=HARMONICS,
            samples=SAMPLES, tolerance=tolerance, on_round=watch.after_curve, on_point=watch.at_point,
            hyper_reduction=True, most_vectors=MOST_VECTORS,
        )  # fmt: skip
    except _Stopped as stop:
        raise _refused(str(stop)) from None
    if found.energy_error > NEARLY * tolerance:
        raise _refused(f"it leaves an error of {100 * found.energy_error:.2g} %")
    model = compressed(found.curve, COMPRESSION * tolerance)
    structure = Structure.of(condensation, preload, laws, Sampling(HARMONICS, SAMPLES), MAX_PERIODS)
    sample = sampled(replace(structure, symmetry=None).contact(model), _motions(found.curve))
    if sample is None:
        return None
    if not stable(model, EvaluatedPoints.of(laws, preload, model.springs, sample)):
        raise _refused("its subset is unstable where all its points slide")
    squares = found.curve.coefficients[:, 1:] ** 2 * found.curve.balance.model.eigenvalues
    return TrainedSubset(model, sample, float(squares.sum(axis=(1, 2)).max()))


def compressed(curve: HarmonicCurve, tolerance: float) -> ReducedModel:
    """Model on the principal shapes of the motions of a ``curve``, and on `MODES` modes.

    The shapes leave at most ``tolerance`` of the largest motion, in the energy norm, of every motion.
    """
    model = curve.balance.model
    root = np.sqrt(model.eigenvalues)  # positive: the interfaces stick and hold the structure
    energetic = curve.coefficients * root  # (p, R, m)
    _, _, shapes = la.svd(energetic.reshape(-1, model.size), full_matrices=False)
    squares = np.sum((energetic @ shapes.T) ** 2, axis=1)  # of each motion in each shape
    beyond = np.cumsum(squares[:, ::-1], axis=1)[:, ::-1].max(axis=0)  # from each shape on
    count = int(np.sum(beyond > tolerance**2 * squares.sum(axis=1).max()))
    vectors = model.vectors @ (shapes[:count] / root).T
    modes = most_excited(model.condensation, MODES)
    return ReducedModel.of_vectors(model.condensation, np.column_stack([vectors, modes]))


def stable(model: ReducedModel, points: EvaluatedPoints) -> bool:
    """Whether the structure has no negative stiffness where all evaluated ``points`` slide.

    The basis contains the sticking stiffness of all points; the subset takes off that of its own points, with their
    weights.
    """
    tangential = points.dofs[: 2 * points.n]
    jump = model.jump[tangential]
    stick = points.weights[: 2 * points.n] * points.reference.springs[: 2 * points.n]
    sliding = np.diag(model.eigenvalues) - jump.T @ (stick[:, None] * jump)
    return bool(la.eigvalsh(sliding)[0] > 0.0)


def _refused(problem: str) -> ConvergenceError:
    return ConvergenceError(
        problem, time_s=None, iterations=0, residual_history=[], advice="set solver.hyper_reduction: false"
    )


def _motions(curve: HarmonicCurve) -> Motions:
    count = len(curve.frequencies)
    spaced = np.linspace(0, count - 1, min(count, MOTIONS)).astype(int)
    kept = np.union1d(spaced, checked_points(curve))
    return Motions(curve.coefficients[kept], curve.frequencies[kept], curve.balance.model.vectors)
