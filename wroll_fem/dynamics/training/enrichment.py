r"""Response curves and backbones in bases that are trained on these curves themselves (`training`)."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, replace

import numpy as np

from wroll_fem.contact.laws import PointLaws
from wroll_fem.dynamics.aft.harmonic_contact import MAX_PERIODS, HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.backbone import BACKBONE_STEPS, BackboneCurve, backbone_curve
from wroll_fem.dynamics.periodic.causes import end_of_backbone
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance
from wroll_fem.dynamics.periodic.point_sample import Motions
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.reduction.condensation import Condensation
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.training.correction import KRYLOV_TOLERANCE, Correction, corrections
from wroll_fem.dynamics.training.course import trained
from wroll_fem.dynamics.training.full_motions import full_motions
from wroll_fem.dynamics.training.point_sampling import PointSampling
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.dynamics.training.training import FIRST_HARMONICS, Curve, Trained, Training
from wroll_fem.dynamics.training.training_state import TrainingFile, curve_of
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.continuation import ROUGH, StepControl
from wroll_fem.typing import FloatArray

FEWEST_POINTS = 5
"""Smallest accepted number of points of a backbone that ends below the requested largest amplitude."""

RESPONSE_TRAINED = 10
"""Largest number of evenly spaced points of a response curve whose motions, in addition to those of the checked points,
serve the basis. The second basis has motions of the full model there, and the means between them are corrected too."""

BACKBONE_POINTS = 15
"""Number of points of a backbone at which the full model is evaluated to check the basis."""


def checked_points(curve: HarmonicCurve) -> list[int]:
    """Indices of the points of a curve at which the basis is checked: both ends, the peak, and points on its flanks."""
    size = np.abs(curve.transmissibility)
    peak = int(size.argmax())
    points = {0, peak, len(size) - 1}
    for level in (0.85, 0.6, 0.35):
        points.add(int(np.argmin(np.abs(size[: peak + 1] - level * size[peak]))))
        points.add(peak + int(np.argmin(np.abs(size[peak:] - level * size[peak]))))
    return sorted(points)


def checked_motions(curve: BackboneCurve) -> list[int]:
    """Indices of the points of a backbone at which the basis is checked: evenly spaced, and the last one."""
    last = len(curve.frequencies) - 1
    points = {int(k) for k in np.linspace(0, last - curve.beyond, BACKBONE_POINTS)}
    return sorted(points | {last})


@dataclass(frozen=True)
class _CurveTask:
    """What a response curve and a backbone that are trained have in common; see `Task`."""

    structure: Structure
    harmonics: int
    steps: StepControl
    subsets: PointSampling
    on_point: Callable[[float, int], None] | None

    def _level(self, factor: float) -> Structure:
        """Structure with the harmonics of a curve whose steps are longer by a factor."""
        return self.structure.with_harmonics(FIRST_HARMONICS if factor > 1.0 else self.harmonics)

    def again(
        self, points: Curve, model: ReducedModel, starts: FloatArray | None = None, only: Container[int] | None = None
    ) -> Curve:
        """Points of a curve in another model; see `Task`."""
        level = self.structure.with_harmonics(points.balance.contact.sampling.harmonics)
        steps = self.steps if starts is None else replace(self.steps, tolerance=ROUGH * self.steps.tolerance)
        return self.subsets.moved(points, level, model, steps, starts, only)


@dataclass(frozen=True)
class _ResponseTask(_CurveTask):
    """Response curve that is trained; see `Task`."""

    amplitude: float
    frequencies: tuple[float, float]

    def solve(self, model: ReducedModel, factor: float) -> HarmonicCurve:
        """Curve in a reduced model, with steps longer by a factor."""
        return self.subsets.curve(self._level(factor), model, self._followed, factor, self.steps, checked_points)

    def _followed(self, contact: HarmonicContact, factor: float) -> HarmonicCurve:
        control = replace(self.steps.longer(factor), keeps=factor == 1.0 and not contact.complete)
        return response_curve(
            contact, amplitude=self.amplitude, frequencies=self.frequencies, control=control, on_point=self.on_point
        )

    def chosen(self, curve: HarmonicCurve) -> list[int]:
        """Indices of the points that are checked."""
        return checked_points(curve)

    def check(self, points: HarmonicCurve, residual: float = KRYLOV_TOLERANCE) -> list[Correction]:
        """Corrections of the motions at points of a curve."""
        self.subsets.seen(points)
        along = [points.direction(k)[None] for k in range(len(points.frequencies))]
        return corrections(points.balance, points.coefficients, points.frequencies, along, tolerance=residual)

    def full_motions(self, points: HarmonicCurve, found: list[Correction], training: Training) -> Motions | None:
        """Motions of the full model near the points of a curve; see `Task`."""
        motions = full_motions(points, found, training.rough)
        if motions is not None:
            self.subsets.prepared(motions)
        return motions

    def shortened(self, curve: HarmonicCurve, points: HarmonicCurve, good: list[bool]) -> HarmonicCurve | None:
        """Curve with a wider gap, if all its inaccurate points lie around the gap."""
        if curve.gap is None:
            return None
        below = [w for w, kept in zip(points.frequencies, good, strict=True) if kept and w <= curve.gap[0]]
        above = [w for w, kept in zip(points.frequencies, good, strict=True) if kept and w >= curve.gap[1]]
        bad = [w for w, kept in zip(points.frequencies, good, strict=True) if not kept]
        if not below or not above or any(w < max(below) or w > min(above) for w in bad):
            return None
        return curve.with_gap(max(below), min(above))

    def restored(self, model: ReducedModel, arrays: dict[str, np.ndarray]) -> HarmonicCurve:
        """Curve of a checkpoint."""
        found = curve_of(HarmonicBalance(self.structure.contact(model), self.amplitude), arrays)
        assert isinstance(found, HarmonicCurve)
        return found


@dataclass(frozen=True)
class _BackboneTask(_CurveTask):
    """Backbone that is trained; see `Task`."""

    tip_amplitudes: tuple[float, float]

    def solve(self, model: ReducedModel, factor: float) -> BackboneCurve:
        """Backbone in a reduced model, with steps longer by a factor; up to its end, if it ends early."""
        try:
            return self.subsets.curve(self._level(factor), model, self._followed, factor, self.steps, checked_motions)
        except ConvergenceError as stop:
            part = stop.partial
            if factor > 1.0 or not isinstance(part, BackboneCurve) or not len(part.frequencies):
                raise
            part = part.cut_off(end_of_backbone(part))
            if len(part.frequencies) - part.beyond < FEWEST_POINTS:
                raise
            return part

    def _followed(self, contact: HarmonicContact, factor: float) -> BackboneCurve:
        control = self.steps.longer(factor)
        return backbone_curve(contact, tip_amplitudes=self.tip_amplitudes, control=control, on_point=self.on_point)

    def chosen(self, curve: BackboneCurve) -> list[int]:
        """Indices of the points that are checked."""
        return checked_motions(curve)

    def check(self, points: BackboneCurve, residual: float = KRYLOV_TOLERANCE) -> list[Correction]:
        """Corrections of the motions at points of a backbone."""
        self.subsets.seen(points)
        along = [_free_of(points, k) for k in range(len(points.frequencies))]
        return corrections(
            points.balance, points.coefficients, points.frequencies, along, points.damping, tolerance=residual
        )

    def full_motions(self, points: BackboneCurve, found: list[Correction], training: Training) -> None:
        """None: not the frequency alone, but the damping of a nonlinear mode too changes with its shape."""
        return

    def shortened(self, curve: BackboneCurve, points: BackboneCurve, good: list[bool]) -> BackboneCurve | None:
        """Backbone up to the first inaccurate motion, if all later ones are inaccurate."""
        count = good.index(False) if False in good else len(good)
        part = curve.take(list(range(len(curve.frequencies) - curve.beyond)))
        part = part.up_to(float(points.places[:count].max(initial=-1.0)), end_of_backbone(points))
        return part if len(part.frequencies) >= FEWEST_POINTS and not any(good[count:]) else None

    def restored(self, model: ReducedModel, arrays: dict[str, np.ndarray]) -> BackboneCurve:
        """Backbone of a checkpoint."""
        found = curve_of(HarmonicBalance(self.structure.contact(model), 0.0), arrays)
        assert isinstance(found, BackboneCurve)
        return found


def _free_of(curve: BackboneCurve, k: int) -> FloatArray:
    """(3, R, m) directions that no correction has: along the backbone, of the amplitude and of the phase."""
    q = curve.coefficients[k]
    size = np.linalg.norm(q)
    return np.array([curve.direction(k), q / size, curve.balance.velocity(q, 1.0) / size])


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
    on_point: Callable[[float, int], None] | None = None,
    file: TrainingFile | None = None,
    hyper_reduction: bool = False,
    most_vectors: float = np.inf,
    snapshots: Callable[[], FloatArray | None] | None = None,
) -> Trained[HarmonicCurve]:
    """Response curve of the full model, accurate to ``tolerance`` in the energy norm; see `response_curve`.

    Parameters
    ----------
    tolerance
        Largest correction at the checked points, relative to the motion, both in the energy norm. The relative
        correction of the tip motion is smaller.
    on_round
        Called with the number of the curve, its model and its error.
    on_point
        Called at every point of a curve, with its frequency in Hz and the number of points so far.
    file
        Checkpoint of the training.
    hyper_reduction
        Whether curves are followed on a weighted subset of the contact points (`PointSampling`).
    most_vectors
        Number of basis vectors above which no further curve is computed.
    snapshots
        Function that returns motions (r, k) in time, in modal coordinates, or None; used if interfaces open widely.

    Raises
    ------
    ConvergenceError
        If the curve cannot be followed in an accurate basis, or no basis reaches the tolerance and none has a
        curve with an error of at most 1 %. ``partial`` holds the last curve.
    """
    structure = Structure.of(condensation, preload, laws, Sampling(harmonics, samples), max_periods)
    steps, subsets = control or StepControl(), PointSampling(wanted=hyper_reduction)
    task = _ResponseTask(structure, harmonics, steps, subsets, on_point, amplitude, frequencies)
    training = subsets.quicker(
        Training(tolerance, max_rounds, on_round, file, snapshots, most=RESPONSE_TRAINED, most_vectors=most_vectors)
    )
    found = trained(structure, training, task)
    return replace(found, curve=subsets.with_reading_points(found.curve, structure, steps), sample=subsets.error)


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
    on_point: Callable[[float, int], None] | None = None,
    file: TrainingFile | None = None,
    hyper_reduction: bool = False,
) -> Trained[BackboneCurve]:
    """Backbone of the full model; see `solve_backbone`. Other arguments and errors as for `trained_response`.

    ``on_point`` is called with the share of the range of amplitudes and the number of points so far.
    """
    structure = Structure.of(condensation, preload, laws, Sampling(harmonics, samples), max_periods)
    steps, subsets = control or BACKBONE_STEPS, PointSampling(wanted=hyper_reduction)
    task = _BackboneTask(structure, harmonics, steps, subsets, on_point, tip_amplitudes)
    training = subsets.quicker(Training(tolerance, max_rounds, on_round, file))
    return replace(trained(structure, training, task), sample=subsets.error)
