"""Laws of all points: registered laws alone, and subsets of points that keep every column."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp

from wroll_fem.case.contact import PenaltyFriction, SmoothedFriction, derived_section
from wroll_fem.contact import laws as contact_laws
from wroll_fem.contact.interface import Interface, NormalPenalty, PointwiseFriction
from wroll_fem.contact.law import FrictionLaw
from wroll_fem.contact.laws import PenaltyCoulomb, PointLaws, RateCoulomb, SmoothedCoulomb, slip_derivatives, stack_laws
from wroll_fem.contact.registry import BY_NAME, LAWS
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.full import FullStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
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


# --- the registry -----------------------------------------------------------------------------------------------------


def test_every_law_has_its_own_number_and_name() -> None:
    assert [BY_NAME[law.name] for law in LAWS] == list(LAWS)
    assert list(three_laws().kind) == [0, 0, 1, 1, 2]


@pytest.mark.parametrize(
    ("law", "section"),
    [(PenaltyCoulomb, PenaltyFriction), (SmoothedCoulomb, SmoothedFriction)],
    ids=["penalty", "smoothed"],
)
def test_the_section_of_a_law_follows_from_its_parameters(law: type[FrictionLaw], section: type) -> None:
    """The section derived from the law has the keys, bounds and descriptions of the one written by hand."""
    derived, written = (kind.model_json_schema()["properties"] for kind in (derived_section(law), section))
    for key in ("mu", "elastic_slip", "reference_speed"):
        assert derived.get(key) == written.get(key)
    assert derived["law"]["const"] == written["law"]["const"] == law.name
    assert derived["law"]["description"] == written["law"]["description"]


def test_a_law_is_built_from_its_section() -> None:
    section = derived_section(SmoothedCoulomb)(law="smoothed_coulomb", mu=0.3, reference_speed=2.0e-3)
    assert SmoothedCoulomb.from_section(section) == SmoothedCoulomb(0.3, 2.0e-3)


def test_a_law_that_sticks_has_the_identity_as_its_derivative_while_it_does() -> None:
    """What harmonic balance relies on where a point that `sticks` has not slid."""
    for law in (PenaltyCoulomb(0.3, 1.0e-6), RATE, SmoothedCoulomb(0.2, 1.0e-3)):
        laws = stack_laws([np.ones(1)], [law], [KN], [True])
        found = slip_derivatives(0, 3.0e-7, -2.0e-7, 1.0e-7, 2.0e-7, 0.0, laws, 1.0e-3)
        assert (found == (1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)) == law.sticks


# --- laws that vary from point to point -------------------------------------------------------------------------------


def rubbing(parts: list[tuple[list[int], FrictionLaw | PointwiseFriction, NormalPenalty]]) -> System:
    """Four masses in a row of springs on rough ground; the interfaces share their points in a given way."""
    k = 1.0e4 * (np.diag([2.0, 2.0, 2.0, 1.0]) - np.diag(np.ones(3), 1) - np.diag(np.ones(3), -1))
    whole = np.zeros((8, 8))
    whole[:4, :4] = k
    interfaces = []
    for number, (points, friction, normal) in enumerate(parts):
        rows = np.zeros((3 * len(points), 8))
        for i, point in enumerate(points):
            rows[3 * i, 4 + point], rows[3 * i + 1, point] = 1.0, 1.0
        place = np.column_stack([np.zeros(len(points)), 0.1 * np.array(points), np.ones(len(points))])
        interfaces.append(
            Interface(f"ground {number}", sp.csr_matrix(rows), np.full(len(points), 1.0e-3), place, friction, normal)
        )
    return System(
        sp.csr_matrix(whole), sp.identity(8, format="csr"), np.repeat([1.0, 0.0], 4), tuple(interfaces),
        {"tip": np.eye(8)[3]}, {"preload": np.repeat([0.0, -10.0], 4)},
    )  # fmt: skip


def motion(system: System, method: str) -> np.ndarray:
    """Tip, its velocity and acceleration, and the energies of a short shake."""
    preload, dt = solve_preload(system), 1.0 / 1400.0
    base = 20.0 * np.sin(2.0 * np.pi * 14.0 * dt * np.arange(301))
    options = NewtonOptions(tolerance=1e-10)
    run = (
        FullStepper(system, preload, Scheme.hht(-0.05), options)
        if method == "full"
        else CondensedStepper(system, preload, Scheme.hht(-0.05), options, dt=dt)
    )
    return run.advance(base, dt, 0.0)[:, :9]


SOFT, STIFF = NormalPenalty(1.0e10), NormalPenalty(3.0e10)
LOW, HIGH = PenaltyCoulomb(0.1, 1.0e-6), PenaltyCoulomb(0.4, 2.0e-6)


@pytest.mark.parametrize("method", ["full", "condensed"])
def test_two_coefficients_on_one_interface_are_two_interfaces(method: str) -> None:
    """Friction and normal penalty that vary over an interface give what two interfaces with one law each give."""
    apart = motion(rubbing([([0, 1], LOW, SOFT), ([2, 3], HIGH, STIFF)]), method)
    which = np.array([0, 0, 1, 1])
    mu, slip = np.array([0.1, 0.4])[which], np.array([1.0e-6, 2.0e-6])[which]
    normal = NormalPenalty(np.array([1.0e10, 3.0e10])[which], separation=np.ones(4, bool))
    for friction in (
        PointwiseFriction((LOW, HIGH), which),
        PointwiseFriction.varying(PenaltyCoulomb, mu=mu, elastic_slip=slip),
    ):
        together = motion(rubbing([([0, 1, 2, 3], friction, normal)]), method)
        scale = np.abs(apart).max(axis=0)
        assert scale[7] > 0.0  # friction does work
        np.testing.assert_allclose(together / scale, apart / scale, rtol=0.0, atol=1e-10)
    uniform = motion(rubbing([([0, 1, 2, 3], LOW, SOFT)]), method)
    assert np.abs(uniform - apart).max() > 1e-3 * np.abs(apart).max()


def test_points_may_have_laws_of_different_kinds() -> None:
    mixed = PointwiseFriction((RATE, SmoothedCoulomb(0.2, 1.0e-3), LOW), np.array([2, 0, 1, 0]))
    laws = rubbing([([0, 1, 2, 3], mixed, SOFT)]).laws
    np.testing.assert_array_equal(laws.kind, [0, 1, 2, 1])
    np.testing.assert_array_equal(laws.mu, [0.1, 0.25, 0.2, 0.25])
    np.testing.assert_array_equal(laws.own[laws.kind == 2, 0], [1.0e-3])
    assert mixed.of_point(2) == SmoothedCoulomb(0.2, 1.0e-3)


@pytest.mark.parametrize(
    "build",
    [
        lambda: PointwiseFriction((LOW,), np.array([0, 1])),
        lambda: PointwiseFriction.varying(PenaltyCoulomb, mu=0.3, elastic_slip=1.0e-6),
        lambda: PointwiseFriction.varying(PenaltyCoulomb, mu=np.ones(2), elastic_slip=np.ones(3)),
        lambda: PointwiseFriction.varying(PenaltyCoulomb, mu=np.array([0.3, -0.1]), elastic_slip=1.0e-6),
        lambda: rubbing([([0, 1], PointwiseFriction((LOW,), np.zeros(3, int)), SOFT)]),
        lambda: rubbing([([0, 1], LOW, NormalPenalty(np.ones(3)))]),
    ],
    ids=["no such law", "no array", "lengths differ", "negative", "points of friction", "points of the penalty"],
)
def test_inadmissible_variations_are_refused(build) -> None:
    with pytest.raises(InputError) as error:
        build()
    assert error.value.remedy
