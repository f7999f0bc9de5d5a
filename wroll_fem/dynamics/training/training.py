r"""Training of a basis for periodic motions: it is enriched by corrections of these motions from the full model.

A first curve is computed in a small basis with large steps and few harmonics. At some of its points the harmonic
balance of the full model, with all modes, is evaluated (`correction`). The principal shapes of the corrected
motions form the next basis (`basis`); motions of a response curve are corrected until they are those of the full model
(`full_motions`). Where they do not converge, they are recomputed and shapes are added until the corrections at these
points are small. The curve is computed in this basis and checked at other points; the remaining corrections are
the error estimate. While it is too large, the shapes of these corrections are added, and the points of the curve are
recomputed in the larger basis.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.point_sample import Motions, SampleError
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training.basis import SMALL
from wroll_fem.dynamics.training.correction import KRYLOV_TOLERANCE, ROUGH_TOLERANCE, Correction
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.dynamics.training.training_state import TrainingFile, TrainingState
from wroll_fem.typing import FloatArray

Curve = TypeVar("Curve", HarmonicCurve, BackboneCurve)

COARSE = 2.5
"""Factor on the step lengths of the curve in the first, inaccurate basis."""

FIRST_HARMONICS, TRAINING_HARMONICS = 3, 5
"""Limits of the number of harmonics: in the first curve, and in the motions of which the next basis is built."""

MOST_TRAINED = 25
"""Largest number of evenly spaced points of a curve, used in addition to the checked points to enrich the basis.
Response curves need fewer (`Training.most`) as long as their errors fall fast."""


class Task(Protocol[Curve]):
    """Response curve or backbone that is trained: how it is followed, checked, moved and cut in a reduced model."""

    def solve(self, model: ReducedModel, factor: float) -> Curve:
        """Curve in a reduced model, with steps longer by a factor.

        Raises
        ------
        ConvergenceError
            If it cannot be followed; ``partial`` holds the points so far.
        """
        ...

    def chosen(self, curve: Curve) -> list[int]:
        """Indices of the points of a curve that are checked."""
        ...

    def check(self, points: Curve, residual: float = KRYLOV_TOLERANCE) -> list[Correction]:
        """Corrections of the motions at points of a curve, from the equations of the full model; one per point.

        ``residual`` is the relative residual to which the linear equations of the corrections are solved.
        """
        ...

    def again(
        self, points: Curve, model: ReducedModel, starts: FloatArray | None = None, only: Container[int] | None = None
    ) -> Curve:
        """Curve with those of its points that converge in another model.

        ``starts`` (p, R, m) are first guesses in the other model; by default they are the motions of the points. With
        given ones the motions only serve the basis, and are less accurate. With ``only``, the other points follow
        without being solutions.
        """
        ...

    def full_motions(self, points: Curve, found: list[Correction], training: Training) -> Motions | None:
        """Motions of the full model, in all modes, near the points of a curve, whose corrections are ``found``.

        None if most of them, or those of such a curve, are not found.
        """
        ...

    def shortened(self, curve: Curve, points: Curve, good: list[bool]) -> Curve | None:
        """Accurate part of a curve, from its checked points and whether each is accurate; None if there is none."""
        ...

    def restored(self, model: ReducedModel, arrays: dict[str, np.ndarray]) -> Curve:
        """Curve of a checkpoint in a reduced model, from its arrays."""
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
    sample : errors of the subset of contact points on which the last curve was followed; None if on all points
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
    most : largest number of evenly spaced points whose corrections do so; `MOST_TRAINED` where errors fall slowly
    most_vectors : number of basis vectors above which no further curve is computed
    """

    tolerance: float = 1e-3
    max_rounds: int = 8
    on_round: Callable[[int, ReducedModel, float], None] | None = None
    file: TrainingFile | None = None
    snapshots: Callable[[], FloatArray | None] | None = None
    rough: float = ROUGH_TOLERANCE
    most: int = MOST_TRAINED
    most_vectors: float = np.inf

    def start(self, structure: Structure) -> TrainingState:
        """State before the first curve, or that of the checkpoint."""
        modes = structure.condensation.eigenvalues
        state = None if self.file is None else self.file.start(modes)
        if state is not None:
            return state
        model = structure.with_harmonics(TRAINING_HARMONICS).first_model()
        factor = 1.0 if len(modes) <= SMALL else COARSE
        return TrainingState(1, model.vectors, model.eigenvalues, factor, False, np.inf, (), None, None, False, None)
