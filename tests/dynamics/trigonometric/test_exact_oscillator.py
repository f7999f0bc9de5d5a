"""Estimates of the time step error for the trigonometric scheme: linear, with friction, softened by slip."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.step_error import Oscillator, curve_error, history_error, period_error
from wroll_fem.signals.base_motion import Dwell

EXACT = Scheme.named("trigonometric")
MOTION = Dwell(1.0, 9.8, 15.0, ramp_cycles=3.0)


@pytest.mark.parametrize("steps", [10, 40])
def test_an_oscillator_that_sticks_has_no_error(steps: int) -> None:
    dt = 1.0 / (9.8 * steps)
    assert history_error(EXACT, dt, MOTION, Oscillator(10.0, 0.005)) < 1e-9
    stuck = Oscillator(10.0, 0.005, friction=0.4, slip=1e3)
    assert history_error(EXACT, dt, MOTION, stuck) < 1e-9
    assert history_error(Scheme.hht(-0.05), dt, MOTION, stuck) > 1e-2


def test_friction_leaves_an_error_of_second_order_against_fine_steps_of_hht() -> None:
    """Slip in every cycle; the reference has 4000 steps per cycle."""
    dt, finer = 1.0 / (9.8 * 40), 100
    fine = MOTION.acceleration(dt / finer * np.arange(40 * 15 * finer + 1))
    slip = 0.5 * float(np.abs(Oscillator(10.0, 0.005).response(Scheme.hht(0.0), dt / finer, fine)).max())
    oscillator = Oscillator(10.0, 0.005, friction=0.4, slip=slip)
    right = oscillator.response(Scheme.hht(0.0), dt / finer, fine)
    errors = []
    for coarser in (1, 2):
        found = oscillator.response(EXACT, coarser * dt, fine, coarser * finer)
        errors.append(float(np.abs(found - right[:: coarser * finer]).max() / np.abs(right).max()))
    estimate = history_error(EXACT, 2.0 * dt, MOTION, oscillator)
    assert errors[0] < 5e-3
    assert 1.5 < errors[1] / errors[0] < 10.0
    assert estimate == pytest.approx(errors[1], rel=0.3)


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_a_softened_mode_has_the_period_error_of_the_page(share: float) -> None:
    """The closed form of one step, 1 - cos Theta = rho (1 - cos a) / (1 - (1 - rho) x), x = 1 - sinc^2(a / 2)."""
    stuck, dt = 160.0, 1.0 / (160.0 * 30)
    angle = 2.0 * np.pi * stuck * dt
    x = 1.0 - np.sinc(0.5 * angle / np.pi) ** 2
    turned = np.arccos(1.0 - share * (1.0 - np.cos(angle)) / (1.0 - (1.0 - share) * x))
    found = period_error(EXACT, dt, stuck * np.sqrt(share), stuck)
    assert found == pytest.approx(np.sqrt(share) * angle / turned - 1.0, rel=0.02)
    assert period_error(EXACT, dt, stuck) == 0.0
    frequency = np.linspace(100.0, 200.0, 400)
    curve = 1.0 / np.abs(1.0 - (frequency / 150.0) ** 2 + 0.04j * frequency / 150.0)
    assert curve_error(EXACT, dt, frequency, curve, 0.02) == 0.0
    assert 0.0 < curve_error(EXACT, dt, frequency, curve, 0.02, stuck) < 1e-3
