"""Harmonic balance against exact periodic solutions, closed forms, time histories and its own energy balance."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import root
from support.empty_figures import empty_figures
from support.exact_systems import coulomb_oscillator, oscillator, slipping_pair
from support.periodic import LAB, TURN, balance, complete, largest, small_roll, with_friction

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.case import load_case
from wroll_fem.contact.rate_coulomb import RateCoulomb
from wroll_fem.contact.smoothed_coulomb import SmoothedCoulomb
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.harmonic_balance import HarmonicBalance, solve_motion
from wroll_fem.dynamics.periodic.response import solve_response
from wroll_fem.dynamics.reduction.condensation import condense
from wroll_fem.dynamics.reduction.reduced_model import ReducedModel
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.statics.preload import solve_preload
from wroll_fem.dynamics.system.system import System
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.full import FullStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme
from wroll_fem.dynamics.time_stepping.records import FRICTION, INPUT, KINETIC, NUMERICAL, STRAIN, VISCOUS
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.dynamics.training.enrichment import trained_response
from wroll_fem.errors import InputError
from wroll_fem.jobs.run import run_case
from wroll_fem.numerics.continuation import StepControl
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.transmissibility import magnitude

# --- closed forms -----------------------------------------------------------------------------------------------------


def test_linear_oscillator_has_the_textbook_transmissibility() -> None:
    """Relative damping: T = (1 + 2 i zeta r) / (1 - r^2 + 2 i zeta r)."""
    plain, f_n, zeta = oscillator(10.0), 10.0, 0.02
    system = dataclasses.replace(plain, damping=2.0 * zeta * TURN * f_n * plain.mass)
    model = ReducedModel.complete(condense(system, np.zeros(0), Scheme.hht(0.0), 1e-3))
    curve = solve_response(model, ContactState.unloaded(system), system.laws, amplitude=3.0, frequencies=(6.0, 15.0))
    r = curve.frequencies / (TURN * f_n)
    exact = (1 + 2j * zeta * r) / (1 - r**2 + 2j * zeta * r)
    np.testing.assert_allclose(curve.transmissibility, exact, rtol=2e-6)  # of the continuation's tolerance, 1e-7
    assert curve.frequencies[[0, -1]] == pytest.approx([TURN * 6.0, TURN * 15.0], rel=1e-12)
    assert curve.folds == 0
    assert curve.stable.all()
    assert np.abs(curve.transmissibility).max() == pytest.approx(np.abs(exact).max())
    assert np.abs(curve.transmissibility).max() > 0.99 * np.hypot(1.0, 2 * zeta) / (2 * zeta)


def bilinear_half_cycle(
    frequency: float, acceleration: float, stiffness: float, spring: float, limit: float, guess: tuple[float, float]
) -> tuple[float, float, float]:
    """Exact steady motion of 1 kg on ``stiffness`` and a Jenkins element (``spring``, ``limit``), base A cos(wt).

    From its turning point X at time a, the mass moves back with the element stuck until that has turned by
    2 limit/spring, then with it slipping until it stands still at -X half a period later. Both pieces are
    solved in closed form; three conditions fix X and the times.

    Returns
    -------
    X (m), phases w a and w b of the turning point and of the onset of slip
    """
    w, delta = frequency, limit / spring

    def motion(t: float, t_0: float, x_0: float, v_0: float, natural: float, constant: float) -> tuple[float, float]:
        def forced(time: float) -> tuple[float, float]:
            gain = acceleration / (natural**2 - w**2)
            return -gain * np.cos(w * time) - constant / natural**2, gain * w * np.sin(w * time)

        a, b = x_0 - forced(t_0)[0], (v_0 - forced(t_0)[1]) / natural
        c, s = np.cos(natural * (t - t_0)), np.sin(natural * (t - t_0))
        return forced(t)[0] + a * c + b * s, forced(t)[1] + natural * (b * c - a * s)

    size = guess[0]

    def conditions(u: np.ndarray) -> list[float]:
        x, start, slips = u[0] * size, u[1] / w, u[2] / w
        x_1, v_1 = motion(slips, start, x, 0.0, np.sqrt(stiffness + spring), limit - spring * x)
        x_2, v_2 = motion(start + np.pi / w, slips, x_1, v_1, np.sqrt(stiffness), -limit)
        return [(x_1 - x + 2.0 * delta) / size, (x_2 + x) / size, v_2 / (w * size)]

    for lag in np.linspace(0.2, 3.0, 15):
        found = root(conditions, [1.0, guess[1], guess[1] + lag], tol=1e-13)
        if found.success and abs(found.x[0] - 1.0) < 0.1 and 0.0 < found.x[2] - found.x[1] < np.pi:
            return float(found.x[0]) * size, float(found.x[1]), float(found.x[2])
    raise AssertionError("no exact solution found")


def bilinear_errors(system: System, acceleration: float, frequency: float, limit: float, spring: float) -> list[float]:
    """Relative error of the amplitude for H = 1, 3, 7, 15."""
    sizes = []
    for harmonics in (1, 3, 7, 15):
        problem = balance(system, acceleration, harmonics, 1024)
        q = solve_motion(problem, frequency)
        sizes.append(largest(q, problem.model.tip))
    phase = float(np.argmax(Sampling(15, 4000).values @ q @ problem.model.tip) * TURN / 4000)
    exact = bilinear_half_cycle(frequency, acceleration, 1e4, spring, limit, (sizes[-1], phase))[0]
    assert exact > 1.2 * limit / spring  # it does slip
    return [size / exact - 1.0 for size in sizes]


@pytest.mark.parametrize("hertz", [19.0, 20.0, 22.0])
def test_bilinear_oscillator_converges_to_its_exact_periodic_motion(hertz: float) -> None:
    gamma, limit = 2e-4, 3.0
    errors = np.abs(bilinear_errors(coulomb_oscillator(gamma=gamma), 2.5, TURN * hertz, limit, limit / gamma))
    assert errors[0] > 1e-3
    assert errors[2] < 3e-4
    assert errors[3] < 2e-5
    assert errors[3] < errors[2] < errors[0]


def test_peak_of_the_bilinear_oscillator_is_exact_at_seven_harmonics() -> None:
    """Caughey (1960), J. Appl. Mech. 27, 640, gives H = 1; the exact peak is that of the piecewise solutions."""
    gamma, limit, acceleration = 2e-4, 3.0, 2.5
    system = coulomb_oscillator(gamma=gamma)
    model, preload = complete(system)
    peaks = {}
    for harmonics in (1, 7):
        curve = solve_response(
            model, preload, system.laws, amplitude=acceleration, frequencies=(16.0, 24.0), harmonics=harmonics,
            samples=512, control=StepControl(largest=0.03),  # a parabola through three points reads the peak
        )  # fmt: skip
        size = np.array([largest(q, model.tip) for q in curve.coefficients])
        k = int(size.argmax())
        fit = np.polynomial.Polynomial.fit(curve.frequencies[k - 1 : k + 2], size[k - 1 : k + 2], 2)
        peaks[harmonics] = float(fit(fit.deriv().roots()[0].real)), float(fit.deriv().roots()[0].real)
    top, at = peaks[7]
    q = curve.coefficients[k]
    phase = float(np.argmax(Sampling(7, 4000).values @ q @ model.tip) * TURN / 4000)
    near = np.linspace(0.99, 1.01, 9) * at
    exact = np.array([bilinear_half_cycle(w, acceleration, 1e4, limit / gamma, limit, (top, phase))[0] for w in near])
    fit = np.polynomial.Polynomial.fit(near, exact, 4)
    roots = fit.deriv().roots()
    best = float(roots[np.argmin(np.abs(roots - at))].real)
    assert top == pytest.approx(float(fit(best)), rel=1e-3)
    assert at == pytest.approx(best, rel=1e-3)
    assert abs(peaks[1][0] / float(fit(best)) - 1.0) > 1e-3


@pytest.mark.parametrize("hertz", [14.0, 18.0])
def test_coulomb_oscillator_converges_to_den_hartogs_exact_solution(hertz: float) -> None:
    r"""Continuous sliding, r = w/w_n, force amplitude P = m A:

    .. math:: x_0^2 = (P/k)^2 / (1 - r^2)^2 - (F/k)^2 [\sin(\pi/r) / (r (1 + \cos(\pi/r)))]^2

    The friction force jumps, so truncation errs by O(1/H): each doubling of H halves it, and the limit is Den
    Hartog's. Den Hartog (1931), Trans. ASME 53, APM-53-9, 107.
    """
    limit, acceleration = 3.0, 5.0
    system = with_friction(coulomb_oscillator(), SmoothedCoulomb(0.3, 3e-4))
    r = TURN * hertz / 100.0
    friction = np.sin(np.pi / r) / (r * (1 + np.cos(np.pi / r)))
    exact = np.sqrt((acceleration / (1 - r * r)) ** 2 - (limit * friction) ** 2) / 1e4
    errors = []
    for harmonics in (7, 15, 31):
        problem = balance(system, acceleration, harmonics, 1024)
        errors.append(largest(solve_motion(problem, TURN * hertz), problem.model.tip) / exact - 1.0)
    assert abs(errors[0]) > 0.01
    np.testing.assert_allclose(errors[1:], np.array(errors[:-1]) / 2.0, rtol=0.1)
    assert abs(2.0 * errors[2] - errors[1]) < 2e-3


# --- time histories and energy ----------------------------------------------------------------------------------------


def damped_pair() -> System:
    """`slipping_pair` with dashpots, so that what rings at the start dies out; soft enough that 9 harmonics do."""
    return dataclasses.replace(slipping_pair(gamma=2e-4), damping=sp.csr_matrix(np.diag([16.0, 8.0, 60.0])))


SOFT_LAWS = {
    "penalty": None,
    "rate": RateCoulomb(0.3, 2e-4, rates=(0.0, 0.02, 0.2), coefficients=(0.3, 0.25, 0.15)),
    "smoothed": SmoothedCoulomb(0.3, 0.02),
}


def steady_cycle(system: System, acceleration: float, frequency: float, cycles: int, steps: int) -> tuple:
    """Tip over the last cycle (steps,) of a shaken start, and what the last cycle added to every record.

    By the compiled steps of `CondensedStepper`, which keep every mode; `FullStepper` has the same first cycles.
    """
    dt = TURN / (frequency * steps)
    preload, scheme, options = solve_preload(system), Scheme.hht(0.0), NewtonOptions()
    time = dt * np.arange(cycles * steps + 1)
    base = np.minimum(1.0, time * frequency / (TURN * 10.0)) * acceleration * np.cos(frequency * time)
    records = CondensedStepper(system, preload, scheme, options, dt=dt).advance(base, dt, 0.0)
    first = FullStepper(system, preload, scheme, options).advance(base[: 2 * steps + 1], dt, 0.0)[:, 0]
    np.testing.assert_allclose(records[: 2 * steps, 0], first, atol=1e-6 * np.abs(first).max())  # Newton's tolerance
    return records[-steps:, 0], records[-1] - records[-1 - steps]


@pytest.mark.parametrize(("law", "tolerance"), [("penalty", 1e-3), ("rate", 4e-3), ("smoothed", 1e-2)])
def test_time_history_settles_on_the_harmonic_balance(law: str, tolerance: float) -> None:
    """Every harmonic of the tip. HHT at alpha = 0 is off by O(dt^2); its slip rates lag by half a step, O(dt)."""
    system, frequency, acceleration, steps = damped_pair(), TURN * 20.0, 4.0, 200
    if SOFT_LAWS[law] is not None:
        system = with_friction(system, SOFT_LAWS[law])
    tip, cycle = steady_cycle(system, acceleration, frequency, 30, steps)
    found = Sampling(9, steps).project @ np.roll(tip, 1)  # records start one step after the phase 0
    problem = balance(system, acceleration, 9, 800)
    q = solve_motion(problem, frequency)
    expected = q @ problem.model.tip
    np.testing.assert_allclose(found[:7], expected[:7], atol=tolerance * np.abs(expected).max())
    assert np.abs(expected[3:]).max() > 5e-3 * np.abs(expected).max()
    assert cycle[NUMERICAL] == pytest.approx(0.0, abs=1e-3 * cycle[INPUT])
    work = problem.cycle_work(q, frequency)
    assert work.input == pytest.approx(cycle[INPUT], rel=2 * tolerance)
    assert work.friction == pytest.approx(cycle[FRICTION], rel=5 * tolerance)
    assert work.viscous == pytest.approx(cycle[VISCOUS], rel=5 * tolerance)
    assert work.friction > 0.1 * work.input


@pytest.mark.parametrize("law", SOFT_LAWS)
def test_input_of_a_cycle_is_what_friction_and_dashpots_take(law: str) -> None:
    """Exactly with the interface's work at the samples, and at O(1/N^2) with traction times plastic slip."""
    system, frequency = damped_pair(), TURN * 20.0
    if SOFT_LAWS[law] is not None:
        system = with_friction(system, SOFT_LAWS[law])
    gaps = []
    for samples in (64, 512, 4096):
        problem = balance(system, 4.0, 3, samples)
        work = problem.cycle_work(solve_motion(problem, frequency), frequency)
        assert work.input == pytest.approx(work.interface + work.viscous, rel=1e-6)
        gaps.append(abs((work.friction + work.modulation + work.viscous) / work.input - 1.0))
        assert work.friction > 0.1 * work.input
    assert gaps[0] < 5e-3
    assert gaps[1] < 1e-4
    assert gaps[2] < 1e-6


def test_viscous_damping_in_time_steps_is_second_order_and_balanced() -> None:
    """Free decay of a damped oscillator against its closed form; input + start = kinetic + strain + viscous."""
    zeta, w = 0.05, TURN * 10.0
    plain = oscillator(10.0)
    system = dataclasses.replace(plain, damping=2.0 * zeta * w * plain.mass)
    errors = []
    for steps in (50, 100, 200):
        dt = 0.1 / steps
        stepper = FullStepper(system, ContactState.unloaded(system), Scheme.hht(0.0), NewtonOptions())
        stepper.start_from(np.array([1e-3]))
        records = stepper.advance(np.zeros(5 * steps + 1), dt, 0.0)
        time, damped = dt * np.arange(1, 5 * steps + 1), w * np.sqrt(1 - zeta**2)
        exact = 1e-3 * np.exp(-zeta * w * time) * (np.cos(damped * time) + zeta * w / damped * np.sin(damped * time))
        errors.append(np.abs(records[:, 0] - exact).max())
        start = 0.5 * plain.stiffness[0, 0] * 1e-6
        total = records[:, KINETIC] + records[:, STRAIN] + records[:, VISCOUS] + records[:, NUMERICAL]
        np.testing.assert_allclose(total, start, rtol=1e-10)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)


def test_a_damping_matrix_of_another_size_is_refused() -> None:
    with pytest.raises(InputError, match="damping"):
        dataclasses.replace(damped_pair(), damping=sp.csr_matrix(np.eye(2)))
    with pytest.raises(InputError, match="symmetric"):
        dataclasses.replace(damped_pair(), damping=sp.csr_matrix([[1.0, 2.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))


# --- the roll ---------------------------------------------------------------------------------------------------------


def test_the_basis_made_by_the_curve_gives_the_tip_of_all_modes() -> None:
    """Every mode kept (no reduction at all) against the trained basis, at the peak and on a flank: tip to 1e-4."""
    system, preload, condensation = small_roll(8, 2)
    keywords = {"amplitude": 8.0, "harmonics": 1, "samples": 64}
    trained = trained_response(
        condensation, preload, system.laws, frequencies=(130.0, 180.0), tolerance=3e-4, **keywords
    )
    curve = trained.curve
    assert curve.balance.model.size < len(condensation.eigenvalues) / 3
    assert trained.energy_error < 3e-4
    everything = ReducedModel.complete(condensation)
    contact = HarmonicContact(everything, preload, system.laws, Sampling(1, 64))
    whole = HarmonicBalance(contact, 8.0)
    peak = int(np.abs(curve.transmissibility).argmax())
    for k in (peak, peak + 8):
        w = curve.frequencies[k]
        start = curve.coefficients[k] @ curve.balance.model.vectors.T
        q = solve_motion(whole, w, start)
        assert whole.residual(q, w)[1].hysteresis.sliding.any()
        exact = np.hypot(*(q[1:3] @ everything.tip))
        assert np.hypot(*(curve.coefficients[k, 1:3] @ curve.balance.model.tip)) == pytest.approx(exact, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("pressure", ["1e4", "1e5"])
def test_a_slow_chirp_traces_the_harmonic_balance(pressure: str) -> None:
    low = "120" if pressure == "1e4" else "140"
    case = load_case(
        LAB,
        ["mesh={circumferential: 12, axial: 4, grading: 1}", f"preload.pressure={pressure}",
         f"excitation.f_start={low}", f"excitation.f_end={170 if pressure == '1e5' else 152}",
         "excitation.ramp_cycles=20", "output.figures=false"],
    )  # fmt: skip
    data = run_analysis(case, progress=SilentProgress())
    steady = summarise(data, case)
    # at 30 steps the peak is 2 % low; in a basis the least pressure, at one point and time, is 2 to 4 % low
    chirp = case.changed("analysis=sweep", "integrator.steps_per_cycle=60", "solver.method=condensed")
    swept = summarise(run_analysis(chirp, progress=SilentProgress()), chirp)
    assert steady["f_n_hz"] == pytest.approx(swept["f_n_hz"], rel=3e-3)
    assert steady["peak_transmissibility"] == pytest.approx(swept["peak_transmissibility"], rel=0.01)
    assert steady["energy_balance_error"] < 5e-3
    # the work of a cycle gives the damping that the height of the peak shows
    top = int(magnitude(data).values.argmax())
    by_height = abs(data.attrs["tip_participation"]) / (2.0 * steady["peak_transmissibility"])
    assert float(data["friction_modal_damping"][top]) == pytest.approx(by_height, rel=0.05)
    assert steady["slipping_area_fraction"][0] > 0.02
    assert steady["open_area_fraction"] == swept["open_area_fraction"] == [0.0]
    assert steady["min_pressure_over_preload"] == pytest.approx(swept["min_pressure_over_preload"], rel=0.01)


@pytest.mark.slow
def test_sixty_four_samples_give_the_curve_of_five_hundred() -> None:
    """Samples at constant phases left ripples of 3e-4 in f_n and 1.5e-3 in zeta."""
    read = []
    for samples in (64, 512):
        case = load_case(LAB, ["mesh={circumferential: 12, axial: 6, grading: 8}", f"harmonic.samples={samples}"])
        read.append(run_analysis(case, progress=SilentProgress()).attrs)
    few, many = read
    allowed = {"half_power_low_hz": 1e-5, "half_power_high_hz": 5e-5, "f_n_hz": 1e-4, "peak_transmissibility": 3e-4}
    for name, relative in (allowed | {"zeta": 7e-4}).items():
        assert few[name] == pytest.approx(many[name], rel=relative)


@pytest.mark.slow
def test_results_of_both_analyses_are_kept_and_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    empty_figures(monkeypatch)
    mesh = "mesh={circumferential: 8, axial: 3, grading: 1}"  # with 2 rows the curve has an internal resonance
    few = "harmonic.harmonics=3"
    case = load_case(LAB, [mesh, few, "excitation.f_start=140", "excitation.f_end=170"])
    run = run_case(case, tmp_path / "harmonic")
    assert {"f_n_hz", "zeta", "peak_transmissibility", "reduction_error_estimate", "folds"} <= set(run.summary)
    assert (tmp_path / "harmonic" / "figures" / "transmissibility.png").is_file()
    stored = load_dataset(tmp_path / "harmonic" / "results.nc")
    assert stored["slip_amplitude"].dims == ("frequency", "interface", "point")
    assert half_power(stored["frequency"].values, magnitude(stored).values).f_n == pytest.approx(run.summary["f_n_hz"])
    case = load_case(LAB.with_name("lab_backbone.yaml"), [mesh, few])
    run = run_case(case, tmp_path / "backbone")
    assert run.summary["zeta_max"] > 0.01
    assert (tmp_path / "backbone" / "figures" / "backbone.png").is_file()
