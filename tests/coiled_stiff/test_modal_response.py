"""Modal response to a sinusoidal base acceleration against exact solutions of the same equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from wroll_fem.coiled_stiff.modal_response import (
    SAMPLES_PER_CYCLE,
    STEADY_CHANGE,
    Oscillators,
    run_to_steady_state,
    steady_transmissibility,
)
from wroll_fem.errors import ConvergenceError, InputError

TWO = Oscillators(np.array([40.0, 130.0]), np.array([0.7, -0.4]), 0.03)


@pytest.mark.parametrize("driven", [7.0, 40.0, 130.0, 410.0])
def test_history_equals_the_matrix_exponential(driven):
    # states q, q', sin W t, cos W t of each mode: x' = A x has the exact solution expm(A t) x(0)
    amplitude, w = 3.0, 2 * np.pi * driven
    times = np.array([0.0, 1e-4, 0.0123, 0.31])
    state = TWO.from_rest(times, driven, amplitude)
    for k, (f, gamma) in enumerate(zip(TWO.frequencies_hz, TWO.participation, strict=True)):
        omega = 2 * np.pi * f
        matrix = np.zeros((4, 4))
        matrix[0, 1], matrix[1] = 1.0, [-(omega**2), -2 * TWO.damping_ratio * omega, -gamma * amplitude, 0.0]
        matrix[2, 3], matrix[3, 2] = w, -w
        exact = np.array([expm(matrix * t)[:, 3] for t in times])
        size = np.abs(state.coordinate[k]).max()
        np.testing.assert_allclose(state.coordinate[k], exact[:, 0], atol=1e-10 * size)
        np.testing.assert_allclose(state.velocity[k], exact[:, 1], atol=1e-10 * np.abs(exact[:, 1]).max())
        np.testing.assert_allclose(
            state.acceleration[k], exact @ matrix[1], atol=1e-10 * np.abs(exact @ matrix[1]).max()
        )


@pytest.mark.parametrize("share", [0.3, 1.0, 1.3, 3.0])
def test_transmissibility_of_one_mode_is_the_textbook_formula(share):
    zeta, gamma = 0.05, 1.7
    one = Oscillators(np.array([25.0]), np.array([gamma]), zeta)
    formula = np.sqrt((1 + (2 * zeta * share) ** 2) / ((1 - share**2) ** 2 + (2 * zeta * share) ** 2))
    tip = np.array([1 / gamma])
    assert abs(steady_transmissibility(one, tip, 25.0 * share)) == pytest.approx(formula, rel=1e-12)
    run = run_to_steady_state(one, tip, 25.0 * share, 2.0)
    base = 2.0 * np.sin(2 * np.pi * 25.0 * share * run.time)
    last = np.abs(base + tip @ run.state.acceleration)[run.last_cycle].max() / 2.0
    assert last == pytest.approx(formula, rel=3e-3)  # what the transient left, and 64 samples per cycle


def test_change_per_cycle_decays_as_the_mode_does():
    cycles = np.arange(1, 40)
    change = TWO.change_per_cycle(cycles, 33.0, 1.0)
    decay = np.exp(-TWO.damping_ratio * 2 * np.pi * TWO.frequencies_hz / 33.0)
    np.testing.assert_allclose(change[:, 1:], change[:, :-1] * decay[:, None], rtol=1e-9, atol=1e-15)


def test_steady_state_is_found_where_the_closed_form_has_it():
    zeta, f = 0.02, 80.0
    one = Oscillators(np.array([f]), np.array([1.0]), zeta)
    run = run_to_steady_state(one, np.array([1.0]), f, 9.81)
    # at resonance the transient's amplitude is that of the steady motion (to zeta^2), e^(-2 pi zeta) of it per cycle
    ratio = np.exp(-2 * np.pi * zeta)
    cycles = np.ceil(1 + np.log(STEADY_CHANGE / (1 - ratio)) / np.log(ratio))
    assert abs(run.change.size - cycles) <= 1
    assert run.change[-1] < STEADY_CHANGE <= run.change[-2]
    assert run.time.size == run.change.size * SAMPLES_PER_CYCLE + 1
    reached = np.abs(run.state.coordinate[0, run.last_cycle]).max() / abs(one.steady(f, 9.81)[0])
    assert reached == pytest.approx(1.0, abs=STEADY_CHANGE / (1 - ratio) + 1 - np.cos(np.pi / SAMPLES_PER_CYCLE))


def test_slow_decay_far_above_resonance_is_not_taken_for_steady():
    # one cycle of the base is a hundredth of the mode's: its free motion hardly changes within it
    one = Oscillators(np.array([1.0]), np.array([1.0]), 0.01)
    run = run_to_steady_state(one, np.array([1.0]), 100.0, 1.0)
    exact = one.steady(100.0, 1.0)[0]
    w = 2 * np.pi * 100.0
    free = run.state.coordinate[0] - (exact * np.exp(1j * w * run.time)).imag
    lasting = 2 * np.pi * np.hypot(0.01, 1.0) / 100.0  # change per cycle over the free motion itself
    assert np.abs(free[run.last_cycle]).max() < 1.1 * STEADY_CHANGE * abs(exact) / lasting


def test_what_has_no_steady_state_is_refused():
    with pytest.raises(InputError, match="damping_ratio: must lie between 0 and 1, got 0"):
        Oscillators(np.array([1.0]), np.array([1.0]), 0.0)
    with pytest.raises(InputError, match="a rigid-body motion has no steady state"):
        Oscillators(np.array([0.0, 3.0]), np.array([1.0, 1.0]), 0.1)
    with pytest.raises(InputError, match=r"modal\.count: no mode moves the tip"):
        run_to_steady_state(TWO, np.zeros(2), 40.0, 1.0)
    slow = Oscillators(np.array([0.01]), np.array([1.0]), 1e-3)
    with pytest.raises(ConvergenceError, match="no steady state"):
        run_to_steady_state(slow, np.array([1.0]), 500.0, 1.0)
