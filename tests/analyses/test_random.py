r"""Analysis random: linear structures against closed forms, a friction oscillator against an independent integration.

The oscillators have 20 Hz, so that a minute of random motion takes a second of computing.
"""

from __future__ import annotations

import re
from math import log10, pi
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import trapezoid
from support.paths import CONFIGS
from support.random_cases import DASHPOT, LIMIT, MASS, SPRING, STEPS, STIFFNESS, linear_case, rubbing_case

import wroll_fem as wf
from wroll_fem.analyses.random import read_spectra
from wroll_fem.analyses.shared.preflight import random_warnings
from wroll_fem.analyses.shared.time_step import steps_per_cycle
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.errors import InputError
from wroll_fem.jobs.run import run_case
from wroll_fem.progress import SilentProgress
from wroll_fem.signals.motions import base_motion
from wroll_fem.typing import ComplexArray, FloatArray

GRAVITY = 9.80665
SILENT = SilentProgress()
LONG_STEPS = "integrator.steps_per_cycle=20"
"""Half as many steps as `STEPS`, for claims that hold at any step."""


def transfer(f: FloatArray, f_n: float, zeta: float) -> ComplexArray:
    r = f / f_n
    return (1.0 + 2j * zeta * r) / (1.0 - r**2 + 2j * zeta * r)


def closed_form(f_n: float, zeta: float) -> tuple[float, float]:
    """Rms of the absolute acceleration, m/s^2, and of the relative displacement, m: integrals over the PSD."""
    f = np.linspace(5.0, 40.0, 200001)
    density = 0.001 * GRAVITY**2
    relative = 1.0 / ((2.0 * pi) ** 2 * (f_n**2 - f**2 + 2j * zeta * f_n * f))
    squares = (np.abs(transfer(f, f_n, zeta)) ** 2, np.abs(relative) ** 2)
    acceleration, displacement = (float(np.sqrt(density * trapezoid(square, f))) for square in squares)
    return acceleration, displacement


@pytest.mark.parametrize(
    ("f_n", "zeta", "seed", "duration"),
    [pytest.param(20.0, 0.02, 1, 60.0, marks=pytest.mark.slow), (16.3, 0.034, 7, 40.0)],
)
def test_a_linear_structure_has_rms_h1_and_zeta_of_the_closed_form(
    f_n: float, zeta: float, seed: int, duration: float
) -> None:
    result = wf.run(linear_case(f_n, zeta, seed=seed, duration=duration), progress=SILENT)
    found = wf.summarise(result)
    acceleration, displacement = closed_form(f_n, zeta)
    stated = 3.0 * found["tip_rms_error"]
    assert 0.005 < found["tip_rms_error"] < 0.06
    assert found["tip_rms_m_s2"] == pytest.approx(acceleration, rel=stated)
    assert found["tip_displacement_rms_m"] == pytest.approx(displacement, rel=stated)
    assert found["base_rms_m_s2"] == pytest.approx(found["psd_rms_m_s2"], rel=0.01)  # without the first second
    longer = numerical_damping(Scheme.hht(-0.05), 2.0 * pi * f_n / (40.0 * STEPS))[1]  # of the time step
    assert found["f_n_hz"] == pytest.approx(f_n / (1.0 + longer), abs=3.0 * found["f_n_error_hz"] + 1e-4 * f_n)
    assert found["zeta"] == pytest.approx(zeta, abs=3.0 * found["zeta_error"] + 0.003 * zeta)  # bias left: 0.2 %
    assert found["zeta_error"] < 0.02 * zeta
    assert found["zeta_quality"] == "ok", found["zeta_doubts"]
    assert found["psd_random_error"] == pytest.approx(found["psd_averages"] ** -0.5, rel=1e-12)
    f = result["frequency"].values
    size = np.hypot(result["transmissibility_real"], result["transmissibility_imag"]).values
    exact = np.abs(transfer(f, f_n / (1.0 + longer), zeta))
    near = np.abs(f - f_n) < 4.0 * zeta * f_n
    far = ~near & (result["coherence"].values > 0.999)
    stated = np.abs(size / exact - 1.0)[near] / result["h1_error"].values[near]  # leakage: coherence of 0.985
    assert np.sqrt(np.mean(stated**2)) < 1.8  # the correction for the resolution raises the noise by up to 1.4
    assert stated.max() < 5.0
    assert np.abs(size / exact - 1.0)[far].max() < 0.03
    assert result["coherence"].values[near].min() > 0.95
    assert abs(found["friction_energy_j"]) < 1e-12 * found["input_work_j"]


@pytest.mark.slow
@pytest.mark.parametrize(("f_n", "zeta", "seed"), [(20.0, 0.02, 1), (16.3, 0.034, 7), (27.0, 0.05, 3)])
def test_200_s_give_the_rms_of_the_closed_form_within_2_percent(f_n: float, zeta: float, seed: int) -> None:
    found = wf.summarise(wf.run(linear_case(f_n, zeta, seed=seed, duration=200.0), progress=SILENT))
    acceleration, displacement = closed_form(f_n, zeta)
    assert found["tip_rms_m_s2"] == pytest.approx(acceleration, rel=0.02)
    assert found["tip_displacement_rms_m"] == pytest.approx(displacement, rel=0.02)


def test_a_linear_structure_has_the_same_damping_at_every_level() -> None:
    low, high = (
        wf.run(linear_case(20.0, 0.02, duration=20.0, level_db=db).changed(LONG_STEPS), progress=SILENT)
        for db in (0.0, 12.0)
    )
    for name, tolerance in (("f_n_hz", 1e-9), ("zeta", 1e-7)):
        assert high.attrs[name] == pytest.approx(low.attrs[name], rel=tolerance)
    assert high.attrs["tip_rms_m_s2"] == pytest.approx(10.0**0.6 * low.attrs["tip_rms_m_s2"], rel=1e-9)
    assert high.attrs["psd_rms_m_s2"] == pytest.approx(10.0**0.6 * low.attrs["psd_rms_m_s2"], rel=1e-12)


def integrated(case: wf.Case, dt: float) -> tuple[FloatArray, FloatArray]:
    """Relative displacement and absolute acceleration of the friction oscillator, by velocity Verlet with small steps.

    Independent of the package: the force of the joint is that of a spring in series with a slider.
    """
    base = base_motion(case.excitation).acceleration(dt * np.arange(round(case.excitation.duration / dt) + 1))
    x = v = elastic = 0.0
    acceleration, slip = -base[0], LIMIT / STIFFNESS
    moved, felt = np.zeros(len(base)), np.zeros(len(base))
    for n, ground in enumerate(base.tolist()):
        if n:
            half = v + 0.5 * dt * acceleration
            step = dt * half
            x += step
            elastic = min(max(elastic + step, -slip), slip)
            force = SPRING * x + STIFFNESS * elastic
            acceleration = -ground - (force + DASHPOT * half) / MASS
            v = half + 0.5 * dt * acceleration
        moved[n], felt[n] = x, acceleration + ground
    return moved, felt


@pytest.mark.parametrize(("seed", "duration"), [(1, 10.0), (23, 10.0)])
def test_a_friction_oscillator_has_the_rms_of_an_independent_integration(seed: int, duration: float) -> None:
    case = rubbing_case(seed=seed, duration=duration)
    result = wf.run(case, progress=SILENT)
    start, dt = result.attrs["steady_start_s"], 1.0 / (40.0 * STEPS * 8)
    moved, felt = (values[round(start / dt) :] for values in integrated(case, dt))
    assert result.attrs["tip_displacement_rms_m"] == pytest.approx(np.sqrt(np.mean(moved**2)), rel=0.01)
    assert result.attrs["tip_rms_m_s2"] == pytest.approx(np.sqrt(np.mean(felt**2)), rel=0.01)
    summary = wf.summarise(result)
    assert summary["friction_energy_j"] > 0.2 * summary["input_work_j"]
    assert summary["energy_balance_error"] < 1e-6
    assert summary["zeta"] > 0.02  # of the dashpot alone: 0.016 with the joint sticking
    assert result["coherence"].values.min() < 0.95


def test_level_and_capacity_doubled_double_the_response() -> None:
    cases = rubbing_case(duration=5.0), rubbing_case(2.0 * LIMIT, duration=5.0, level_db=20.0 * log10(2.0))
    single, double = (wf.run(case.changed(LONG_STEPS), progress=SILENT) for case in cases)
    for name in ("tip_displacement", "tip_acceleration", "base_acceleration"):
        largest = np.abs(double[name].values).max()
        np.testing.assert_allclose(double[name].values, 2.0 * single[name].values, rtol=0.0, atol=1e-9 * largest)
    np.testing.assert_allclose(double["tip_psd"], 4.0 * single["tip_psd"], rtol=1e-7)
    np.testing.assert_allclose(double["friction_energy"], 4.0 * single["friction_energy"], rtol=1e-8)


@pytest.mark.parametrize("method", ["condensed", pytest.param("full", marks=pytest.mark.slow)])
def test_the_methods_agree(method: str) -> None:
    case = rubbing_case(duration=4.4).changed(LONG_STEPS)
    reduced, other = (
        wf.run(case.changed(f"solver.method={name}"), progress=SILENT)["tip_displacement"].values
        for name in ("reduced", method)
    )
    np.testing.assert_allclose(reduced, other, rtol=0.0, atol=1e-7 * np.abs(other).max())  # Newton's tolerance


def test_the_transient_of_the_start_is_left_out() -> None:
    case = rubbing_case(duration=10.0)
    result = wf.run(case, progress=SILENT)
    found = read_spectra(result, case.excitation, case.output.damping)
    f_n, zeta = found.resonance
    assert found.start == pytest.approx(min(2.5, 5.0 / (2.0 * pi * f_n * zeta)), rel=0.05)  # time constants
    assert result.attrs["steady_start_s"] == found.start > 0.5
    steady = result["time"].values >= found.start
    tip = (result["tip_acceleration"] + result["base_acceleration"]).values
    assert result.attrs["tip_rms_m_s2"] == pytest.approx(np.sqrt(np.mean(tip[steady] ** 2)), rel=1e-12)
    assert result.attrs["tip_3sigma_m_s2"] == 3.0 * result.attrs["tip_rms_m_s2"]


def test_a_resumed_run_equals_one_that_was_not_interrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from wroll_fem.dynamics.time_stepping import simulate

    case = rubbing_case(duration=4.5).changed(LONG_STEPS, "solver.checkpoint_seconds=0.001", "output.figures=false")
    whole = wf.run(case, progress=SILENT)
    advance, calls = simulate._Run.advance, []

    def stopped(run: simulate._Run, *arguments: object) -> None:
        calls.append(1)
        if len(calls) == 6:
            raise KeyboardInterrupt
        advance(run, *arguments)

    monkeypatch.setattr(simulate._Run, "advance", stopped)
    with pytest.raises(KeyboardInterrupt):
        wf.run(case, out=tmp_path / "run", progress=SILENT)
    monkeypatch.undo()
    again = run_case(case, tmp_path / "run", resume=True, progress=SILENT)
    assert again.summary["steps"] == 3600
    with xr.open_dataset(tmp_path / "run" / "results.nc", engine="h5netcdf") as stored:
        for name in ("tip_displacement", "friction_energy", "tip_psd"):
            np.testing.assert_array_equal(stored[name].values, whole[name].values)


def roll(*overrides: str) -> wf.Case:
    return wf.load_case(CONFIGS / "lab_random.yaml", list(overrides))


@pytest.mark.parametrize("coil", ["coil={model: none}", "coil.model=bonded"])
def test_a_linear_roll_has_rms_and_h1_of_its_modes(coil: str) -> None:
    """The mandrel alone, and with a bonded coil, against the sum of their modes."""
    coarse = ["mesh.circumferential=8", "mesh.axial=3", coil, "damping.modal=0.02"]
    case = roll(*coarse, "excitation.duration=6", "excitation.psd={frequency: [60, 260], g2_per_hz: [0.002, 0.01]}")
    result = wf.run(case, progress=SILENT)
    modes = wf.run(case.changed("analysis=modal", "modal={count: 20, interface: bonded}"), progress=SILENT)
    f, shares = modes["mode_frequency"].values, modes["tip_participation"].values
    dt = float(np.diff(result["time"].values[:2])[0])
    slow = f / (1.0 + np.array([numerical_damping(Scheme.hht(-0.05), 2.0 * pi * one * dt)[1] for one in f]))

    def ratio(at: FloatArray, natural: FloatArray) -> ComplexArray:
        at = at[:, None]
        return 1.0 + (shares * at**2 / (natural**2 - at**2 + 2j * 0.02 * natural * at)).sum(axis=1)

    at = np.linspace(60.0, 260.0, 40001)
    exact = np.sqrt(trapezoid(case.excitation.psd.table.density(at) * np.abs(ratio(at, f)) ** 2, at))
    assert result.attrs["tip_rms_m_s2"] == pytest.approx(exact, rel=max(0.02, 3.0 * result.attrs["tip_rms_error"]))
    assert result.attrs["zeta"] == pytest.approx(0.02, rel=0.03)
    bending = slow[np.argmax(np.abs(shares))]
    assert result.attrs["f_n_hz"] == pytest.approx(bending, rel=1e-3)
    band = result.sel(frequency=slice(65.0, 250.0))
    size = np.hypot(band["transmissibility_real"], band["transmissibility_imag"]).values
    apart = np.abs(size / np.abs(ratio(band["frequency"].values, slow)) - 1.0) / np.maximum(band["h1_error"], 0.01)
    assert np.sqrt(np.mean(apart.values**2)) < 1.8
    assert apart.values.max() < 5.0


def test_the_mandrel_alone_is_the_same_at_every_level_and_along_every_direction() -> None:
    """f_n 0.1 %, zeta 3 % over a factor of ten in level (C38, C49)."""
    coarse = ["mesh.circumferential=8", "mesh.axial=3", "coil={model: none}", "damping.modal=0.02"]
    case = roll(*coarse, "excitation.duration=6", "excitation.psd={frequency: [60, 260], g2_per_hz: [0.002, 0.01]}")
    levels = wf.run(case.changed("excitation.levels=[0.1, 0.3, 1]"), progress=SILENT)
    f_n, zeta = levels["frequency_at_level"].values, levels["damping_at_level"].values
    np.testing.assert_allclose(f_n, f_n[0], rtol=1e-3)
    np.testing.assert_allclose(zeta, zeta[0], rtol=0.03)
    assert np.all(np.abs(zeta - 0.02) < 3.0 * levels["damping_error_at_level"].values + 6e-5)
    along_x, along_y = (
        wf.run(case.changed("excitation.duration=0.8", f"excitation.direction={axis}"), progress=SILENT)
        for axis in "xy"
    )
    difference = along_y["tip_displacement"].values - along_x["tip_displacement"].values
    assert np.abs(difference).max() < 1e-6 * np.abs(along_x["tip_displacement"].values).max()  # a roll is round


def test_the_steps_of_auto_follow_resonance_and_highest_frequency() -> None:
    shipped = roll()
    assert steps_per_cycle(shipped) == 24
    assert steps_per_cycle(roll("excitation.psd.frequency=[20, 2000]")) == 20
    assert steps_per_cycle(roll("excitation.psd.frequency=[20, 160]")) == 40
    assert steps_per_cycle(roll("integrator.steps_per_cycle=33")) == 33
    tail = roll("excitation.psd={frequency: [20, 300, 310, 2000], g2_per_hz: [0.01, 0.01, 1e-9, 1e-9]}")
    assert 295.0 < tail.excitation.highest_frequency_hz < 310.0
    (text,) = random_warnings(tail)
    assert "nearly all of its energy lies below" in text
    (text,) = random_warnings(roll("excitation.psd.frequency=[400, 900]"))
    assert "misses the resonance" in text


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("excitation.psd.frequency=[300, 20]", "excitation.psd.frequency"),
        ("excitation.psd.g2_per_hz=[0.01, -0.01]", "got -0.01 g^2/Hz"),
        ("excitation.psd.g2_per_hz=[0.01, 0.01, 0.01]", "3 densities for 2 frequencies"),
        ("excitation.psd.frequency=[0, 300]", "above zero"),
        ("excitation.duration=0.5", "excitation.duration: too short to average spectra"),
        ("excitation.resolution=0.1", "excitation.resolution: too fine"),
        ("excitation.resolution=30", "give 0.133 to 14 Hz"),
        ("excitation.crest_limit=1", "excitation.crest_limit"),
        ("excitation.resolution=-1", "excitation.resolution"),
        ("excitation.kind=chirp", "analysis random needs a random"),
        ("integrator.steps_per_cycle=10", "too few steps per cycle"),
        ("excitation.psdd=1", "psdd"),
    ],
)
def test_bad_input_is_one_line(override: str, words: str) -> None:
    with pytest.raises(InputError, match=re.escape(words)) as caught:
        roll(override)
    assert "\n" not in str(caught.value)
    assert str(caught.value).count(", got ") <= 1


def test_a_record_too_short_for_the_resonance_is_invalid_or_doubtful() -> None:
    for duration, quality in ((8.0, "invalid"), (25.0, "doubtful")):
        coarse = wf.run(linear_case(20.0, 0.02, duration=duration).changed(LONG_STEPS), progress=SILENT)
        assert coarse.attrs["zeta_quality"] == quality
        assert "set excitation.duration to" in coarse.attrs["zeta_doubts"]


def test_the_default_estimator_is_the_rational_fraction_and_is_kept() -> None:
    case = roll()
    assert case.output.damping == "rational_fraction"
    assert roll("output.damping=half_power").output.damping == "half_power"
    again = wf.load_case(CONFIGS / "lab_random.yaml", ["output={figures: false}"])
    assert again.output.damping == "rational_fraction"
    assert again.hash() == case.hash()
