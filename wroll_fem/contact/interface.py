"""Interface: two surfaces with matching points, their relative displacement, areas and laws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Trace
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.pointwise import PointwiseFriction
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

__all__ = [
    "FrictionLaw", "Interface", "NormalPenalty", "PenaltyCoulomb", "PointwiseFriction", "RateCoulomb",
    "SmoothedCoulomb", "facing", "matched_interface",
]  # fmt: skip


@dataclass(frozen=True, eq=False)
class NormalPenalty:
    """Penalty law of normal contact. Each value is one number, or an (n_points,) array that varies from point to point.

    Attributes
    ----------
    stiffness
        Pressure per unit penetration, Pa/m.
    separation
        True: unilateral contact (no tension, the surfaces can separate). False: bilateral contact.
    """

    stiffness: float | FloatArray
    separation: bool | np.ndarray = True  # of flags; BoolArray is a name that the site cannot print

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, NormalPenalty):
            return NotImplemented
        return np.array_equal(self.stiffness, other.stiffness) and np.array_equal(self.separation, other.separation)

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True)
class Interface:
    """Interface of two bodies: relative displacement (outer minus inner body) at matching points, areas and laws.

    Attributes
    ----------
    name
        Name in messages and results. Interfaces are in order from the inside outwards.
    operator
        (3 * n_points, n_dofs of the system) sparse matrix from the displacements to the relative displacements, m.
        Row 3 k + c is component c of (normal, hoop, axial) at point k.
    areas
        (n_points,) tributary area of each point, m^2.
    points
        (n_points, 3) cylindrical coordinates (theta rad, z m, r m).
    friction
        Friction law: one for all points, or `PointwiseFriction`.
    normal
        Normal law.
    fills_body
        True: the points fill a body, as those between the wraps of a coil. False: they lie on a surface.
    """

    name: str
    operator: sp.csr_matrix
    areas: FloatArray
    points: FloatArray
    friction: FrictionLaw | PointwiseFriction
    normal: NormalPenalty
    fills_body: bool = False

    def __post_init__(self) -> None:
        if self.operator.shape[0] != 3 * len(self.areas) or self.points.shape != (len(self.areas), 3):
            raise InputError(
                f"interface {self.name}: the operator has {self.operator.shape[0]} rows for {len(self.areas)} areas "
                f"and points of shape {self.points.shape}; each point needs 3 rows, 1 area and 3 coordinates"
            )
        varying = {
            "friction": self.friction.index if isinstance(self.friction, PointwiseFriction) else 0,
            "normal.stiffness": self.normal.stiffness,
            "normal.separation": self.normal.separation,
        }
        for name, values in varying.items():
            if np.shape(values) not in ((), (self.n_points,)):
                raise InputError(
                    f"interface {self.name}: {name} has the shape {np.shape(values)}, but there are {self.n_points} "
                    "points",
                    remedy="give one value, or one per point",
                )

    @property
    def n_points(self) -> int:
        """Number of contact points."""
        return len(self.areas)


def matched_interface(
    name: str,
    inner: Trace,
    outer: Trace,
    columns: tuple[slice, slice],
    n_dofs: int,
    friction: FrictionLaw | PointwiseFriction,
    normal: NormalPenalty,
) -> Interface:
    """Interface between the outer surface of one body and the inner surface of the next.

    Parameters
    ----------
    inner, outer
        Trace of the inner body's outer surface and of the outer body's inner surface.
    columns
        Degrees of freedom of the inner body, and of the outer body, within those of the system.
    n_dofs
        Number of degrees of freedom of the system.

    Raises
    ------
    InputError
        If the points of the two surfaces differ in number, or in position by more than 1e-6 of the radius.
    """
    radius = float(np.mean(inner.points[:, 2]))
    if inner.points.shape != outer.points.shape:
        raise InputError(
            f"interface {name}: the two surfaces have {len(inner.points)} and {len(outer.points)} points",
            key="mesh",
            remedy="mesh both with the same circumferential and axial divisions",
        )
    offset = np.abs(inner.points - outer.points) * np.array([radius, 1.0, 1.0])
    if offset.max() > 1e-6 * radius:
        raise InputError(
            f"interface {name}: points of the two surfaces that should coincide are up to {offset.max():.3g} m apart",
            key="mesh",
            remedy="mesh both with the same circumferential and axial divisions",
        )
    rows = sp.coo_matrix(outer.operator), sp.coo_matrix(inner.operator)
    row = np.concatenate([rows[0].row, rows[1].row])
    col = np.concatenate([rows[0].col + columns[1].start, rows[1].col + columns[0].start])
    data = np.concatenate([rows[0].data, -rows[1].data])
    operator = sp.csr_matrix((data, (row, col)), shape=(inner.operator.shape[0], n_dofs))
    return Interface(name, operator, inner.areas, inner.points, friction, normal)


facing = matched_interface
"""Former name of `matched_interface`, kept as an alias."""
