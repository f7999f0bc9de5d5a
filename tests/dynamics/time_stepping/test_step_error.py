"""Error of the time step: closed forms against integrated oscillators, exact solutions and finer runs of a roll."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.exact_systems import oscillator
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis, summarise
from wroll_fem.analyses.shared.time_step import WANTED, detuned_harmonic, steps_per_cycle, sweep_step_error
from wroll_fem.case import load_case
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.time_stepping.full import FullStepper
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.time_stepping.simulate import simulate
from wroll_fem.dynamics.time_stepping.step_error import (
    FINER,
    FITTED_CYCLES,
    Oscillator,
    curve_error,
    fitted_oscillator,
    history_error,
    without_ripple,
)
from wroll_fem.dynamics.time_stepping.stepper import NewtonOptions
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.base_motion import Dwell
from wroll_fem.signals.transmissibility import magnitude
from wroll_fem.typing import FloatArray

TURN = 2.0 * np.pi
SCHEMES = [Scheme.hht(-0.05), Scheme.named("no_damping"), Scheme.named("quasi_static")]


def integrated(f_n: float, zeta: float, motion: Dwell, dt: float, scheme: Scheme) -> np.ndarray:
    """History of the tip of one mass with a dashpot, by the full stepper."""
    plain = oscillator(f_n)
    system = dataclasses.replace(plain, damping=2.0 * zeta * TURN * f_n * plain.mass)
    state = ContactState.unloaded(system)
    stepper = FullStepper(system, state, scheme, NewtonOptions())
    found = simulate(system, state, motion, dt=dt, scheme=scheme, stepper=stepper)
    return np.asarray(found["tip_displacement"].values)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_filter_gives_the_steps_of_the_full_solver(scheme: Scheme) -> None:
    motion, dt = Dwell(1.0, 9.0, 6.0, ramp_cycles=2.0), 1.0 / (9.0 * 40)
    right = integrated(10.0, 0.02, motion, dt, scheme)
    base = motion.acceleration(dt * np.arange(len(right)))
    np.testing.assert_allclose(
        Oscillator(10.0, 0.02).response(scheme, dt, base), right, atol=1e-9 * np.abs(right).max()
    )


def test_an_oscillator_whose_friction_never_slides_is_the_linear_one() -> None:
    motion, dt, scheme = Dwell(1.0, 9.0, 8.0, ramp_cycles=2.0), 1.0 / (9.0 * 40), SCHEMES[0]
    base = motion.acceleration(dt * np.arange(321))
    linear = Oscillator(10.0, 0.01).response(scheme, dt, base)
    stuck = Oscillator(10.0, 0.01, friction=0.4, slip=1e3).response(scheme, dt, base)
    np.testing.assert_allclose(stuck, linear, atol=1e-9 * np.abs(linear).max())
    sliding = Oscillator(10.0, 0.01, friction=0.4, slip=0.2 * np.abs(linear).max()).response(scheme, dt, base)
    assert np.abs(sliding - linear).max() > 0.1 * np.abs(linear).max()


@pytest.mark.parametrize("zeta", [0.003, 0.05])
@pytest.mark.parametrize("driven", [8.0, 9.8, 10.0, 12.0])
def test_the_error_of_a_dwell_is_that_against_the_exact_solution(driven: float, zeta: float) -> None:
    """Sharp and broad peaks, below, at and above resonance; the reference is a Runge-Kutta solution to 1e-9."""
    scheme, motion = Scheme.hht(-0.05), Dwell(1.0, driven, 15.0, ramp_cycles=3.0)
    dt, w = 1.0 / (driven * 40), TURN * 10.0
    found = integrated(10.0, zeta, motion, dt, scheme)
    times = dt * np.arange(len(found))

    def rates(t: float, y: np.ndarray) -> list[float]:
        return [y[1], -2.0 * zeta * w * y[1] - w**2 * y[0] - float(motion.acceleration(t))]

    exact = solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], "DOP853", times, rtol=1e-9, atol=1e-13).y[0]
    error = np.abs(found - exact).max() / np.abs(exact).max()
    fitted, misfit = fitted_oscillator(scheme, dt, motion, found)
    assert misfit < 1e-3
    assert (fitted.frequency_hz, fitted.zeta) == pytest.approx((10.0, zeta), rel=0.02)
    assert history_error(scheme, dt, motion, fitted) == pytest.approx(error, rel=0.1)


def test_a_long_record_is_fitted_by_its_first_cycles_alone() -> None:
    motion, dt, scheme = Dwell(5.0, 9.8, 150, 10), 1.0 / (9.8 * 40), Scheme.hht(-0.05)
    found = Oscillator(10.0, 0.003).response(scheme, dt, motion.acceleration(dt * np.arange(150 * 40 + 1)))
    later = found.copy()
    later[dt * np.arange(len(found)) > FITTED_CYCLES / 9.8 + dt] = 0.0
    fits = [fitted_oscillator(scheme, dt, motion, record) for record in (found, later)]
    assert fits[0] == fits[1]
    assert (fits[0][0].frequency_hz, fits[0][0].zeta) == pytest.approx((10.0, 0.003), rel=0.01)


def steady_curve(scheme: Scheme, dt: float, oscillator: Oscillator, frequency: FloatArray) -> FloatArray:
    """|T| of an oscillator that HHT integrates until it is steady: the transfer function of the recursive filter."""
    z = np.exp(1j * TURN * frequency * dt)
    weight = np.polyval([1.0 + scheme.alpha, -scheme.alpha], z)
    return np.asarray(np.abs(1.0 - weight * (z - 1.0) ** 2 / np.polyval(oscillator.filter(scheme, dt)[1], z)))


@pytest.mark.parametrize("name", ["hht", "moderate_dissipation"])
@pytest.mark.parametrize("zeta", [0.005, 0.02, 0.1])
def test_the_error_of_a_linear_peak_is_that_of_a_finer_step(name: str, zeta: float) -> None:
    """For a sharp peak it is the steepest slope of |T|, 0.385 of the peak per half-power half-width, times 0.23 %."""
    scheme = Scheme.hht(-0.05) if name == "hht" else Scheme.named(name)
    dt, frequency = 1.0 / (10.0 * 40), np.linspace(5.0, 15.0, 4001)
    coarse, fine = (steady_curve(scheme, step, Oscillator(10.0, zeta), frequency) for step in (dt, dt / FINER))
    right = float(np.abs(coarse - fine).max() / fine.max())
    added, longer = numerical_damping(scheme, TURN / 40)
    found = curve_error(scheme, dt, frequency, coarse, zeta + added)
    assert 0.5 < found / right < 2.0
    if name == "hht" and zeta == 0.02:
        assert found == pytest.approx(right, rel=0.1)
        assert found == pytest.approx(0.385 * longer / zeta, rel=0.1)


def test_ripple_on_a_flank_is_no_error_of_the_step() -> None:
    """A smaller step damps the ripple less; its shift kept the estimate from falling with the step."""
    frequency = np.linspace(8.0, 12.0, 2001)
    plain = 20.0 / np.hypot(1.0, (frequency - 10.0) / np.where(frequency < 10.0, 0.05, 0.5))
    place = np.where((frequency > 9.0) & (frequency < 9.9), np.sin(np.pi * (frequency - 9.0) / 0.9) ** 2, 0.0)
    for steps, ripple in ((40, 1.0), (80, 2.0), (160, 4.0)):
        rings = plain + ripple * place * np.sin(200.0 * frequency)
        smooth, found, raw = (
            curve_error(SCHEMES[0], 0.1 / steps, frequency, curve, 0.05)
            for curve in (plain, without_ripple(rings), rings)
        )
        assert found == pytest.approx(smooth, rel=0.1)
    assert raw > 2.0 * smooth  # at the smallest step


def test_the_error_of_a_sweep_with_friction_is_that_of_a_finer_step() -> None:
    """Friction makes the lower flank steep: the same shift of frequency costs three times as much as at a dashpot."""
    words = [
        "analysis=sweep",
        "excitation={kind: chirp, amplitude: 10, f_start: 120, f_end: 180, rate_oct_per_min: 60, ramp_cycles: 10}",
        "mesh={circumferential: 8, axial: 3, grading: 1}", "output.figures=false",
    ]  # fmt: skip
    coarse, fine = (
        run_analysis(
            load_case(CONFIGS / "tiny.yaml", [*words, f"integrator.steps_per_cycle={steps}"]),
            progress=SilentProgress(),
        )
        for steps in (40, 160)
    )
    found = magnitude(coarse)
    right = magnitude(fine).interp(frequency=found["frequency"])
    error = float(np.abs(found - right).max() / right.max())
    assert 0.5 < coarse.attrs["time_step_error"] / error < 2.0


@pytest.mark.parametrize(("frequency", "level"), [(120, 20.0), (150, 5.0), (175, 20.0)])
def test_the_error_of_a_roll_that_slips_is_within_a_factor_of_two_of_a_ten_times_finer_run(
    frequency: float, level: float
) -> None:
    dwell = f"excitation={{kind: dwell, amplitude: {level}, frequency: {frequency}, cycles: 10, ramp_cycles: 3}}"
    words = [
        dwell,
        "solver.method=condensed",
        "mesh={circumferential: 8, axial: 3, grading: 1}",
        "output.figures=false",
    ]
    coarse, fine = (
        run_analysis(
            load_case(CONFIGS / "tiny.yaml", [*words, f"integrator.steps_per_cycle={steps}"]), progress=SilentProgress()
        )
        for steps in (40, 400)
    )
    right = fine["tip_displacement"].values[::10]
    error = np.abs(coarse["tip_displacement"].values - right).max() / np.abs(right).max()
    assert 0.5 < coarse.attrs["time_step_error"] / error < 2.0
    assert fine.attrs["time_step_error"] < 0.03 * error
    told = [text for text in summarise(coarse)["warnings"] if "the time step changes the history" in text]
    assert bool(told) == (coarse.attrs["time_step_error"] > WANTED)


def test_a_mode_that_friction_drives_at_a_harmonic_is_told() -> None:
    """A second resonance at five times the excitation, which the time step detunes, is not in `time_step_error`."""
    dwell = "excitation={kind: dwell, amplitude: 20, frequency: 165, cycles: 20, ramp_cycles: 5}"
    words = [
        dwell,
        "solver.method=condensed",
        "mesh={circumferential: 8, axial: 3, grading: 1}",
        "output.figures=false",
    ]
    found = run_analysis(load_case(CONFIGS / "tiny.yaml", words), progress=SilentProgress())
    told = [text for text in summarise(found)["warnings"] if "lies near 5 times the excitation frequency" in text]
    assert len(told) == 1
    assert "time_step_error does not include this" in told[0]


def test_steps_that_are_left_out_are_chosen_by_the_error() -> None:
    def steps(frequency: float, *words: str, cycles: int = 40, scheme: str = "hht") -> int:
        dwell = f"excitation={{kind: dwell, amplitude: 5, frequency: {frequency}, cycles: {cycles}}}"
        case = load_case(CONFIGS / "lab_dwell.yaml", [dwell, f"integrator={{scheme: {scheme}}}", *words])
        return steps_per_cycle(case)  # type: ignore[arg-type]

    assert steps(150.0) > 40  # near the resonance
    assert steps(600.0) == 40
    assert steps(150.0, "integrator.steps_per_cycle=40") == 40  # written keys stay
    assert steps(150.0, scheme="no_damping") <= steps(150.0)
    assert load_case(CONFIGS / "lab_sweep.yaml", ["integrator={scheme: hht}"]).time_step == pytest.approx(1 / 175 / 40)


@pytest.mark.parametrize(
    "damping",
    ["{modal: %g}", "{modal: [%g, 0.1]}", "{modal: [[100, %g], [400, %g]]}", "{rayleigh: {beta: %g}}",
     "{loss_factor: {mandrel: %g, coil: 0.4}}"],
)  # fmt: skip
def test_the_sharper_the_peak_the_finer_are_the_steps(damping: str) -> None:
    """Off the resonance of the bonded roll by 2 %: a ratio of 0.1 or 1 %, in five ways. Slip adds to a small ratio."""
    turn = 2.0 * np.pi * 160.0
    factor = 2.0 if "loss" in damping else 2.0 / turn if "beta" in damping else 1.0

    def steps(ratio: float, model: str) -> int:
        words = damping.replace("%g", f"{factor * ratio:g}")
        changes = ["excitation={kind: dwell, amplitude: 5, frequency: 160, cycles: 400}", "integrator={scheme: hht}"]
        case = load_case(CONFIGS / "lab_dwell.yaml", [*changes, f"coil.model={model}", f"damping={words}"])
        return steps_per_cycle(case)  # type: ignore[arg-type]

    sharp, usual, broad = (steps(ratio, "bonded") for ratio in (1e-3, 1e-2, 1e-1))
    assert sharp > usual > broad
    assert steps(1e-3, "layers") == steps(1e-2, "layers") > steps(1e-1, "layers")


def test_the_hash_of_histories_with_chosen_steps_names_the_choice() -> None:
    for file, same in (("lab_sweep", True), ("lab_modal", True), ("lab_dwell", False)):
        left_out, written = (
            load_case(CONFIGS / f"{file}.yaml", ["integrator={scheme: hht}", *words])
            for words in ((), ("integrator.steps_per_cycle=40",))
        )
        assert (left_out.hash() == written.hash()) == same


def test_a_mode_that_a_harmonic_of_friction_drives_and_the_step_detunes_is_told() -> None:
    """At 156 Hz and 20 m/s^2 a fine step finds a fifth harmonic of 39 % of the fundamental, 40 steps per cycle 2 %."""
    case = load_case(CONFIGS / "tiny.yaml", ["excitation.frequency=156"])
    modes = {"base": np.array([1.0, 0.3]), "tip": np.array([1.0, -0.4])}
    near, far = (SimpleNamespace(eigenvalues=(TURN * np.array([157.0, f])) ** 2, **modes) for f in (790.0, 900.0))
    text = detuned_harmonic(case, near)  # type: ignore[arg-type]
    assert "a mode at 790 Hz lies near 5 times the excitation frequency" in text
    steps = int(text.rsplit(" ", 1)[1])
    assert steps > 80
    assert detuned_harmonic(case.changed(f"integrator.steps_per_cycle={steps}"), near) == ""  # type: ignore[arg-type]
    assert detuned_harmonic(case, far) == ""  # type: ignore[arg-type]


def test_coarse_steps_whose_error_is_unknown_are_told() -> None:
    """No oscillator fits what 3 steps per cycle leave of a dwell, and no peak is read from a flat curve."""
    words = ["solver.allow_coarse=true", "output.figures=false", "mesh={circumferential: 8, axial: 3, grading: 1}"]
    told = "the error by the time step is unknown, and {} steps per cycle are too few to rely on"
    dwell = load_case(CONFIGS / "tiny.yaml", [*words, "integrator.steps_per_cycle=3"])
    progress = SilentProgress()
    found = run_analysis(dwell, progress=progress)
    assert np.isnan(found.attrs["time_step_error"])
    assert sum(told.format(3) in text for text in progress.warnings) == 1
    unread = SimpleNamespace(resonant=False)
    chirp = [*words, "excitation={kind: chirp, amplitude: 1, f_start: 100, f_end: 200, rate_oct_per_min: 60}"]
    for steps, warned in ((10, True), (19, True), (20, False)):
        sweep = load_case(CONFIGS / "tiny.yaml", [*chirp, "analysis=sweep", f"integrator.steps_per_cycle={steps}"])
        error, text = sweep_step_error(sweep, (np.ones(3), np.ones(3)), unread)  # type: ignore[arg-type]
        assert np.isnan(error)
        assert (told.format(steps) in text) == warned
