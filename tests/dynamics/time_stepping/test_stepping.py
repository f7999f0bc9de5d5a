"""Steps of rubbing systems: energy, agreement of the steppers, failures, cuts, restored states."""

import numpy as np
import pytest
from support.exact_systems import (
    STEPPERS,
    contact_point,
    dense_system,
    orbiting_mass,
    slipping_pair,
    stepper,
    unbalanced,
)

from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import (
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
)
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.errors import ConvergenceError

BOTH = pytest.mark.parametrize("method", STEPPERS)


def shaken_pair(method, scheme, *, steps=600, amplitude=20.0, options=None):
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
    system, end = orbiting_mass(), 0.125
    tips = []
    for steps in (200, 400, 800):
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
    return run, 40.0 * np.sin(2 * np.pi * 16.0 * dt * np.arange(101)), dt


@BOTH
def test_a_step_that_fails_is_cut(method):
    """With few Newton iterations allowed some steps are halved; the run goes on and its ledger still closes."""
    run, base, dt = orbit(method, NewtonOptions(max_iterations=5, max_cuts=8))
    records = run.advance(base, dt, 0.0)
    assert 0 < run.cuts < 100
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
    run.advance(base[:301], dt, 0.0)
    saved = run.snapshot()
    first = run.advance(base[300:], dt, 300 * dt)
    end = run.snapshot()
    run.restore(saved)
    again = run.advance(base[300:], dt, 300 * dt)
    fresh = shaken_pair(method, Scheme.hht(-0.05))[0]
    fresh.restore(saved)
    other = fresh.advance(base[300:], dt, 300 * dt)
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
    run = stepper("full", system, solve_preload(system), Scheme.hht(0.0), dt, NewtonOptions(max_cuts=0))
    records = run.advance(40.0 * np.sin(2 * np.pi * 20.0 * dt * np.arange(401)), dt, 0.0)
    assert records[:, OPEN].max() == 1.0
    assert np.all(np.isfinite(records))


@BOTH
@pytest.mark.parametrize(
    ("gamma", "remedy"),
    [(2e-6, "raise integrator.steps_per_cycle or solver.max_cuts"), (1e-13, "raise contact.friction.elastic_slip")],
)
def test_a_step_that_fails_on_nearly_rigid_friction_names_the_elastic_slip(method, gamma, remedy):
    """Smaller steps do not help where a point changes between stick and slip within a part of any step."""
    system, scheme, dt = slipping_pair(gamma=gamma), Scheme.hht(-0.05), 1.0 / 14.0 / 100
    run = stepper(method, system, solve_preload(system), scheme, dt, NewtonOptions(max_iterations=1, max_cuts=2))
    run.start_from(np.array([1e-4, 2e-4, 0.0]))
    with pytest.raises(ConvergenceError) as told:
        run.advance(20.0 * np.sin(2 * np.pi * 14.0 * dt * np.arange(200)), dt, 0.0)
    assert remedy in str(told.value)
