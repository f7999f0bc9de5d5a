r"""Discrete joints between degrees of freedom: friction elements, nonlinear springs and stops, as interfaces of points.

A joint acts on the difference of two displacements (or on any row of displacements), in N and m, without area and
without additional degrees of freedom. Each of its contact points has the area 1 m^2, so that Pa stand for N. A constant
normal force is a contact pressure whose normal row is zero.

References
----------
Iwan (1966), J. Appl. Mech. 33, 893, doi:10.1115/1.3625199.
Segalman (2005), J. Appl. Mech. 72, 752, doi:10.1115/1.1989354 (four-parameter Iwan model).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from wroll_fem.contact.bouc_wen import BoucWen as BoucWenLaw
from wroll_fem.contact.interface import Interface, NormalPenalty
from wroll_fem.contact.kernels import OPEN
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.point import contact_dofs
from wroll_fem.contact.pointwise import PointwiseFriction
from wroll_fem.contact.polynomial_spring import PolynomialSpring
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

At = int | tuple[int, int] | npt.ArrayLike
"""Place of a joint: a degree of freedom (towards the base), a pair (i, j) for u_i - u_j, or a row (n,)."""

SMALLEST_SLIDER, EVEN_SHARE = 1e-3, 3
"""Slip limit of the smallest slider of an Iwan joint, relative to the largest. One of `EVEN_SHARE` sliders divides the
slip limits evenly, the others geometrically."""

STOP_SCALE = 1e-2
"""Length to which Newton's tolerance refers at a stop, relative to its gap."""

FAR = 10.0
"""A nonlinear spring without a length: displacement at which the nonlinear part of its force equals the linear one,
divided by its length."""


@dataclass(frozen=True)
class Points:
    """Contact points of a joint.

    Attributes
    ----------
    rows : (m, 3, n) normal, first and second tangential row of each point
    laws : friction law of each point
    stiffness : (m,) normal stiffness, N/m
    separation : (m,) whether a point can open
    force : (m,) normal force at rest, N
    gap : (m,) initial gap, m
    """

    rows: FloatArray
    laws: Sequence[FrictionLaw]
    stiffness: FloatArray
    separation: np.ndarray
    force: FloatArray
    gap: FloatArray


@dataclass(frozen=True, kw_only=True)
class Joint(ABC):
    """Base class of the joints.

    Attributes
    ----------
    at
        Degree of freedom (counted from 0; the joint then acts towards the base), pair (i, j) for the displacement of i
        relative to j, or row (n,) whose product with the displacements is the relative displacement, m.
    name
        Name in messages and results; the kind of the joint if empty.
    """

    at: At
    name: str = ""

    @abstractmethod
    def points(self, n: int) -> Points:
        """Contact points in a structure with ``n`` degrees of freedom."""

    def linear(self, n: int) -> sp.csr_matrix | None:
        """(n, n) stiffness that the joint adds to that of the structure, N/m; None without it."""
        return None

    def _sliders(self, n: int, laws: Sequence[FrictionLaw], forces: FloatArray, across: At | None = None) -> Points:
        """Points in parallel under constant normal ``forces`` (m,), N, whose normal rows are zero."""
        rows = np.zeros((len(laws), 3, n))
        rows[:, 1] = row_of(self.at, n)
        if across is not None:
            rows[:, 2] = row_of(across, n)
        stiffness = np.array([law.mu * p / law.elastic_slip for law, p in zip(laws, forces, strict=True)])
        stiffness = np.where(stiffness > 0.0, stiffness, 1.0)
        return Points(rows, laws, stiffness, np.zeros(len(laws), bool), forces, np.zeros(len(laws)))


def row_of(at: At, n: int) -> FloatArray:
    """(n,) row of a place; see `At`.

    Raises
    ------
    InputError
        If a degree of freedom does not exist, or the row has another length.
    """
    values = np.asarray(at, float)
    if values.ndim == 1 and values.shape == (n,) and not (n == 2 and isinstance(at, tuple)):
        return values
    if values.ndim > 1 or (values.ndim == 1 and values.shape != (2,)):
        raise InputError(
            f"a joint has a row of shape {values.shape} for {n} degrees of freedom",
            key="at", remedy="give a degree of freedom, a pair (i, j), or one number per degree of freedom",
        )  # fmt: skip
    row = np.zeros(n)
    for sign, index in zip((1.0, -1.0), np.atleast_1d(values), strict=False):
        if index != int(index) or not 0 <= index < n:
            raise InputError(
                f"a joint is at degree of freedom {index:g}, but there are {n}",
                key="at", remedy=f"count from 0 to {n - 1}",
            )  # fmt: skip
        row[int(index)] += sign
    return row


def _positive(kind: str, **values: float) -> None:
    for key, value in values.items():
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{kind}: {key} is {value:g}", key=key, remedy="give a positive number")


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
        _positive("Jenkins", stiffness=self.stiffness, limit=self.largest_force)

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
        _positive("Iwan", stiffness=self.stiffness, limit=self.limit, sliders=self.sliders)
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
        _positive("BoucWen", stiffness=self.stiffness, limit=self.limit)

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
        _positive("Friction", normal_force=self.normal_force)

    def points(self, n: int) -> Points:
        """See `Joint`."""
        return self._sliders(n, [self.law], np.array([self.normal_force]), self.across)


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
        _positive("Spring", length=self.scale)

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
        _positive("Gap", stiffness=self.stiffness)
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


def with_joints(system: System, joints: Sequence[Joint]) -> tuple[System, ContactState]:
    """System with an interface for each joint, and its state at rest, in which it is in equilibrium.

    Raises
    ------
    InputError
        If a joint is at a degree of freedom that does not exist, or the system has interfaces already.
    """
    n = system.n_dofs
    if system.interfaces:
        raise InputError("a system with interfaces cannot have joints", remedy="write the joints as interfaces")
    parts = [joint.points(n) for joint in joints]
    interfaces = tuple(_interface(joint, k, part) for k, (joint, part) in enumerate(zip(joints, parts, strict=True), 1))
    stiffness = system.stiffness
    for added in (joint.linear(n) for joint in joints):
        if added is not None:
            stiffness = (stiffness + added).tocsr()
    system = replace(system, stiffness=stiffness, interfaces=interfaces)
    state = ContactState.unloaded(system)
    if not parts:
        return system, state
    dofs = contact_dofs(system.n_points)
    force, kn = (np.concatenate([getattr(part, name) for part in parts]) for name in ("force", "stiffness"))
    gap = np.concatenate([part.gap for part in parts])
    state.jump[dofs[:, 2]] = np.where(gap > 0.0, gap, -force / kn)
    state.traction[dofs[:, 2]] = -force
    state.status[gap > 0.0] = OPEN
    return system, state


def joint_force(joint: Joint, displacement: npt.ArrayLike) -> FloatArray:
    """Quasi-static force (m,), N, of a joint for a history of its relative displacement (m,), m, from rest.

    With ``across``, both are (m, 2). The force is positive where it resists a positive displacement.
    """
    path = np.asarray(displacement, float)
    across = getattr(joint, "across", None)
    if path.ndim != (1 if across is None else 2):
        raise InputError(
            f"the displacement of a joint has the shape {path.shape}", remedy="give (m,), or (m, 2) with across"
        )
    path = path.reshape(len(path), -1)
    n = 1 + max(_last(place) for place in (joint.at, across) if place is not None)
    directions = np.array([row_of(place, n) for place in (joint.at, across) if place is not None])
    plain = System(sp.csr_matrix((n, n)), sp.identity(n, format="csr"), np.zeros(n))
    system, state = with_joints(plain, [joint])
    # displacements of the degrees of freedom with these relative displacements
    moves = np.linalg.lstsq(directions, path.T, rcond=None)[0].T
    contact, force, rest = TrialContact(system), np.empty_like(path), state.jump.copy()
    onto = np.linalg.pinv(directions.T)
    for k, move in enumerate(moves):
        jump = rest + system.jump @ move
        traction = contact(jump, state)
        force[k] = onto @ (system.jump.T @ traction + system.stiffness @ move)
        state = contact.committed(move, jump)
    return force[:, 0] if across is None else force


def _last(at: At) -> int:
    """Last degree of freedom of a place."""
    values = np.asarray(at, float)
    return int(values.max()) if values.ndim == 0 or isinstance(at, tuple) else len(values) - 1


def _interface(joint: Joint, number: int, part: Points) -> Interface:
    laws = list(dict.fromkeys(part.laws))
    index = np.array([laws.index(law) for law in part.laws])
    count = len(part.laws)
    return Interface(
        name=joint.name or f"{type(joint).__name__.lower()}_{number}",
        operator=sp.csr_matrix(part.rows.reshape(3 * count, -1)),
        areas=np.ones(count),
        points=np.full((count, 3), np.nan),
        friction=laws[0] if len(laws) == 1 else PointwiseFriction(tuple(laws), index),
        normal=NormalPenalty(part.stiffness, part.separation),
    )
