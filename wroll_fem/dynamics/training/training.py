r"""Training of a basis for periodic motions: it is enriched by corrections of these motions from the full model.

A first curve is computed in a small basis with large steps and few harmonics. At some of its points the harmonic
balance of the full model, with all modes, is evaluated (`correction`). The principal shapes of the corrected
motions form the next basis (`basis`). The motions are then recomputed and shapes are added until the corrections at
these points are small. The curve is computed in this basis and checked at other points; the remaining corrections are
the error estimate. While it is too large, the shapes of these corrections are added, and the points of the curve are
recomputed in the larger basis.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.causes import beyond_training, ends_in_every_basis, opens_widely
from wroll_fem.dynamics.periodic.point_sample import SampleError
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training.basis import (
    COMPRESSION,
    SMALL,
    principal_span,
    with_shapes,
    with_snapshots,
)
from wroll_fem.dynamics.training.correction import KRYLOV_TOLERANCE, ROUGH_TOLERANCE, Correction
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.dynamics.training.training_state import TrainingFile, TrainingState, arrays_of
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray

Curve = TypeVar("Curve", HarmonicCurve, BackboneCurve)

Seen = TypeVar("Seen", HarmonicCurve, BackboneCurve, contravariant=True)

COARSE = 2.5
"""Factor on the step lengths of the curve in the first, inaccurate basis."""

POINT_ROUNDS, POINT_SHARE = 4, 0.5
"""Largest number of times that the motion at a point of a curve is corrected and the basis enriched. A point is left
earlier once its correction is at most `POINT_SHARE` times the tolerance."""

FIRST_HARMONICS, TRAINING_HARMONICS = 3, 5
"""Limits of the number of harmonics: in the first curve, and in the motions of which the next basis is built."""

MOST_TRAINED = 25
"""Largest number of evenly spaced points of a curve, used in addition to the checked points to enrich the basis."""

LINEAR = 0.5
"""Largest relative correction at which the corrected motion is more accurate than the uncorrected motion."""

MOVABLE = 20.0
"""Largest error, relative to the tolerance, at which the points of a curve are recomputed in the next basis. Above it
a new curve is computed."""

HOPELESS, HOPELESS_ROUNDS = 3.0, 3
"""Relative correction above which the training ends if two curves in a row exceed it, and number of curves from which
this limit applies. Corrections from linearised equations do not converge if they are this large."""

LARGEST_BASIS = 250
"""Number of basis vectors above which the training ends: a curve would take minutes."""

CUT_ROUNDS, CUT_ERROR = 3, 100.0
"""From curve number `CUT_ROUNDS` on, a curve is cut to its accurate part if its error exceeds `CUT_ERROR` times the
tolerance."""

UNSURE, SURE_ROUNDS = 0.1, 5
"""Largest relative correction of the motions beyond the end of a backbone at which this end is accepted. If corrections
are larger, an insufficient basis may have caused it. From curve number `SURE_ROUNDS` on, any end is accepted."""

OPEN_TOLERANCE, SNAPSHOT_SHARE = 5e-3, 2.0
"""Smallest tolerance where interfaces open widely: a smaller one asks for hundreds of basis vectors, and neglected
harmonics weigh as much. Energy norm, relative to it, above which a principal shape of motions in time is added."""

DOUBTFUL = 0.01
"""Largest error of a curve that is returned above the tolerance, with a warning. Above it the training fails."""


class Check(Protocol[Seen]):
    """Function that computes corrections of the motions at points of a curve from the equations of the full model.

    ``residual`` is the relative residual to which the linear equations of the corrections are solved.
    """

    def __call__(self, points: Seen, residual: float = KRYLOV_TOLERANCE) -> list[Correction]:
        """One correction per point."""
        ...


class Again(Protocol[Curve]):
    """Function that recomputes points of a curve in another model.

    ``starts`` (p, R, r) are first guesses in modal coordinates; by default they are the motions of the points.
    """

    def __call__(self, points: Curve, model: ReducedModel, starts: FloatArray | None = None) -> Curve:
        """Curve with the points that converge."""
        ...


@dataclass(frozen=True)
class Trained(Generic[Curve]):
    """Response curve or backbone with the errors of the basis that was enriched for it.

    Attributes
    ----------
    curve : response curve or backbone
    energy_error : largest remaining correction at the checked points, relative to the motion, both in the energy norm
    tip_error : largest relative change of the fundamental of the tip displacement by these corrections
    rounds : number of curves computed
    span_error : relative energy norm of what the motions lack in modes of a path (`PathSpan`); 0 with other modes
    sample : errors of the subset of contact points on which the curve was followed; None if on all points
    """

    curve: Curve
    energy_error: float
    tip_error: float
    rounds: int
    span_error: float = 0.0
    sample: SampleError | None = None


@dataclass(frozen=True)
class Training:
    """Settings of the training.

    Attributes
    ----------
    tolerance : largest correction at the checked points, relative to the motion, both in the energy norm
    max_rounds : largest number of curves
    on_round : called with the number of the curve, its model and its error
    file : checkpoint from which to continue, and to which the state before every curve goes; None without checkpoints
    snapshots : function that returns motions (r, k) in time, in modal coordinates, for the basis of a roll whose
        interfaces open widely; None if there is none
    rough : relative residual of corrections that only enrich the basis
    most : largest number of evenly spaced points whose corrections do so, see `MOST_TRAINED`
    """

    tolerance: float = 1e-3
    max_rounds: int = 8
    on_round: Callable[[int, ReducedModel, float], None] | None = None
    file: TrainingFile | None = None
    snapshots: Callable[[], FloatArray | None] | None = None
    rough: float = ROUGH_TOLERANCE
    most: int = MOST_TRAINED

    def start(self, structure: Structure) -> TrainingState:
        """State before the first curve, or that of the checkpoint."""
        modes = structure.condensation.eigenvalues
        state = None if self.file is None else self.file.start(modes)
        if state is not None:
            return state
        model = structure.with_harmonics(TRAINING_HARMONICS).first_model()
        factor = 1.0 if len(modes) <= SMALL else COARSE
        return TrainingState(1, model.vectors, model.eigenvalues, factor, False, np.inf, (), None, False)


def trained(
    structure: Structure,
    training: Training,
    solve: Callable[[ReducedModel, float], Curve],
    chosen: Callable[[Curve], list[int]],
    check: Check[Curve],
    again: Again[Curve],
    shortened: Callable[[Curve, Curve, list[bool]], Curve | None],
    restored: Callable[[ReducedModel, dict[str, np.ndarray]], Curve],
) -> Trained[Curve]:
    """Response curve or backbone in a basis that is enriched until the corrections of its motions meet the tolerance.

    Parameters
    ----------
    solve : computes the curve in a reduced model, with steps longer by a factor
    chosen : returns the indices of the points of a curve to be checked
    check : see `Check`
    again : see `Again`
    shortened : cuts a curve to its accurate part; called with the curve, its checked points and whether each of them
        is accurate; returns None if no such part exists
    restored : curve of a checkpoint in a reduced model, from its arrays
    """
    tolerance, state = training.tolerance, training.start(structure)
    model = ReducedModel.on(structure.condensation, state.vectors, state.eigenvalues)
    small = len(structure.condensation.eigenvalues) <= SMALL
    factor, stuck, error, used = state.factor, state.stuck, state.error, set(state.used)
    watched = state.watched
    if watched:
        training, tolerance = _loosened(training)
    moved = None if state.curve is None else restored(model, state.curve)
    before: Curve | None = None
    for number in range(state.number, training.max_rounds + 1):
        stopped: ConvergenceError | None = None
        try:
            curve = solve(model, factor) if moved is None else moved
        except ConvergenceError as stop:
            if len(getattr(stop.partial, "frequencies", ())) < 3:
                raise
            curve, stopped = stop.partial, stop
        count, coarse, richer = len(curve.frequencies), factor > 1.0, curve
        if coarse:
            richer = curve.extended(structure.with_harmonics(TRAINING_HARMONICS).contact(model))
        picked = _others(chosen(curve), used, count)
        points = richer.take(picked)
        found = dict(zip(picked, check(points, training.rough if coarse else KRYLOV_TOLERANCE), strict=True))
        held = [found[k] for k in picked if k < count - curve.beyond]
        previous, error = error, max(f.energy for f in held)
        past = max((found[k].energy for k in picked if k >= count - curve.beyond), default=0.0)
        unsure = past > UNSURE and number < SURE_ROUNDS
        if training.on_round is not None:
            training.on_round(number, model, error)
        if stopped is not None and not coarse and ends_in_every_basis(curve, before, error):
            raise stopped
        before = curve if stopped is not None and not coarse else None
        hopeless = (number >= HOPELESS_ROUNDS and min(previous, error) > HOPELESS) or model.size > LARGEST_BASIS
        late = number >= CUT_ROUNDS and error > CUT_ERROR * tolerance
        if error > tolerance and (hopeless or late or stuck or number == training.max_rounds):
            good = [f.energy <= tolerance for f in held]
            part = shortened(curve, points, good)
            if part is not None and not coarse:
                held = [f for f, kept in zip(held, good, strict=True) if kept]
                return Trained(part, max(f.energy for f in held), max(f.tip for f in held), number)
        ends = hopeless or stuck or beyond_training(curve, number, error)
        lost = (ends and error > DOUBTFUL) or opens_widely(curve, error)
        if training.snapshots is not None and not watched and lost:
            shapes, training = training.snapshots(), replace(training, snapshots=None)
            if shapes is not None:
                training, tolerance = _loosened(training)
                model = _watched(structure, training, shapes)
                factor, stuck, error, used, before, moved, watched = COARSE, False, np.inf, set(), None, None, True
                continue
        if ends:
            break
        if error <= tolerance and not coarse and not unsure:
            if stopped is not None:
                raise stopped
            return Trained(curve.without_beyond(), error, max(f.tip for f in held), number)
        movable = not coarse and stopped is None and curve.beyond == 0 and error <= MOVABLE * tolerance
        used = set(picked)
        if movable or (coarse and error < LINEAR):
            used |= _spread(count, training.most)
        rest = sorted(used - set(picked))
        if rest:
            found |= dict(zip(rest, check(richer.take(rest), training.rough), strict=True))
        size, moved = model.size, None
        if movable:
            model = _joined(structure, training, model, list(found.values()))
            moved = again(curve, model)
            moved = moved if len(moved.frequencies) == count else None
        else:
            points, anew = richer.take(sorted(used)), not small and coarse
            model = _enriched(structure, training, points, [found[k] for k in sorted(used)], check, again, anew=anew)
        used = set() if moved is None else used
        stuck, factor = model.size == size and not coarse, 1.0
        if training.file is not None:
            training.file.keep(
                structure.condensation.eigenvalues,
                TrainingState(
                    number + 1, model.vectors, model.eigenvalues, factor, stuck, error, tuple(sorted(used)),
                    None if moved is None else arrays_of(moved), watched,
                ),
            )  # fmt: skip
    if stopped is None and error <= DOUBTFUL:
        return Trained(curve.without_beyond(), error, max(f.tip for f in held), number)
    failure = ConvergenceError(
        "the reduced model does not reach harmonic.reduction_tolerance",
        time_s=None,
        iterations=number,
        residual_history=[error],
        advice="use a larger harmonic.reduction_tolerance",
    )
    failure.partial = curve
    raise failure


def _spread(count: int, most: int) -> set[int]:
    """Indices of at most ``most`` of ``count`` points, evenly spaced and with both ends."""
    return {int(k) for k in np.linspace(0, count - 1, min(count, most))}


def _others(picked: list[int], used: set[int], count: int) -> list[int]:
    """Indices ``picked`` from ``count`` points; each one in ``used`` is replaced by an unused neighbour, if any."""
    free = [next((j for j in (k, k + 1, k - 1) if 0 <= j < count and j not in used), k) for k in picked]
    return sorted(set(free))


def _enriched(
    structure: Structure,
    training: Training,
    points: Curve,
    found: list[Correction],
    check: Check[Curve],
    again: Again[Curve],
    *,
    anew: bool,
) -> ReducedModel:
    """Reduced model with a basis enriched until the motions at ``points`` need only small corrections.

    ``found`` are the corrections of these motions in the present basis. The shapes of large corrections are added to
    the basis and the motions are recomputed, up to `POINT_ROUNDS` times. With ``anew``, a basis of the corrected
    motions first replaces the given one, and finally a basis of the recomputed motions replaces the enriched one.
    Neither replacement is made if a point does not converge.
    """
    model, condensation, symmetry = points.balance.model, structure.condensation, structure.symmetry
    wanted, settled = len(points.frequencies), []
    negligible = COMPRESSION * training.tolerance
    if anew and max(f.energy for f in found) < LINEAR:
        motions = _modal(points) + np.array([f.modal.T for f in found])
        corrected = principal_span(condensation, motions, POINT_SHARE * training.tolerance, symmetry)
        moved = again(points, corrected, motions)
        if len(moved.frequencies) == wanted:
            model, points, found = corrected, moved, check(moved, training.rough)
    for number in range(POINT_ROUNDS + 1):
        large = [
            k for k, f in enumerate(found) if f.energy > POINT_SHARE * training.tolerance and number < POINT_ROUNDS
        ]
        small = sorted(set(range(len(found))) - set(large))
        settled.append(points.take(small))
        if not large:
            break
        model = _joined(structure, training, model, [found[k] for k in large])
        starts = _modal(points) + np.array([f.modal.T if f.energy < LINEAR else 0.0 * f.modal.T for f in found])
        points = again(points.take(large), model, starts[large])
        if not len(points.frequencies):
            break
        found = check(points, training.rough)
    if not anew or sum(len(part.frequencies) for part in settled) < wanted:
        return model
    motions = np.concatenate([_modal(part) for part in settled if len(part.frequencies)])
    return principal_span(condensation, motions, negligible, symmetry)


def _joined(structure: Structure, training: Training, model: ReducedModel, found: list[Correction]) -> ReducedModel:
    """Reduced model whose basis is extended by the shapes of the large corrections in ``found``.

    A correction is large if its energy norm, relative to the motion, exceeds `POINT_SHARE` times the tolerance.
    """
    large = [f.shapes for f in found if f.energy > POINT_SHARE * training.tolerance]
    return with_shapes(model, np.column_stack(large), 0.2 * training.tolerance, structure.symmetry)


def _loosened(training: Training) -> tuple[Training, float]:
    """Training of a roll whose interfaces open widely, and its tolerance."""
    tolerance = max(training.tolerance, OPEN_TOLERANCE)
    return replace(training, tolerance=tolerance), tolerance


def _watched(structure: Structure, training: Training, snapshots: FloatArray) -> ReducedModel:
    """First model with the shapes of motions in time."""
    first = structure.with_harmonics(TRAINING_HARMONICS).first_model()
    return with_snapshots(first, snapshots, SNAPSHOT_SHARE * training.tolerance, structure.symmetry)


def _modal(points: Curve) -> FloatArray:
    """(p, R, r) Fourier coefficients of the motions at p ``points``, in modal coordinates of the condensation."""
    return np.asarray(points.coefficients @ points.balance.model.vectors.T)
