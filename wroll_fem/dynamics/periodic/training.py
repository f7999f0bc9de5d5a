r"""Training of a basis for periodic motions: it gets what the balance of the whole structure finds missing on a curve.

A curve is computed in a small basis with large steps and few harmonics. At some of its points the balance of the
*whole* structure is evaluated (`correction`). The principal shapes of the corrected motions are the next basis
(`basis`); the motions are computed again, and shapes are added, until the corrections at these points are small. Then
the curve is computed in this basis, and checked at points of its own; what is left is the error estimate. While it is
too large, shapes of corrections between those points join, and the points of the curve are moved to the larger basis.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.periodic.aft import HarmonicContact, Sampling
from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.basis import COMPRESSION, SMALL, first_model, principal_span, with_shapes
from wroll_fem.dynamics.periodic.causes import WIDE, opening
from wroll_fem.dynamics.periodic.correction import KRYLOV_TOLERANCE, ROUGH_TOLERANCE, Correction
from wroll_fem.dynamics.periodic.half_period import HalfPeriod
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.errors import ConvergenceError
from wroll_fem.typing import FloatArray

Curve = TypeVar("Curve", HarmonicCurve, BackboneCurve)

Seen = TypeVar("Seen", HarmonicCurve, BackboneCurve, contravariant=True)

COARSE = 2.5
"""Factor on the steps of the curves in bases that are not good yet."""

POINT_ROUNDS, POINT_SHARE = 4, 0.5
"""Enrichments at the points of one curve, and the share of the tolerance at which they end."""

FIRST_HARMONICS, TRAINING_HARMONICS = 3, 5
"""Most harmonics of the curve in the first basis, and of the motions at its points in the following ones."""

MOST_TRAINED = 25
"""Points of a curve at which the basis is enriched, besides those that are compared with the whole structure."""

LINEAR = 0.5
"""Largest correction after which the corrected motion is closer than the motion itself."""

MOVABLE = 20.0
"""Largest error, over the tolerance, of a curve whose points are moved to the next basis; others are followed anew."""

HOPELESS, HOPELESS_ROUNDS = 3.0, 3
"""Correction that ends the training after so many curves: linearised, corrections that large do not converge."""

RATTLING, MOST_OPEN = 0.5, 0.5
"""Error that ends the training where the surfaces open widely at the resonance (`WIDE`), and the share of points that
open with which it does so before `HOPELESS_ROUNDS`: bases for rattling layers have hundreds of vectors, and curves in
them take minutes."""

LARGEST_BASIS = 250
"""Vectors of a basis beyond which a curve takes minutes."""

CUT_ROUNDS, CUT_ERROR = 3, 100.0
"""Curves after which the points that the basis still misses, by this multiple of the tolerance, are cut off."""

UNSURE, SURE_ROUNDS = 0.1, 5
"""Error of the motion beyond the end of a backbone above which this end may be one of the basis, and the number of
curves after which it is taken as it is."""

DOUBTFUL = 0.01
"""Error up to which a curve whose basis grows no further is returned, for the analysis to warn; above, it fails."""


class Check(Protocol[Seen]):
    """Corrections of the whole structure at points, to a relative residual of their linear equations."""

    def __call__(self, points: Seen, residual: float = KRYLOV_TOLERANCE) -> list[Correction]:
        """One correction per point."""
        ...


class Again(Protocol[Curve]):
    """Points of a curve computed in another model, from modal motions (p, R, r) if there are any."""

    def __call__(self, points: Curve, model: ReducedModel, starts: FloatArray | None = None) -> Curve:
        """Points that converge."""
        ...


@dataclass(frozen=True)
class Trained(Generic[Curve]):
    """Response curve or backbone with the basis that was enriched for it.

    Attributes
    ----------
    curve : response or backbone
    energy_error : largest energy norm of what the whole structure still adds at the checked points, over the motion's
    tip_error : largest change of the tip's fundamental that it makes
    rounds : curves computed
    """

    curve: Curve
    energy_error: float
    tip_error: float
    rounds: int


@dataclass(frozen=True)
class Structure:
    """Whole structure with its contact, from which reduced models and their contacts are made.

    Attributes
    ----------
    condensation, preload, laws : modes, state that motions are relative to, laws of the points
    sampling : harmonics and samples
    max_periods : periods that the hysteresis may take to become periodic
    symmetry : half-period symmetry, None without one
    """

    condensation: Condensation
    preload: ContactState
    laws: PointLaws
    sampling: Sampling
    max_periods: int
    symmetry: HalfPeriod | None

    @classmethod
    def of(
        cls, condensation: Condensation, preload: ContactState, laws: PointLaws, sampling: Sampling, max_periods: int
    ) -> Structure:
        """Structure with the symmetry that it has."""
        symmetry = None if sampling.odd else HalfPeriod.of(condensation, preload, laws)
        return cls(condensation, preload, laws, sampling, max_periods, symmetry)

    def contact(self, model: ReducedModel) -> HarmonicContact:
        """Contact of a model."""
        return HarmonicContact(
            model, self.preload, self.laws, self.sampling, max_periods=self.max_periods, symmetry=self.symmetry
        )

    def with_harmonics(self, most: int) -> Structure:
        """The same with no more harmonics than ``most``."""
        s = self.sampling
        return self if s.harmonics <= most else replace(self, sampling=Sampling(most, s.samples, odd=s.odd))

    def first_model(self) -> ReducedModel:
        """Model to start from."""
        return first_model(self.condensation, self.preload, self.laws, self.sampling, self.symmetry)


@dataclass(frozen=True)
class Training:
    """Settings of the training.

    Attributes
    ----------
    tolerance : largest correction at the checked points, relative to the motion in the energy norm
    max_rounds : curves at most
    on_round : called with the number of the curve, its model and its error
    """

    tolerance: float = 1e-3
    max_rounds: int = 8
    on_round: Callable[[int, ReducedModel, float], None] | None = None


def trained(
    structure: Structure,
    training: Training,
    solve: Callable[[ReducedModel, float], Curve],
    chosen: Callable[[Curve], list[int]],
    check: Check[Curve],
    again: Again[Curve],
    shortened: Callable[[Curve, Curve, list[bool]], Curve | None],
) -> Trained[Curve]:
    """Curves in bases that grow until the corrections are below the tolerance.

    Parameters
    ----------
    solve : curve in a model, with steps longer by a factor
    chosen : a few points of a curve
    check : corrections of the whole structure at points
    again : the same points computed in another model, from starts if there are any; points that do not converge are
        left out
    shortened : the part of a curve between its good points, from the curve, its points, and which are good; or None
    """
    tolerance = training.tolerance
    model = structure.with_harmonics(TRAINING_HARMONICS).first_model()
    small = len(structure.condensation.eigenvalues) <= SMALL
    factor, stuck = 1.0 if small else COARSE, False
    moved: Curve | None = None
    used: set[int] = set()
    for number in range(1, training.max_rounds + 1):
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
        found = dict(zip(picked, check(points, ROUGH_TOLERANCE if coarse else KRYLOV_TOLERANCE), strict=True))
        held = [found[k] for k in picked if k < count - curve.beyond]
        error = max(f.energy for f in held)
        past = max((found[k].energy for k in picked if k >= count - curve.beyond), default=0.0)
        unsure = past > UNSURE and number < SURE_ROUNDS
        if training.on_round is not None:
            training.on_round(number, model, error)
        hopeless = (number >= HOPELESS_ROUNDS and error > HOPELESS) or model.size > LARGEST_BASIS
        late = number >= CUT_ROUNDS and error > CUT_ERROR * tolerance
        if error > tolerance and (hopeless or late or stuck or number == training.max_rounds):
            good = [f.energy <= tolerance for f in held]
            part = shortened(curve, points, good)
            if part is not None and not coarse:
                held = [f for f, kept in zip(held, good, strict=True) if kept]
                return Trained(part, max(f.energy for f in held), max(f.tip for f in held), number)
        wide = MOST_OPEN if number < HOPELESS_ROUNDS else WIDE
        rattles = isinstance(curve, HarmonicCurve) and error > RATTLING and opening(curve) > wide
        if hopeless or stuck or rattles:
            break
        if error <= tolerance and not coarse and not unsure:
            if stopped is not None:
                raise stopped
            return Trained(curve.without_beyond(), error, max(f.tip for f in held), number)
        movable = not coarse and stopped is None and curve.beyond == 0 and error <= MOVABLE * tolerance
        used = set(picked)
        if movable or (coarse and error < LINEAR):
            used |= _spread(count, MOST_TRAINED)
        rest = sorted(used - set(picked))
        if rest:
            found |= dict(zip(rest, check(richer.take(rest), ROUGH_TOLERANCE), strict=True))
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
    """Up to ``most`` of ``count`` points, both ends among them."""
    return {int(k) for k in np.linspace(0, count - 1, min(count, most))}


def _others(picked: list[int], used: set[int], count: int) -> list[int]:
    """The ``picked`` of ``count`` points; neighbours in place of those that are ``used``, where there are any."""
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
    """Model in which the corrections ``found`` at ``points`` become small.

    The shapes of the corrections join the basis, and the motions are computed again, until the corrections are small.
    With ``anew`` a basis made of the corrected motions takes the place of the first one, and in the end those shapes
    leave it that no motion has; points that do not converge prevent both.
    """
    model, condensation, symmetry = points.balance.model, structure.condensation, structure.symmetry
    wanted, settled = len(points.frequencies), []
    negligible = COMPRESSION * training.tolerance
    if anew and max(f.energy for f in found) < LINEAR:
        motions = _modal(points) + np.array([f.modal.T for f in found])
        corrected = principal_span(condensation, motions, POINT_SHARE * training.tolerance, symmetry)
        moved = again(points, corrected, motions)
        if len(moved.frequencies) == wanted:
            model, points, found = corrected, moved, check(moved, ROUGH_TOLERANCE)
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
        found = check(points, ROUGH_TOLERANCE)
    if not anew or sum(len(part.frequencies) for part in settled) < wanted:
        return model
    motions = np.concatenate([_modal(part) for part in settled if len(part.frequencies)])
    return principal_span(condensation, motions, negligible, symmetry)


def _joined(structure: Structure, training: Training, model: ReducedModel, found: list[Correction]) -> ReducedModel:
    """Model whose basis has the shapes of the larger corrections ``found`` as well."""
    large = [f.shapes for f in found if f.energy > POINT_SHARE * training.tolerance]
    return with_shapes(model, np.column_stack(large), 0.2 * training.tolerance, structure.symmetry)


def _modal(points: Curve) -> FloatArray:
    """(p, R, r) motions in modes of the condensation."""
    return np.asarray(points.coefficients @ points.balance.model.vectors.T)
