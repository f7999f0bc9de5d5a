r"""Basis of a reduced model by harmonic balance itself: adds what the balance of the whole structure finds missing.

A curve is computed in a small basis with large steps. At a few of its points the balance of the *whole* structure is
evaluated (`correction`); the principal shapes of the corrections join the basis (`basis`), and the motions at these
points are computed again, until the corrections are small. Then the curve is computed in this basis, and checked at
points of its own; what is left is the error estimate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.periodic.aft import MAX_PERIODS, HarmonicContact, Sampling
from wroll_fem.dynamics.periodic.backbone import BACKBONE_STEPS, BackboneCurve, backbone_curve
from wroll_fem.dynamics.periodic.basis import COMPRESSION, SMALL, first_model, principal_span, with_shapes
from wroll_fem.dynamics.periodic.causes import end_of_backbone
from wroll_fem.dynamics.periodic.correction import Correction, correction
from wroll_fem.dynamics.periodic.half_period import HalfPeriod
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.continuation import StepControl
from wroll_fem.typing import FloatArray

Curve = TypeVar("Curve", HarmonicCurve, BackboneCurve)

COARSE = 2.5
"""Factor on the steps of the curves in bases that are not good yet."""

POINT_ROUNDS, POINT_SHARE = 4, 0.5
"""Enrichments at the points of one curve, and the share of the tolerance at which they end."""

TRAINING_HARMONICS = 5
"""Most harmonics of the curves in bases that are not good yet."""

HOPELESS, HOPELESS_ROUNDS = 3.0, 3
"""Correction that ends the training after so many curves: linearised, corrections that large do not converge."""

LARGEST_BASIS = 250
"""Vectors of a basis beyond which a curve takes minutes."""

CUT_ROUNDS, CUT_ERROR = 3, 100.0
"""Curves after which the points that the basis still misses, by this multiple of the tolerance, are cut off."""

UNSURE, SURE_ROUNDS = 0.1, 5
"""Error of the motion beyond the end of a backbone above which this end may be one of the basis, and the number of
curves after which it is taken as it is."""

FEWEST_POINTS = 5
"""Points of a backbone that ends early."""

DOUBTFUL = 0.01
"""Error up to which a curve whose basis grows no further is returned, for the analysis to warn; above, it fails."""

BACKBONE_POINTS = 15
"""Points of a backbone that are compared with the whole structure."""


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


def checked_points(curve: HarmonicCurve) -> list[int]:
    """Points of a curve to compare with the whole structure: both ends, the peak, and its flanks."""
    size = np.abs(curve.transmissibility)
    peak = int(size.argmax())
    points = {0, peak, len(size) - 1}
    for level in (0.85, 0.6, 0.35):
        points.add(int(np.argmin(np.abs(size[: peak + 1] - level * size[peak]))))
        points.add(peak + int(np.argmin(np.abs(size[peak:] - level * size[peak]))))
    return sorted(points)


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

    @property
    def coarse(self) -> Structure:
        """The same with no more than `TRAINING_HARMONICS`."""
        s = self.sampling
        if s.harmonics <= TRAINING_HARMONICS:
            return self
        return replace(self, sampling=Sampling(TRAINING_HARMONICS, s.samples, odd=s.odd))

    def like(self, contact: HarmonicContact) -> Structure:
        """Itself or `coarse`: the one with the harmonics of ``contact``."""
        return self if contact.sampling.harmonics == self.sampling.harmonics else self.coarse

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


def _trained(
    structure: Structure,
    training: Training,
    solve: Callable[[ReducedModel, float], Curve],
    chosen: Callable[[Curve], Curve],
    check: Callable[[Curve], list[Correction]],
    again: Callable[[Curve, ReducedModel], Curve],
    shortened: Callable[[Curve, Curve, list[bool]], Curve | None],
) -> Trained[Curve]:
    """Curves in bases that grow until the corrections are below the tolerance.

    Parameters
    ----------
    solve : curve in a model, with steps longer by a factor
    chosen : a few points of a curve
    check : corrections of the whole structure at points
    again : the same points computed in another model; points that do not converge are left out
    shortened : the part of a curve between its good points, from the curve, its points, and which are good; or None
    """
    symmetry, tolerance = structure.symmetry, training.tolerance
    model = structure.coarse.first_model()
    small = len(structure.condensation.eigenvalues) <= SMALL
    factor = 1.0 if small else COARSE
    compress, stuck = not small, False
    for number in range(1, training.max_rounds + 1):
        stopped: ConvergenceError | None = None
        try:
            curve = solve(model, factor)
        except ConvergenceError as stop:
            if len(getattr(stop.partial, "frequencies", ())) < 3:
                raise
            curve, stopped = stop.partial, stop
        points = chosen(curve)
        wanted, found = len(points.frequencies), check(points)
        held = found[: wanted - points.beyond]
        error = max(f.energy for f in held)
        unsure = max((f.energy for f in found[len(held) :]), default=0.0) > UNSURE and number < SURE_ROUNDS
        if training.on_round is not None:
            training.on_round(number, model, error)
        hopeless = (number >= HOPELESS_ROUNDS and error > HOPELESS) or model.size > LARGEST_BASIS
        late = number >= CUT_ROUNDS and error > CUT_ERROR * tolerance
        if error > tolerance and (hopeless or late or stuck or number == training.max_rounds):
            good = [f.energy <= tolerance for f in held]
            part = shortened(curve, points, good)
            if part is not None and factor == 1.0:
                held = [f for f, kept in zip(held, good, strict=True) if kept]
                return Trained(part, max(f.energy for f in held), max(f.tip for f in held), number)
        if hopeless or stuck:
            break
        if error <= tolerance and (factor == 1.0 or stopped is not None) and not unsure:
            if stopped is not None:
                raise stopped
            return Trained(curve.without_beyond(), error, max(f.tip for f in held), number)
        size, coarse = model.size, factor > 1.0
        for _ in range(POINT_ROUNDS):
            if max(f.energy for f in found) <= POINT_SHARE * tolerance:
                break
            model = with_shapes(model, np.column_stack([f.shapes for f in found]), 0.2 * tolerance, symmetry)
            points = again(points, model)
            if not len(points.frequencies):
                break
            found = check(points)
        if compress and factor > 1.0 and len(points.frequencies) == wanted:
            model = principal_span(model, points.coefficients, COMPRESSION * tolerance, symmetry)
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


def trained_response(
    condensation: Condensation,
    preload: ContactState,
    laws: PointLaws,
    *,
    amplitude: float,
    frequencies: tuple[float, float],
    harmonics: int = 3,
    samples: int = 64,
    max_periods: int = MAX_PERIODS,
    tolerance: float = 1e-3,
    max_rounds: int = 8,
    control: StepControl | None = None,
    on_round: Callable[[int, ReducedModel, float], None] | None = None,
) -> Trained[HarmonicCurve]:
    """Response curve (`harmonic_balance.solve_response`) of the whole structure to ``tolerance`` in the energy norm.

    Parameters
    ----------
    tolerance
        Largest correction at the checked points, relative to the motion in the energy norm; the tip's is smaller.
    on_round
        Called with the number of the curve, its model and its error.

    Raises
    ------
    ConvergenceError
        When the curve cannot be followed in a good basis, or the basis does not become good; ``partial`` holds the
        last curve.
    """
    structure = Structure.of(condensation, preload, laws, Sampling(harmonics, samples), max_periods)
    steps = control or StepControl()

    def solve(model: ReducedModel, factor: float) -> HarmonicCurve:
        return response_curve(
            (structure.coarse if factor > 1.0 else structure).contact(model), amplitude=amplitude,
            frequencies=frequencies, control=steps.longer(factor),
        )  # fmt: skip

    def check(points: HarmonicCurve) -> list[Correction]:
        return [
            correction(points.balance, q, w, points.direction(k)[None])
            for k, (q, w) in enumerate(zip(points.coefficients, points.frequencies, strict=True))
        ]

    def again(points: HarmonicCurve, model: ReducedModel) -> HarmonicCurve:
        return points.moved_to(structure.like(points.balance.contact).contact(model), steps)

    def chosen(curve: HarmonicCurve) -> HarmonicCurve:
        return curve.take(checked_points(curve))

    def shortened(curve: HarmonicCurve, points: HarmonicCurve, good: list[bool]) -> HarmonicCurve | None:
        if curve.gap is None:
            return None
        below = [w for w, kept in zip(points.frequencies, good, strict=True) if kept and w <= curve.gap[0]]
        above = [w for w, kept in zip(points.frequencies, good, strict=True) if kept and w >= curve.gap[1]]
        bad = [w for w, kept in zip(points.frequencies, good, strict=True) if not kept]
        if not below or not above or any(w < max(below) or w > min(above) for w in bad):
            return None
        return curve.with_gap(max(below), min(above))

    training = Training(tolerance, max_rounds, on_round)
    return _trained(structure, training, solve, chosen, check, again, shortened)


def trained_backbone(
    condensation: Condensation,
    preload: ContactState,
    laws: PointLaws,
    *,
    tip_amplitudes: tuple[float, float],
    harmonics: int = 3,
    samples: int = 64,
    max_periods: int = MAX_PERIODS,
    tolerance: float = 1e-3,
    max_rounds: int = 8,
    control: StepControl | None = None,
    on_round: Callable[[int, ReducedModel, float], None] | None = None,
) -> Trained[BackboneCurve]:
    """Backbone (see `backbone.solve_backbone`) of the whole structure; arguments and errors as `trained_response`."""
    structure = Structure.of(condensation, preload, laws, Sampling(harmonics, samples), max_periods)
    steps = control or BACKBONE_STEPS

    def solve(model: ReducedModel, factor: float) -> BackboneCurve:
        contact = (structure.coarse if factor > 1.0 else structure).contact(model)
        try:
            return backbone_curve(contact, tip_amplitudes=tip_amplitudes, control=steps.longer(factor))
        except ConvergenceError as stop:
            part = stop.partial
            if factor > 1.0 or not isinstance(part, BackboneCurve) or not len(part.frequencies):
                raise
            part = part.cut_off(end_of_backbone(part))
            if len(part.frequencies) - part.beyond < FEWEST_POINTS:
                raise
            return part

    def shortened(curve: BackboneCurve, points: BackboneCurve, good: list[bool]) -> BackboneCurve | None:
        count = good.index(False) if False in good else len(good)
        part = curve.take(np.arange(len(curve.frequencies) - curve.beyond))
        part = part.up_to(float(points.places[:count].max(initial=-1.0)), end_of_backbone(points))
        return part if len(part.frequencies) >= FEWEST_POINTS and not any(good[count:]) else None

    def free_of(curve: BackboneCurve, k: int) -> FloatArray:
        q = curve.coefficients[k]
        size = np.linalg.norm(q)
        return np.array([curve.direction(k), q / size, curve.balance.velocity(q, 1.0) / size])

    def check(points: BackboneCurve) -> list[Correction]:
        return [
            correction(points.balance, q, w, free_of(points, k), points.damping[k])
            for k, (q, w) in enumerate(zip(points.coefficients, points.frequencies, strict=True))
        ]

    def again(points: BackboneCurve, model: ReducedModel) -> BackboneCurve:
        return points.moved_to(structure.like(points.balance.contact).contact(model), steps)

    def chosen(curve: BackboneCurve) -> BackboneCurve:
        last = len(curve.frequencies) - 1
        points = np.unique(np.linspace(0, last - curve.beyond, BACKBONE_POINTS).astype(int))
        if curve.beyond:
            points = np.append(points, last)
        return replace(curve.take(points), beyond=min(curve.beyond, 1))

    training = Training(tolerance, max_rounds, on_round)
    return _trained(structure, training, solve, chosen, check, again, shortened)
