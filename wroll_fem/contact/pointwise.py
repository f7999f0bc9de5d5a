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
    """One friction law for each point of an interface.

    Attributes
    ----------
    laws
        The distinct laws.
    index
        (n_points,) index in ``laws`` of the law of each point.
    """

    laws: tuple[FrictionLaw, ...]
    index: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "laws", tuple(self.laws))
        object.__setattr__(self, "index", np.asarray(self.index, np.int64))
        inside = self.index.ndim == 1 and np.all((self.index >= 0) & (self.index < len(self.laws)))
        if not self.laws or not inside:
            raise InputError(
                f"the friction law indices must form a one-dimensional array and refer to the {len(self.laws)} given "
                f"laws; the array has the shape {self.index.shape}",
                key="contact.friction",
                remedy="give one index for each contact point, counted from 0",
            )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PointwiseFriction):
            return NotImplemented
        return self.laws == other.laws and np.array_equal(self.index, other.index)

    __hash__ = None  # type: ignore[assignment]

    @classmethod
    def varying(cls, law: type[FrictionLaw], **parameters: npt.ArrayLike) -> Self:
        """Friction laws of one type whose ``parameters`` vary from point to point: numbers or (n_points,) arrays.

        Raises
        ------
        InputError
            If no parameter is an array, the arrays have different lengths, or a value is out of range.
        """
        try:
            columns = np.broadcast_arrays(*(np.asarray(value, float) for value in parameters.values()))
        except ValueError:
            columns = []
        if not columns or columns[0].ndim != 1:
            raise InputError(
                f"the parameters of {law.__name__} must be numbers and one-dimensional arrays of equal length",
                key="contact.friction",
                remedy="give at least one (n_points,) array; the other parameters may be numbers",
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
    """Distinct laws of all interfaces, and the index (n,) of each point's law; ``counts``: points per interface."""
    found: dict[FrictionLaw, int] = {}
    law_of_point = [np.zeros(0, np.int64)]
    for law, count in zip(friction, counts, strict=True):
        pointwise = law if isinstance(law, PointwiseFriction) else PointwiseFriction((law,), np.zeros(count, int))
        for part in pointwise.laws:
            check_registered(part)
        places = [found.setdefault(part, len(found)) for part in pointwise.laws]
        law_of_point.append(np.array(places)[pointwise.index])
    return list(found), np.concatenate(law_of_point)
