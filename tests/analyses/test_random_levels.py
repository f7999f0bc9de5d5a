"""Random motions at several levels and with several records in one run, and lengths from a wanted accuracy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.paths import CONFIGS
from support.random_cases import LIMIT, linear_case, rubbing_case

import wroll_fem as wf
from wroll_fem.analyses import summarise, write_figures
from wroll_fem.analyses.forecasts.closed_forms import beam_frequency
from wroll_fem.analyses.history import _Integration
from wroll_fem.analyses.random import estimate_random
from wroll_fem.analyses.random_levels import _holds_history, seeds_of
from wroll_fem.analyses.random_plan import planned
from wroll_fem.dynamics.time_stepping import simulate
from wroll_fem.errors import InputError, ReductionError
from wroll_fem.jobs.run import run_case
from wroll_fem.plotting import style
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import load_dataset
from wroll_fem.results.storage.checkpoint import write_checkpoint

SILENT = SilentProgress()


def rubbing(limit: float = LIMIT, **motion: object) -> wf.Case:
    """Friction oscillator with 20 steps per cycle of 40 Hz, half of those of the other tests of random motions."""
    return rubbing_case(limit, **motion).changed("integrator.steps_per_cycle=20")


def test_every_level_is_the_history_of_that_level_alone() -> None:
    """Structure and modes are shared; the histories are those of single runs."""
    case = rubbing(duration=6.0)
    both = wf.run(case.replace({"excitation.levels_db": [-6.0, 3.0]}), progress=SILENT)
    assert both.sizes["level"] == 2
    for number, level in enumerate((-6.0, 3.0)):
        alone = wf.run(rubbing(duration=6.0, level_db=level), progress=SILENT)
        one = both.isel(level=number)
        assert float(one["level_db"]) == level
        for name in ("tip_rms", "tip_displacement_rms", "base_rms", "base_shear_rms"):
            entry = alone.attrs.get(
                f"{name}_n" if "shear" in name else f"{name}_m" if "disp" in name else f"{name}_m_s2"
            )
            assert float(one[f"{name}_at_level"]) == pytest.approx(entry, rel=0.02)  # another start of the steady part
        assert float(one["friction_energy_at_level"]) == pytest.approx(float(alone["friction_energy"][-1]), rel=1e-12)
        np.testing.assert_allclose(one["max_slip"].values, alone["max_slip"].values, rtol=1e-12)
        np.testing.assert_allclose(one["cumulative_slip"].values, alone["cumulative_slip"].values, rtol=1e-12)
    assert both["frequency_at_level"][0] > both["frequency_at_level"][1]  # softening
    summary = summarise(both)
    assert summary["level_db"] == [-6.0, 3.0]
    assert summary["level_f_n_hz"] == both["frequency_at_level"].values.tolist()
    assert summary["energy_balance_error"] < 1e-6
    assert summary["interface_pressure_mean_pa"]


def test_levels_and_capacity_doubled_double_every_response() -> None:
    """The same two level factors on a structure with twice the friction limit, and twice the levels."""
    single = wf.run(rubbing(duration=5.0).replace({"excitation.levels": [0.5, 1.0]}), progress=SILENT)
    double = wf.run(rubbing(2.0 * LIMIT, duration=5.0).replace({"excitation.levels": [1.0, 2.0]}), progress=SILENT)
    for name in ("tip_rms_at_level", "tip_displacement_rms_at_level", "base_rms_at_level", "max_slip"):
        np.testing.assert_allclose(double[name].values, 2.0 * single[name].values, rtol=1e-9)
    np.testing.assert_allclose(double["tip_psd"].values, 4.0 * single["tip_psd"].values, rtol=1e-7)
    for name in ("frequency_at_level", "damping_at_level"):
        np.testing.assert_allclose(double[name].values, single[name].values, rtol=1e-6)


@pytest.mark.slow
def test_records_are_averaged_and_their_scatter_is_that_of_the_error_bars() -> None:
    """A linear oscillator: the mean of five records has the given zeta within its error, at both levels."""
    case = linear_case(20.0, 0.04, duration=15.0)
    found = wf.run(case.replace({"excitation.records": 5, "excitation.levels": [1.0, 3.0]}), progress=SILENT)
    assert found.attrs["seeds"] == found["seed"].values.tolist() == seeds_of(1, 5)
    assert len(set(seeds_of(1, 5))) == 5
    assert seeds_of(1, 5)[:3] == seeds_of(1, 3)
    assert not set(seeds_of(2, 5)) & set(seeds_of(1, 5))
    one = found.isel(level=0)
    assert float(one["damping_at_level"]) == pytest.approx(0.04, abs=3.0 * float(one["damping_error_at_level"]) + 2e-4)
    assert float(one["damping_at_level"]) == pytest.approx(float(one["damping_of_record"].mean()), rel=0.01)
    np.testing.assert_allclose(found["damping_at_level"][1], found["damping_at_level"][0], rtol=1e-7)
    np.testing.assert_allclose(found["tip_rms_at_level"][1], 3.0 * found["tip_rms_at_level"][0], rtol=1e-9)
    squares = one["tip_rms_of_record"].values ** 2
    assert float(one["tip_rms_at_level"]) == pytest.approx(np.sqrt(squares.mean()), rel=1e-12)
    ratio = float(one["damping_scatter_at_level"] / one["damping_error_at_level"])
    assert 0.3 < ratio < 3.0  # five records: the scatter itself is known to 35 %
    alone = wf.run(case, progress=SILENT)
    assert float(one["tip_rms_of_record"][0]) == pytest.approx(alone.attrs["tip_rms_m_s2"], rel=0.01)
    spent = [
        one["psd_averages"] / one["psd_resolution_hz"] for one in (found.attrs, alone.attrs)
    ]  # time of the records
    assert spent[0] == pytest.approx(5.0 * spent[1], rel=0.2)


@pytest.mark.slow
def test_a_resumed_series_equals_one_that_was_not_interrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupted within the third of four histories; the first two are not computed again."""
    monkeypatch.setattr(simulate, "CHUNK", 1200)  # fewer checkpoints, whose files take most of the time
    case = rubbing(duration=4.5).replace(
        {"solver.checkpoint_seconds": 0.001, "excitation.levels": [0.5, 1.0], "excitation.records": 2,
         "output.figures": False}
    )  # fmt: skip
    whole = wf.run(case, progress=SILENT)
    advance, calls = simulate._Run.advance, []

    def stopped(run: simulate._Run, *arguments: object) -> None:
        calls.append(1)
        if len(calls) == 2 * chunks + 3:
            raise KeyboardInterrupt
        advance(run, *arguments)

    chunks = -(-whole.attrs["steps"] // 4 // simulate.CHUNK)
    with monkeypatch.context() as patch:
        patch.setattr(simulate._Run, "advance", stopped)
        with pytest.raises(KeyboardInterrupt):
            wf.run(case, out=tmp_path / "run", progress=SILENT)
    kept = sorted((tmp_path / "run" / "levels").glob("*.nc"))
    assert len(kept) == 2
    times = [file.stat().st_mtime_ns for file in kept]
    calls.clear()
    with monkeypatch.context() as patch:
        patch.setattr(simulate._Run, "advance", lambda run, *arguments: (calls.append(1), advance(run, *arguments))[1])
        run_case(case, tmp_path / "run", resume=True, progress=SILENT)
    assert len(calls) == 2 * chunks - 2
    assert [file.stat().st_mtime_ns for file in kept] == times
    again = load_dataset(tmp_path / "run" / "results.nc")
    for name in ("tip_rms_at_level", "tip_psd", "cumulative_slip", "damping_at_level"):
        np.testing.assert_array_equal(again[name].values, whole[name].values)
    assert len(list((tmp_path / "run" / "levels").glob("*.nc"))) == 4
    assert load_dataset(kept[0]).sizes["time"] > 1000


def roll(*overrides: str) -> wf.Case:
    return wf.load_case(CONFIGS / "lab_random.yaml", list(overrides))


SHORT = ("mesh.circumferential=8", "mesh.axial=2", "excitation.duration=0.55", "integrator.steps_per_cycle=20")
TWO_LEVELS = (*SHORT, "excitation.levels_db=[-12, 0]", "output={figures: false, fields: none}")


@pytest.fixture(scope="module")
def two_levels() -> tuple[xr.Dataset, int, int]:
    """Result of a roll at two levels; how often its structure was assembled and its modes were computed."""
    from wroll_fem.analyses import history

    prepared, condensed = [], []
    prepare, modes = history.prepare, history.modes_to_reduce
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(history, "prepare", lambda *given: (prepared.append(1), prepare(*given))[1])
        patch.setattr(history, "modes_to_reduce", lambda *given: (condensed.append(1), modes(*given))[1])
        found = wf.run(roll(*TWO_LEVELS), progress=SILENT)
    return found, len(prepared), len(condensed)


def test_a_roll_resumed_between_two_histories_keeps_its_basis(
    two_levels: tuple[xr.Dataset, int, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case, whole = roll(*TWO_LEVELS), two_levels[0]
    advance, calls = simulate._Run.advance, []
    chunks = -(-whole.attrs["steps"] // 2 // simulate.CHUNK)

    def stopped(run: simulate._Run, *arguments: object) -> None:
        calls.append(1)
        if len(calls) == chunks + 1:
            raise RuntimeError("killed")  # without a checkpoint of the second history
        advance(run, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(simulate._Run, "advance", stopped)
        with pytest.raises(RuntimeError):
            wf.run(case, out=tmp_path / "run", progress=SILENT)
    run_case(case, tmp_path / "run", resume=True, progress=SILENT)
    again = load_dataset(tmp_path / "run" / "results.nc")
    for name in ("tip_displacement_rms_at_level", "tip_psd", "cumulative_slip"):
        np.testing.assert_array_equal(again[name].values, whole[name].values)


def test_a_roll_at_two_levels_draws_its_figures_and_shares_its_modes(
    two_levels: tuple[xr.Dataset, int, int], tmp_path: Path
) -> None:
    found, prepared, condensed = two_levels
    assert (prepared, condensed) == (1, 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "DPI", 30)
        names = {path.name for path in write_figures(found, tmp_path)}
    assert {"levels.png", "slip_map_01.png"} <= names
    assert not {"spectra.png", "response.png", "energy_ledger.png"} & names
    assert found["base_shear_rms_at_level"].values[1] > found["base_shear_rms_at_level"].values[0] > 0.0
    assert found["base_moment_rms_at_level"].values[1] > found["base_moment_rms_at_level"].values[0] > 0.0
    alone = wf.run(roll(*SHORT, "excitation.level_db=0"), progress=SILENT)
    rms = float(found["tip_displacement_rms_at_level"][1])
    assert rms == pytest.approx(alone.attrs["tip_displacement_rms_m"], rel=0.02)  # steady parts of other lengths


@pytest.mark.parametrize("fallen", [0, 1])
def test_one_level_may_fall_back_to_condensed(fallen: int, monkeypatch: pytest.MonkeyPatch) -> None:
    history, tried = _Integration.history, []

    def falling(run: _Integration, method: str, *given: object) -> xr.Dataset:
        tried.append(method)
        if method == "reduced" and tried.count("reduced") == fallen + 1:
            raise ReductionError("the basis is too small", time_s=0.0, iterations=0, residual_history=[], advice="none")
        return history(run, method, *given)

    monkeypatch.setattr(_Integration, "history", falling)
    found = wf.run(roll(*TWO_LEVELS), progress=SILENT)
    assert tried == [["reduced", "condensed", "reduced"], ["reduced", "reduced", "condensed"]][fallen]
    assert found.attrs["method"] == ["condensed, reduced", "reduced, condensed"][fallen]
    assert found.attrs["training_time_s"] > 0.0
    assert found.attrs["reduction_error_estimate"] > 0.0  # of the level that did not fall back
    assert summarise(found)["method"] == found.attrs["method"]


@pytest.mark.parametrize(
    ("f_n", "zeta", "bias", "error"),
    [pytest.param(20.0, 0.05, 0.02, 0.15, marks=pytest.mark.slow), (17.0, 0.1, 0.02, 0.25)],
)
def test_an_automatic_length_gives_the_wanted_errors(f_n: float, zeta: float, bias: float, error: float) -> None:
    wanted = {"frequency": f_n, "zeta": zeta, "bias": bias, "random_error": error}
    case = linear_case(f_n, zeta).replace({"excitation.duration": "auto", "excitation.accuracy": wanted})
    found = wf.run(case, progress=SILENT)
    assert found.attrs["psd_random_error"] == pytest.approx(error, rel=0.1)
    assert found.attrs["psd_peak_bias"] == pytest.approx(bias, rel=0.1)
    assert found.attrs["duration_s"] == planned(case).excitation.duration
    four = case.replace({"excitation.records": 4})
    shorter = planned(four).excitation.duration
    assert shorter < found.attrs["duration_s"]
    assert estimate_random(four)["duration_s"] == pytest.approx(4.0 * shorter)


def test_the_length_for_a_roll_follows_its_estimated_resonance() -> None:
    case = roll("excitation.duration=auto")
    width = 2.0 * 0.02 * beam_frequency(case, bonded=False)  # Bendat and Piersol: bias (1/3) (B_e / B_r)^2, B_e = 2 df
    resolution = 0.5 * width * np.sqrt(3.0 * 0.02)
    assert planned(case).excitation.duration == pytest.approx(0.5 * 107.0 / resolution, rel=0.05)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("excitation.levels=[1, 0.5]", "excitation.levels: must be above zero and ascend"),
        ("excitation.levels=[0, 1]", "above zero"),
        ("excitation.levels_db=[0, 0]", "must ascend"),
        ("excitation.levels_db=[]", "must ascend"),
        ("excitation={levels: [1, 2], levels_db: [0, 6]}", "excitation.levels_db: the level is given twice"),
        ("excitation={level_db: 3, levels_db: [0, 6]}", "the level is given twice"),
        ("excitation.records=0", "excitation.records"),
        ("excitation.duration=soon", "excitation.duration"),
        ("excitation.duration=-1", "write a length in s, or auto"),
        ("excitation={duration: auto, accuracy: {bias: 2}}", "excitation.accuracy.bias"),
    ],
)
def test_bad_levels_are_one_line(override: str, words: str) -> None:
    given = {"psd": {"frequency": [20, 300], "g2_per_hz": [0.01]}, "kind": "random", "duration": 30}
    key, _, text = override.partition("=")
    if key == "excitation":
        import yaml

        override = f"excitation={yaml.safe_dump(given | yaml.safe_load(text), default_flow_style=True, width=1000)}"
    with pytest.raises(InputError) as caught:
        roll(override)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_matrices_need_a_frequency_for_an_automatic_length() -> None:
    with pytest.raises(InputError, match=r"excitation.duration.*accuracy.frequency"):
        linear_case(20.0, 0.02).replace({"excitation.duration": "auto"})


def test_a_case_without_levels_keeps_its_hash() -> None:
    empty = "excitation={kind: random, psd: {frequency: [20, 300], g2_per_hz: 0.01}, duration: 30, levels: null}"
    plain = "excitation={kind: random, psd: {frequency: [20, 300], g2_per_hz: 0.01}, duration: 30}"
    assert roll(empty).hash() == roll(plain).hash() != roll("excitation.levels=[1]").hash()


def test_a_checkpoint_holds_a_history_unless_it_says_that_one_is_complete(tmp_path: Path) -> None:
    begun, between = tmp_path / "begun.npz", tmp_path / "between.npz"
    write_checkpoint(begun, {"step": np.array(7)})
    write_checkpoint(between, {"completed": np.array(True)})
    assert [_holds_history(path) for path in (begun, between, tmp_path / "none.npz", None)] == [
        True,
        False,
        False,
        False,
    ]
