"""Contact laws through their compiled kernels: Jenkins loop, tangents, memory, varying pressure, isotropy."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.integrate import trapezoid

from wroll_fem.bodies.body import Trace
from wroll_fem.contact import kernels
from wroll_fem.contact.interface import Interface, NormalPenalty, PenaltyCoulomb, facing
from wroll_fem.contact.laws import stack_laws
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError

MU, GAMMA, KN, PRESSURE = 0.3, 2.0e-6, 1.0e12, 1.0e5
STICK_STIFFNESS = MU * PRESSURE / GAMMA  # Pa/m
CLOSED = -PRESSURE / KN  # normal displacement that gives PRESSURE, m
AREA = 2.0e-4  # m^2
DT = 1.0e-4  # s; penalty friction does not feel it


@dataclass
class Points:
    """Interface points (one by default) with committed state; slots are hoop, axial of each, then normals."""

    g: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, CLOSED]))
    separation: bool = True
    mu: float = MU

    def __post_init__(self):
        n = len(self.g) // 3
        self.law = stack_laws([np.full(n, AREA)], [PenaltyCoulomb(self.mu, GAMMA)], [KN], [self.separation])
        self.e, self.work, self.path = np.zeros(2 * n), np.zeros(5), np.zeros(n)
        self.peak, self.peak_vector, self.start = np.zeros(n), np.zeros(2 * n), self.g.copy()
        self.t = self.trial(self.g)[0]

    def trial(self, g):
        """Traction, elastic slip and status at a trial displacement."""
        n = self.law.n
        t, e, status = np.zeros(3 * n), np.zeros(2 * n), np.zeros(n, np.int64)
        kernels.trial_traction(np.asarray(g, float), self.g, self.e, self.law, DT, t, e, status)
        return t, e, status

    def tangent(self, g):
        d = np.full((self.law.n, 3, 3), np.nan)
        kernels.consistent_tangent(np.asarray(g, float), self.g, self.e, self.law, DT, d)
        return d

    def move(self, g):
        """Commit the displacement g and book its work; returns traction and status."""
        g = np.asarray(g, float)
        t, e, status = self.trial(g)
        kernels.interface_work(self.g, self.e, self.t, g, e, t, self.law, self.work)
        kernels.record_slip(self.g, self.e, g, e, self.start, status, self.path, self.peak, self.peak_vector)
        self.g, self.e, self.t = g, e, t
        return t, status


def straight(path):
    """Displacements (n, 3) along the hoop direction at constant pressure."""
    return np.column_stack([path, np.zeros(len(path)), np.full(len(path), CLOSED)])


def through(turning, steps):
    """Values from each turning point to the next in equal ``steps``, first one left out."""
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(turning)])


def test_jenkins_loop_passes_its_eight_turning_points():
    """Loading to A, to -A and back: traction at each corner and zero crossing, elastic slip included.

    |tau| <= mu p, slope mu p / gamma* while sticking: a reversal at A slips again after 2 gamma*.
    """
    a, limit = 7.0 * GAMMA, MU * PRESSURE
    corners = {
        GAMMA: limit, a: limit, a - GAMMA: 0.0, a - 2 * GAMMA: -limit,
        -a: -limit, -a + GAMMA: 0.0, -a + 2 * GAMMA: limit,
    }  # fmt: skip
    expected = [*corners.items(), (a, limit)]
    point = Points()
    for g in straight(np.array([x for x, _ in expected])):
        traction, _ = point.move(g)
        assert traction[0] == pytest.approx(dict(expected)[g[0]], abs=1e-9 * limit)
        assert traction[1] == 0.0


def test_stick_and_slip_are_told_apart_at_the_elastic_slip():
    point = Points()
    assert point.move([0.999 * GAMMA, 0.0, CLOSED])[1] == kernels.STICK
    assert point.move([1.001 * GAMMA, 0.0, CLOSED])[1] == kernels.SLIP
    assert point.move([0.9 * GAMMA, 0.0, CLOSED])[1] == kernels.STICK


def test_loop_area_is_exact():
    """A closed loop of amplitude A dissipates 4 mu N (A - gamma*), by its area and by the ledger; none of it is stored.

    Steps end at the corners, so the trapezoidal rule is exact.
    """
    a = 6.0 * GAMMA
    point = Points()
    for g in straight(through([0.0, a], 12)):
        point.move(g)
    start, x, force = point.work.copy(), [point.g[0]], [point.t[0]]
    for g in straight(through([a, -a, a], 24)):
        point.move(g)
        x.append(point.g[0])
        force.append(point.t[0])
    exact = 4.0 * MU * PRESSURE * AREA * (a - GAMMA)
    friction, contact, modulation, total, impact = point.work - start
    assert AREA * trapezoid(force, x) == pytest.approx(exact, rel=1e-12)
    assert friction == pytest.approx(exact, rel=1e-12)
    assert total == pytest.approx(exact, rel=1e-12)
    assert contact == pytest.approx(0.0, abs=1e-12 * exact)
    assert modulation == pytest.approx(0.0, abs=1e-12 * exact)
    assert impact == pytest.approx(0.0, abs=1e-12 * exact)


def test_ledger_splits_the_work_of_any_path_completely():
    """Friction + stored + modulation = total work on a random closed path in all three directions."""
    rng = np.random.default_rng(3)
    steps = rng.standard_normal((400, 6)) * np.array([0.6, 0.6, 0.6, 0.6, 0.0, 0.0]) * GAMMA
    path = np.cumsum(steps, axis=0)
    path[:, 4:] = CLOSED * (1.0 + 0.5 * np.sin(np.linspace(0, 40, 400)))[:, None] * np.array([1.0, 0.7])
    points = Points(np.concatenate([np.zeros(4), path[0, 4:]]))
    independent = 0.0
    for g in path:
        before = points.g, points.t
        points.move(g)
        independent += AREA * 0.5 * (points.t + before[1]) @ (points.g - before[0])
    assert points.work[3] == pytest.approx(independent, rel=1e-12)
    assert points.work[:3].sum() == pytest.approx(points.work[3], rel=1e-10)
    assert points.work[0] > 0.0
    assert abs(points.work[2]) > 1e-3 * points.work[0]  # the pressure did vary


@pytest.mark.parametrize(
    ("g", "kind"),
    [
        ([0.4 * GAMMA, -0.5 * GAMMA, CLOSED], kernels.STICK),
        ([3.0 * GAMMA, 1.5 * GAMMA, CLOSED], kernels.SLIP),
        ([-0.6 * GAMMA, 2.0 * GAMMA, 1.7 * CLOSED], kernels.SLIP),
        ([0.3 * GAMMA, 0.2 * GAMMA, 0.2 * CLOSED], kernels.STICK),
        ([3.0 * GAMMA, 1.5 * GAMMA, -0.3 * CLOSED], kernels.OPEN),
    ],
    ids=["stick", "slip", "slip at higher pressure", "stick at lower pressure", "open"],
)
@pytest.mark.parametrize("separation", [True, False])
def test_tangent_is_the_derivative_of_the_traction(g, kind, separation):
    """Central differences in all three components, from a state with elastic slip; includes the pressure's column."""
    point = Points(separation=separation)
    point.move([0.3 * GAMMA, 0.2 * GAMMA, CLOSED])
    g, step = np.array(g), np.array([1e-5 * GAMMA, 1e-5 * GAMMA, 1e-5 * abs(CLOSED)])
    if separation:
        assert point.trial(g)[2] == kind
    differences = np.empty((3, 3))
    for j in range(3):
        shift = np.zeros(3)
        shift[j] = step[j]
        differences[:, j] = (point.trial(g + shift)[0] - point.trial(g - shift)[0]) / (2.0 * step[j])
    # central differences of the circular return map are second order: (1e-5)^2, and 1e-16 / 1e-5 of rounding
    scale = np.outer(np.ones(3), [STICK_STIFFNESS, STICK_STIFFNESS, KN])
    np.testing.assert_allclose(point.tangent(g)[0] / scale, differences / scale, atol=1e-8)


def test_trial_leaves_the_committed_state_alone():
    point = Points()
    point.move([3.0 * GAMMA, GAMMA, CLOSED])
    before = [array.copy() for array in (point.g, point.e, point.t, *point.law)]
    first = point.trial([-5.0 * GAMMA, 2.0 * GAMMA, -CLOSED])
    point.tangent([-5.0 * GAMMA, 2.0 * GAMMA, -CLOSED])
    for kept, array in zip(before, (point.g, point.e, point.t, *point.law), strict=True):
        np.testing.assert_array_equal(kept, array)
    again = point.trial([-5.0 * GAMMA, 2.0 * GAMMA, -CLOSED])
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("factor", [0.1, 0.5, 2.0, 10.0])
def test_limit_and_stick_stiffness_follow_the_pressure(factor):
    """At a held elastic slip the traction scales with the current pressure; so does the limit."""
    point = Points()
    point.move([0.5 * GAMMA, 0.0, CLOSED])
    held = point.trial([0.5 * GAMMA, 0.0, factor * CLOSED])[0]
    assert held[0] == pytest.approx(0.5 * factor * MU * PRESSURE, rel=1e-12)
    assert -held[2] == pytest.approx(factor * PRESSURE, rel=1e-12)
    assert point.tangent([0.5 * GAMMA, 0.0, factor * CLOSED])[0, 0, 0] == pytest.approx(factor * STICK_STIFFNESS)
    slipping = point.trial([50.0 * GAMMA, 0.0, factor * CLOSED])[0]
    assert slipping[0] == pytest.approx(factor * MU * PRESSURE, rel=1e-12)


def test_open_surfaces_carry_nothing_and_bilateral_ones_pull():
    apart = [0.5 * GAMMA, 0.2 * GAMMA, -0.5 * CLOSED]
    point = Points()
    point.move(apart)  # the step that opens it has a traction of its own: test_impact.py
    traction, _, status = point.trial(apart)
    np.testing.assert_array_equal(traction, 0.0)
    assert status == kernels.OPEN
    np.testing.assert_array_equal(point.tangent(apart), 0.0)
    traction, _, status = Points(separation=False).trial(apart)
    assert traction[2] == pytest.approx(0.5 * PRESSURE)  # tension, and tension has no friction
    np.testing.assert_array_equal(traction[:2], 0.0)
    assert status != kernels.OPEN


def test_no_work_is_done_while_open():
    point = Points()
    point.move([0.0, 0.0, -CLOSED])
    before = point.work.copy()
    for x in through([0.0, 8 * GAMMA, -8 * GAMMA, 0.0], 5):
        point.move([x, 0.5 * x, -CLOSED])
    np.testing.assert_array_equal(point.work, before)
    assert point.path[0] == 0.0


@pytest.mark.parametrize("angle", [0.3, np.pi / 2, 2.2, -1.0])
def test_friction_is_isotropic(angle):
    """Rotating a path of hoop and axial slip rotates the traction and leaves the work unchanged."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    phase = np.linspace(0.0, 4.0 * np.pi, 90)
    path = GAMMA * np.column_stack([3.0 * np.sin(phase), 1.7 * np.cos(2.0 * phase) - 1.7])
    plain, turned = Points(), Points()
    for x in path:
        a = plain.move([*x, CLOSED])[0]
        b = turned.move([*(turn @ x), CLOSED])[0]
        np.testing.assert_allclose(b[:2], turn @ a[:2], atol=1e-10 * MU * PRESSURE)
        assert np.hypot(a[0], a[1]) <= MU * PRESSURE * (1.0 + 1e-12)
    np.testing.assert_allclose(turned.work, plain.work, rtol=1e-10, atol=1e-12 * plain.work[0])
    assert turned.path == pytest.approx(plain.path, rel=1e-12)
    assert turned.peak == pytest.approx(plain.peak, rel=1e-12)


def test_slipping_traction_opposes_the_motion():
    """On a long straight way the traction turns into the direction of the relative motion, at its limit."""
    point = Points()
    point.move([5.0 * GAMMA, 0.0, CLOSED])
    for s in np.linspace(0.0, 200.0 * GAMMA, 100):
        point.move([5.0 * GAMMA + 0.6 * s, 0.8 * s, CLOSED])
    np.testing.assert_allclose(point.t[:2], MU * PRESSURE * np.array([0.6, 0.8]), rtol=1e-6)


def test_plastic_and_elastic_slip_add_up_to_the_relative_displacement():
    point = Points()
    turning = np.array([0.0, 5.0, -3.0, 4.0]) * GAMMA
    previous = 0.0
    for x, g in zip(through(turning, 40), straight(through(turning, 40)), strict=True):
        point.move(g)
        previous = x
    plastic = np.array([5.0 - 1.0, 8.0 - 2.0, 7.0 - 2.0]) * GAMMA  # each reversal first unwinds 2 gamma*
    assert point.path[0] == pytest.approx(plastic.sum(), rel=1e-12)
    assert plastic[0] - plastic[1] + plastic[2] + point.e[0] == pytest.approx(previous, rel=1e-12)
    assert point.peak[0] == pytest.approx(5.0 * GAMMA, rel=1e-12)
    np.testing.assert_allclose(point.peak_vector, [5.0 * GAMMA, 0.0], rtol=1e-12)


def test_frictionless_points_transmit_no_shear():
    point = Points(mu=0.0)
    traction, status = point.move([9.0 * GAMMA, 4.0 * GAMMA, CLOSED])
    np.testing.assert_array_equal(traction[:2], 0.0)
    assert traction[2] == pytest.approx(-PRESSURE)
    assert status == kernels.SLIP
    assert point.work[0] == 0.0


def test_stacked_interfaces_keep_their_slots_and_laws():
    """Operator rows (normal, hoop, axial) of two interfaces arrive in slots hoop, axial of each point, then normals."""
    rows = np.arange(1.0, 10.0)
    parts = []
    for first, mu in ((0, 0.1), (1, 0.4)):
        points = 1 + first
        operator = sp.csr_matrix(rows[3 * first : 3 * first + 3 * points, None] * np.array([[1.0, 0.0]]))
        parts.append(
            Interface(
                f"i{first}", operator, np.full(points, 1.0 + first), np.zeros((points, 3)),
                PenaltyCoulomb(mu, 1e-6 * (1 + first)), NormalPenalty(1e9 * (1 + first), separation=bool(first)),
            )
        )  # fmt: skip
    system = System(sp.identity(2, format="csr"), sp.identity(2, format="csr"), np.ones(2), tuple(parts))
    np.testing.assert_array_equal(system.jump.toarray()[:, 0], [2, 3, 5, 6, 8, 9, 1, 4, 7])
    np.testing.assert_array_equal(system.weights, [1, 1, 2, 2, 2, 2, 1, 2, 2])
    law = system.laws
    np.testing.assert_array_equal(law.mu, [0.1, 0.4, 0.4])
    np.testing.assert_array_equal(law.kn, [1e9, 2e9, 2e9])
    np.testing.assert_array_equal(law.gamma, [1e-6, 2e-6, 2e-6])
    np.testing.assert_array_equal(law.separation, [False, True, True])


def _trace(shift=0.0, n=3):
    points = np.column_stack([np.linspace(0.0, 2.0, n), np.full(n, 0.1 + shift), np.full(n, 0.04)])
    return Trace(sp.identity(3 * n, format="csr"), points, np.full(n, 1e-4))


LAWS = PenaltyCoulomb(0.2, 1e-6), NormalPenalty(1e10)


def test_facing_surfaces_give_outer_minus_inner():
    interface = facing("a/b", _trace(), _trace(), (slice(0, 9), slice(9, 18)), 18, *LAWS)
    u = np.concatenate([np.arange(9.0), 10.0 * np.arange(9.0)])
    np.testing.assert_allclose(interface.operator @ u, 9.0 * np.arange(9.0))


@pytest.mark.parametrize("other", [_trace(1e-4), _trace(n=4)], ids=["shifted", "finer"])
def test_surfaces_that_do_not_match_are_refused(other):
    width = other.operator.shape[1]
    with pytest.raises(InputError, match="a/b") as error:
        facing("a/b", _trace(), other, (slice(0, 9), slice(9, 9 + width)), 9 + width, *LAWS)
    assert error.value.remedy


@pytest.mark.parametrize(("mu", "gamma", "key"), [(-0.1, 1e-6, "mu"), (0.2, 0.0, "elastic_slip")])
def test_inadmissible_friction_is_refused(mu, gamma, key):
    with pytest.raises(InputError) as error:
        PenaltyCoulomb(mu, gamma)
    assert error.value.key == f"contact.friction.{key}"
