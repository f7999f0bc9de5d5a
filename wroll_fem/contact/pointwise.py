"""Friction laws that vary from point to point of an interface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.registry import check_registered
from wroll_fem.errors import InputError
from wroll_fem.typing import IntArray


@dataclass(frozen=True, eq=False)
class PointwiseFriction:
    """A law for every point of an interface.

    Attributes
    ----------
    laws
        The different laws.
    index
        (n_points,) place of each point's law in ``laws``.
    """

    laws: tuple[FrictionLaw, ...]
    index: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "laws", tuple(self.laws))
        object.__setattr__(self, "index", np.asarray(self.index, np.int64))
        inside = self.index.ndim == 1 and np.all((self.index >= 0) & (self.index < len(self.laws)))
        if not self.laws or not inside:
            raise InputError(
                f"index {self.index.shape} of the friction laws does not choose among {len(self.laws)} laws",
                key="contact.friction",
                remedy="give one number per point, counted from 0",
            )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PointwiseFriction):
            return NotImplemented
        return self.laws == other.laws and np.array_equal(self.index, other.index)

    __hash__ = None  # type: ignore[assignment]

    @classmethod
    def varying(cls, law: type[FrictionLaw], **parameters: npt.ArrayLike) -> Self:
        """One law whose ``parameters`` are numbers or (n_points,) arrays.

        Raises
        ------
        InputError
            When no parameter is an array, the arrays have different lengths, or a value is not admissible.
        """
        try:
            columns = np.broadcast_arrays(*(np.asarray(value, float) for value in parameters.values()))
        except ValueError:
            columns = []
        if not columns or columns[0].ndim != 1:
            raise InputError(
                f"parameters of {law.__name__} are neither numbers nor arrays of one length",
                key="contact.friction",
                remedy="give (n_points,) arrays, at least one, and numbers",
            )
        rows, index = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
        build: Any = law
        laws = (build(**dict(zip(parameters, row.tolist(), strict=True))) for row in rows)
        return cls(tuple(laws), index.ravel())

    def of_point(self, k: int) -> FrictionLaw:
        """Law of point ``k``."""
        return self.laws[self.index[k]]


def different_laws(
    friction: Sequence[FrictionLaw | PointwiseFriction], counts: Sequence[int]
) -> tuple[list[FrictionLaw], IntArray]:
    """Different laws of interfaces with ``counts`` points, and (n,) which of them each point has."""
    found: dict[FrictionLaw, int] = {}
    law_of_point = [np.zeros(0, np.int64)]
    for law, count in zip(friction, counts, strict=True):
        pointwise = law if isinstance(law, PointwiseFriction) else PointwiseFriction((law,), np.zeros(count, int))
        for part in pointwise.laws:
            check_registered(part)
        places = [found.setdefault(part, len(found)) for part in pointwise.laws]
        law_of_point.append(np.array(places)[pointwise.index])
    return list(found), np.concatenate(law_of_point)
