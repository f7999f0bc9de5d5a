"""Curve of a training with its corrections: how accurate it is, whether it may be the result, and which is better."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic

import numpy as np

from wroll_fem.dynamics.periodic.response import HarmonicCurve
from wroll_fem.dynamics.training.correction import Correction
from wroll_fem.dynamics.training.training import Curve, Trained
from wroll_fem.errors import ConvergenceError

UNSURE, SURE_ROUNDS = 0.1, 5
"""Largest relative correction of the motions beyond the end of a backbone at which this end is accepted. If corrections
are larger, an insufficient basis may have caused it. From curve number `SURE_ROUNDS` on, any end is accepted."""

DOUBTFUL = 0.01
"""Largest error of a curve that is returned above the tolerance, with a warning. Above it the training fails."""

CLOSE = 0.1
"""Largest error of a curve for which a larger tolerance is worth a trial."""


@dataclass(frozen=True)
class CheckedCurve(Generic[Curve]):
    """Curve in one basis, with the corrections at its checked points.

    Attributes
    ----------
    number : number of the curve, from 1
    curve : the curve, or what there is of it
    stopped : error that ended the curve; None if it is complete
    coarse : whether it was computed with longer steps
    richer : the curve with as many harmonics as the motions of which the next basis is built
    points : the checked points of ``richer``
    found : index of a checked point -> its correction
    held : corrections that count, without those of motions beyond the end of a backbone
    beyond : largest correction of these motions
    partial : whether only its checked points and those used for the basis are solutions in the present basis
    """

    number: int
    curve: Curve
    stopped: ConvergenceError | None
    coarse: bool
    richer: Curve
    points: Curve
    found: dict[int, Correction]
    held: list[Correction]
    beyond: float
    partial: bool

    @property
    def error(self) -> float:
        """Largest correction that counts, relative to the motion."""
        return max(one.energy for one in self.held)

    @property
    def tip_error(self) -> float:
        """Largest relative change of the tip displacement by corrections that count."""
        return max(one.tip for one in self.held)

    @property
    def unsure(self) -> bool:
        """Whether an insufficient basis may have ended this backbone."""
        return self.beyond > UNSURE and self.number < SURE_ROUNDS

    @property
    def incomplete(self) -> bool:
        """Whether the curve leaves out a part of what was asked for: a gap, or the motions past an early end."""
        return self.curve.gap is not None if isinstance(self.curve, HarmonicCurve) else bool(self.curve.cut)

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """The smaller, the better; see `KeptCurve.rank`."""
        return self.coarse or self.unsure, self.incomplete, self.error

    @property
    def acceptable(self) -> bool:
        """Whether the curve is complete and accurate enough to be returned, with a warning above the tolerance."""
        return self.stopped is None and self.error <= DOUBTFUL

    @property
    def advice(self) -> str:
        """What to try if no basis reaches the tolerance: a larger one, or the frequency where every basis fails."""
        if self.error <= CLOSE:
            return "use a larger harmonic.reduction_tolerance"
        worst = next(k for k, correction in self.found.items() if correction.energy == self.error)
        hertz = self.curve.frequencies[worst] / (2.0 * np.pi)
        return (
            f"at {hertz:.4g} Hz the basis vectors miss {100 * self.error:.0f} % of the motion: use a smaller "
            "excitation (backbone.tip_largest for a backbone), leave this frequency out of the band, or compute a sweep"
        )

    def accepted(self) -> Trained[Curve]:
        """The curve, without what is beyond its end, as the result of the training."""
        return Trained(self.curve.without_beyond(), self.error, self.tip_error, self.number)
