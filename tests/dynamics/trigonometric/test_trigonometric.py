"""Trigonometric integration: exact while sticking, energy, order, agreement with other schemes, resume, refusals."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
import xarray as xr
from support.exact_systems import contact_point, coulomb_oscillator, dense_system, lifting_mass, orbiting_mass
from support.interrupted import interrupted
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping import simulate as module
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.time_stepping.simulate import Checkpointing, make_stepper, simulate
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.dynamics.trigonometric.stepper import TrigonometricStepper
from wroll_fem.errors import InputError, ReductionError
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.base_motion import Dwell
from wroll_fem.typing import FloatArray

EXACT = Scheme.named("trigonometric")
HHT = Scheme.hht(-0.05)
LAB = CONFIGS / "lab_sweep.yaml"
DT = 1.0 / (150.0 * 40)
STRONG = Dwell(30.0, 150.0, 8.0, ramp_cycles=3.0)


@cache
def prepared(*overrides: str) -> tuple[System, ContactState]:
    case = load_case(LAB, ["mesh={circumferential: 8, axial: 4, grading: 2}", *overrides])
    return prepare(case, SilentProgress())


def history(
    system: System, state: ContactState, motion: Dwell, dt: float, scheme: Scheme, **more: object
) -> xr.Dataset:
    method = str(more.pop("method", "reduced"))
    tolerance = float(more.pop("tolerance", 2e-3))  # type: ignore[arg-type]
    run = make_stepper(
        system, state, method=method, scheme=scheme, options=NewtonOptions(), dt=dt, reduction_tolerance=tolerance
    )
    return simulate(system, state, motion, dt=dt, scheme=scheme, stepper=run, **more)  # type: ignore[arg-type]


def gap(found: xr.Dataset) -> float:
    """Error of the energy identity, relative to the largest input work."""
    stored = found["kinetic_energy"] + found["strain_energy"] + found["contact_energy"]
    names = ("friction_energy", "pressure_modulation_work", "numerical_dissipation", "material_damping")
    spent = sum(found[name] for name in (*names, "impact_dissipation"))
    return float(np.abs(found["input_work"] - stored - spent).max() / np.abs(found["input_work"]).max())


def difference(found: xr.Dataset, right: xr.Dataset, name: str = "tip_displacement") -> float:
    """Largest difference at the times of ``found``, relative to the largest value; steps divide each other."""
    every = round((len(right["time"]) - 1) / (len(found["time"]) - 1))
    a, b = found[name].values, right[name].values[::every]
    return float(np.abs(a - b).max() / np.abs(b).max())


class Sine:
    """Base acceleration sin(w t) from rest, for which modes have closed solutions."""

    def __init__(self, frequency: float, cycles: float):
        self.w, self.duration = 2.0 * np.pi * frequency, cycles / frequency

    def acceleration(self, time: FloatArray) -> FloatArray:
        return np.sin(self.w * time)


def modal_solution(value: float, rate: float, w: float, times: FloatArray) -> FloatArray:
    """q'' + rate q' + value q = sin(w t) from rest: steady part plus the decaying free motion."""
    steady = 1.0 / (value - w**2 + 1j * rate * w)
    found = np.imag(steady * np.exp(1j * w * times))
    own = np.sqrt(complex(value - 0.25 * rate**2))
    q, v = -steady.imag, -float(np.real(steady * w))
    decay = np.exp(-0.5 * rate * times)
    return found + decay * np.real(q * np.cos(own * times) + (v + 0.5 * rate * q) / own * np.sin(own * times))


@pytest.mark.parametrize("steps", [8, 20])
def test_a_stuck_roll_has_the_modal_response_of_its_closed_form(steps: int) -> None:
    """All damped modes of a roll that sticks, base sine of 150 Hz; at 8 steps its polynomial in a step leaves 5e-9.

    At 20 steps it leaves 3e-12. The ratio of the largest to the smallest eigenvalue is 7e7.
    """
    words = ["mesh={circumferential: 8, axial: 2, grading: 1}", "coil.model=bonded", "damping.modal=0.004"]
    system, state = prepare(load_case(LAB, words), SilentProgress())
    dt, sine = 1.0 / (150.0 * steps), Sine(150.0, 15.0)
    run = TrigonometricStepper(system, state, EXACT, NewtonOptions(), dt=dt)
    modes = run.condensation
    run.adopt(ReducedModel.complete(modes))
    found = simulate(system, state, sine, dt=dt, scheme=EXACT, stepper=run)
    times, right = found["time"].values, 0.0
    for value, rate, share in zip(
        modes.eigenvalues, np.concatenate(modes.damping), -modes.base * modes.tip, strict=True
    ):
        right = right + share * modal_solution(value, rate, sine.w, times)
    tip = found["tip_displacement"].values
    assert len(times) > 15 * steps
    assert np.abs(tip - right).max() < (1e-11 if steps == 20 else 1e-7) * np.abs(right).max()
    assert gap(found) < 1e-6


def test_coupled_damping_has_the_closed_form_too() -> None:
    """A chain of five masses with one dashpot to ground, which couples the modes: 10 steps per cycle.

    The probe is the sum of two masses; the dashpot acts on one of them, so that its force is seen in the acceleration.
    """
    k = 4.0e4 * (2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1))
    dashpot = np.zeros((5, 5))
    dashpot[0, 0] = 60.0
    plain = dense_system(k, np.eye(5), np.ones(5), tip=[1.0, 0, 0, 0, 1.0])
    system = dataclasses.replace(plain, damping=sp.csr_matrix(dashpot))
    state, sine, dt = ContactState.unloaded(system), Sine(20.0, 12.0), 1.0 / 400.0
    found = history(system, state, sine, dt, EXACT)  # type: ignore[arg-type]
    matrix = np.block([[np.zeros((5, 5)), np.eye(5)], [-k, -dashpot]])
    load = np.concatenate([np.zeros(5), -np.ones(5)])
    steady = np.linalg.solve(1j * sine.w * np.eye(10) - matrix, load)
    step, y = la.expm(dt * matrix), -steady.imag
    tip, acceleration = [], []
    for time in found["time"].values:
        turned = steady * np.exp(1j * sine.w * time)
        tip.append(np.sum((np.imag(turned) + y)[[0, 4]]))
        acceleration.append(np.sum((np.imag(1j * sine.w * turned) + matrix @ y)[[5, 9]]))
        y = step @ y
    assert np.abs(found["tip_displacement"].values - tip).max() < 1e-10 * np.abs(tip).max()
    assert np.abs(found["tip_acceleration"].values - acceleration).max() < 1e-10 * np.abs(acceleration).max()
    assert gap(found) < 1e-6


@pytest.mark.parametrize("overrides", [(), ("damping.modal=0.01",), ("preload.pressure=1.0e3", "damping.modal=0.01")])
def test_energy_identity_holds_through_slip_opening_and_growth_of_the_basis(overrides: tuple[str, ...]) -> None:
    found = history(*prepared(*overrides), STRONG, DT, EXACT)
    assert gap(found) < 1e-8  # the ledger has the residual of the iteration, 1e-3 of the elastic slip
    assert float(found["slipping_fraction"].max()) > 0.1
    assert (float(found["open_fraction"].max()) > 0.1) == ("preload.pressure=1.0e3" in overrides)
    assert abs(float(found["numerical_dissipation"][-1])) < 2e-2 * float(found["input_work"][-1])
    friction = found["friction_energy"].values
    assert friction[-1] > 0.0 if not overrides else friction[-1] > 1e-3 * float(found["input_work"][-1])


def test_a_roll_agrees_with_condensed_at_four_times_the_steps() -> None:
    motion = Dwell(5.0, 150.0, 12.0, ramp_cycles=4.0)
    right = history(*prepared(), motion, DT / 4.0, Scheme.hht(0.0), method="condensed")
    found = history(*prepared(), motion, DT, EXACT, tolerance=1e-3)
    implicit = history(*prepared(), motion, DT, HHT, tolerance=1e-3)
    assert difference(found, right) < 1.2e-2  # at 160 steps the period of the reference is still 1.3e-4 too long
    assert difference(implicit, right) > 8.0 * difference(found, right)
    friction = [float(run["friction_energy"][-1]) for run in (found, right)]
    assert friction[0] == pytest.approx(friction[1], rel=2e-2)


def jenkins(gamma: float = 1e-4) -> System:
    """A mass on a spring, and on a friction point of half its stiffness that slides at ``gamma``."""
    point = contact_point([0, 1], [1, 0], [0, 0], mu=0.5, gamma=gamma, kn=1.0e8)
    k = np.diag([5.0e3, 0.0])
    return dense_system(k, np.eye(2), [1, 0], point, tip=[1, 0], preload=[0, -1.0e4 * gamma])


def central_differences(steps: int, dwell: Dwell, gamma: float) -> FloatArray:
    """The same oscillator, x'' + 5e3 (x + e) = -a_g with |e| <= gamma, by central differences."""
    times = np.linspace(0.0, dwell.duration, steps + 1)
    h, base = times[1], dwell.acceleration(times)
    x, before, e = 0.0, 0.5 * h * h * -base[0], 0.0
    found = np.zeros(steps + 1)
    for n in range(steps):
        new = 2.0 * x - before - h * h * (5.0e3 * (x + e) + base[n])
        e = min(max(e + new - x, -gamma), gamma)
        before, x = x, new
        found[n + 1] = x
    return found


def test_a_jenkins_oscillator_agrees_with_fine_steps_to_second_order() -> None:
    """Slip in every cycle; 20 to 320 steps per cycle against central differences with 20480."""
    system, dwell = jenkins(), Dwell(3.0, 14.0, 8.0, ramp_cycles=2.0)
    state = solve_preload(system)
    counts = np.array([20, 40, 80, 160, 320])
    fine = central_differences(8 * 20480, dwell, 1e-4)
    errors = []
    for count in counts:
        found = history(system, state, dwell, 1.0 / (14.0 * count), EXACT)
        tip = found["tip_displacement"].values
        errors.append(np.abs(tip - fine[:: (len(fine) - 1) // (len(tip) - 1)]).max() / np.abs(fine).max())
        assert gap(found) < 1e-6
    assert float(found["friction_energy"][-1]) > 0.1 * float(found["input_work"][-1])
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert -2.5 < slope < -1.6
    assert errors[1] < 5e-3


@pytest.mark.parametrize("number", range(6))
def test_random_systems_agree_with_fine_steps_of_hht(number: int) -> None:
    """Chains of three masses on two friction points, random stiffness, damping, pressure; seeds (15, number)."""
    rng = np.random.default_rng([15, number])
    k = np.diag(10.0 ** rng.uniform(3.5, 5.0, 3)) + 2.0e3 * np.array([[2, -1, 0], [-1, 2, -1], [0, -1, 1.0]])
    mu, gamma = rng.uniform(0.2, 0.6), 10.0 ** rng.uniform(-6.0, -4.0)
    full = np.zeros((5, 5))
    full[:3, :3] = k
    points = [
        contact_point(np.eye(5)[3 + i], np.eye(5)[i] - (np.eye(5)[2] if i else 0.0), np.zeros(5), mu=mu, gamma=gamma,
                      kn=1.0e8) for i in range(2)
    ]  # fmt: skip
    system = dense_system(full, np.eye(5), [1, 1, 1, 0, 0], *points, tip=[0, 0, 1, 0, 0],
                          preload=[0, 0, 0, *(-rng.uniform(0.5, 5.0, 2))])  # fmt: skip
    system = dataclasses.replace(system, damping=rng.uniform(0.2, 3.0) * system.mass)
    state = solve_preload(system)
    dwell = Dwell(rng.uniform(2.0, 8.0), 12.0, 4.0, ramp_cycles=2.0)
    right = history(system, state, dwell, 1.0 / (12.0 * 3200), Scheme.hht(0.0))
    errors = []
    for steps in (80, 320):
        found = history(system, state, dwell, 1.0 / (12.0 * steps), EXACT)
        errors.append(difference(found, right))
        assert gap(found) < 1e-6
    assert errors[1] < 4e-3
    assert errors[1] < 0.25 * errors[0] + 1e-4


def test_coulomb_friction_takes_four_mu_n_over_k_per_cycle() -> None:
    """Free decay after a pulse: the only mode sticks with 3e8 N/m and slides with 1e4 N/m.

    It is not resolved, and the midpoint rule with a weight of 0.55 damps its sliding by 0.05 omega h: 3e-4 here, which
    takes another 2 % of the drop at the largest of the peaks.
    """
    system = coulomb_oscillator(gamma=1e-8)
    dt = 2.0 * np.pi / 100.0 / 1000
    run = TrigonometricStepper(system, solve_preload(system), EXACT, NewtonOptions(), dt=dt)
    base = np.zeros(1000 * 6)
    base[:250] = 150.0 * np.sin(np.pi * np.arange(250) / 250)
    records = run.advance(base, dt, 0.0)
    u = np.abs(records[300:, 0])
    peaks = u[1:-1][(u[1:-1] > u[:-2]) & (u[1:-1] >= u[2:])]
    assert len(peaks) > 4
    np.testing.assert_allclose(-np.diff(peaks)[:4], 2.0 * 0.3 * 10.0 / 1.0e4, rtol=4e-2)


def test_a_lifting_mass_follows_its_opening() -> None:
    """Penalty contact that opens and closes: implicit, to second order, against fine steps of HHT."""
    system = lifting_mass()
    state, dwell = solve_preload(system), Dwell(20.0, 20.0, 10.0, ramp_cycles=2.0)
    right = history(system, state, dwell, 1.0 / (20.0 * 3200), Scheme.hht(0.0))
    assert float(right["open_fraction"].max()) == 1.0
    coarse, fine = (history(system, state, dwell, 1.0 / (20.0 * n), EXACT) for n in (50, 200))
    assert difference(fine, right) < 1e-2
    assert difference(fine, right) < 0.3 * difference(coarse, right)
    assert gap(fine) < 1e-6


def test_what_it_cannot_follow_is_refused() -> None:
    system, state = prepared("preload.pressure=1.0e3")
    run = TrigonometricStepper(system, state, EXACT, NewtonOptions(), dt=DT, largest_error=1e-2)
    with pytest.raises(ReductionError, match=r"use integrator\.scheme: hht"):
        simulate(system, state, STRONG, dt=DT, scheme=EXACT, stepper=run)
    falling = RateCoulomb(0.3, 1e-6, (0.0, 1e-3), (0.3, 0.2))
    for law, words in ((SmoothedCoulomb(0.3, 1e-6), "friction without memory"), (falling, "falls with the slip rate")):
        point = contact_point([0, 1], [1, 0], [0, 0], mu=0.5, gamma=1e-4, kn=1.0e8)
        point = dataclasses.replace(point, friction=law)
        rough = dense_system(np.diag([5.0e3, 0.0]), np.eye(2), [1, 0], point, tip=[1, 0], preload=[0, -1.0])
        with pytest.raises(InputError, match=words):
            TrigonometricStepper(rough, solve_preload(rough), EXACT, NewtonOptions(), dt=1e-3)
    for method in ("condensed", "full"):
        with pytest.raises(InputError, match="does not propagate modes"):
            make_stepper(system, state, method=method, scheme=EXACT, options=NewtonOptions(), dt=DT)


@pytest.mark.parametrize("stops", [pytest.param([2], marks=pytest.mark.slow), [1, 2]])
def test_a_resumed_run_is_the_same_bit_by_bit(
    stops: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "CHUNK", 50)
    options = {"dt": DT, "scheme": EXACT, "method": "reduced", "every": 10}
    system, state = prepared("damping.modal=0.01")
    motion = Dwell(30.0, 150.0, 4.0, ramp_cycles=2.0)
    whole = simulate(system, state, motion, **options)  # type: ignore[arg-type]
    path = tmp_path / "state.npz"
    for number, stop in enumerate(stops):
        with interrupted(monkeypatch, TrigonometricStepper, stop):
            simulate(system, state, motion, checkpoint=Checkpointing(path, resume=number > 0), **options)  # type: ignore[arg-type]
    rest = simulate(system, state, motion, checkpoint=Checkpointing(path, resume=True), **options)  # type: ignore[arg-type]
    for name in whole.variables:
        np.testing.assert_array_equal(rest[name].values, whole[name].values, err_msg=str(name))
    assert rest.attrs["reduction_error_estimate"] == whole.attrs["reduction_error_estimate"]


def test_an_orbiting_mass_slips_along_a_circle_as_with_hht() -> None:
    """Two directions of slip, varying pressure."""
    system = orbiting_mass()
    state, dwell = solve_preload(system), Dwell(20.0, 12.0, 8.0, ramp_cycles=2.0)
    right = history(system, state, dwell, 2.5e-5, HHT)
    found = history(system, state, dwell, 2.5e-4, EXACT)
    a = np.interp(found["time"], right["time"], right["tip_displacement"])
    assert np.abs(found["tip_displacement"].values - a).max() < 2e-2 * np.abs(a).max()


def test_the_scheme_has_no_period_error() -> None:
    assert numerical_damping(EXACT, 0.5) == (0.0, 0.0)
