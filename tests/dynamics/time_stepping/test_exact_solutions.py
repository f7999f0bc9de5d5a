"""Friction, statics and stepping against exact solutions: Jenkins element, two leaves, Coulomb oscillator."""

import numpy as np
import pytest
from scipy.integrate import trapezoid
from support.exact_systems import (
    STEPPERS,
    TwoLeaves,
    contact_point,
    coulomb_oscillator,
    dense_system,
    interface_ledger,
    legs,
    stepper,
    unbalanced,
    with_preload,
)

from wroll_fem.dynamics.statics.preload import solve_load_path, solve_preload
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import FRICTION, MODULATION, NUMERICAL

BOTH = pytest.mark.parametrize("method", STEPPERS)


# --- Jenkins element --------------------------------------------------------------------------------------------------


def test_jenkins_element_loses_its_loop_area():
    """Spring k_1 and friction in series, parallel to k_2, under a load cycle of amplitude P.

    The friction branch carries at most mu N and sticks with k_s = 1 / (1/k_1 + gamma* / (mu N)), so it slips
    after delta = mu N / k_s. The load P = k_2 X + mu N gives the amplitude X, and a steady cycle loses
    4 mu N (X - delta). Steps end at the loop's corners, where F = +-P and F = +-(k_2 (X - 2 delta) - mu N).
    """
    k_1, k_2, force, mu, gamma, peak = 4.0e5, 1.0e5, 50.0, 0.4, 1.0e-6, 60.0
    point = contact_point([0, 0, 1], [0, 1, 0], [0, 0, 0], mu=mu, gamma=gamma, kn=1.0e9)
    k = [[k_1 + k_2, -k_1, 0.0], [-k_1, k_1, 0.0], [0.0, 0.0, 0.0]]
    system = dense_system(k, np.eye(3), [0, 0, 0], point, tip=[1, 0, 0], preload=[0, 0, -force])
    limit = mu * force
    x, delta = (peak - limit) / k_2, limit * (1.0 / k_1 + gamma / limit)
    corner = k_2 * (x - 2.0 * delta) - limit
    to_start, cycle = legs([0.0, peak], 10), legs([peak, corner, -peak, -corner, peak], 8)
    states = solve_load_path(system, with_preload(system, [1, 0, 0], [*to_start, *cycle]), solve_preload(system))[9:]
    tip = np.array([state.displacement[0] for state in states])
    exact = 4.0 * limit * (x - delta)
    assert tip[0] == pytest.approx(x, rel=1e-8)
    assert tip[8] == pytest.approx(x - 2.0 * delta, rel=1e-8)
    assert tip[16] == pytest.approx(-x, rel=1e-8)
    assert trapezoid([peak, *cycle], tip) == pytest.approx(
        exact, rel=1e-7
    )  # of the static residual, 1e-9 of all forces
    friction, stored, modulation, _, _ = interface_ledger(system, states)
    assert friction == pytest.approx(exact, rel=1e-7)
    assert abs(stored) + abs(modulation) < 1e-7 * exact


# --- two leaves -------------------------------------------------------------------------------------------------------


def leaf_cycle(leaves, amplitude, steps):
    """Load levels, states and deflections over 0 -> P -> -P -> P, with the index where the closed cycle starts."""
    loads = legs([0.0, amplitude, -amplitude, amplitude], steps)
    states = solve_load_path(
        leaves.system, with_preload(leaves.system, leaves.tip, loads), solve_preload(leaves.system)
    )
    return loads, states, np.array([leaves.tip @ state.displacement for state in states])


def test_two_leaf_cantilever_follows_goodman_and_klumpp():
    r"""Stiffness stuck and slipping, onset of slip, loop area, and the work of the plastic slips.

    Stuck, the two leaves are one section of 8 I_1: k_1 = 3 E (8 I_1) / L^3. The shear stress at mid-depth is
    3 P / (4 b h) all along and reaches mu p everywhere at P_s = 4/3 b h mu p. From there the interface carries
    the constant mu p, so that increments bend two separate leaves: k_2 = 3 E (2 I_1) / L^3. Steady cycles
    between +-P_m are parallelograms with sides (2 P_s / k_1, 2 P_s) and (2 (P_m - P_s) / k_2, 2 (P_m - P_s)), of area

    .. math:: D = 4 P_s (P_m - P_s) (1/k_2 - 1/k_1) = P_s (P_m - P_s) L^3 / (2 E I_1).

    Goodman and Klumpp (1956), J. Appl. Mech. 23, 421.
    """
    leaves, steps, ratio = TwoLeaves(gamma=1.0e-9), 12, 3.0
    p_s = leaves.slip_load
    loads, states, w = leaf_cycle(leaves, ratio * p_s, steps)
    stiffness = leaves.bending / leaves.length**3
    # elastic slip of 1e-9 m softens the stuck beam by 2e-5; see the next test
    assert loads[0] / w[0] == pytest.approx(24.0 * stiffness, rel=1e-4)
    slipping = np.array([np.mean(state.status == 1) for state in states[:steps]])
    below, above = loads[:steps] < 0.999 * p_s, loads[:steps] > 1.001 * p_s
    assert np.all(slipping[below] == 0.0)
    assert np.all(slipping[above] == 1.0)
    later = np.flatnonzero(above)[1:]
    np.testing.assert_allclose(np.diff(loads[later]) / np.diff(w[later]), 6.0 * stiffness, rtol=1e-6)
    exact = p_s * (ratio - 1.0) * p_s / (2.0 * stiffness)
    area = trapezoid(loads[steps - 1 :], w[steps - 1 :])
    friction, stored, modulation, _, _ = interface_ledger(leaves.system, states[steps - 1 :])
    assert area == pytest.approx(exact, rel=1e-4)
    assert friction == pytest.approx(area, rel=1e-7)
    assert abs(stored) + abs(modulation) < 1e-7 * area


def test_two_leaf_cantilever_converges_with_the_elastic_slip():
    """Errors of stuck stiffness and loop area fall in proportion to gamma*: 0.5 % already at 1e-6 m."""
    softness, losses = [], []
    gammas = np.array([1.0e-6, 1.0e-7, 1.0e-8])
    for gamma in gammas:
        leaves = TwoLeaves(gamma=gamma)
        p_s, stiffness = leaves.slip_load, leaves.bending / leaves.length**3
        loads, _, w = leaf_cycle(leaves, 3.0 * p_s, 12)
        softness.append(1.0 - loads[0] / w[0] / (24.0 * stiffness))
        losses.append(1.0 - trapezoid(loads[11:], w[11:]) / (p_s * 2.0 * p_s / (2.0 * stiffness)))
    assert 0.0 < losses[0] < 5e-3
    for errors in (softness, losses):
        slopes = np.diff(np.log(errors)) / np.diff(np.log(gammas))
        np.testing.assert_allclose(slopes, 1.0, atol=0.1)
        assert slopes[1] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("young", [210e9, 70e9, 2.4e9])
@pytest.mark.parametrize("steps", [1, 3])
def test_two_leaves_slip_all_at_once_in_every_material(young, steps):
    """Steps that end at the load at which all points reach the limit together, and beyond; eight elements."""
    leaves = TwoLeaves(young=young, elements=8)
    loads, _, w = leaf_cycle(leaves, leaves.slip_load, steps)
    stuck = 24.0 * leaves.bending / leaves.length**3
    assert loads[-1] / w[-1] == pytest.approx(stuck, rel=2e-3)  # gamma* softens it, most in steel
    _, _, w = leaf_cycle(leaves, 2.0 * leaves.slip_load, steps)
    exact = leaves.slip_load * (1.0 / stuck + 4.0 / stuck)
    assert w[steps - 1] == pytest.approx(exact, rel=2e-3)


def test_two_leaf_cantilever_is_exact_on_any_mesh():
    """The discrete leaves hold the stuck and the slipping solution: one element does as well as six."""
    area = []
    for elements in (1, 6):
        loads, _, w = leaf_cycle(TwoLeaves(elements=elements), 3.0 * TwoLeaves().slip_load, 12)
        area.append(trapezoid(loads[11:], w[11:]))
    assert area[0] == pytest.approx(area[1], rel=2e-5)


# --- Coulomb oscillator -----------------------------------------------------------------------------------------------


@BOTH
@pytest.mark.parametrize("gamma", [1.0e-8, 1.0e-5])
def test_coulomb_oscillator_loses_four_mu_n_over_k_per_cycle(method, gamma):
    """Each half cycle from x_0 to -x_1: k (x_0^2 - x_1^2) / 2 = mu N (x_0 + x_1 - 2 gamma*).

    The friction force first turns over, which takes 2 gamma* and no work, so that the amplitude falls by
    2 mu N / k (1 - 2 gamma* / (x_0 + x_1)); with gamma* -> 0 that is the classical 4 mu N / k per cycle.
    Turning points are parabolas through three steps. 400 steps per cycle leave errors of 1e-5 of the period and
    the force's turn in the middle of a step, 3e-4 of the drop at the smallest amplitude.
    """
    k, force, mu, x = 1.0e4, 10.0, 0.3, 0.01
    system = coulomb_oscillator(stiffness=k, force=force, mu=mu, gamma=gamma)
    dt = 2.0 * np.pi / np.sqrt(k) / 400
    run = stepper(method, system, solve_preload(system), Scheme.hht(0.0), dt)
    run.start_from(np.array([x, 0.0]))
    records = run.advance(np.zeros(400 * 4 + 11), dt, 0.0)
    u = np.abs(records[:, 0])
    peaks = [x]
    for i in np.flatnonzero((u[1:-1] > u[:-2]) & (u[1:-1] >= u[2:])) + 1:
        a, b, c = np.polyfit([-1, 0, 1], u[i - 1 : i + 2], 2)
        peaks.append(c - b * b / (4.0 * a))
    peaks = np.array(peaks)
    assert len(peaks) == 9
    exact = 2.0 * mu * force / k * (1.0 - 2.0 * gamma / (peaks[1:] + peaks[:-1]))
    np.testing.assert_allclose(-np.diff(peaks), exact, rtol=3e-4)
    if gamma < 1e-7:
        np.testing.assert_allclose(peaks[:-2:2] - peaks[2::2], 4.0 * mu * force / k, rtol=3e-4)


@BOTH
def test_released_energy_is_stored_or_rubbed_away(method):
    """Without numerical damping: initial strain energy = kinetic + strain + elastic slip + friction, to rounding."""
    system, x = coulomb_oscillator(), 0.01
    dt = 2.0 * np.pi / 100.0 / 60
    run = stepper(method, system, solve_preload(system), Scheme.hht(0.0), dt)
    run.start_from(np.array([x, 0.0]))
    records = run.advance(np.zeros(601), dt, 0.0)
    initial = 0.5 * 1.0e4 * x**2
    np.testing.assert_allclose(-unbalanced(records), initial, rtol=1e-8)
    assert records[-1, FRICTION] > 0.9 * initial
    assert np.all(np.diff(records[:, FRICTION]) >= -1e-9 * initial)
    np.testing.assert_allclose(records[:, NUMERICAL], 0.0, atol=1e-12 * initial)
    np.testing.assert_allclose(records[:, MODULATION], 0.0, atol=1e-9 * initial)


@BOTH
def test_friction_of_the_ledger_is_the_path_times_the_limit(method):
    """At constant pressure the friction work is mu N times the plastic path that the slip record accumulates."""
    system = coulomb_oscillator(gamma=1.0e-6)
    dt = 2.0 * np.pi / 100.0 / 200
    run = stepper(method, system, solve_preload(system), Scheme.hht(-0.05), dt)
    run.start_from(np.array([0.01, 0.0]))
    records = run.advance(np.zeros(601), dt, 0.0)
    # steps in which the traction turns over carry the mean traction: first order in gamma* / path
    assert records[-1, FRICTION] == pytest.approx(3.0 * run.slip.path[0], rel=2e-3)
    np.testing.assert_allclose(run.slip.peak, 0.01, rtol=1e-3)
