"""Statics and time stepping against exact solutions, each through the same `System` code as the roll."""

from itertools import pairwise

import numpy as np
import pytest
from exact_systems import (
    STEPPERS,
    TwoLeaves,
    contact_point,
    coulomb_oscillator,
    dense_system,
    interface_ledger,
    orbiting_mass,
    oscillator,
    slipping_pair,
    stepper,
    with_preload,
)
from scipy.integrate import trapezoid

from wroll_fem.dynamics.hht import Scheme
from wroll_fem.dynamics.static import ContactState, solve_load_path, solve_preload
from wroll_fem.dynamics.stepper import (
    CONTACT,
    FRICTION,
    INPUT,
    INTERFACE,
    ITERATIONS,
    KINETIC,
    MODULATION,
    NUMERICAL,
    OPEN,
    SLIPPING,
    STRAIN,
    NewtonOptions,
)
from wroll_fem.errors import ConvergenceError, InputError

BOTH = pytest.mark.parametrize("method", STEPPERS)


def unbalanced(records):
    """Input less everything it can have become, J per step."""
    return records[:, INPUT] - records[:, KINETIC : NUMERICAL + 1].sum(axis=1)


def rest(system):
    return solve_preload(system) if system.interfaces else ContactState.unloaded(system)


def legs(turning, steps):
    """Equal steps from each turning point to the next, the very first point left out."""
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(turning)])


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
    records = run.advance(np.zeros(400 * 6 + 11), dt, 0.0)
    u = np.abs(records[:, 0])
    peaks = [x]
    for i in np.flatnonzero((u[1:-1] > u[:-2]) & (u[1:-1] >= u[2:])) + 1:
        a, b, c = np.polyfit([-1, 0, 1], u[i - 1 : i + 2], 2)
        peaks.append(c - b * b / (4.0 * a))
    peaks = np.array(peaks)
    assert len(peaks) == 13
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
    records = run.advance(np.zeros(1001), dt, 0.0)
    # steps in which the traction turns over carry the mean traction: first order in gamma* / path
    assert records[-1, FRICTION] == pytest.approx(3.0 * run.slip.path[0], rel=2e-3)
    np.testing.assert_allclose(run.slip.peak, 0.01, rtol=1e-3)


# --- linear dynamics --------------------------------------------------------------------------------------------------


@BOTH
@pytest.mark.parametrize("ratio", [0.3, 0.8, 1.3, 2.5])
def test_transmissibility_of_one_mass_is_the_closed_form(method, ratio):
    """A sine base motion of frequency r f_0 from rest: T = |A_tip + A_g| / |A_g| = 1 / |1 - r^2|.

    The motion is exactly the sum of sines at both frequencies; least squares separates them. Second-order steps
    lower the natural frequency by (omega h)^2 / 12, which 1 / (1 - r^2) amplifies: with 200 steps per cycle of the
    faster motion the closed form with that frequency is met to 1e-6, the exact one to 5e-4.
    """
    f_0, a_g = 10.0, 3.0
    system = oscillator(f_0)
    dt = 1.0 / (f_0 * max(1.0, ratio)) / 200
    time = dt * np.arange(int(5.0 / (f_0 * dt)) + 1)
    base = a_g * np.sin(2 * np.pi * ratio * f_0 * time)
    run = stepper(method, system, rest(system), Scheme.hht(0.0), dt)
    absolute = run.advance(base, dt, 0.0)[:, 2] + base[1:]
    discrete = np.arctan(np.pi * f_0 * dt) / (np.pi * dt)  # Hz, of the trapezoidal rule
    phases = 2 * np.pi * time[1:, None] * np.array([ratio * f_0, discrete])
    fit = np.linalg.lstsq(np.hstack([np.sin(phases), np.cos(phases)]), absolute, rcond=None)[0]
    measured = np.hypot(fit[0], fit[2]) / a_g * np.sign(fit[0])
    stepped = np.tan(np.pi * ratio * f_0 * dt) / (np.pi * f_0 * dt)
    assert measured == pytest.approx(1.0 / (1.0 - stepped**2), rel=1e-6)
    assert measured == pytest.approx(1.0 / (1.0 - ratio**2), rel=5e-4)


def final_error(method, scheme, steps):
    """Error of displacement and velocity of two coupled masses after a cycle of free motion, against their modes."""
    k, m = np.array([[3.0, -1.0], [-1.0, 2.0]]) * 1.0e3, np.diag([2.0, 1.0])
    system = dense_system(k, m, [1, 1], tip=[0, 1])
    root = np.diag(1.0 / np.sqrt(np.diag(m)))
    squares, shapes = np.linalg.eigh(root @ k @ root)
    start, end = np.array([1.0e-3, -0.5e-3]), 0.3
    q = shapes.T @ np.linalg.solve(root, start)
    omega = np.sqrt(squares)
    exact = np.array(
        [(root @ shapes @ (q * np.cos(omega * end)))[1], -(root @ shapes @ (q * omega * np.sin(omega * end)))[1]]
    )
    run = stepper(method, system, rest(system), scheme, end / steps)
    run.start_from(start)
    record = run.advance(np.zeros(steps + 1), end / steps, 0.0)[-1]
    return np.abs(record[:2] - exact) / np.array([1.0e-3, 1.0e-3 * omega[0]])


@BOTH
@pytest.mark.parametrize(
    ("scheme", "order", "bound"),
    [
        (Scheme.hht(0.0), 2, 2.5e-3),
        (Scheme.hht(-0.1), 2, 3e-3),
        (Scheme.hht(-0.3), 2, 3.5e-3),
        (Scheme.named("transient_fidelity"), 2, 3e-3),
        (Scheme.named("moderate_dissipation"), 2, 3.5e-3),
        (Scheme.named("quasi_static"), 1, 0.26),
    ],
    ids=["newmark", "-0.1", "-0.3", "transient_fidelity", "moderate_dissipation", "backward Euler"],
)
def test_hht_order_table(method, scheme, order, bound):
    """Slope of the error over halved steps, and its size at 400 steps (60 to 40 per cycle of the two modes)."""
    errors = np.array([final_error(method, scheme, steps) for steps in (400, 800, 1600)])
    slopes = np.log2(errors[:-1] / errors[1:])
    np.testing.assert_allclose(slopes, order, atol=0.02 if order == 2 else 0.12)
    assert np.all(errors[0] < bound)


def test_schemes_have_the_parameters_of_the_source():
    """Table B.1: beta = (1 - alpha)^2 / 4, gamma = 1/2 - alpha; outside the stable range is refused."""
    for name, alpha, beta, gamma in (
        ("transient_fidelity", -0.05, 0.275625, 0.55),
        ("moderate_dissipation", -0.41421, 0.5, 0.91421),
        ("no_damping", 0.0, 0.25, 0.5),
        ("quasi_static", 0.0, 1.0, 1.5),
    ):
        found = Scheme.named(name)
        np.testing.assert_allclose([found.alpha, found.beta, found.gamma], [alpha, beta, gamma], atol=1e-5)
    for alpha in (0.01, -0.42):
        with pytest.raises(InputError):
            Scheme.hht(alpha)
    with pytest.raises(InputError, match="trapezoid"):
        Scheme.named("trapezoid")


@BOTH
@pytest.mark.parametrize("alpha", [0.0, -0.05, -0.3, -0.41421, None])
def test_numerical_dissipation_is_the_energy_a_free_oscillator_loses(method, alpha):
    """20 steps per period: the scheme's own term of the ledger accounts for every joule that goes."""
    scheme = Scheme.named("quasi_static") if alpha is None else Scheme.hht(alpha)
    system, x = oscillator(10.0), 1.0e-3
    run = stepper(method, system, rest(system), scheme, 0.005)
    run.start_from(np.array([x]))
    records = run.advance(np.zeros(201), 0.005, 0.0)
    initial = 0.5 * system.stiffness[0, 0] * x**2
    lost = initial - records[:, KINETIC] - records[:, STRAIN]
    np.testing.assert_allclose(records[:, NUMERICAL], lost, atol=1e-10 * initial)
    if alpha == 0.0:
        assert abs(lost[-1]) < 1e-10 * initial
    else:
        assert lost[-1] > 1e-3 * initial


# --- energy, steps, state ---------------------------------------------------------------------------------------------


def shaken_pair(method, scheme, *, steps=1500, amplitude=20.0, options=None):
    """Stepper and records of two rubbing masses under a sine of 14 Hz, 100 steps per cycle."""
    system = slipping_pair()
    dt = 1.0 / 14.0 / 100
    base = amplitude * np.sin(2 * np.pi * 14.0 * dt * np.arange(steps + 1))
    run = stepper(method, system, solve_preload(system), scheme, dt, options)
    return run, base, dt


@BOTH
@pytest.mark.parametrize("alpha", [0.0, -0.05, -0.3, -0.41421, None])
def test_energy_balance_closes_in_slip_with_varying_pressure(method, alpha):
    """Input = kinetic + strain + contact + friction + modulation + numerical at every step, to Newton's tolerance."""
    scheme = Scheme.named("quasi_static") if alpha is None else Scheme.hht(alpha)
    run, base, dt = shaken_pair(method, scheme)
    records = run.advance(base, dt, 0.0)
    assert np.mean(records[:, SLIPPING]) > 0.5
    assert records[:, OPEN].max() == 0.0
    assert abs(records[-1, MODULATION]) > 1e-9 * records[-1, FRICTION]
    scale = records[-1, INPUT]
    assert np.abs(unbalanced(records)).max() < 1e-8 * scale
    parts = records[:, FRICTION] + records[:, CONTACT] + records[:, MODULATION]
    assert np.abs(parts - records[:, INTERFACE]).max() < 1e-8 * scale


@pytest.mark.parametrize("alpha", [0.0, -0.3, None])
def test_steppers_agree_on_two_rubbing_masses(alpha):
    """Full and condensed share only the contact law; Newton's tolerance is 1e-8 of the elastic slip."""
    scheme = Scheme.named("quasi_static") if alpha is None else Scheme.hht(alpha)
    results = []
    for method in STEPPERS:
        run, base, dt = shaken_pair(method, scheme)
        results.append(run.advance(base, dt, 0.0))
    full, condensed = results
    for column in (0, 1, 2, INPUT, FRICTION, STRAIN):
        scale = np.abs(full[:, column]).max()
        np.testing.assert_allclose(condensed[:, column], full[:, column], atol=1e-7 * scale)


@BOTH
def test_slip_in_two_directions_follows_small_steps(method):
    """A mass on an orbit slips all the time, its traction turning: both steppers converge to one motion."""
    system, end = orbiting_mass(), 0.25
    tips = []
    for steps in (400, 800, 1600):
        dt = end / steps
        run = stepper(method, system, solve_preload(system), Scheme.hht(-0.05), dt)
        run.start_from(np.array([0.0, 0.004, 0.0]))
        records = run.advance(40.0 * np.sin(2 * np.pi * 16.0 * dt * np.arange(steps + 1)), dt, 0.0)
        tips.append(records[-1, 0])
        assert np.mean(records[:, SLIPPING]) > 0.9
    assert abs(tips[1] - tips[2]) < 0.3 * abs(tips[0] - tips[1])
    assert abs(tips[1] - tips[2]) < 1e-3 * abs(tips[2])


def orbit(method, options):
    """The orbiting mass at 16 steps per cycle, where the traction turns by a large angle in each step."""
    system, dt = orbiting_mass(), 1.0 / 256.0
    run = stepper(method, system, solve_preload(system), Scheme.hht(-0.05), dt, options)
    run.start_from(np.array([0.0, 0.004, 0.0]))
    return run, 40.0 * np.sin(2 * np.pi * 16.0 * dt * np.arange(201)), dt


@BOTH
def test_a_step_that_fails_is_cut(method):
    """With few Newton iterations allowed some steps are halved; the run goes on and its ledger still closes."""
    run, base, dt = orbit(method, NewtonOptions(max_iterations=5, max_cuts=8))
    records = run.advance(base, dt, 0.0)
    assert 0 < run.cuts < 200
    assert np.abs(
        records[:, INPUT] + 0.5 * 1.2e4 * 0.004**2 - records[:, KINETIC : NUMERICAL + 1].sum(axis=1)
    ).max() < (1e-8 * records[-1, INPUT])
    free, base, dt = orbit(method, NewtonOptions())
    reference = free.advance(base, dt, 0.0)
    # cut steps are finer, not the same: the motions differ by the error of a coarse step
    assert np.abs(records[:, 0] - reference[:, 0]).max() < 0.3 * np.abs(reference[:, 0]).max()


@BOTH
@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("value", [np.inf, np.nan])
def test_an_impossible_step_raises_and_keeps_the_last_good_state(method, value):
    """A base motion that breaks off: time, iterations, residuals and advice are told, nothing of it is committed."""
    run, base, dt = shaken_pair(
        method, Scheme.hht(-0.05), steps=300, options=NewtonOptions(max_iterations=12, max_cuts=3)
    )
    good, *_ = shaken_pair(method, Scheme.hht(-0.05), steps=300)
    good.advance(base[:201], dt, 0.0)
    base[201] = value
    with pytest.raises(ConvergenceError) as error:
        run.advance(base, dt, 0.0)
    assert error.value.time_s == pytest.approx(200 * dt)
    assert error.value.iterations == 12
    assert len(error.value.residual_history) > 0
    assert "steps_per_cycle" in error.value.advice
    assert "t = " in str(error.value)
    kept, expected = run.snapshot(), good.snapshot()
    for name, values in expected.items():
        np.testing.assert_array_equal(kept[name], values, err_msg=name)
    base[201] = 0.0
    assert np.all(np.isfinite(run.advance(base[200:], dt, 200 * dt)))


@BOTH
def test_newton_that_may_not_iterate_raises(method):
    """A tolerance out of reach ends in an error with the history of residuals, not in a result."""
    run, base, dt = orbit(method, NewtonOptions(max_iterations=1, max_cuts=2))
    before = run.snapshot()
    with pytest.raises(ConvergenceError) as error:
        run.advance(base, dt, 0.0)
    assert error.value.time_s == 0.0
    assert error.value.iterations == 1
    assert "cut 2 times" in error.value.advice
    for name, values in run.snapshot().items():
        np.testing.assert_array_equal(before[name], values, err_msg=name)


@BOTH
def test_a_cut_that_fails_half_way_leaves_nothing_behind(method, monkeypatch):
    """The first part of a cut step succeeds, a later one does not: the state goes back to the start of the step."""
    run, base, dt = shaken_pair(method, Scheme.hht(-0.05), options=NewtonOptions(max_cuts=3))
    run.advance(base[:201], dt, 0.0)
    before, original, done = run.snapshot(), run.try_steps, []

    def only_the_first_part(acceleration, step, records):
        if step < dt:
            done.append(original(acceleration[:2], step, records[:1]))
        return 1 if step < dt else 0

    monkeypatch.setattr(run, "try_steps", only_the_first_part)
    with pytest.raises(ConvergenceError, match="cut 3 times"):
        run.advance(base[200:], dt, 200 * dt)
    assert done == [1, 1, 1]
    for name, values in run.snapshot().items():
        np.testing.assert_array_equal(values, before[name], err_msg=name)


@BOTH
def test_restored_run_repeats_bit_by_bit(method):
    """Same numbers from the same stepper gone back and from a new one that was given the snapshot."""
    run, base, dt = shaken_pair(method, Scheme.hht(-0.05), amplitude=40.0)
    run.advance(base[:801], dt, 0.0)
    saved = run.snapshot()
    first = run.advance(base[800:], dt, 800 * dt)
    end = run.snapshot()
    run.restore(saved)
    again = run.advance(base[800:], dt, 800 * dt)
    fresh = shaken_pair(method, Scheme.hht(-0.05))[0]
    fresh.restore(saved)
    other = fresh.advance(base[800:], dt, 800 * dt)
    np.testing.assert_array_equal(again, first)
    np.testing.assert_array_equal(other, first)
    for name, values in fresh.snapshot().items():
        np.testing.assert_array_equal(values, end[name], err_msg=name)
    assert first[:, ITERATIONS].max() > 1


def test_full_newton_does_not_alternate_at_an_impact():
    """Surfaces that open and land hard: backtracking finds each step, where full steps went to and fro for ever."""
    k = 1.0e4 * np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, 0.3], [0.0, 0.3, 1.0]])
    point = contact_point([0, 0, 1], [-1, 1, 0], [0, 0, 0], mu=0.3, gamma=2.0e-6, kn=1.0e8)
    system = dense_system(k, np.diag([1.0, 0.5, 0.5]), [1, 1, 0], point, tip=[0, 1, 0], preload=[0, 0, -20.0])
    dt = 1.0 / 2000.0
    run = stepper("full", system, solve_preload(system), Scheme.hht(0.0), dt)
    records = run.advance(40.0 * np.sin(2 * np.pi * 20.0 * dt * np.arange(1501)), dt, 0.0)
    assert records[:, OPEN].max() == 1.0
    assert np.all(np.isfinite(records))
