"""Sweeps up and down in one run (`sweep_direction: up_down`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.interrupted import interrupted
from support.oscillator import steady
from support.paths import CONFIGS

import wroll_fem as wf
from wroll_fem.analyses.shared.time_step import time_grid
from wroll_fem.dynamics.time_stepping import simulate
from wroll_fem.dynamics.time_stepping.hht import Scheme, numerical_damping
from wroll_fem.dynamics.time_stepping.reduced import ReducedStepper
from wroll_fem.errors import InputError
from wroll_fem.jobs.run import run_case
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset
from wroll_fem.signals.damping import half_power
from wroll_fem.signals.motions import base_motion
from wroll_fem.signals.sweeps import sweep_of
from wroll_fem.signals.there_and_back import ThereAndBack
from wroll_fem.typing import FloatArray

SILENT = SilentProgress()
F_N, ZETA, SECONDS = 10.0, 0.04, 60.0
STIFFNESS = (2.0 * np.pi * F_N) ** 2
BANDS = {"geometric": {"rate_oct_per_min": 60.0 * np.log2(13.0 / 7.0) / SECONDS}, "linear": {"rate_hz_per_s": 0.1}}
NOTCH = {"frequency": [8.0, 9.0, 11.0, 12.0], "factor": [1.0, 0.6, 0.6, 1.0]}

pytestmark = pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")


def chirp(law: str = "geometric", amplitude: float = 0.5, **keys: object) -> wf.Chirp:
    """Sweep from 7 Hz to 13 Hz and back in 120 s."""
    given = {"f_start": 7.0, "f_end": 13.0, "ramp_cycles": 10, "sweep_direction": "up_down"} | BANDS[law] | keys
    return wf.Chirp(amplitude=amplitude, **given)


def sizes(result: wf.Result) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Frequency (n,), Hz, and |T| upward and downward (n,)."""
    data = result.data
    parts = ("transmissibility", "down_transmissibility")
    up, down = (np.hypot(data[f"{name}_real"], data[f"{name}_imag"]).values for name in parts)
    return data["frequency"].values, up, down


def linear() -> wf.OwnStructure:
    return wf.structure(np.array([[STIFFNESS]]), np.eye(1), damping=ZETA)


@pytest.mark.parametrize(
    ("law", "notched"),
    [
        ("geometric", False), ("linear", True),
        pytest.param("linear", False, marks=pytest.mark.slow), pytest.param("geometric", True, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_the_branches_of_a_linear_structure_mirror(law: str, notched: bool) -> None:
    """The lag, of a fifth of the half-width, has the same size and the other sign; so have the deviations of |T|."""
    profile = {"profile": NOTCH} if notched else {}
    result = linear().run_sweep(chirp(law, **profile), integrator=wf.Integrator(steps_per_cycle=60))
    frequency, up, down = sizes(result)
    read = result.summary
    centre = 0.5 * (read["f_n_hz"] + read["down_f_n_hz"])
    lag = read["f_n_hz"] - centre
    assert 0.1 < lag / (ZETA * F_N) < 0.3
    longer = numerical_damping(Scheme.hht(-0.05), 2.0 * np.pi * F_N / (60.0 * 13.0))[1]
    assert centre == pytest.approx(F_N * (1.0 - ZETA**2) / (1.0 + longer), rel=3e-4)  # peak of |T|
    heights = read["peak_transmissibility"], read["down_peak_transmissibility"]
    reached = read["sweep_attainment"], read["down_sweep_attainment"]
    assert heights[1] / heights[0] == pytest.approx(reached[1] / reached[0], rel=1e-3)  # upward less
    assert heights[1] == pytest.approx(heights[0], rel=5e-3)
    assert read["down_zeta"] == pytest.approx(read["zeta"], rel=6e-3)
    exact = half_power(frequency, np.abs(steady(frequency, F_N, ZETA))).zeta
    assert read["zeta"] == pytest.approx(exact, rel=0.02)  # table in `signals.transmissibility`
    assert read["zeta_quality"] == read["down_zeta_quality"] == "ok"
    curve = np.abs(steady(frequency * F_N * (1.0 - ZETA**2) / centre, F_N, ZETA))
    lags = up - curve, down - curve
    assert np.abs(lags[0]).max() > 0.05 * up.max()  # on the flanks; twice the even part
    even = (lag / (ZETA * F_N)) ** 2 * up.max()  # the sum of a resonance moved to both sides: T'' = T / (zeta f)^2
    np.testing.assert_allclose(lags[0], -lags[1], atol=1.5 * even)


def test_the_upward_branch_is_an_upward_sweep_and_the_downward_one_a_downward_sweep() -> None:
    twice, steps = {"rate_oct_per_min": 2.0 * BANDS["geometric"]["rate_oct_per_min"]}, wf.Integrator(steps_per_cycle=40)
    both = linear().run_sweep(chirp(**twice), integrator=steps)
    f, up, down = sizes(both)
    for keys, size in (
        ({"sweep_direction": "up"}, up),
        ({"f_start": 13.0, "f_end": 7.0, "sweep_direction": "down", "ramp_cycles": 0}, down),
    ):
        alone = linear().run_sweep(chirp(**twice, **keys), integrator=steps)
        other = np.hypot(alone.data["transmissibility_real"], alone.data["transmissibility_imag"]).values
        inside = np.interp(f, alone.data["frequency"].values, other)[5:-5]
        outside = np.abs(f - alone.data.attrs["f_start_hz"])[5:-5] > 1.0  # the transient of its start
        np.testing.assert_allclose(size[5:-5][outside], inside[outside], atol=1e-3 * size.max())


@pytest.mark.slow
def test_both_branches_of_a_friction_oscillator_agree_with_harmonic_balance() -> None:
    """A softening resonance without folds, slow enough for its steep flank: 2 % of the peak."""
    structure = wf.structure(
        np.array([[0.85 * STIFFNESS]]), np.eye(1),
        [wf.joints.Jenkins(at=0, stiffness=0.15 * STIFFNESS, limit=0.6)], damping=0.04,
    )  # fmt: skip
    curve = structure.run_harmonic(wf.Chirp(f_start=7.0, f_end=13.0, rate_oct_per_min=1, amplitude=0.6))
    f = curve.data["frequency"].values
    T = np.hypot(curve.data["transmissibility_real"], curve.data["transmissibility_imag"]).values
    assert (np.diff(f) > 0.0).all()  # no fold
    assert T.max() < 10.0
    slow = chirp("linear", amplitude=0.6, f_start=8.0, f_end=12.0, rate_hz_per_s=0.0375)
    result = structure.run_sweep(slow, integrator=wf.Integrator(steps_per_cycle=80))
    frequency, up, down = sizes(result)
    for size in (up, down):
        np.testing.assert_allclose(size, np.interp(frequency, f, T), atol=0.02 * T.max())
    read = result.summary
    assert read["f_n_hz"] == pytest.approx(f[T.argmax()], rel=5e-3)
    assert read["down_f_n_hz"] == pytest.approx(f[T.argmax()], rel=5e-3)
    assert result.summary["friction_energy_j"] > 0.1 * result.summary["input_work_j"]


@pytest.mark.parametrize("law", ["geometric", "linear"])
@pytest.mark.parametrize("seed", range(5))
def test_phase_and_motion_are_continuous_at_the_turn(law: str, seed: int) -> None:
    rng = np.random.default_rng([31, seed])
    low = rng.uniform(3.0, 30.0)
    motion = base_motion(chirp(law, f_start=low, f_end=low * rng.uniform(1.5, 6.0), profile=NOTCH))
    assert isinstance(motion, ThereAndBack)
    h = 1e-9 * motion.turn
    around = motion.turn + h * np.array([-2.0, -1.0, 1.0, 2.0])
    for values in (motion.phase(around), motion.frequency(around), motion.acceleration(around)):
        assert np.ptp(values) < 1e-3 * max(1.0, np.abs(values).max())
    t, h = np.linspace(0.0, motion.duration, 801), 1e-7 * motion.turn
    slope = (motion.phase(t[1:-1] + h) - motion.phase(t[1:-1] - h)) / (2.0 * h)
    np.testing.assert_allclose(slope, 2.0 * np.pi * motion.frequency(t[1:-1]), rtol=1e-3)
    np.testing.assert_allclose(motion.frequency(t), motion.frequency(t[::-1]), rtol=1e-9)
    ramp = motion.up.ramp_cycles / motion.up.f_start
    later = (t > ramp) & (t < motion.duration - ramp)
    times, values = motion.samples(motion.duration / 100.5)
    assert len(times) == 102  # the last one just beyond the end
    np.testing.assert_array_equal(values, motion.acceleration(times))
    factor = motion.amplitude * motion.up.profile(motion.frequency(t))
    np.testing.assert_allclose(motion.acceleration(t)[later], (factor * np.sin(motion.phase(t)))[later], atol=1e-6)


ROLL = (
    "mesh={circumferential: 8, axial: 2}", "output={figures: false, fields: none}", "solver.checkpoint_seconds=0.001",
    "excitation={kind: chirp, amplitude: 20.0, f_start: 60, f_end: 240, rate_oct_per_min: 400, "
    "sweep_direction: up_down}",
)  # fmt: skip


def test_steps_follow_the_frequency_up_and_down() -> None:
    case = wf.load_case(CONFIGS / "lab_sweep.yaml", [*ROLL, "integrator.follow_frequency=true", "preload.pressure=1e3"])
    grid, motion = time_grid(case, 60.0), base_motion(case.excitation)
    assert motion.duration <= grid.times[-1] < motion.duration + 2.0 * grid.steps.max()
    longest = np.maximum(*motion.frequency(np.stack([grid.times[:-1], grid.times[1:]])))
    assert (grid.steps * longest * case.integrator.steps <= 1.0 + 1e-6).all()
    assert grid.steps[0] == grid.steps[-1] == 2.0 * grid.steps.min()
    assert len(grid.ends) == 3


def test_a_resumed_run_equals_one_that_was_not_interrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulate, "CHUNK", 400)  # fewer checkpoints
    case = wf.load_case(CONFIGS / "lab_sweep.yaml", [*ROLL, "integrator.follow_frequency=true"])
    whole = wf.run(case, progress=SILENT)
    with interrupted(monkeypatch, ReducedStepper, 6):
        wf.run(case, out=tmp_path / "run", progress=SILENT)
    run_case(case, tmp_path / "run", resume=True, progress=SILENT)
    again = load_dataset(tmp_path / "run" / "results.nc")
    for name in ("transmissibility_real", "down_transmissibility_real", "friction_energy"):
        np.testing.assert_array_equal(again[name].values, whole[name].values)
    assert sweep_of(again) is None
    assert again.attrs["down_f_n_hz"] == whole.attrs["down_f_n_hz"]
    assert again["max_slip"].max() > 0.0


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("excitation.f_end=30", "excitation.sweep_direction: the frequency runs from 60 to 30 Hz"),
        ("excitation.sweep_direction=down", "give f_end below f_start"),
        ("excitation.sweep_direction=there", "excitation.sweep_direction"),
        ("analysis=harmonic", "a response curve has no direction"),
    ],
)
def test_bad_directions_are_one_line(override: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        wf.load_case(CONFIGS / "lab_sweep.yaml", [*ROLL, override])
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_case_without_a_direction_keeps_its_hash() -> None:
    given = [wf.load_case(CONFIGS / "lab_sweep.yaml", more) for more in ([], ["excitation.sweep_direction=null"])]
    assert given[0].hash() == given[1].hash() != wf.load_case(CONFIGS / "lab_sweep.yaml", list(ROLL)).hash()
