"""Rate-dependent and regularised Coulomb friction: points by hand, then the time steppers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from support.exact_systems import (
    STEPPERS,
    contact_point,
    dense_system,
    orbiting_mass,
    slipping_pair,
    stepper,
    with_law,
)
from support.friction_point import AREA, CLOSED, GAMMA, KN, MU, PRESSURE, V0, Point

from wroll_fem.contact import kernels
from wroll_fem.contact.bouc_wen import BoucWen
from wroll_fem.contact.elastic_coulomb import ElasticCoulomb
from wroll_fem.contact.laws import PenaltyCoulomb, RateCoulomb, SmoothedCoulomb, stack_laws
from wroll_fem.contact.polynomial_spring import PolynomialSpring
from wroll_fem.contact.rate_coulomb import coefficient
from wroll_fem.contact.smoothed_coulomb import regularised_sign
from wroll_fem.dynamics.statics.contact_springs import reference_stiffness, stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import (
    CONTACT,
    FRICTION,
    INPUT,
    INTERFACE,
    KINETIC,
    MODULATION,
    NUMERICAL,
    OPEN,
    RECORDS,
    SLIPPING,
    STRAIN,
)
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.errors import ConvergenceError, InputError

RATES, COEFFICIENTS = (0.0, 0.008, 0.02, 0.1), (MU, MU, 0.3, 0.42)
PENALTY = PenaltyCoulomb(MU, GAMMA)
RATE = RateCoulomb(MU, GAMMA, RATES, COEFFICIENTS)
SMOOTHED = SmoothedCoulomb(MU, V0)
BOUC_WEN = BoucWen(MU, GAMMA, 1.5, 0.7)
POLYNOMIAL = PolynomialSpring(GAMMA, (0.4, 0.3, 0.5))
ELASTIC = ElasticCoulomb(MU, GAMMA, MU * PRESSURE / GAMMA)
LAWS = pytest.mark.parametrize(
    "law", [PENALTY, RATE, SMOOTHED, BOUC_WEN, POLYNOMIAL, ELASTIC],
    ids=["penalty", "rate", "smoothed", "bouc_wen", "polynomial", "elastic"],
)  # fmt: skip
BOTH = pytest.mark.parametrize("method", STEPPERS)


# --- rate-dependent coefficient ---------------------------------------------------------------------------------------


def test_a_constant_table_is_penalty_coulomb():
    """A table that does not vary, and any table in statics, gives the numbers of the penalty law bit by bit."""
    rng = np.random.default_rng(5)
    path = np.cumsum(rng.standard_normal((300, 3)) * GAMMA * np.array([0.7, 0.7, 0.0]), axis=0)
    path[:, 2] = CLOSED * (1.0 + 0.6 * np.sin(np.linspace(0.0, 20.0, 300)))
    flat = RateCoulomb(MU, GAMMA, (0.0, 0.1), (MU, MU))
    for law, dt in ((flat, 1e-4), (flat, np.inf), (RATE, np.inf)):
        plain, point = Point(PENALTY), Point(law)
        for g in path:
            np.testing.assert_array_equal(point.tangent(g, dt), plain.tangent(g, dt))
            np.testing.assert_array_equal(point.move(g, dt)[0], plain.move(g, 1e-4)[0])
        np.testing.assert_array_equal(point.work, plain.work)
        assert point.work[0] > 0.0


@pytest.mark.parametrize("speed", [0.001, 0.008, 0.014, 0.02, 0.05, 0.0999, 0.1, 0.3])
@pytest.mark.parametrize("angle", [0.0, 2.1])
def test_sliding_at_constant_velocity_meets_the_table(speed, angle):
    """Steady sliding at V carries mu(V) p against the motion, whatever the step."""
    expected = np.interp(speed, RATES, COEFFICIENTS) * PRESSURE
    for dt in (1e-3, 1e-4):
        point = Point(RATE)
        direction = np.array([np.cos(angle), np.sin(angle)])
        for i in range(1, 50 + int(20 * GAMMA / (speed * dt))):
            traction, status = point.move([*(speed * dt * i * direction), CLOSED], dt)
        np.testing.assert_allclose(traction[:2], expected * direction, rtol=1e-12, atol=1e-12 * expected)
        assert status == kernels.SLIP


def test_the_table_is_linear_between_its_rows_and_constant_beyond():
    rates, mus = np.array([[0.0, 9.0, 9.0], [0.0, 1.0, 3.0]]), np.array([[0.1, 0.2, 0.2], [0.5, 0.3, 0.7]])
    expected = {
        (0, 0.0): (0.1, 0.1 / 9), (0, 4.5): (0.15, 0.1 / 9), (0, 9.0): (0.2, 0.0), (0, 1e300): (0.2, 0.0),
        (1, 0.0): (0.5, -0.2), (1, 0.5): (0.4, -0.2), (1, 1.0): (0.3, 0.2), (1, 2.0): (0.5, 0.2), (1, 3.0): (0.7, 0.0),
    }  # fmt: skip
    for (row, speed), value in expected.items():
        assert coefficient(speed, row, np.stack([rates, mus], axis=1)) == pytest.approx(value, rel=1e-14)
    assert coefficient(4.0, 0, np.array([[[0.0], [0.3]]])) == (0.3, 0.0)


def test_points_keep_their_own_laws_and_tables():
    """Interfaces with different laws and tables of different length, stacked."""
    other = RateCoulomb(0.1, 1e-6, (0.0, 0.05), (0.1, 0.9))
    law = stack_laws([np.ones(1)] * 4, [RATE, PENALTY, other, SMOOTHED], [KN] * 4, [True] * 4)
    dt, speed = 1e-3, 0.06
    g = np.concatenate([np.tile([speed * dt, 0.0], 4), np.full(4, CLOSED)])
    t, e, status = np.zeros(12), np.zeros(8), np.zeros(4, np.int64)
    kernels.trial_traction(g, np.zeros(12), np.zeros(8), law, dt, t, e, status)
    mus = [np.interp(speed, RATES, COEFFICIENTS), MU, 0.9, MU * np.tanh(0.5 * speed / V0)]
    np.testing.assert_allclose(t[0:8:2], np.array(mus) * PRESSURE, rtol=1e-13)
    assert list(law.kind) == [1, 0, 1, 2]


@pytest.mark.parametrize(
    ("mu", "rates", "coefficients", "key"),
    [
        (0.2, (0.0, 1.0), (0.2,), "rate_table"),
        (0.2, (0.1, 1.0), (0.2, 0.3), "rate_table"),
        (0.2, (0.0, 1.0, 0.5), (0.2, 0.3, 0.4), "rate_table"),
        (0.2, (0.0, 1.0), (0.2, -0.1), "rate_table"),
        (0.0, (0.0, 1.0), (0.0, 0.1), "rate_table"),
        (0.3, (0.0, 1.0), (0.2, 0.1), "mu"),
    ],
)
def test_inadmissible_tables_are_refused(mu, rates, coefficients, key):
    with pytest.raises(InputError) as error:
        RateCoulomb(mu, GAMMA, rates, coefficients)
    assert error.value.key == f"contact.friction.{key}"
    assert error.value.remedy


# --- smoothed sign ----------------------------------------------------------------------------------------------------


def test_smoothed_sign_is_the_logistic_function_of_equation_5_4():
    """Claim C77: S(x) = 2 / (1 + exp(-x)) - 1 = tanh(x / 2); slope 1/2 at zero; no overflow, no cancellation."""
    x = np.concatenate([np.linspace(-30.0, 30.0, 2001), [-700.0, 700.0]])
    s = np.array([regularised_sign(v) for v in x])
    np.testing.assert_allclose(s, 2.0 / (1.0 + np.exp(-x)) - 1.0, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(s, np.tanh(x / 2.0), rtol=0.0, atol=1e-14)
    assert [round(regularised_sign(1.0), 4), round(regularised_sign(5.0), 5)] == [0.4621, 0.98661]
    assert [regularised_sign(v) for v in (-1e308, -1e4, 0.0, 1e4, 1e308, np.inf)] == [-1.0, -1.0, 0.0, 1.0, 1.0, 1.0]
    assert regularised_sign(1e-12) == pytest.approx(5e-13, rel=1e-14)


def cycle_dissipation(law, amplitude, omega, steps, pressure=lambda phase: 1.0 + 0.0 * phase):
    """Friction work and energy left in the contact over one steady cycle of a point that moves as sin(omega t)."""
    dt = 2.0 * np.pi / omega / steps
    phase = omega * dt * np.arange(-1, steps + 1)
    path = np.column_stack([0.6 * amplitude * np.sin(phase), 0.8 * amplitude * np.sin(phase), CLOSED * pressure(phase)])
    point = Point(law, path[0])
    point.move(path[1], dt)
    before = point.work.copy()
    for g in path[2:]:
        point.move(g, dt)
    return point, point.work - before


@pytest.mark.parametrize("ratio", [0.2, 1.0, 4.0])
def test_smoothed_friction_of_a_sine_dissipates_its_integral(ratio):
    """Per cycle: integral of mu p S(|V| / V_0) |V| dt; second order in the step, 1e-6 at 4000 steps."""
    omega = 2.0 * np.pi * 150.0
    amplitude = ratio * V0 / omega

    def modulation(phase):
        return 1.0 + 0.4 * np.sin(2.0 * phase) ** 2

    def power(phase):
        speed = amplitude * omega * abs(np.cos(phase))
        return MU * PRESSURE * modulation(phase) * (2.0 / (1.0 + np.exp(-speed / V0)) - 1.0) * speed

    half = 0.5 * np.pi
    exact = AREA * sum(quad(power, i * half, (i + 1) * half, epsabs=0, epsrel=1e-12)[0] for i in range(4)) / omega
    errors = []
    for steps in (2000, 4000):
        point, work = cycle_dissipation(SMOOTHED, amplitude, omega, steps, modulation)
        errors.append(abs(work[0] / exact - 1.0))
        assert abs(work[1]) < 1e-9 * exact  # the normal penalty alone stores, and gives back
        assert abs(work[2]) < 1e-15 * exact
    assert errors[1] < 1e-6
    assert errors[1] < 0.3 * errors[0]
    np.testing.assert_array_equal(point.e, 0.0)


def test_slow_smoothed_friction_is_a_damper_of_half_the_limit():
    """Far below V_0 the point is a dashpot mu p / (2 V_0): pi c omega A^2 per cycle (the slope 1/2 of S)."""
    omega = 2.0 * np.pi * 150.0
    amplitude = 1e-3 * V0 / omega
    exact = np.pi * AREA * MU * PRESSURE / (2.0 * V0) * omega * amplitude**2
    assert cycle_dissipation(SMOOTHED, amplitude, omega, 4000)[1][0] == pytest.approx(exact, rel=2e-6)


def test_smoothed_friction_tends_to_coulomb_as_the_reference_speed_falls():
    """4 mu N A per cycle is approached from below; what is missing falls with the square of V_0."""
    omega, amplitude = 2.0 * np.pi * 150.0, 2.0e-5
    limit = 4.0 * MU * PRESSURE * AREA * amplitude
    missing = []
    for fraction in (0.04, 0.02, 0.01):
        law = SmoothedCoulomb(MU, fraction * amplitude * omega)
        missing.append(1.0 - cycle_dissipation(law, amplitude, omega, 8000)[1][0] / limit)
    assert 0.0 < missing[2] < 2e-4
    assert missing[0] / missing[1] == pytest.approx(4.0, rel=0.02)
    assert missing[1] / missing[2] == pytest.approx(4.0, rel=0.02)


def test_smoothed_friction_counts_as_slip_above_its_reference_speed():
    point, dt = Point(SMOOTHED), 1e-4
    assert point.move([0.9 * V0 * dt, 0.0, CLOSED], dt)[1] == kernels.STICK
    assert point.path[0] == 0.0
    assert point.move([0.9 * V0 * dt + 3.0 * V0 * dt, 0.0, CLOSED], dt)[1] == kernels.SLIP
    assert point.path[0] == pytest.approx(3.0 * V0 * dt, rel=1e-12)
    assert point.move([0.0, 0.0, -CLOSED], dt)[1] == kernels.OPEN


def test_smoothed_friction_holds_nothing_at_rest():
    point = Point(SMOOTHED)
    for g in ([3e-5, 1e-5, CLOSED], [3e-5, 2e-5, 3.0 * CLOSED]):
        traction = point.trial(g, np.inf)[0]
        np.testing.assert_array_equal(traction[:2], 0.0)
        np.testing.assert_array_equal(point.tangent(g, np.inf)[:2], 0.0)
        assert traction[2] == pytest.approx(KN * g[2])
    np.testing.assert_array_equal(point.move([4e-5, 0.0, CLOSED], 1e-4)[0][1], 0.0)
    np.testing.assert_array_equal(point.move([4e-5, 0.0, CLOSED], 1e-4)[0][:2], 0.0)  # stopped


@pytest.mark.parametrize(("mu", "speed", "key"), [(-0.1, 1e-3, "mu"), (0.2, 0.0, "reference_speed")])
def test_inadmissible_smoothing_is_refused(mu, speed, key):
    with pytest.raises(InputError) as error:
        SmoothedCoulomb(mu, speed)
    assert error.value.key == f"contact.friction.{key}"


# --- all laws ---------------------------------------------------------------------------------------------------------


@LAWS
@pytest.mark.parametrize("speed", [0.0005, 0.004, 0.013, 0.06, 0.5])
@pytest.mark.parametrize("pressure", [0.3, 1.0, 1.9, -0.5])
def test_tangent_is_the_derivative_of_the_traction(law, speed, pressure):
    """Central differences in all three components, the increment at an angle to the elastic slip."""
    point, dt = Point(law), 1e-4
    point.move([0.7 * GAMMA, -0.4 * GAMMA, CLOSED], dt)
    g = point.g + np.array([0.8 * speed * dt, 0.6 * speed * dt, (pressure - 1.0) * CLOSED])
    step = np.array([1e-5 * speed * dt, 1e-5 * speed * dt, 1e-5 * abs(CLOSED)])
    differences = np.empty((3, 3))
    for j in range(3):
        shift = np.zeros(3)
        shift[j] = step[j]
        differences[:, j] = (point.trial(g + shift, dt)[0] - point.trial(g - shift, dt)[0]) / (2.0 * step[j])
    tangent = point.tangent(g, dt)
    # rounding of the normal gap's sum, 1e-16 / 1e-5, and second order in the step
    scale = np.outer([MU * PRESSURE, MU * PRESSURE, PRESSURE], 1.0 / np.array([speed * dt, speed * dt, abs(CLOSED)]))
    np.testing.assert_allclose(tangent / scale, differences / scale, atol=1e-8)
    if pressure < 0.0:  # the step opens the point
        np.testing.assert_array_equal(tangent[0, :2], 0.0)


@pytest.mark.parametrize("law", [RATE, SMOOTHED], ids=["rate", "smoothed"])
def test_the_rate_is_that_of_the_step(law):
    """The same increment in half the time is twice the speed; the same speed gives the same traction."""
    fast = [Point(law).move([0.03 * dt, 0.0, CLOSED], dt)[0][0] for dt in (1e-3, 2e-3)]
    assert fast[0] == pytest.approx(fast[1], rel=1e-12)
    slow = Point(law).move([0.03e-3, 0.0, CLOSED], 4e-3)[0][0]
    assert slow < 0.99 * fast[0]


SYSTEM_LAWS = {
    "penalty": PenaltyCoulomb(0.3, 2e-6),
    "flat": RateCoulomb(0.3, 2e-6, (0.0, 1.0), (0.3, 0.3)),
    "rate": RateCoulomb(0.3, 2e-6, (0.0, 0.02, 0.1, 0.4), (0.3, 0.3, 0.45, 0.6)),
    "falling": RateCoulomb(0.3, 2e-6, (0.0, 0.02, 0.4), (0.3, 0.3, 0.2)),
    "smoothed": SmoothedCoulomb(0.3, 5e-3),
    "bouc_wen": BoucWen(0.3, 5e-5, 1.5, 0.7),
    "elastic": ElasticCoulomb(0.3, 2e-6, 1.5e6),
}
LAWS = ["penalty", "rate", "falling", "smoothed", "bouc_wen", "elastic"]


def slow_if(repeated, name):
    """Mark of a second test of the law that takes the most iterations."""
    return pytest.mark.slow if repeated and name == "bouc_wen" else []


def shaken(method, name, *, pair=True, steps=400, options=None):
    """Stepper, records of a small rubbing system under a sine of 14 Hz, 100 steps per cycle."""
    system = with_law(slipping_pair() if pair else orbiting_mass(), SYSTEM_LAWS[name])
    dt = 1.0 / 1400.0
    base = 20.0 * np.sin(2 * np.pi * 14.0 * dt * np.arange(steps + 1))
    run = stepper(method, system, solve_preload(system), Scheme.hht(-0.05), dt, options)
    if not pair:
        run.start_from(np.array([0.0, 0.004, 0.0]))
    return run, run.advance(base, dt, 0.0)


def unbalanced(records):
    return records[:, INPUT] - records[:, KINETIC : NUMERICAL + 1].sum(axis=1)


@pytest.mark.parametrize(
    ("pair", "name"),
    [
        pytest.param(pair, name, id=f"{'pair' if pair else 'orbit'}-{name}", marks=slow_if(not pair, name))
        for pair in (True, False)
        for name in LAWS
    ],
)
def test_steppers_agree_for_every_law(name, pair):
    """Full and condensed to 1e-8, in one direction with varying pressure and in two with turning traction."""
    exact = NewtonOptions(tolerance=1e-10)
    full, condensed = (shaken(method, name, pair=pair, steps=200, options=exact)[1] for method in STEPPERS)
    assert np.mean(full[:, SLIPPING]) > 0.2
    for column in (0, 1, 2, INPUT, FRICTION, STRAIN):
        scale = np.abs(full[:, column]).max()
        np.testing.assert_allclose(condensed[:, column], full[:, column], rtol=0.0, atol=1e-8 * scale)


@pytest.mark.parametrize(
    ("method", "name"),
    [pytest.param(m, name, marks=slow_if(m == "full", name)) for name in LAWS for m in STEPPERS],
)
def test_the_ledger_closes_for_every_law(method, name):
    """Input = kinetic + strain + contact + friction + modulation + numerical at every step."""
    run, records = shaken(method, name)
    scale = records[-1, INPUT]
    assert np.mean(records[:, SLIPPING]) > 0.2
    assert records[:, OPEN].max() == 0.0
    assert records[-1, FRICTION] > 0.2 * scale
    assert np.abs(unbalanced(records)).max() < 1e-8 * scale
    parts = records[:, FRICTION] + records[:, CONTACT] + records[:, MODULATION]
    assert np.abs(parts - records[:, INTERFACE]).max() < 1e-8 * scale
    if name == "smoothed":
        np.testing.assert_array_equal(run.elastic_slip, 0.0)
        assert np.abs(records[:, MODULATION]).max() == 0.0


@BOTH
def test_a_flat_table_is_penalty_coulomb_in_motion_too_and_a_rising_one_is_not(method):
    plain, same, rate = (shaken(method, name, steps=200)[1][:, 0] for name in ("penalty", "flat", "rate"))
    np.testing.assert_array_equal(same, plain)
    assert np.abs(rate - plain).max() > 0.02 * np.abs(plain).max()


@pytest.mark.parametrize("name", ["rate", "smoothed"])
def test_substeps_of_a_cut_step_have_their_own_rate(name):
    """A step halved by either stepper equals two steps of half the size, of both steppers, under linear base motion."""
    dt = 1.0 / 1400.0
    system = with_law(slipping_pair(), SYSTEM_LAWS[name])
    preload, options, records = solve_preload(system), NewtonOptions(tolerance=1e-10), []
    for method in STEPPERS:
        cut, fine = (stepper(method, system, preload, Scheme.hht(-0.05), h, options) for h in (dt, 0.5 * dt))
        record = np.zeros((1, len(RECORDS)))
        cut._cut_step(np.array([0.0, 6.0e4]), dt, 0.0, record)
        records += [record[0, :11], fine.advance(np.array([0.0, 3.0e4, 6.0e4]), 0.5 * dt, 0.0)[-1, :11]]
    assert records[0][FRICTION] > 0.0
    for other in records[1:]:
        np.testing.assert_allclose(other, records[0], rtol=1e-8, atol=1e-10 * np.abs(records[0]).max())


def test_preload_with_smoothed_friction_is_frictionless():
    """Statics know no rates: the pressures are those of mu = 0, and nothing is held tangentially."""
    base = orbiting_mass()
    smoothed, none = (solve_preload(with_law(base, law)) for law in (SMOOTHED, PenaltyCoulomb(0.0, 1e-6)))
    assert isinstance(smoothed, ContactState)
    np.testing.assert_array_equal(smoothed.traction, none.traction)
    np.testing.assert_array_equal(smoothed.traction[:2], 0.0)
    assert smoothed.traction[2] == pytest.approx(-10.0)
    trial = TrialContact(with_law(base, SMOOTHED))
    np.testing.assert_array_equal(trial(smoothed.jump + [1e-4, 2e-4, 0.0], smoothed)[:2], 0.0)


# --- reference stiffness ----------------------------------------------------------------------------------------------


def test_the_smoothed_law_has_no_stick_spring_but_a_reference_stiffness():
    """The latter is its tangent in a step from rest."""
    system, dt = with_law(orbiting_mass(), SMOOTHED), 1e-4
    preload = solve_preload(system)
    np.testing.assert_array_equal(stick_springs(system, preload)[:2], 0.0)
    reference, trial = reference_stiffness(system, preload, dt), TrialContact(system)
    trial(preload.jump, preload, dt)
    np.testing.assert_allclose(reference, trial.stiffness(preload.jump, preload, dt=dt).diagonal(), rtol=1e-12)
    for law in (PENALTY, RATE):
        other = with_law(orbiting_mass(), law)
        state = solve_preload(other)
        np.testing.assert_array_equal(reference_stiffness(other, state, dt), stick_springs(other, state))


def test_a_load_that_smoothed_friction_would_have_to_hold_has_no_equilibrium():
    """Statics say so; penalty friction holds the same block below mu N = 3 N."""
    block = dense_system(
        np.zeros((3, 3)), np.eye(3), [1, 0, 0],
        contact_point([0, 0, 1], [1, 0, 0], [0, 1, 0], mu=0.3, gamma=1e-6, kn=1e8),
        tip=[1, 0, 0], preload=[0, 2.0, -10.0],
    )  # fmt: skip
    assert solve_preload(block).traction[1] == pytest.approx(2.0, rel=1e-9)
    with pytest.raises(ConvergenceError, match="friction or a support"):
        solve_preload(with_law(block, SMOOTHED))
