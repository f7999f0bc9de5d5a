"""Joints with friction: Jenkins element, Iwan joint, Bouc-Wen hysteresis, and any friction law.

References
----------
Iwan (1966), J. Appl. Mech. 33, 893, doi:10.1115/1.3625199.
Segalman (2005), J. Appl. Mech. 72, 752, doi:10.1115/1.1989354 (four-parameter Iwan model).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wroll_fem.contact.bouc_wen import BoucWen as BoucWenLaw
from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.dynamics.joints.joint import At, Joint, Points, check_positive, row_of
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

SMALLEST_SLIDER, EVEN_SHARE = 1e-3, 3
"""Slip limit of the smallest slider of an Iwan joint, relative to the largest. One of `EVEN_SHARE` sliders divides the
slip limits evenly, the others geometrically."""


@dataclass(frozen=True, kw_only=True)
class Jenkins(Joint):
    """Elastic dry friction: a spring in series with a slider, under a constant normal force.

    Attributes
    ----------
    stiffness
        Stiffness k_t while it sticks, N/m.
    limit
        Force at which it slides, N; or give ``mu`` and ``normal_force``.
    mu, normal_force
        Coefficient of friction, and constant normal force, N.
    across
        Place of the second tangential direction; the limit then holds for the magnitude of the force.
    """

    stiffness: float
    limit: float | None = None
    mu: float | None = None
    normal_force: float | None = None
    across: At | None = None

    def __post_init__(self) -> None:
        pair = self.mu is not None and self.normal_force is not None
        if pair == (self.limit is not None) or (self.mu is None) != (self.normal_force is None):
            raise InputError(
                "Jenkins: give either the limit, or mu and normal_force", key="limit", remedy="give one of the two"
            )
        check_positive("Jenkins", stiffness=self.stiffness, limit=self.largest_force)

    @property
    def largest_force(self) -> float:
        """Force at which the joint slides, N."""
        if self.limit is not None:
            return self.limit
        assert self.mu is not None
        assert self.normal_force is not None
        return self.mu * self.normal_force

    def points(self, n: int) -> Points:
        """See `Joint`."""
        law = PenaltyCoulomb(1.0, self.largest_force / self.stiffness)
        return self._sliders(n, [law], np.array([self.largest_force]), self.across)


@dataclass(frozen=True, kw_only=True)
class Coulomb(Joint):
    """Elastic dry friction under a normal force that varies with the motion: springs along and across the contact.

    Attributes
    ----------
    normal
        Place of the normal relative displacement, positive where the contact opens.
    stiffness, normal_stiffness
        Tangential stiffness k_t while it sticks, and normal stiffness, N/m.
    mu
        Coefficient of friction: it slides at mu times the present normal force.
    normal_force, gap
        Normal force at rest, N, or gap at rest, m; one of the two at most.
    force
        Typical normal force, N, to which tolerances refer; ``normal_force`` if None.
    across
        Place of the second tangential direction.
    """

    normal: At
    stiffness: float
    normal_stiffness: float
    mu: float
    normal_force: float = 0.0
    gap: float = 0.0
    force: float | None = None
    across: At | None = None

    def __post_init__(self) -> None:
        if self.normal_force < 0.0 or self.gap < 0.0 or (self.normal_force and self.gap):
            raise InputError(
                f"Coulomb: normal_force is {self.normal_force:g} and gap is {self.gap:g}", key="normal_force",
                remedy="give one of them, not negative",
            )  # fmt: skip
        if not self.typical_force > 0.0:
            raise InputError(
                "Coulomb: without a normal force at rest its typical value is unknown", key="force",
                remedy="give force, N: the typical normal force",
            )  # fmt: skip
        check_positive("Coulomb", stiffness=self.stiffness, normal_stiffness=self.normal_stiffness, mu=self.mu)

    @property
    def typical_force(self) -> float:
        """Typical normal force, N."""
        return self.normal_force if self.force is None else self.force

    def points(self, n: int) -> Points:
        """See `Joint`."""
        rows = np.zeros((1, 3, n))
        rows[0, 0], rows[0, 1] = row_of(self.normal, n), row_of(self.at, n)
        if self.across is not None:
            rows[0, 2] = row_of(self.across, n)
        law = ElasticCoulomb(self.mu, self.mu * self.typical_force / self.stiffness, self.stiffness)
        return Points(
            rows, [law], np.array([float(self.normal_stiffness)]), np.ones(1, bool),
            np.array([float(self.normal_force)]), np.array([float(self.gap)]),
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Iwan(Joint):
    r"""Four-parameter Iwan joint (Segalman 2005): sliders in parallel, whose limits follow a power law.

    The density of sliders of slip limit :math:`\phi` is :math:`R \phi^\chi` up to :math:`\phi_{max}`, where further
    sliders of the joint stiffness S slide together. At small amplitudes the loss per cycle is proportional to the
    amplitude to the power :math:`3 + \chi`.

    Attributes
    ----------
    stiffness
        Stiffness K_T while all sliders stick, N/m.
    limit
        Force F_S at which all sliders slide, N.
    chi
        Exponent, above -1.
    beta
        Ratio of S to the stiffness of the other sliders, 0 or more.
    sliders
        Number of sliders of the power law.
    """

    stiffness: float
    limit: float
    chi: float
    beta: float = 0.0
    sliders: int = 150

    def __post_init__(self) -> None:
        check_positive("Iwan", stiffness=self.stiffness, limit=self.limit, sliders=self.sliders)
        if not self.chi > -1.0:
            raise InputError(f"Iwan: chi is {self.chi:g}", key="chi", remedy="give a number above -1")
        if not self.beta >= 0.0:
            raise InputError(f"Iwan: beta is {self.beta:g}", key="beta", remedy="give 0 or more")

    @property
    def largest_slip(self) -> float:
        """Slip limit phi_max of the last sliders, m."""
        inner = (self.chi + 1.0) / (self.chi + 2.0)
        return self.limit * (1.0 + self.beta) / (self.stiffness * (self.beta + inner))

    def of_sliders(self) -> tuple[FloatArray, FloatArray]:
        """Stiffness (m,), N/m, and slip limit (m,), m, of each slider.

        A slider has the stiffness of its part of the slip limits, and the limit with which the force of the part is
        exact once it slides.
        """
        last, chi, even = self.largest_slip, self.chi, self.sliders // EVEN_SHARE
        parts = np.arange(1, even + 1) / (even + 1), np.geomspace(SMALLEST_SLIDER, 1.0, self.sliders - even)
        edges = np.unique(np.concatenate([[0.0], *parts]))
        whole = self.stiffness / (1.0 + self.beta)  # of the power law
        stiffness = whole * np.diff(edges ** (chi + 1.0))
        force = whole * last * (chi + 1.0) / (chi + 2.0) * np.diff(edges ** (chi + 2.0))
        limit = force / stiffness
        if self.beta > 0.0:
            stiffness = np.append(stiffness, self.stiffness * self.beta / (1.0 + self.beta))
            limit = np.append(limit, last)
        return stiffness, limit

    def points(self, n: int) -> Points:
        """See `Joint`."""
        stiffness, limit = self.of_sliders()
        return self._sliders(n, [PenaltyCoulomb(1.0, float(x)) for x in limit], stiffness * limit)


@dataclass(frozen=True, kw_only=True)
class BoucWen(Joint):
    """Bouc-Wen hysteresis; see `contact.bouc_wen`.

    Attributes
    ----------
    stiffness
        Stiffness at rest, N/m, of the hysteretic part.
    limit
        Force that the hysteretic part approaches, N.
    exponent, unloading
        n, and beta / (beta + gamma).
    across
        Place of the second tangential direction.
    """

    stiffness: float
    limit: float
    exponent: float = 1.0
    unloading: float = 0.5
    across: At | None = None

    def __post_init__(self) -> None:
        check_positive("BoucWen", stiffness=self.stiffness, limit=self.limit)

    def points(self, n: int) -> Points:
        """See `Joint`."""
        law = BoucWenLaw(1.0, self.limit / self.stiffness, self.exponent, self.unloading)
        return self._sliders(n, [law], np.array([self.limit]), self.across)


@dataclass(frozen=True, kw_only=True)
class Friction(Joint):
    """Any registered friction law under a constant normal force.

    Attributes
    ----------
    law
        Friction law, for example `wroll_fem.contact.interface.SmoothedCoulomb`.
    normal_force
        Constant normal force, N.
    across
        Place of the second tangential direction.
    """

    law: FrictionLaw
    normal_force: float
    across: At | None = None

    def __post_init__(self) -> None:
        check_positive("Friction", normal_force=self.normal_force)

    def points(self, n: int) -> Points:
        """See `Joint`."""
        return self._sliders(n, [self.law], np.array([self.normal_force]), self.across)
