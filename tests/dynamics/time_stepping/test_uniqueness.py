"""Steps with falling friction: when they have one solution, and that others are refused."""

from __future__ import annotations

import numpy as np
import pytest
from support.exact_systems import STEPPERS, coulomb_oscillator, stepper, with_law

from wroll_fem.contact.laws import PenaltyCoulomb, RateCoulomb, SmoothedCoulomb
from wroll_fem.dynamics.statics.contact_state import TrialContact
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.uniqueness import uniqueness_ratio
from wroll_fem.errors import InputError


def falling_oscillator(fall=1.0):
    """A mass of 1 kg on a spring, pressed by 10 N; the coefficient falls from 0.3 by ``fall`` s/m."""
    return with_law(coulomb_oscillator(mu=0.3), RateCoulomb(0.3, 1e-8, (0.0, 0.2 / fall), (0.3, 0.1)))


def test_the_uniqueness_ratio_is_the_negative_spring_over_the_dynamic_stiffness():
    """One mass: (1 + alpha) N |mu'| / h over m / (beta h^2) + (1 + alpha) k; nothing falls, nothing to check."""
    system, scheme, dt = falling_oscillator(3.0), Scheme.hht(-0.05), 2e-3
    exact = 0.95 * 10.0 * 3.0 / dt / (1.0 / (scheme.beta * dt**2) + 0.95 * 1e4)
    assert uniqueness_ratio(system, solve_preload(system), scheme, dt) == pytest.approx(exact, rel=1e-9)
    rising = RateCoulomb(0.3, 2e-6, (0.0, 0.02, 0.1, 0.4), (0.3, 0.3, 0.45, 0.6))
    for law in (PenaltyCoulomb(0.3, 2e-6), rising, SmoothedCoulomb(0.3, 5e-3)):
        other = with_law(coulomb_oscillator(), law)
        assert uniqueness_ratio(other, solve_preload(other), scheme, dt) == 0.0


@pytest.mark.parametrize("fall", [0.5, 0.95, 1.05, 2.0])
def test_a_step_has_several_solutions_beyond_the_limit_and_one_below(fall):
    """Solutions of g = g_hat - F t(g), counted over g, for every load that makes the mass slide."""
    system, scheme, dt = coulomb_oscillator(), Scheme.hht(-0.05), 2e-3
    inertia = 1.0 / (scheme.beta * dt**2) + 0.95 * 1e4
    slope = fall * inertia * dt / (0.95 * 10.0)  # s/m: the ratio is `fall`
    system = falling_oscillator(slope)
    preload = solve_preload(system)
    assert uniqueness_ratio(system, preload, scheme, dt) == pytest.approx(fall, rel=1e-9)
    trial = TrialContact(system)
    g = np.linspace(0.0, 0.5 / slope * dt, 4001)
    push = inertia * g + 0.95 * np.array([trial(preload.jump + [x, 0.0, 0.0], preload, dt)[0] for x in g])
    most = max(np.count_nonzero(np.diff(push > load)) for load in np.linspace(0.03, push.max(), 97))
    assert (most > 1) == (fall > 1.0)


@pytest.mark.parametrize("method", STEPPERS)
def test_steps_that_falling_friction_makes_ambiguous_are_refused(method):
    system, scheme, dt = falling_oscillator(2e3), Scheme.hht(-0.05), 2e-3
    preload = solve_preload(system)
    with pytest.raises(InputError, match="more than one solution") as error:
        stepper(method, system, preload, scheme, dt).advance(np.zeros(2), dt, 0.0)
    assert error.value.key == "contact.friction.rate_table"
    factor = int(error.value.remedy.split()[1])
    assert (
        uniqueness_ratio(system, preload, scheme, dt / factor)
        < 1.0
        <= uniqueness_ratio(system, preload, scheme, 2 * dt / factor)
    )
    stepper(method, system, preload, scheme, dt / factor).advance(np.zeros(2), dt / factor, 0.0)
