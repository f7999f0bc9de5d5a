r"""Compliance of fixture and machine: given, or from the record of a rigid specimen.

.. math:: x = x_{measured} - c(F), \qquad c(F) = \sum_j c_j F^j
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.numerics.inference import Estimate, combined_freedom, linear_fit
from wroll_fem.typing import FloatArray

BEYOND = 0.02
"""Part of the force range of the rigid specimen by which a test may exceed it without a warning."""

CURVED = 3.5
"""Ratio of the next term of the polynomial to its error from which the rigid specimen is called curved."""


@dataclass(frozen=True, eq=False)
class Fixture:
    """Displacement of the fixture as a polynomial of the force.

    Attributes
    ----------
    coefficients
        (d,) c_1 to c_d, m/N^j.
    covariance
        (d, d) their covariance.
    freedom
        Degrees of freedom of the covariance.
    span
        Smallest and largest force of the rigid specimen, N.
    doubts
        Doubts, one sentence each.
    """

    coefficients: FloatArray
    covariance: FloatArray
    freedom: float = np.inf
    span: tuple[float, float] = (-np.inf, np.inf)
    doubts: tuple[str, ...] = ()

    @classmethod
    def given(cls, stiffness: float, error: float = 0.0) -> Fixture:
        """Fixture of a given stiffness, N/m, with its standard error.

        Raises
        ------
        InputError
            If the stiffness is not positive.
        """
        if not stiffness > 0.0:
            raise InputError(
                f"the stiffness is {stiffness:g} N/m", key="fixture_stiffness", remedy="give a number above 0"
            )
        return cls(np.array([1.0 / stiffness]), np.array([[(error / stiffness**2) ** 2]]))

    @classmethod
    def measured(cls, rigid: ShearRecord, *, degree: int = 1) -> Fixture:
        """Fixture from the record of a specimen without shear deformation, such as a solid block.

        Raises
        ------
        InputError
            If the displacement does not rise with the force.
        """
        low, high = float(rigid.force.min()), float(rigid.force.max())
        scale = max(abs(low), abs(high))
        s = rigid.force / scale
        time = (rigid.time - rigid.time[0]) / (rigid.time[-1] - rigid.time[0])
        names = [f"c{j}" for j in range(degree + 1)]
        monotone = bool(np.all(np.diff(rigid.smooth_force) > -rigid.smooth_noise))
        # noise of the force lowers the slope, unless time explains it
        instruments = {f"t{j}": time**j for j in range(degree + 1)} if monotone else None
        found = linear_fit({name: s**j for j, name in enumerate(names)}, rigid.displacement, instruments=instruments)
        if not found["c1"].value > 0.0:
            raise InputError(
                "the displacement of the rigid specimen does not rise with the force", file=rigid.source,
                remedy="check the columns and their signs",
            )  # fmt: skip
        doubts = []
        more = linear_fit({f"c{j}": s**j for j in range(degree + 2)}, rigid.displacement)[f"c{degree + 1}"]
        if abs(more.value) > CURVED * more.error:
            doubts.append(
                f"the rigid specimen departs from a polynomial of degree {degree} over {low:.3g} to {high:.3g} N by "
                f"{abs(more.value):.2g} m; raise rigid_degree"
            )
        factors = scale ** -np.arange(1.0, degree + 1.0)
        covariance = found.covariance[1:, 1:] * np.outer(factors, factors)
        return cls(found.x[1:] * factors, covariance, found.freedom, (low, high), tuple(doubts))

    def displacement(self, force: FloatArray) -> FloatArray:
        """(n,) displacement of the fixture at forces (n,), m."""
        powers = np.arange(1, len(self.coefficients) + 1)
        return np.asarray(force[:, None] ** powers @ self.coefficients)

    def corrected(self, record: ShearRecord) -> ShearRecord:
        """Record with the displacement of the specimen alone."""
        return replace(record, displacement=record.displacement - self.displacement(record.force))

    def removed(self, slope: Estimate, record: ShearRecord) -> Estimate:
        """Stiffness of the specimen alone, N/m, from that of specimen and fixture over the forces of a record.

        Raises
        ------
        InputError
            If the fixture alone is softer than the whole.
        """
        force = record.force
        size = len(self.coefficients)
        # slope of F^j over F in this window: the compliance is linear in the coefficients
        weights = np.array([np.polyfit(force, force**j, 1)[0] for j in range(1, size + 1)])
        own = float(weights @ self.coefficients)
        rest = 1.0 / slope.value - own
        if not rest > 0.0:
            raise InputError(
                f"the fixture alone ({1.0 / own:.4g} N/m) is not stiffer than specimen and fixture "
                f"({slope.value:.4g} N/m)", file=record.source, key="fixture_stiffness",
                remedy="check the unit of fixture_stiffness and the record of the rigid specimen",
            )  # fmt: skip
        variances = (slope.error / slope.value**2) ** 2, float(weights @ self.covariance @ weights)
        error = float(np.sqrt(sum(variances))) / rest**2
        return Estimate(1.0 / rest, error, combined_freedom(variances, (slope.freedom, self.freedom)))

    def exceeded(self, record: ShearRecord) -> str:
        """Warning if the forces of a record lie outside those of the rigid specimen; empty otherwise."""
        reach = BEYOND * (self.span[1] - self.span[0]) if np.isfinite(self.span[1]) else 0.0
        low, high = float(record.force.min()), float(record.force.max())
        if low >= self.span[0] - reach and high <= self.span[1] + reach:
            return ""
        return (
            f"{record.source}: forces of {low:.3g} to {high:.3g} N exceed those of the rigid specimen, "
            f"{self.span[0]:.3g} to {self.span[1]:.3g} N; its polynomial is extrapolated"
        )
