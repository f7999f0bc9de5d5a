"""Reduced model and subset of the contact points for time histories, from the motions of a response curve."""

from __future__ import annotations

from typing import NamedTuple

from wroll_fem.dynamics.reduction.evaluated_points import PointSample
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel


class TrainedSubset(NamedTuple):
    """Result of a training.

    Attributes
    ----------
    model : reduced model of the whole structure
    sample : weighted subset of its contact points
    largest : squared energy norm of the largest motion of the training, J; 0 if it is not known
    """

    model: ReducedModel
    sample: PointSample
    largest: float = 0.0
