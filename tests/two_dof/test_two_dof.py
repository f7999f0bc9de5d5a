"""Two masses with friction: equations, both solvers against each other and against exact limits, energy, damping."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.errors import InputError
from wroll_fem.two_dof import (
    ARRANGEMENTS,
    PeriodicSolver,
    TwoMasses,
    design_space,
    integrate_to_steady_state,
    peak_half_power,
    regularised_sign,
    response_map,
    two_mass_system,
)  # fmt: skip
from wroll_fem.two_dof.model import RELATIVE_VELOCITY
from wroll_fem.two_dof.time import _rates, _slopes, dwell, integrate, parameters

DAMPED = TwoMasses(c1=0.05, c2=0.04)
"""Table 5.2 with dashpots that let a start from rest settle soon."""


@cache
def solver(arrangement: str, capacity: float, smoothing: float = 1.0) -> PeriodicSolver:
    return PeriodicSolver(TwoMasses(arrangement=arrangement, smoothing=smoothing).preloaded(capacity))


# --- the model --------------------------------------------------------------------------------------------------------


def test_regularised_sign_is_the_logistic_function_of_equation_5_4() -> None:
    x = np.linspace(-40.0, 40.0, 321)
    np.testing.assert_allclose(regularised_sign(x), 2.0 / (1.0 + np.exp(-x)) - 1.0, atol=4e-16)
    np.testing.assert_allclose(regularised_sign(x), np.tanh(x / 2.0), atol=1e-14)
    np.testing.assert_allclose(regularised_sign([1.0, 5.0]), [0.4621, 0.98661], atol=1e-5, rtol=1e-4)


def test_capacity_moves_mass_and_stiffness_by_equations_5_6_and_5_7() -> None:
    loose, tight = TwoMasses().preloaded(1.0), TwoMasses().preloaded(100.0)
    share = 2.0 / (1.0 + np.exp(-1.0)) - 1.0
    np.testing.assert_allclose([loose.m1, loose.m2, loose.k2], [1 + 0.85 * (1 - share), 0.85 * share, 1.15 * share])
    np.testing.assert_allclose([tight.m1, tight.m2, tight.k2], [1.0, 0.85, 1.15])
    assert loose.m1 + loose.m2 == pytest.approx(1.85)
    constant = TwoMasses(preload_dependent=False).preloaded(1.0)
    assert (constant.m1, constant.m2, constant.k2) == (1.0, 0.85, 1.15)


def accelerations(model: TwoMasses, capacity: float, omega: float, t: float, state: np.ndarray) -> tuple[float, float]:
    """Equations 5.2 and 5.3 and their like for Fig 5.1b and c, spelled out."""
    p = model.preloaded(capacity)
    (x1, x2, v1, v2), friction = state, capacity * float(regularised_sign(model.smoothing * (state[2] - state[3])))
    y, ydot = p.base_amplitude * np.sin(omega * t), p.base_amplitude * omega * np.cos(omega * t)
    first = p.k1 * y + p.c1 * ydot - p.k1 * x1 - p.c1 * v1 - friction
    second = -p.k2 * x2 - p.c2 * v2 + friction
    if model.arrangement == "both_on_base":
        second += p.k2 * y + p.c2 * ydot
    if model.arrangement == "secondary_on_primary":
        link = p.k2 * (x1 - x2) + p.c2 * (v1 - v2)
        first, second = first - link, link + friction
    return first / p.m1, second / p.m2


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_compiled_equations_are_those_of_the_source_and_of_the_matrices(arrangement: str) -> None:
    model = TwoMasses(arrangement=arrangement, smoothing=1.7)
    p, rng = model.preloaded(3.0), np.random.default_rng(4)
    system, omega = two_mass_system(p), 0.9
    for t in (0.3, 2.0):
        state = rng.standard_normal(4)
        found = _rates(t, state, omega, parameters(p))
        np.testing.assert_allclose(found, [*state[2:], *accelerations(model, 3.0, omega, t, state)], rtol=1e-13)
        # relative to the base, as the System has it
        y = p.base_amplitude * np.sin(omega * t)
        ydot, yddot = p.base_amplitude * omega * np.cos(omega * t), -(omega**2) * y
        u, v = state[:2] - y, state[2:] - ydot
        friction = 3.0 * np.tanh(0.5 * 1.7 * (v @ RELATIVE_VELOCITY)) * RELATIVE_VELOCITY
        pull = (system.stiffness.toarray()[:2, :2] @ u) + (system.damping.toarray()[:2, :2] @ v) + friction
        load = -system.mass.toarray()[:2, :2] @ np.ones(2) * yddot + p.ground_coupling * (p.k2 * y + p.c2 * ydot)
        np.testing.assert_allclose(np.diag(p.mass) * (found[2:] - yddot), load - pull, rtol=1e-12, atol=1e-12)
        differences = np.array(
            [(_rates(t, state + h, omega, parameters(p)) - _rates(t, state - h, omega, parameters(p))) / 2e-6
             for h in 1e-6 * np.eye(4)]
        ).T  # fmt: skip
        np.testing.assert_allclose(_slopes(t, state, omega, parameters(p)), differences, atol=1e-8)


def test_values_without_a_meaning_are_refused() -> None:
    with pytest.raises(InputError, match=r"two_dof\.c1: c1 = 0\.0; give a positive number"):
        TwoMasses(c1=0.0)
    with pytest.raises(InputError, match=r"two_dof\.arrangement: unknown arrangement 'd'; use both_on_base, secondary"):
        TwoMasses(arrangement="d")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"friction_capacity: must be positive and finite, got -1; give forces"):
        TwoMasses().preloaded(-1)
    with pytest.raises(InputError, match=r"two_dof\.omega: the frequencies must be positive and increasing"):
        response_map(TwoMasses(), [1.0], np.array([1.0, 0.9, 0.8, 0.7, 0.6]))


# --- periodic motions -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
@pytest.mark.parametrize("capacity", [1.0, 4.0])
def test_time_and_periodic_solver_agree(arrangement: str, capacity: float) -> None:
    """Two formulations (absolute and relative), two methods; asked for is 1e-4."""
    pressed = TwoMasses(c1=0.05, c2=0.04, arrangement=arrangement).preloaded(capacity)
    periodic = PeriodicSolver(pressed)
    for omega in (0.6, 0.85, 1.05, 1.5):
        steady = integrate_to_steady_state(pressed, omega)
        assert steady.periodicity_error < 1e-6
        assert periodic.motion(omega).transmissibility == pytest.approx(steady.transmissibility, rel=5e-6)


@pytest.mark.parametrize(("capacity", "omega"), [(1.0, 0.83), (2.0, 0.97), (10.0, 1.08)])
def test_a_start_on_the_periodic_motion_stays_on_it(capacity: float, omega: float) -> None:
    """Table 5.2's dashpots, at the peaks, where settling would take very long; the base moves as -Y0 cos."""
    motion = solver("both_on_base", capacity).motion(omega)
    quarter = -0.5 * np.pi / omega  # sin(w (t - quarter)) is -cos
    odd = np.arange(1.0, len(motion.absolute), 2)
    state = np.concatenate([motion.absolute[1::2].sum(0), omega * (odd[:, None] * motion.absolute[2::2]).sum(0)])
    times = quarter + np.array([0.0, 2.0 * np.pi / omega])
    end = integrate(motion.preloaded, omega, state, times, 1e-11)[-1]
    np.testing.assert_allclose(end, state, atol=2e-5 * np.abs(state).max())


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
@pytest.mark.parametrize("smoothing", [1.0, 5.0])
def test_energy_of_a_cycle_balances(arrangement: str, smoothing: float) -> None:
    """Equations in absolute displacements at four times the samples; asked for is 1e-6."""
    for capacity in (1.0, 5.0, 100.0):
        periodic = solver(arrangement, capacity, smoothing)
        for motion in periodic.curve(np.linspace(0.5, 1.9, 8)):
            energy = motion.energy()
            assert energy.balance_error < 1e-6
            assert min(energy.input, energy.primary, energy.secondary, energy.friction) > 0.0
            assert motion.energy(finer=16).input == pytest.approx(energy.input, rel=1e-9)


def test_derivative_along_a_line_is_that_of_the_compiled_contact() -> None:
    periodic = solver("both_on_base", 5.0)
    motion = periodic.motion(1.05)
    line = periodic._contacts[motion.harmonics]
    contact = line.evaluate(line.motion(motion.reduced), motion.omega)
    for found, expected in zip(line.jacobian(contact), HarmonicContact.jacobian(line, contact), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


def linear_response(model: TwoMasses, capacity: float, omega: float, extra: float) -> float:
    """|x1| / Y0 with friction in place of a dashpot ``extra`` between the masses."""
    p = model.preloaded(capacity)
    link = extra * np.outer(RELATIVE_VELOCITY, RELATIVE_VELOCITY)
    a, b = p.support_coupling
    base = (p.k1 + 1j * omega * p.c1) * np.array([1.0, 0.0])
    base = base + (p.k2 + 1j * omega * p.c2) * b * np.array([-a, 1.0])
    dynamic = p.stiffness + 1j * omega * (p.damping + link) - omega**2 * p.mass
    return float(np.abs(np.linalg.solve(dynamic, base)[0]))


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_slow_rubbing_is_that_of_a_dashpot(arrangement: str) -> None:
    """The slope of S at zero is 1/2: a small base motion sees a dashpot F_c s / 2, exactly as the amplitude falls."""
    model = TwoMasses(arrangement=arrangement, base_amplitude=1e-6)
    periodic = PeriodicSolver(model.preloaded(3.0))
    for omega in (0.5, 0.95, 1.6):
        exact = linear_response(model, 3.0, omega, 1.5)
        assert periodic.motion(omega).transmissibility == pytest.approx(exact, rel=1e-8)


def test_without_friction_to_speak_of_the_masses_are_on_their_own() -> None:
    model = TwoMasses(preload_dependent=False)
    periodic = PeriodicSolver(model.preloaded(1e-9))
    for omega in (0.7, 1.3):
        assert periodic.motion(omega).transmissibility == pytest.approx(
            linear_response(model, 1e-9, omega, 0.0), rel=1e-6
        )


def test_coulomb_limit_of_a_rigid_secondary_is_den_hartogs() -> None:
    """A massless secondary on a very stiff spring moves with the base: friction against it, sliding throughout.

    Den Hartog (1931): u^2 = (Y0 r^2/(1 - r^2))^2 - (F/k)^2 [sin(pi/r) / (r (1 + cos(pi/r)))]^2, relative to the base.
    The smoothed law errs by O(1/s): twice the steepness halves the error, and the limit is Den Hartog's.
    """
    r, force, errors = 0.8, 0.4, []
    friction = force * np.sin(np.pi / r) / (r * (1.0 + np.cos(np.pi / r)))
    exact = np.sqrt((r * r / (1.0 - r * r)) ** 2 - friction**2)
    for smoothing in (50.0, 100.0):
        model = TwoMasses(
            c1=1e-9, c2=1e-9, m2=1e-9, k2=1e6, base_amplitude=1.0, smoothing=smoothing, preload_dependent=False
        )
        motion = PeriodicSolver(model.preloaded(force)).motion(r)
        path = Sampling(motion.harmonics, 8192, odd=True).values @ motion.relative[:, 0]
        errors.append(np.abs(path).max() / exact - 1.0)
    assert abs(errors[0]) > 0.01
    assert abs(2.0 * errors[1] - errors[0]) < 6e-4


def test_the_motion_does_not_depend_on_where_the_search_starts() -> None:
    """There is one periodic motion."""
    periodic = solver("both_on_base", 2.0)
    cold = periodic.motion(0.97)
    for omega in (0.5, 1.4):
        assert periodic.motion(0.97, periodic.motion(omega)).transmissibility == pytest.approx(
            cold.transmissibility, rel=1e-5
        )


def test_a_steep_law_is_reached_from_smoother_ones() -> None:
    motion = solver("both_on_base", 100.0, 100.0).motion(1.05)
    assert motion.energy().balance_error < 1e-6
    assert motion.transmissibility == pytest.approx(
        solver("both_on_base", 100.0, 10.0).motion(1.05).transmissibility, rel=1e-2
    )


def test_six_time_constants_of_the_source_are_close_to_the_periodic_motion() -> None:
    p = TwoMasses().preloaded(2.0)
    found = dwell(p, 1.2, 6.0 / (0.002 * 1.2))
    assert found == pytest.approx(solver("both_on_base", 2.0).motion(1.2).transmissibility, rel=1e-3)


# --- readings and maps ------------------------------------------------------------------------------------------------


def test_a_peak_far_narrower_than_the_grid_is_read_exactly() -> None:
    """Masses stuck by a stiff dashpot: half power reads the damping of the pair, on a grid 15 widths apart."""
    model = TwoMasses(base_amplitude=1e-9)
    periodic = PeriodicSolver(model.preloaded(1e4))
    read = peak_half_power(periodic, np.linspace(0.4, 2.0, 40))
    p = periodic.preloaded
    dense = np.linspace(0.999, 1.001, 4001) * p.stuck_frequency
    exact = np.array([linear_response(model, 1e4, w, 5e3) for w in dense])
    assert read.f_n == pytest.approx(dense[exact.argmax()], rel=1e-6)
    assert read.peak == pytest.approx(exact.max(), rel=1e-4)
    zeta = (p.c1 + p.c2) / (2.0 * np.sqrt((p.k1 + p.k2) * (p.m1 + p.m2)))
    assert read.zeta == pytest.approx(zeta, rel=5e-3)


def test_the_higher_of_two_peaks_is_read_even_where_the_grid_sees_the_other() -> None:
    model = TwoMasses(base_amplitude=100.0, preload_dependent=False, arrangement="secondary_on_primary")
    periodic = PeriodicSolver(model.preloaded(1e-6))
    low, high = periodic.preloaded.free_frequencies
    grid = np.array([0.4, 0.5, 0.6, 0.75, 0.95, 1.2, 1.5, high, 2.0])
    seen = [linear_response(model, 1e-6, w, 0.0) for w in grid]
    assert grid[int(np.argmax(seen))] == high
    assert linear_response(model, 1e-6, low, 0.0) > max(seen)
    assert peak_half_power(periodic, grid).f_n == pytest.approx(low, rel=1e-4)


def test_maps_are_the_same_on_one_and_on_two_processes() -> None:
    omegas = np.linspace(0.5, 1.8, 16)
    one, two = (response_map(DAMPED, [1.0, 3.0], omegas, workers=n) for n in (1, 2))
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a.transmissibility, b.transmissibility)
        assert a.half_power == b.half_power
    space = design_space(DAMPED, [0.5, 0.85], [1.15], [3.0], points=16, workers=1)
    assert space.zeta.shape == (2, 1, 1)
    assert space.zeta[1, 0, 0] == pytest.approx(one[1].half_power.zeta, rel=5e-3)
    assert space.omega_peak[1, 0, 0] == pytest.approx(one[1].half_power.f_n, rel=1e-3)


def test_response_map_in_time_is_that_of_harmonic_balance() -> None:
    omegas = np.linspace(0.6, 1.5, 5)
    periodic, time = (response_map(DAMPED, [2.0], omegas, method=m, workers=1)[0] for m in ("periodic", "time"))
    np.testing.assert_allclose(time.transmissibility, periodic.transmissibility, rtol=1e-5)
    assert np.isnan(time.input).all()


def test_names_of_version_0_1_still_work() -> None:
    from wroll_fem import two_dof

    assert two_dof.settle is two_dof.integrate_to_steady_state
    assert two_dof.peak_readings is two_dof.peak_half_power
    assert two_dof.fit_family is two_dof.fit_curves
    assert two_dof.smoothed_sign is two_dof.regularised_sign
    assert isinstance(TwoMasses().pressed(1.0), two_dof.Pressed)


@pytest.mark.parametrize("size", [1e-6, 1e4])
def test_the_steady_state_is_found_in_any_unit_of_length(size: float) -> None:
    """Lengths, forces and 1/smoothing times ``size`` is the same motion, found after the same number of periods."""
    large = dataclasses.replace(DAMPED, preload_dependent=False)
    small = dataclasses.replace(large, base_amplitude=size * large.base_amplitude, smoothing=large.smoothing / size)
    found = integrate_to_steady_state(small.preloaded(3.0 * size), 0.9)
    expected = integrate_to_steady_state(large.preloaded(3.0), 0.9)
    assert found.periods == expected.periods
    assert found.transmissibility == pytest.approx(expected.transmissibility, rel=1e-6)


def test_the_start_settles_as_fast_as_its_slowest_mode_decays() -> None:
    """Nearly linear: exp(-sigma n T) reaches the accuracy after n periods, counted in blocks of 8 (two of them to
    spare); the amplitude of the transient moves n by ln(2)/(sigma T), 4 periods."""
    model, omega, accuracy = dataclasses.replace(DAMPED, preload_dependent=False).preloaded(1e-3), 0.9, 1e-6
    motion = np.block([
        [np.zeros((2, 2)), np.eye(2)],
        [-np.linalg.solve(model.mass, model.stiffness), -np.linalg.solve(model.mass, model.damping)],
    ])  # fmt: skip
    decay = -np.linalg.eigvals(motion).real.max() * 2.0 * np.pi / omega
    needed = -np.log(accuracy) / decay
    assert needed - 8 <= integrate_to_steady_state(model, omega, accuracy=accuracy).periods <= needed + 16
