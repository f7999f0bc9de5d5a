"""Joints without loss: nonlinear springs and elastic stops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.polynomial_spring import PolynomialSpring
from wroll_fem.dynamics.joints.joint import Joint, Points, check_positive, row_of
from wroll_fem.errors import InputError

STOP_SCALE = 1e-2
"""Length to which Newton's tolerance refers at a stop, relative to its gap."""

FAR = 10.0
"""A nonlinear spring without a length: displacement at which the nonlinear part of its force equals the linear one,
divided by its length."""


@dataclass(frozen=True, kw_only=True)
class Spring(Joint):
    """Spring whose force is a polynomial of the relative displacement g: k_1 g + k_2 g^2 + k_3 g^3 + ...

    Attributes
    ----------
    coefficients
        k_1, k_2, k_3, ... in N/m, N/m^2, N/m^3, ...; a cubic spring is (0, 0, k_3).
    length
        Typical displacement, m, to which Newton's tolerance refers. None: a tenth of the displacement at which the
        nonlinear part equals the linear part; without a linear part it has to be given.
    """

    coefficients: Sequence[float]
    length: float | None = None

    def __post_init__(self) -> None:
        if not any(self.coefficients[1:]):
            raise InputError(
                "Spring: it has no nonlinear coefficient", key="coefficients",
                remedy="give k_1, k_2, k_3, ...; a linear spring belongs to K",
            )  # fmt: skip
        if self.length is None and not self.coefficients[0]:
            raise InputError(
                "Spring: without a linear part its typical displacement is unknown", key="length",
                remedy="give length, m: the typical relative displacement",
            )  # fmt: skip
        check_positive("Spring", length=self.scale)

    @property
    def scale(self) -> float:
        """Typical displacement, m."""
        if self.length is not None:
            return self.length
        first, *higher = (abs(float(k)) for k in self.coefficients)
        return min((first / k) ** (1.0 / i) for i, k in enumerate(higher, start=1) if k) / FAR

    def points(self, n: int) -> Points:
        """See `Joint`."""
        forces = [0.0, *(k * self.scale**i for i, k in enumerate(self.coefficients[1:], start=2))]
        unit = max(abs(force) for force in forces)
        law = PolynomialSpring(self.scale, tuple(force / unit for force in forces))
        return self._sliders(n, [law], np.array([unit]))

    def linear(self, n: int) -> sp.csr_matrix | None:
        """See `Joint`."""
        row = sp.csr_matrix(row_of(self.at, n))
        return (float(self.coefficients[0]) * row.T @ row).tocsr() if self.coefficients[0] else None


@dataclass(frozen=True, kw_only=True)
class Gap(Joint):
    """Elastic stop: a spring that acts where the relative displacement exceeds the gap.

    Attributes
    ----------
    stiffness
        Stiffness of the stop, N/m.
    gap
        Relative displacement at which the stop closes, m; negative if it is pressed together at rest.
    both
        True: a second stop acts below -gap.
    """

    stiffness: float
    gap: float
    both: bool = False

    def __post_init__(self) -> None:
        check_positive("Gap", stiffness=self.stiffness)
        if not np.isfinite(self.gap):
            raise InputError(f"Gap: gap is {self.gap:g}", key="gap", remedy="give a length in m")
        if self.both and not self.gap > 0.0:
            raise InputError(
                f"Gap: gap is {self.gap:g} with stops on both sides", key="gap", remedy="give a positive length in m"
            )

    def points(self, n: int) -> Points:
        """See `Joint`."""
        count = 2 if self.both else 1
        rows = np.zeros((count, 3, n))
        rows[0, 0] = -row_of(self.at, n)  # the normal displacement is positive where the stop opens
        if self.both:
            rows[1, 0] = -rows[0, 0]
        law = PenaltyCoulomb(0.0, STOP_SCALE * abs(self.gap) or 1e-6)
        return Points(
            rows, [law] * count, np.full(count, float(self.stiffness)), np.ones(count, bool),
            np.full(count, max(0.0, -self.stiffness * self.gap)), np.full(count, max(0.0, self.gap)),
        )  # fmt: skip
