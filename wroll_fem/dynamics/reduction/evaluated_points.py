"""Contact points at which friction laws are evaluated: all points of a structure, or a weighted subset of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from wroll_fem.contact.kernels import Reference
from wroll_fem.contact.laws import PointLaws
from wroll_fem.contact.point import dofs_of, per_dof
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.typing import FloatArray, IntArray


class PointSample(NamedTuple):
    """Weighted subset of the contact points (`point_sample`).

    Attributes
    ----------
    points : (a,) indices of the points of the subset among those that it stands for
    factors : (a,) factors on their areas, positive
    """

    points: IntArray
    factors: FloatArray


@dataclass(frozen=True)
class EvaluatedPoints:
    """Laws and preload state of the n evaluated points among all contact points.

    Attributes
    ----------
    laws : friction and normal laws; the areas contain the weights
    dofs : (3 n,) indices among the contact degrees of freedom of all points
    weights : (3 n,) area per contact degree of freedom, m^2
    reference : preload state and reference contact stiffness
    """

    laws: PointLaws
    dofs: IntArray
    weights: FloatArray
    reference: Reference

    @classmethod
    def of(
        cls, laws: PointLaws, preload: ContactState, springs: FloatArray, sample: PointSample | None = None
    ) -> EvaluatedPoints:
        """All points, or those of a ``sample``; ``springs`` (3 n_points,), Pa/m, is the reference contact stiffness."""
        points, factors = (np.arange(laws.n), np.ones(laws.n)) if sample is None else sample
        dofs = dofs_of(points, laws.n)
        taken = laws.take(points)._replace(area=laws.area[points] * factors)
        slip = preload.elastic_slip[dofs[: 2 * len(points)]]
        reference = Reference(preload.jump[dofs], slip, preload.traction[dofs], springs[dofs])
        return cls(taken, dofs, per_dof(taken.area, taken.area), reference)

    def take(self, points: IntArray) -> EvaluatedPoints:
        """Some of these points, with the given indices among them."""
        here = dofs_of(points, self.n)
        jump, slip, traction, springs = self.reference
        reference = Reference(jump[here], slip[here[: 2 * len(points)]], traction[here], springs[here])
        return EvaluatedPoints(self.laws.take(points), self.dofs[here], self.weights[here], reference)

    @property
    def n(self) -> int:
        """Number of evaluated points."""
        return self.laws.n
