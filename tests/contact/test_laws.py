"""Laws of all points: registered laws alone, and subsets of points that keep every column."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass

import numpy as np
import pytest

from wroll_fem.contact import laws as contact_laws
from wroll_fem.contact.laws import PenaltyCoulomb, PointLaws, RateCoulomb, SmoothedCoulomb, stack_laws
from wroll_fem.errors import InputError

KN = 1.0e12
RATE = RateCoulomb(0.25, 2.0e-6, (0.0, 0.1), (0.25, 0.35))


@dataclass(frozen=True)
class Unknown:
    """Looks like a law, but nobody has registered it."""

    mu: float = 0.3
    elastic_slip: float = 1.0e-6


def test_an_object_that_is_no_registered_law_is_refused() -> None:
    with pytest.raises(InputError, match="Unknown is not a registered friction law") as error:
        stack_laws([np.ones(2)], [Unknown()], [KN], [True])  # type: ignore[list-item]
    assert error.value.key == "contact.friction"
    assert "PenaltyCoulomb" in str(error.value.remedy)
    assert "\n" not in str(error.value)


def three_laws() -> PointLaws:
    laws = [PenaltyCoulomb(0.3, 1.0e-6), RATE, SmoothedCoulomb(0.2, 1.0e-3)]
    return stack_laws([np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.array([5.0])], laws, [KN] * 3, [True] * 3)


def test_taking_points_carries_every_column() -> None:
    whole, points = three_laws(), np.array([3, 0, 4])
    part = whole.take(points)
    for name in whole._fields:
        all_of_them, some = getattr(whole, name), getattr(part, name)
        if name in contact_laws.SHARED:
            assert some is all_of_them
        else:
            assert len(all_of_them) == whole.n
            np.testing.assert_array_equal(some, all_of_them[points])


def test_a_column_that_is_added_later_is_carried_too() -> None:
    """The preload of a roll takes one point for each row: a column left behind would give it another point's value."""

    whole = three_laws()
    wider = namedtuple("Wider", [*PointLaws._fields, "warmth"])(*whole, np.arange(5.0))
    part = PointLaws.take(wider, np.array([4, 1]))  # type: ignore[arg-type]
    np.testing.assert_array_equal(part.warmth, [4.0, 1.0])
    np.testing.assert_array_equal(part.area, whole.area[[4, 1]])
