"""Friction laws and interfaces refuse parameters out of range in one line, also without a case file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
import scipy.sparse as sp

from wroll_fem.bodies.body import Trace
from wroll_fem.contact.bouc_wen import BoucWen
from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.interface import NormalPenalty, matched_interface
from wroll_fem.contact.penalty_coulomb import PenaltyCoulomb
from wroll_fem.contact.pointwise import PointwiseFriction
from wroll_fem.contact.polynomial_spring import PolynomialSpring
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.registry import BY_NAME, LAWS, register_law
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb
from wroll_fem.errors import InputError

NAN = float("nan")
LOW, HIGH = PenaltyCoulomb(0.1, 1e-6), PenaltyCoulomb(0.4, 2e-6)


@pytest.mark.parametrize(
    ("made", "told"),
    [
        (lambda: PenaltyCoulomb(-0.1, 1e-6), "coefficient of friction -0.1 is negative"),
        (lambda: PenaltyCoulomb(NAN, 1e-6), "coefficient of friction nan is negative"),
        (lambda: PenaltyCoulomb(0.1, 0.0), "elastic slip 0.0 m is not positive"),
        (lambda: PenaltyCoulomb(0.1, NAN), "elastic slip nan m is not positive"),
        (lambda: ElasticCoulomb(-0.1, 1e-6, 1e9), "coefficient of friction -0.1 is negative"),
        (lambda: ElasticCoulomb(0.1, 1e-6, 0.0), "stick stiffness 0.0 Pa/m is not positive"),
        (lambda: SmoothedCoulomb(-0.1, 1e-3), "coefficient of friction -0.1 is negative"),
        (lambda: SmoothedCoulomb(0.1, 0.0), "reference speed 0.0 m/s is not positive"),
        (lambda: BoucWen(-0.1, 1e-6, 1.0, 0.5), "coefficient of friction -0.1 is negative"),
        (lambda: BoucWen(0.1, 1e-6, 0.9, 0.5), "exponent 0.9 is below 1"),
        (lambda: BoucWen(0.1, 1e-6, 1.0, 0.4), "unloading 0.4 is below 0.5"),
        (lambda: PolynomialSpring(0.0, (1.0,)), "length 0.0 m is not positive"),
        (lambda: PolynomialSpring(1e-6, (0.0, 0.0)), "all coefficients of a polynomial spring are zero"),
        (lambda: RateCoulomb(0.3, 1e-6, (0.0, 1.0), (0.4, 0.3)), "0.3 differs from the first coefficient"),
        (lambda: RateCoulomb(0.4, 1e-6, (), ()), "slip_rate is empty"),
        (lambda: RateCoulomb(0.4, 1e-6, (0.0, 1.0), (0.4,)), "mu has 1 values for 2 slip rates"),
        (lambda: RateCoulomb(0.4, 1e-6, (0.1, 1.0), (0.4, 0.3)), "slip_rate must start at 0 m/s"),
        (lambda: RateCoulomb(0.4, 1e-6, (0.0, 0.0), (0.4, 0.3)), "slip_rate must rise"),
        (lambda: RateCoulomb(0.4, 1e-6, (0.0, 1.0), (0.4, -0.3)), "mu must be 0 or more"),
        (lambda: RateCoulomb(0.0, 1e-6, (0.0, 1.0), (0.0, 0.3)), "mu must not start at 0"),
        (lambda: PointwiseFriction((), np.array([], int)), "refer to the 0 given laws"),
        (lambda: PointwiseFriction((LOW, HIGH), np.array([0, 2])), "refer to the 2 given laws"),
        (lambda: PointwiseFriction((LOW, HIGH), np.array([0, -1])), "refer to the 2 given laws"),
        (lambda: PointwiseFriction((LOW, HIGH), np.array([[0, 1]])), r"the array has the shape \(1, 2\)"),
        (lambda: PointwiseFriction.varying(PenaltyCoulomb), "must be numbers and one-dimensional arrays"),
        (lambda: PointwiseFriction.varying(PenaltyCoulomb, mu=0.1, elastic_slip=1e-6), "one-dimensional arrays"),
        (lambda: PointwiseFriction.varying(PenaltyCoulomb, mu=[0.1, 0.2], elastic_slip=[1e-6] * 3), "equal length"),
    ],
)  # fmt: skip
def test_a_law_with_wrong_parameters_is_refused_in_one_line(made: Callable[[], object], told: str) -> None:
    with pytest.raises(InputError, match=told) as caught:
        made()
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("law", [PenaltyCoulomb(0.0, 1e-6), SmoothedCoulomb(0.0, 1e-3), BoucWen(0.0, 1e-6, 1.0, 0.5)])
def test_limits_of_the_parameters_belong_to_their_range(law: object) -> None:
    """No friction, the smallest exponent, and unloading with the stiffness at rest are allowed."""
    assert law == type(law)(**vars(law))


def test_a_table_without_friction_at_all_is_allowed() -> None:
    assert RateCoulomb(0.0, 1e-6, (0.0, 1.0), (0.0, 0.0)).mu == 0.0


def test_the_name_of_a_law_is_taken_once() -> None:
    @dataclass(frozen=True)
    class Other(PenaltyCoulomb):
        name: ClassVar[str] = "penalty_coulomb"

    before = list(LAWS), dict(BY_NAME)
    with pytest.raises(InputError, match="the friction law 'penalty_coulomb' exists"):
        register_law(Other)
    assert register_law(PenaltyCoulomb) is PenaltyCoulomb  # again the same one
    assert before == (LAWS, BY_NAME)


def trace(points: np.ndarray) -> Trace:
    return Trace(sp.eye(3 * len(points), format="csr"), points, np.ones(len(points)))


def test_surfaces_that_do_not_match_make_no_interface() -> None:
    points = np.array([[0.0, 0.0, 0.04], [0.0, 0.1, 0.04]])
    columns = slice(0, 6), slice(6, 12)
    made = lambda other: matched_interface(  # noqa: E731
        "a/b", trace(points), trace(other), columns, 12, LOW, NormalPenalty(1e9)
    )
    both = made(points + [1e-8, 1e-9, 0.0])  # within 1e-6 of the radius
    np.testing.assert_array_equal(both.operator.toarray(), np.hstack([-np.eye(6), np.eye(6)]))
    with pytest.raises(InputError, match="the two surfaces have 2 and 1 points"):
        made(points[:1])
    for off in ([1e-5, 0.0, 0.0], [0.0, 1e-6, 0.0]):
        with pytest.raises(InputError, match=r"should coincide are up to .* m apart"):
            made(points + off)


def test_normal_laws_are_equal_if_their_numbers_are() -> None:
    assert NormalPenalty(1e9) == NormalPenalty(1e9)
    assert NormalPenalty(1e9) != NormalPenalty(2e9)
    assert NormalPenalty(np.array([1e9, 1e9])) != NormalPenalty(np.array([1e9, 2e9]))
    assert NormalPenalty(1e9) != 1e9
