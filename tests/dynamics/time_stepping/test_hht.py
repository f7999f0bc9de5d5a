"""Time integration of linear systems: transmissibility, order, parameters, dissipation."""

import numpy as np
import pytest
from support.exact_systems import (
    STEPPERS,
    dense_system,
    oscillator,
    rest,
    stepper,
)

from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import KINETIC, NUMERICAL, STRAIN
from wroll_fem.errors import InputError

BOTH = pytest.mark.parametrize("method", STEPPERS)


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
    time = dt * np.arange(int(3.0 / (f_0 * dt)) + 1)
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
    first = 200 if order == 2 else 400
    errors = np.array([final_error(method, scheme, times * first) for times in (1, 2, 4)])
    slopes = np.log2(errors[:-1] / errors[1:])
    np.testing.assert_allclose(slopes, order, atol=0.02 if order == 2 else 0.12)
    assert np.all(errors[400 // first - 1] < bound)


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
