"""Analysis shock: oscillators with exact responses, resumed runs, kinds of shocks, directions, and the lab backbone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from support.exact_systems import coulomb_oscillator, dense_system
from support.interrupted import interrupted
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.shared.preflight import motion_remarks
from wroll_fem.analyses.shock import run_shock
from wroll_fem.analyses.shock_plan import planned
from wroll_fem.dynamics.system.io import save_system
from wroll_fem.dynamics.time_stepping.condensed import CondensedStepper
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.progress import SilentProgress

F_N, ZETA = 10.0, 0.01
PULSE = {"kind": "half_sine", "amplitude": 30.0, "duration": 0.04, "decay": 1.6}
METHODS = [pytest.param("full", marks=pytest.mark.slow), "condensed", "reduced"]


class Warned(SilentProgress):
    """Progress that keeps its warnings."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []

    def warning(self, message: str) -> None:
        self.texts.append(message)


def damped_oscillator(folder: Path) -> Path:
    omega = 2 * np.pi * F_N
    plain = dense_system([[2.0 * omega**2]], [[2.0]], [1.0], tip=[1.0])
    system = replace(plain, damping=sp.csr_matrix([[2.0 * 2 * ZETA * omega]]))
    return save_system(system, folder / "oscillator.npz")


def shock(file: Path, *, method="condensed", steps=100, alpha=0.0, **changes):
    excitation = {**PULSE, "highest_frequency": F_N, **changes}
    return wf.Case(
        analysis="shock", structure={"file": str(file)}, excitation=excitation, solver={"method": method},
        integrator={"scheme": "hht", "alpha": alpha, "steps_per_cycle": steps},
    )  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_linear_oscillator_has_the_response_of_its_spectrum_and_its_own_damping(tmp_path, method):
    """1 % asked for zeta. 100 steps per cycle: the period is 0.03 % too long, the peak 0.1 % off."""
    result = wf.run(shock(damped_oscillator(tmp_path), method=method))
    numbers = wf.summarise(result)
    time = np.linspace(0.0, 0.04, 4001)
    base = 30.0 * np.sin(np.pi * time / 0.04)
    exact = wf.signals.shock_spectrum(base, time[1], [F_N], 0.5 / ZETA)[0]
    assert numbers["tip_peak_m_s2"] == pytest.approx(exact, rel=2e-3)
    assert numbers["decay_f_hz"] == pytest.approx(F_N, rel=1e-3)
    assert numbers["decay_zeta"] == pytest.approx(ZETA, rel=2e-3)
    assert numbers["zeta_quality"] == "ok"
    assert numbers["energy_balance_error"] < 1e-6
    assert abs(numbers["decay_zeta_numerical"]) < 1e-8
    assert numbers["zeta_material"] == pytest.approx(ZETA, rel=2e-3)
    np.testing.assert_allclose(result["decay_damping"], ZETA, rtol=5e-3)
    np.testing.assert_allclose(result["decay_frequency"], F_N, rtol=1e-3)


def test_spectrum_of_the_base_is_that_of_the_pulse_and_the_tips_peak_is_at_its_resonance(tmp_path):
    result = wf.run(shock(damped_oscillator(tmp_path), q=25.0, highest_frequency=100.0))
    lines = result["natural_frequency"].values
    time = np.linspace(0.0, 0.04, 8001)
    exact = wf.signals.shock_spectrum(30.0 * np.sin(np.pi * time / 0.04), time[1], lines, 25.0)
    np.testing.assert_allclose(result["srs_base"], exact, rtol=1e-3)
    pulse = 30.0 * np.sin(np.pi * time / 0.04)
    for quantity in ("absolute_acceleration", "relative_displacement", "pseudo_velocity"):
        for interval in ("maximax", "primary", "residual"):  # of the base: during the shock, and after it
            exact = wf.signals.shock_spectrum(pulse, time[1], lines, 25.0, quantity=quantity, interval=interval)
            found = result[f"srs_base_{quantity}"].sel(interval=interval).values
            np.testing.assert_allclose(found, exact, rtol=2e-3, atol=1e-3 * exact.max())
        largest = result[f"srs_tip_{quantity}"].sel(interval=["primary", "residual"]).max("interval")
        np.testing.assert_array_equal(largest, result[f"srs_tip_{quantity}"].sel(interval="maximax"))
    assert result["srs_base_pseudo_velocity"].attrs["units"] == "m s-1"
    top = int(np.argmax(result["srs_tip"].values))
    assert lines[top] == pytest.approx(F_N, rel=0.03)  # 24 lines per octave
    assert result["srs_tip"].attrs["units"] == "m s-2"
    assert result["srs_tip"].values[-1] == pytest.approx(wf.summarise(result)["tip_peak_m_s2"], rel=0.02)


def test_short_pulse_leaves_its_velocity_and_slow_pulse_its_static_displacement(tmp_path):
    file, omega = damped_oscillator(tmp_path), 2 * np.pi * F_N
    for kind, area in (("half_sine", 2 / np.pi), ("sawtooth", 0.5), ("trapezoid", 0.9)):
        numbers = wf.summarise(wf.run(shock(file, kind=kind, amplitude=1000.0, duration=1e-3, decay=0.5)))
        lost = np.exp(-ZETA * np.pi / 2)  # until a quarter of a period
        assert numbers["tip_displacement_peak_m"] == pytest.approx(1000.0 * 1e-3 * area / omega * lost, rel=2e-3)
        assert numbers["velocity_change_m_s"] == pytest.approx(area, rel=1e-9)
    slow = shock(file, kind="trapezoid", duration=6.0, rise=0.4, fall=0.4, decay=1.0)
    numbers = wf.summarise(wf.run(slow))
    assert numbers["tip_displacement_peak_m"] == pytest.approx(30.0 / omega**2, rel=0.01)
    assert numbers["tip_peak_m_s2"] == pytest.approx(30.0, rel=0.01)


def test_linear_response_scales_with_the_amplitude(tmp_path):
    file = damped_oscillator(tmp_path)
    one, seven = (wf.run(shock(file, amplitude=a, decay=1.5)) for a in (3.0, 21.0))
    np.testing.assert_allclose(seven["tip_displacement"], 7 * one["tip_displacement"], rtol=1e-9, atol=1e-12)
    assert one.attrs["decay_zeta"] == pytest.approx(seven.attrs["decay_zeta"], rel=1e-6)


def rubbing_shock(folder, method):
    """A mass that rubs, 15.9 Hz, mu N / k = 0.3 mm, thrown to some 30 mm."""
    file = save_system(coulomb_oscillator(), folder / "rubbing.npz")
    changes = {"amplitude": 600.0, "duration": 0.008, "decay": 1.2, "highest_frequency": 16.0}
    return shock(file, method=method, steps=80, alpha=-0.05, **changes)


@pytest.mark.parametrize("method", METHODS)
def test_rubbing_mass_decays_as_dry_friction_does(tmp_path, method):
    """Its amplitude falls by 4 mu N / k per cycle, zeta = 2 mu N / (pi k a): 3 %, for the window spans 4 cycles."""
    result = wf.run(rubbing_shock(tmp_path, method))
    a, zeta = result["decay_amplitude"].values, result["decay_damping"].values
    middle = (a < 0.75 * a[0]) & (a > 0.3 * a[0])
    assert middle.sum() > 5
    np.testing.assert_allclose(zeta[middle], 2 * 3e-4 / (np.pi * a[middle]), rtol=0.03)
    np.testing.assert_allclose(result["decay_frequency"].values[middle], 100 / (2 * np.pi), rtol=2e-3)
    assert result.attrs["zeta_quality"] == "doubtful"
    assert "decay_damping" in result.attrs["zeta_doubts"]
    assert result.attrs["decay_zeta_numerical"] < 0.05 * result.attrs["decay_zeta"]


def test_a_record_of_a_pulse_gives_the_response_of_the_pulse(tmp_path):
    file = damped_oscillator(tmp_path)
    time = np.arange(0.0, 0.06, 2e-4)
    base = np.where(time < 0.05, 30.0 * np.sin(np.pi * (time - 0.01) / 0.04), 0.0) * (time > 0.01)
    rows = "\n".join(f"{t:.6f},{a / 9.80665:.9g},0" for t, a in zip(time, base, strict=True))
    (tmp_path / "base.csv").write_text(f"time,base,other\n{rows}\n")
    pulse = wf.run(shock(file, decay=0.5))
    record = {"kind": "file", "file": str(tmp_path / "base.csv"), "unit": "g", "column": "base", "decay": 0.5}
    case = wf.Case(
        analysis="shock", structure={"file": str(file)}, excitation={**record, "highest_frequency": F_N},
        integrator={"alpha": 0.0, "steps_per_cycle": 200}, solver={"method": "condensed"},
    )  # fmt: skip
    found = wf.run(case)
    for name in ("tip_peak_m_s2", "tip_displacement_peak_m"):
        assert found.attrs[name] == pytest.approx(pulse.attrs[name], rel=5e-3)
    assert motion_remarks(case) == []


def test_motion_of_a_spectrum_has_it_in_the_result(tmp_path):
    srs = {"frequency": [10, 40, 100], "acceleration_g": [2, 10, 10], "q": 10}
    case = wf.Case(
        analysis="shock", structure={"file": str(damped_oscillator(tmp_path))}, solver={"method": "condensed"},
        excitation={"kind": "srs", "srs": srs, "seed": 3, "decay": 0.6},
    )  # fmt: skip
    result = wf.run(case)
    lines = result["natural_frequency"].values
    inside = (lines > 10.0) & (lines < 100.0)
    wanted = 9.80665 * np.exp(np.interp(np.log(lines[inside]), np.log([10, 40, 100]), np.log([2, 10, 10])))
    off = 20 * np.log10(result["srs_base"].values[inside] / wanted)
    assert np.abs(off).max() < 2.5  # 1.5 dB at every sixth octave, more between
    assert abs(result.attrs["velocity_change_m_s"]) == 0.0


@pytest.mark.parametrize(("method", "stepper"), [("condensed", CondensedStepper), ("reduced", ReducedStepper)])
def test_resumed_run_equals_the_whole(tmp_path, monkeypatch, method, stepper):
    case = rubbing_shock(tmp_path, method)
    whole = run_shock(case, progress=SilentProgress())
    saved = tmp_path / "checkpoint.npz"
    with interrupted(monkeypatch, stepper, 4):
        run_shock(case, progress=SilentProgress(), checkpoint=saved)
    resumed = run_shock(case, progress=SilentProgress(), checkpoint=saved, resume=True)
    for name in ("tip_displacement", "friction_energy", "srs_tip", "decay_damping"):
        np.testing.assert_array_equal(resumed[name], whole[name])


def test_modes_that_the_time_step_does_not_resolve_are_named(tmp_path):
    """A second mode at 31 times the first, which a short pulse excites too."""
    k1, k2 = (2 * np.pi * 10.0) ** 2, (2 * np.pi * 300.0) ** 2 * 0.5
    system = dense_system([[k1 + k2, -k2], [-k2, k2]], np.diag([1.0, 1.0]), [1.0, 1.0], tip=[0.0, 1.0])
    system = replace(system, influence=np.array([1.0, 0.0]))
    file = save_system(system, tmp_path / "two.npz")
    coarse = shock(file, duration=0.02, decay=1.0, highest_frequency=50.0, steps=40)
    progress = Warned()
    run_shock(coarse, progress=progress)
    (text,) = [text for text in progress.texts if "does not resolve" in text]
    assert "at 300 Hz" in text
    fine = coarse.replace(
        {"excitation.highest_frequency": float(text.split("highest_frequency to ")[1].split(" or")[0])}
    )
    progress = Warned()
    run_shock(fine, progress=progress)
    assert not [text for text in progress.texts if "does not resolve" in text]


def test_too_short_a_decay_gives_no_damping_but_a_reason(tmp_path):
    result = wf.run(shock(damped_oscillator(tmp_path), decay=0.3))
    numbers = wf.summarise(result)
    assert np.isnan(numbers["decay_zeta"])
    assert numbers["zeta_quality"] == "invalid"
    assert "set excitation.decay to" in numbers["zeta_doubts"][0]
    assert "decay_damping" not in result


def test_plan_of_a_roll_follows_its_resonance_and_puts_the_pulse_on_steps():
    case = wf.load_case(
        CONFIGS / "tiny.yaml", ["analysis=shock", "excitation={kind: sawtooth, amplitude: 50, duration: 0.011}"]
    )
    plan = planned(case)
    assert 0.3 < plan.excitation.decay < 0.6  # 60 cycles of some 150 Hz
    dt = 1.0 / (plan.excitation.highest_frequency_hz * plan.integrator.steps)
    assert 0.011 / dt == pytest.approx(round(0.011 / dt), abs=1e-6)
    assert plan.excitation.highest_frequency_hz == pytest.approx(14.4 / 0.011, rel=0.01)
    slow = planned(case.replace({"excitation.duration": 1.0}))
    assert 420.0 < slow.excitation.highest_frequency_hz < 600.0
    own = planned(case.replace({"excitation.decay": 0.2, "excitation.highest_frequency": 2000.0}))
    assert own.excitation.decay == 0.2
    assert 2000.0 <= own.excitation.highest_frequency_hz < 2010.0


def test_roll_responds_alike_in_x_and_y():
    """The mesh of 8 elements around has a quarter turn as symmetry; with x half of the roll is solved."""
    text = [
        "analysis=shock", "mesh={circumferential: 8, axial: 2}", "solver.method=condensed",
        "excitation={kind: half_sine, amplitude_g: 30, duration: 0.003, decay: 0.02, highest_frequency: 400}",
    ]  # fmt: skip
    x, y = (wf.run(wf.load_case(CONFIGS / "tiny.yaml", [*text, f"excitation.direction={d}"])) for d in "xy")
    for name in ("tip_peak_m_s2", "base_peak_m_s2"):
        assert x.attrs[name] == pytest.approx(y.attrs[name], rel=1e-5)
    assert float(x["friction_energy"][-1]) == pytest.approx(float(y["friction_energy"][-1]), rel=1e-4)
    assert float(x["friction_energy"][-1]) > 0.0


@pytest.mark.slow
def test_decay_of_the_lab_roll_follows_its_backbone(tmp_path):
    """Coarse mesh, 0.5 % material damping: 0.5 % in frequency, 4 % in damping from 1.5 to 0.013 mm (two decades).

    A cycle of the decay, from peak to peak, dissipates what a steady cycle of its mean amplitude does: neither other
    modes nor the memory of the contact change the damping.
    """
    text = ["mesh={circumferential: 12, axial: 6, grading: 8}", "damping.modal=0.005"]
    backbone = wf.run(wf.load_case(CONFIGS / "lab_backbone.yaml", [*text, "backbone.tip_largest=1.6e-3"]))
    pulse = "excitation={kind: half_sine, amplitude_g: 120, duration: 0.003}"
    result = wf.run(wf.load_case(CONFIGS / "lab_backbone.yaml", [*text, "analysis=shock", pulse]))
    a = result["decay_amplitude"].values
    used = a < 1.56e-3  # the first values are of the end of the shock itself
    assert a[used][0] > 1.5e-3
    assert a[used][-1] < 2e-5
    tip = backbone["tip_amplitude"].values
    f, zeta = (np.interp(a[used], tip, backbone[name].values) for name in ("resonance_frequency", "modal_damping"))
    np.testing.assert_allclose(result["decay_frequency"].values[used], f, rtol=5e-3)
    np.testing.assert_allclose(result["decay_damping"].values[used], zeta, rtol=0.04)
    after = result.isel(time=result["time"].values > result.attrs["shock_end_s"])
    x = after["tip_displacement"].values
    peaks = np.flatnonzero(np.diff(np.sign(np.diff(x)))) + 1
    lost = sum(after[name].values for name in ("friction_energy", "material_damping", "numerical_dissipation"))
    level = np.abs(x[peaks])
    mean, work = 0.25 * (level[:-2] + 2.0 * level[1:-1] + level[2:]), lost[peaks][2:] - lost[peaks][:-2]
    steady = sum(backbone[f"{name}_work_per_cycle"].values for name in ("friction", "material_damping"))
    large = (mean < 1.3e-3) & (mean > 2e-4)
    assert large.sum() > 10
    np.testing.assert_allclose(work[large], np.interp(mean[large], tip, steady), rtol=0.05)  # peaks at time steps
