"""Hyper-reduction of the curves of a training: followed on a weighted subset of the contact points, then completed.

The subset (`point_sample`) is chosen for the latest motions whose corrections were computed. Before the first of them,
motions imposed in the main mode take their place. The points of a followed curve are then solved for once more with the
forces of all contact points; Newton's matrix still comes from the subset. The result has no error of the subset. What
does not converge is repeated with all points.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import replace
from typing import TypeVar

from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.periodic.backbone import BackboneCurve
from wroll_fem.dynamics.periodic.point_sample import Motions, SampleError, sample_error, sampled
from wroll_fem.dynamics.periodic.reading_points import with_reading_points
from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.reduction.evaluated_points import PointSample
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.training.basis import imposed_motions
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.dynamics.training.training import COARSE, Training
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.continuation import StepControl
from wroll_fem.typing import FloatArray

Curve = TypeVar("Curve", HarmonicCurve, BackboneCurve)

FEWEST = 40
"""Number of evaluated contact points below which no subset is sought."""

COMPLETED = 1e-6
"""Largest Newton correction, in scaled unknowns, after which a motion counts as completed. Its error
is that of Newton's matrix, some tenths. The work of a cycle is then balanced to 1e-6."""

PATIENCE, RENEWAL = 3, 0.6
"""Factor on the largest number of iterations of such a correction, as Newton's matrix is approximate, and ratio of
successive residuals above which it factorises a new one. A new one is as approximate as the old one."""

SUBSET_ROUGH, SUBSET_TRAINED = 1e-2, 2
"""Relative residual of the corrections that enrich the basis, and largest number of points whose corrections do so in
addition to the checked ones: both ends of the curve, which are among these. Corrections would take half of the time
otherwise."""

MOST_MOTIONS = 12
"""Largest number of motions for which a subset is chosen; evenly spaced ones of more."""


class PointSampling:
    """Subsets of the contact points for the curves of a training.

    Parameters
    ----------
    wanted
        Whether subsets are used; without them every curve has all points.

    Attributes
    ----------
    error : errors of the subset on the last curve; None if this curve was followed with all points
    motions : motions for which the next subset is chosen; None before the first corrections
    last_subset : the last subset from which Newton's matrix came; None before it
    """

    def __init__(self, *, wanted: bool):
        self.wanted = wanted
        self.error: SampleError | None = None
        self.motions: Motions | None = None
        self.last_subset: PointSample | None = None
        self._renew = True
        self._latest: PointSample | None = None

    def quicker(self, training: Training) -> Training:
        """Settings of a training with fewer and less accurate corrections for its basis, if subsets are used."""
        return replace(training, rough=SUBSET_ROUGH, most=SUBSET_TRAINED) if self.wanted else training

    def seen(self, points: HarmonicCurve | BackboneCurve) -> None:
        """Take note of motions whose corrections are computed; the largest set since the last curve counts."""
        if not self.wanted or not len(points.frequencies):
            return
        if self._renew or self.motions is None or len(points.frequencies) >= len(self.motions.frequencies):
            self.motions, self._renew, self._latest = _some(points), False, None

    def prepared(self, motions: Motions) -> None:
        """Take note of the motions of which the basis of the next curve is made."""
        if self.wanted:
            self.motions, self._renew, self._latest = motions.some(MOST_MOTIONS), False, None

    def moved(
        self, points: Curve, level: Structure, model: ReducedModel, control: StepControl, starts: FloatArray | None,
        only: Container[int] | None,
    ) -> Curve:  # fmt: skip
        """Points of a curve, recomputed in another model with the forces of all contact points; see ``moved_to``."""
        whole = level.contact(model)
        if self.wanted and self.motions is not None and whole.n >= FEWEST:
            if self._latest is None:
                self._latest = sampled(whole, self.motions)
            self.last_subset = self._latest
            return points.moved_to(level.contact(model, tangent=self._latest), control, starts, only, exact=whole)
        return points.moved_to(whole, control, starts, only)

    def curve(
        self, level: Structure, model: ReducedModel, follow: Callable[[HarmonicContact, float], Curve], factor: float,
        control: StepControl, chosen: Callable[[Curve], list[int]],
    ) -> Curve:  # fmt: skip
        """Curve of a reduced model with the forces of all contact points; a rough one with those of a subset.

        Parameters
        ----------
        level
            Structure with the harmonics of the curve.
        follow
            Follows the curve of a contact, with steps longer by a factor.
        factor
            Factor on the lengths of the steps; above 1, the curve is rough.
        chosen
            Indices of the points of a curve at which the errors of the subset are found.

        Raises
        ------
        ConvergenceError
            If the curve cannot be followed with all points.
        """
        whole, self.error = level.contact(model), None
        sample = self._before(level, whole, follow, rough=factor > 1.0)
        part = None if sample is None else _followed(level.contact(model, sample=sample), follow, factor)
        self._renew = True
        if sample is None or part is None:
            return follow(whole, factor)
        if factor > 1.0:
            return part.extended(whole)
        self.last_subset = sample
        loose = replace(control, tolerance=COMPLETED, max_iterations=PATIENCE * control.max_iterations, renewal=RENEWAL)
        done = part.moved_to(level.contact(model, tangent=sample), loose, part.coefficients, exact=whole)
        if len(done.frequencies) < len(part.frequencies):
            return follow(whole, factor)
        at = chosen(done)
        self.error = sample_error(
            whole, sample, part.coefficients[at], part.frequencies[at], done.coefficients[at], done.frequencies[at]
        )
        return done

    def with_reading_points(self, curve: HarmonicCurve, level: Structure, control: StepControl) -> HarmonicCurve:
        """Curve with points for its readings (`with_reading_points`), by Newton's matrix of the last subset."""
        level, quick = level.with_harmonics(curve.balance.contact.sampling.harmonics), None
        if self.last_subset is not None:
            quick = level.contact(curve.balance.model, tangent=self.last_subset)
        return with_reading_points(curve, control, quick)

    def _before(
        self, level: Structure, whole: HarmonicContact, follow: Callable[[HarmonicContact, float], Curve], *,
        rough: bool,
    ) -> PointSample | None:  # fmt: skip
        """Subset for a curve; before the first corrections from imposed motions, and then from a rough curve."""
        if not self.wanted or whole.n < FEWEST:
            return None
        if self.motions is not None:
            return sampled(whole, self.motions)
        first = sampled(whole, imposed_motions(whole))
        if first is None or rough:
            return first
        curve = _followed(level.contact(whole.model, sample=first), follow, COARSE)
        return first if curve is None else sampled(whole, _some(curve))


def _followed(
    contact: HarmonicContact, follow: Callable[[HarmonicContact, float], Curve], factor: float
) -> Curve | None:
    """Curve on a subset of the points; None if it does not converge, or has a gap, a skipped part or an early end."""
    try:
        found = follow(contact, factor)
    except ConvergenceError:
        return None
    if isinstance(found, HarmonicCurve) and (found.gap is not None or found.skipped):
        return None
    return found


def _some(points: HarmonicCurve | BackboneCurve) -> Motions:
    return Motions(points.coefficients, points.frequencies, points.balance.model.vectors).some(MOST_MOTIONS)
