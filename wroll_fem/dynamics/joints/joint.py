"""Base class of the joints, their places, and their contact points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from wroll_fem.contact.law import FrictionLaw
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

At = int | tuple[int, int] | npt.ArrayLike
"""Place of a joint: a degree of freedom (towards the base), a pair (i, j) for u_i - u_j, or a row (n,)."""


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


def check_positive(kind: str, **values: float) -> None:
    """Refuse numbers that are not positive; their names are those of the attributes of the joint ``kind``."""
    for key, value in values.items():
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{kind}: {key} is {value:g}", key=key, remedy="give a positive number")
