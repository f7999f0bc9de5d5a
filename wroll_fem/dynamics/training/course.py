"""Course of a training: one curve after the other, each in a larger basis, until its corrections are small."""

from __future__ import annotations

from dataclasses import replace
from typing import Generic

import numpy as np

from wroll_fem.dynamics.periodic.causes import beyond_training, ends_in_every_basis, opens_widely
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training.basis import SMALL
from wroll_fem.dynamics.training.checked_curve import DOUBTFUL, CheckedCurve
from wroll_fem.dynamics.training.correction import KRYLOV_TOLERANCE
from wroll_fem.dynamics.training.full_motions import LINEAR
from wroll_fem.dynamics.training.growth import enriched, joined, loosened, watched
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.dynamics.training.training import (
    COARSE,
    MOST_TRAINED,
    TRAINING_HARMONICS,
    Curve,
    Task,
    Trained,
    Training,
)
from wroll_fem.dynamics.training.training_state import KeptCurve, TrainingState, arrays_of
from wroll_fem.errors import ConvergenceError

MOVABLE = 20.0
"""Largest error, relative to the tolerance, at which the points of a curve are recomputed in the next basis. Above it
a new curve is computed."""

SPARSE = 0.6
"""Share of the points of a curve below which only the points of the next basis and of the next check are recomputed.
The others keep their motions of the basis before until the error is small enough."""

HOPELESS, HOPELESS_ROUNDS = 3.0, 3
"""Relative correction above which the training ends if two curves in a row exceed it, and number of curves from which
this limit applies. Corrections from linearised equations do not converge if they are this large."""

LARGEST_BASIS = 250
"""Number of basis vectors above which the training ends: a curve would take minutes. None is computed in such a basis
if the one before is accurate."""

SLOW = 0.5
"""Error of a curve, relative to that of the one before, above which up to `MOST_TRAINED` evenly spaced points of it
serve the next basis."""

CUT_ROUNDS, CUT_ERROR = 3, 100.0
"""From curve number `CUT_ROUNDS` on, a curve is cut to its accurate part if its error exceeds `CUT_ERROR` times the
tolerance."""


def trained(structure: Structure, training: Training, task: Task[Curve]) -> Trained[Curve]:
    """Response curve or backbone in a basis that is enriched until the corrections of its motions meet the tolerance.

    Raises
    ------
    ConvergenceError
        If the curve ends in every basis, or no basis reaches the tolerance and no curve is accurate to `DOUBTFUL`;
        ``partial`` holds the last curve.
    """
    course = _Course(structure, training, task)
    try:
        return _followed(course, training)
    except ConvergenceError:
        kept = course.kept()
        if kept is None:
            raise
        return kept


def _followed(course: _Course[Curve], training: Training) -> Trained[Curve]:
    """Curves of a training until one is accurate enough, or until no further one is worth its time; see `trained`."""
    for number in range(course.first, training.max_rounds + 1):
        checked = course.next_curve(number)
        part = course.accurate_part(checked)
        if part is not None:
            return part
        ends = course.ends(checked)
        if course.watches(checked, ends):
            continue
        if ends:
            break
        if checked.error <= course.tolerance and not checked.coarse and not checked.unsure:
            checked = course.whole(checked, anew=True)
            if checked.stopped is not None:
                raise checked.stopped
            if checked.error <= course.tolerance:
                return checked.accepted()
        if number == training.max_rounds:
            break
        accurate = checked.acceptable and not checked.coarse
        if accurate and not checked.unsure:
            course.keep(checked)
        course.enrich(checked)
        if course.size > training.most_vectors or (course.size > LARGEST_BASIS and accurate):
            break
    kept = course.kept(before=checked)
    if kept is not None:
        return kept
    checked = course.whole(checked, anew=checked.error <= DOUBTFUL)
    if checked.acceptable:
        return checked.accepted()
    failure = ConvergenceError(
        "the reduced model does not reach harmonic.reduction_tolerance",
        time_s=None,
        iterations=checked.number,
        residual_history=[checked.error],
        advice=checked.advice,
    )
    failure.partial = checked.curve
    raise failure


class _Course(Generic[Curve]):
    """State of a training between its curves.

    Attributes
    ----------
    first : number of the first curve to compute
    tolerance : largest correction that is accepted
    """

    def __init__(self, structure: Structure, training: Training, task: Task[Curve]):
        state = training.start(structure)
        self._structure = structure
        self._task: Task[Curve] = task
        self._small = len(structure.condensation.eigenvalues) <= SMALL
        self._model = ReducedModel.on(structure.condensation, state.vectors, state.eigenvalues)
        self._factor, self._stuck, self._used, self._watched = state.factor, state.stuck, set(state.used), state.watched
        self._moved: Curve | None = None if state.curve is None else task.restored(self._model, state.curve)
        self._checks, self._kept, self._count = state.checks, state.kept, state.number - 1
        self._stopped_before: Curve | None = None
        self._error, self._previous = state.error, np.inf
        self._training, self.tolerance = loosened(training) if state.watched else (training, training.tolerance)
        self.first = state.number

    def next_curve(self, number: int) -> CheckedCurve[Curve]:
        """Compute the next curve, unless its points were moved to the present basis already, and check it.

        Raises
        ------
        ConvergenceError
            If fewer than three points can be computed, or the curve ends in every basis.
        """
        stopped: ConvergenceError | None = None
        self._count = number
        try:
            curve = self._task.solve(self._model, self._factor) if self._moved is None else self._moved
        except ConvergenceError as stop:
            if len(getattr(stop.partial, "frequencies", ())) < 3:
                raise
            curve, stopped = stop.partial, stop
        count, coarse, richer = len(curve.frequencies), self._factor > 1.0, curve
        if coarse:
            contact = self._structure.with_harmonics(TRAINING_HARMONICS).contact(self._model)
            richer = curve.extended(contact)
        checks = self._checks
        picked = _others(self._task.chosen(curve), self._used, count) if checks is None else list(checks)
        points = richer.take(picked)
        corrections = self._task.check(points, self._training.rough if coarse else KRYLOV_TOLERANCE)
        found = dict(zip(picked, corrections, strict=True))
        held = [found[k] for k in picked if k < count - curve.beyond]
        beyond = max((found[k].energy for k in picked if k >= count - curve.beyond), default=0.0)
        checked = CheckedCurve(number, curve, stopped, coarse, richer, points, found, held, beyond, checks is not None)
        self._previous, self._error = self._error, checked.error
        if self._training.on_round is not None:
            self._training.on_round(number, self._model, checked.error)
        cut = stopped is not None and not coarse
        if stopped is not None and cut and ends_in_every_basis(curve, self._stopped_before, checked.error):
            self._kept = None
            raise stopped
        self._stopped_before = curve if cut else None
        return checked

    def accurate_part(self, checked: CheckedCurve[Curve]) -> Trained[Curve] | None:
        """Accurate part of a curve that becomes no better; None if it may, or if no such part exists."""
        number, error = checked.number, checked.error
        late = number >= CUT_ROUNDS and error > CUT_ERROR * self.tolerance
        final = self._hopeless(checked) or late or self._stuck or number == self._training.max_rounds
        if error <= self.tolerance or not final:
            return None
        good = [one.energy <= self.tolerance for one in checked.held]
        part = self._task.shortened(checked.curve, checked.points, good)
        if part is None or checked.coarse:
            return None
        if checked.partial and (part := self._solved(part, self._model)) is None:
            return None
        held = [one for one, kept in zip(checked.held, good, strict=True) if kept]
        return Trained(part, max(one.energy for one in held), max(one.tip for one in held), number)

    def whole(self, checked: CheckedCurve[Curve], *, anew: bool) -> CheckedCurve[Curve]:
        """The curve with all its points in the present basis; if one does not converge, a curve ``anew`` in this basis.

        Raises
        ------
        ConvergenceError
            If the new curve has fewer than three points, or ends in every basis.
        """
        if not checked.partial:
            return checked
        curve = self._solved(checked.curve, self._model)
        if curve is not None:
            return replace(checked, curve=curve, partial=False)
        return self.next_curve(checked.number) if anew else checked

    def _solved(self, curve: Curve, model: ReducedModel) -> Curve | None:
        found = self._task.again(curve, model)
        if len(found.frequencies) == len(curve.frequencies):
            return found
        self._moved, self._checks, self._used = None, None, set()
        return None

    def keep(self, checked: CheckedCurve[Curve]) -> None:
        """Keep an accurate curve, unless an earlier one is better: errors need not fall from one basis to the next."""
        if self._kept is None or checked.rank < self._kept.rank:
            model, curve = checked.curve.balance.model, checked.curve.without_beyond()
            self._kept = KeptCurve(
                model.vectors, model.eigenvalues, arrays_of(curve), checked.error, checked.tip_error,
                checked.incomplete, checked.partial,
            )  # fmt: skip

    def kept(self, *, before: CheckedCurve[Curve] | None = None) -> Trained[Curve] | None:
        """The kept curve with all its points, if it is better than the one ``before``; None without such a curve."""
        kept = self._kept
        if kept is None or (before is not None and before.rank <= kept.rank):
            return None
        self._kept = None
        model = ReducedModel.on(self._structure.condensation, kept.vectors, kept.eigenvalues)
        curve: Curve | None = self._task.restored(model, kept.curve)
        if kept.partial and curve is not None:
            curve = self._solved(curve, model)
        return None if curve is None else Trained(curve, kept.energy_error, kept.tip_error, self._count)

    @property
    def size(self) -> int:
        """Number of basis vectors of the next curve."""
        return self._model.size

    def ends(self, checked: CheckedCurve[Curve]) -> bool:
        """Whether no further curve is worth its time."""
        beyond = beyond_training(checked.curve, checked.number, checked.error)
        return self._hopeless(checked) or self._stuck or beyond

    def watches(self, checked: CheckedCurve[Curve], ends: bool) -> bool:
        """Begin anew with shapes of motions in time, if interfaces open widely and there are such motions."""
        lost = (ends and checked.error > DOUBTFUL) or opens_widely(checked.curve, checked.error)
        if self._training.snapshots is None or self._watched or not lost:
            return False
        shapes, self._training = self._training.snapshots(), replace(self._training, snapshots=None)
        if shapes is None:
            return False
        self._training, self.tolerance = loosened(self._training)
        self._model = watched(self._structure, self._training, shapes)
        self._factor, self._stuck, self._error, self._used = COARSE, False, np.inf, set()
        self._stopped_before, self._moved, self._checks, self._watched = None, None, None, True
        return True

    def enrich(self, checked: CheckedCurve[Curve]) -> None:
        """Enrich the basis by the corrections of the curve, and keep the state before the next curve."""
        structure, training, task, count = self._structure, self._training, self._task, len(checked.curve.frequencies)
        found, size, complete = dict(checked.found), self._model.size, checked.stopped is None
        close = checked.error <= MOVABLE * self.tolerance
        movable = not checked.coarse and complete and checked.curve.beyond == 0 and close
        used = set(found)
        if movable or (checked.coarse and checked.error < LINEAR):
            slow = checked.error > SLOW * self._previous
            used |= _spread(count, MOST_TRAINED if slow else training.most)
        rest = sorted(used - set(found))
        if rest:
            found |= dict(zip(rest, task.check(checked.richer.take(rest), training.rough), strict=True))
        self._moved = self._checks = None
        if movable:
            self._model = joined(structure, training, self._model, list(found.values()))
            self._move(checked.curve, used)
        else:
            points, anew = checked.richer.take(sorted(used)), not self._small and checked.coarse
            corrections = [found[k] for k in sorted(used)]
            self._model = enriched(
                structure, training, points, corrections, task, around=checked.richer if anew else None, used=used
            )
        self._used = set() if self._moved is None else used
        self._stuck, self._factor = self._model.size == size and not checked.coarse, 1.0
        if training.file is not None:
            training.file.keep(structure.condensation.eigenvalues, self._state(checked.number + 1))

    def _move(self, curve: Curve, used: set[int]) -> None:
        """Recompute a curve in the present basis: all its points, or of many those ``used`` and the next ones to check.

        If a point does not converge, the next curve is computed anew.
        """
        count = len(curve.frequencies)
        checks = _others(self._task.chosen(curve), used, count)
        needed = used | set(checks)
        few = len(needed) < SPARSE * count
        moved = self._task.again(curve, self._model, only=needed if few else None)
        if len(moved.frequencies) == count:
            self._moved, self._checks = moved, tuple(checks) if few else None

    def _state(self, number: int) -> TrainingState:
        curve = None if self._moved is None else arrays_of(self._moved)
        return TrainingState(
            number, self._model.vectors, self._model.eigenvalues, self._factor, self._stuck, self._error,
            tuple(sorted(self._used)), self._checks, curve, self._watched, self._kept,
        )  # fmt: skip

    def _hopeless(self, checked: CheckedCurve[Curve]) -> bool:
        diverges = checked.number >= HOPELESS_ROUNDS and min(self._previous, checked.error) > HOPELESS
        return diverges or self._model.size > LARGEST_BASIS


def _spread(count: int, most: int) -> set[int]:
    """Indices of at most ``most`` of ``count`` points, evenly spaced and with both ends."""
    return {int(k) for k in np.linspace(0, count - 1, min(count, most))}


def _others(picked: list[int], used: set[int], count: int) -> list[int]:
    """Indices ``picked`` from ``count`` points; each one in ``used`` is replaced by an unused neighbour, if any."""
    free = [next((j for j in (k, k + 1, k - 1) if 0 <= j < count and j not in used), k) for k in picked]
    return sorted(set(free))
