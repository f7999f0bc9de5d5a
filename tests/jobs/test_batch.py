"""`wroll batch`: grids of cases expanded, run, skipped, failed, interrupted and gathered."""

from __future__ import annotations

import csv
import itertools
import json
import re
import shutil
import sys
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.paths import ROOT
from typer.testing import CliRunner, Result

from wroll_fem import cli
from wroll_fem.errors import InputError
from wroll_fem.jobs import batch
from wroll_fem.jobs.batch import draw_figures, load_series, run_grid, table_dataset, write_tables
from wroll_fem.jobs.executors import Ended, Job, LocalPool
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.jobs.grid import load_grid
from wroll_fem.progress import SilentProgress

TINY = ROOT / "configs" / "tiny.yaml"
STUDIES = sorted((ROOT / "configs" / "studies").glob("*.yaml"))
QUICK = "output.figures: [false], output.fields: [none], excitation.cycles: [3]"


def grid_file(folder: Path, text: str) -> Path:
    path = folder / "grid.yaml"
    path.write_text(text)
    return path


def wroll(*words: str | Path) -> Result:
    return CliRunner().invoke(cli.app, [str(word) for word in words])


def rows(out: Path) -> list[dict[str, str]]:
    with (out / "batch.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture(scope="module")
def run_once(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """Folder of a grid of two preloads, and of two cases that cannot converge."""
    folder = tmp_path_factory.mktemp("batch")
    text = (
        f"base: {TINY}\n"
        f"grid: {{solver.max_iterations: [30, 1], solver.max_cuts: [1], preload.pressure: [1.0e5, 3e4], {QUICK}}}\n"
    )
    path = grid_file(folder, text)
    return folder, wroll("batch", path, "--out", folder / "out", "--workers", "1")


@pytest.fixture
def finished(run_once: tuple[Path, Result], tmp_path: Path) -> tuple[Path, Path, Result]:
    """Grid file, folder and output of that batch, in a copy that the test may change."""
    folder, done = run_once
    copy = shutil.copytree(folder, tmp_path / "finished")
    return copy / "grid.yaml", copy / "out", done


# ---- what a grid file expands to ------------------------------------------------------------------


def test_every_combination_becomes_a_case_named_by_what_varies(tmp_path: Path) -> None:
    text = "grid: {preload.pressure: [1.0e+4, 3e4], contact.friction.mu: [0.25, 0.45], mesh.axial: [4]}"
    grid = load_grid(grid_file(tmp_path, f"base: {TINY}\n{text}"))
    names = [f"pressure_{p}__mu_{mu}" for p, mu in itertools.product(("10000", "30000"), ("0.25", "0.45"))]
    assert [m.name for m in grid.members] == names
    for m, (p, mu) in zip(grid.members, itertools.product((1e4, 3e4), (0.25, 0.45)), strict=True):
        assert (m.case.preload.pressure, m.case.contact.friction.mu, m.case.mesh.axial) == (p, mu, 4)
        assert m.values == {"preload.pressure": p, "contact.friction.mu": mu, "mesh.axial": 4}


def test_paths_are_relative_to_the_grid_file(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "case.yaml").write_text(TINY.read_text())
    grid = load_grid(grid_file(tmp_path / "deep", "base: ../case.yaml\ngrid: {coil.base: [free, clamped]}"))
    assert [m.case.coil.base for m in grid.members] == ["free", "clamped"]


def test_case_files_are_an_axis_and_the_reference_stands_outside(tmp_path: Path) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(TINY.read_text().replace("mu: 0.25", "mu: 0.5"))
    text = f"cases: [{TINY}, other.yaml]\nreference: {TINY}\ngrid: {{preload.pressure: [1.0e+4, 2.0e+4]}}"
    grid = load_grid(grid_file(tmp_path, text))
    assert [m.name for m in grid.members] == [
        "tiny__pressure_10000", "tiny__pressure_20000", "other__pressure_10000", "other__pressure_20000", "reference",
    ]  # fmt: skip
    assert [m.values.get("case") for m in grid.members] == ["tiny", "tiny", "other", "other", None]
    assert grid.members[2].case.contact.friction.mu == 0.5
    assert grid.members[-1].case.preload.pressure == 1e5


def test_lists_are_values_too_and_equal_last_words_use_the_whole_key(tmp_path: Path) -> None:
    text = (
        "grid: {coil.layers: [2], preload.pressure: [[200.0, 200.0], [100.0, 300.0]],"
        " mandrel.material.E: [2.0e+9, 3.0e+9], coil.material.E: [2.8e+9, 5.6e+9]}"
    )
    grid = load_grid(grid_file(tmp_path, f"base: {TINY}\n{text}"))
    assert grid.members[0].name == "pressure_2x200__mandrel.material.E_2e+09__coil.material.E_2.8e+09"
    assert grid.members[-1].name == "pressure_100-300__mandrel.material.E_3e+09__coil.material.E_5.6e+09"
    assert grid.members[-1].case.preload.pressure == [100.0, 300.0]


def test_samples_fill_every_slice_of_every_range_once(tmp_path: Path) -> None:
    """Latin hypercube: n equal slices of each range hold one sample each; the seed makes it repeatable."""
    text = (
        f"base: {TINY}\nsamples: {{count: 8, seed: 3, ranges: {{contact.friction.mu: [0.1, 0.5],"
        " preload.pressure: {low: 1.0e+4, high: 3.0e+5, scale: log}}}\ngrid: {mesh.axial: [4, 6]}"
    )
    grid = load_grid(grid_file(tmp_path, text))
    assert [m.name for m in grid.members[:3]] == ["sample_1__axial_4", "sample_1__axial_6", "sample_2__axial_4"]
    assert len(grid.members) == 16
    mu, pressure = (np.array([m.values[key] for m in grid.members[::2]]) for key in list(grid.members[0].values)[1:3])
    np.testing.assert_array_equal(np.sort(np.floor((mu - 0.1) / 0.05)), np.arange(8))
    np.testing.assert_array_equal(np.sort(np.floor(8 * np.log(pressure / 1e4) / np.log(30.0))), np.arange(8))
    assert [m.case.preload.pressure for m in grid.members[::2]] == list(pressure)
    again, other = (load_grid(grid_file(tmp_path, text.replace("seed: 3", f"seed: {n}"))) for n in (3, 4))
    assert [m.values for m in again.members] == [m.values for m in grid.members]
    assert [m.values for m in other.members] != [m.values for m in grid.members]


@pytest.mark.parametrize(
    ("text", "key", "said"),
    [
        ("base: {tiny}\ngrid: {preload.presure: [1, 2]}", "grid.preload.presure", "did you mean pressure?"),
        ("base: {tiny}\ngrid: {preload.pressure: [1, -2]}", "grid.preload.pressure", "got -2"),
        ("base: {tiny}\ngrid: {preload.pressure: 5}", "grid", "preload.pressure is not a list"),
        ("base: {tiny}\ngrid: {preload.pressure: []}", "grid", "preload.pressure is an empty list"),
        ("base: {tiny}\ngrid: {preload.pressure: [1, 1]}", "grid", "has a duplicate value"),
        ("base: {tiny}\ngrid: {preload.pressure: [3e4, 30 kPa]}", "grid.yaml", "two cases have the same folder"),
        ("base: {tiny}\ngrid: {}", "grid", "is empty: no key is varied"),
        ("base: {tiny}", "grid", "is empty: no key is varied"),
        ("grid: {preload.pressure: [1, 2]}", "base", "is missing"),
        ("base: nowhere.yaml\ngrid: {preload.pressure: [1, 2]}", "base", "case file not found"),
        ("cases: [nowhere.yaml]\ngrid: {preload.pressure: [1, 2]}", "cases", "case file not found"),
        ("base: {tiny}\nreference: nowhere.yaml\ngrid: {mesh.axial: [4]}", "reference", "case file not found"),
        ("base: {tiny}\ncases: [{tiny}]\ngrid: {mesh.axial: [4]}", "base", "cannot be combined with cases"),
        ("base: {tiny}\ngrids: {mesh.axial: [4]}", "grids", "did you mean grid?"),
        ("base: {tiny}\ngrid: {mesh.axial: [4]}\nfigure: slip_extend", "figure", "unknown figure"),
        ("base: {tiny}\nsamples: {count: 3}", "samples.ranges", "missing"),
        ("base: {tiny}\nsamples: {count: 3, ranges: {}}", "samples.ranges", "ranges is empty"),
        ("base: {tiny}\nsamples: {count: 3, ranges: {preload.pressure: [5, 1]}}", "samples.ranges", "low, high"),
        (
            "base: {tiny}\nsamples: {count: 3, ranges: {preload.pressure: {low: 0, high: 1, scale: log}}}",
            "samples.ranges.preload.pressure",
            "a logarithmic range must start above 0",
        ),
        ("base: {tiny}\nsamples: {count: 3, ranges: {mesh.axail: [4, 6]}}", "samples.ranges.mesh.axail", "axial"),
        (
            "base: {tiny}\ngrid: {preload.pressure: [1, 2]}\nsamples: {count: 3, ranges: {preload.pressure: [1, 2]}}",
            "samples.ranges",
            "is also in grid",
        ),
        ("- base", "grid.yaml", "is not a grid: it contains a list"),
        ("", "grid.yaml", "is empty"),
    ],
)
def test_a_wrong_grid_file_exits_2_with_one_line(tmp_path: Path, text: str, key: str, said: str) -> None:
    path = grid_file(tmp_path, text.replace("{tiny}", str(TINY)))
    done = wroll("batch", path, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert str(path) in done.stderr
    assert key in done.stderr
    assert said in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_grid_file_that_is_not_there_exits_2(tmp_path: Path) -> None:
    done = wroll("batch", tmp_path / "nowhere.yaml")
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "file not found; give the path of a grid file" in done.stderr


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_every_study_of_the_repository_is_valid(path: Path) -> None:
    grid = load_grid(path)
    assert len({m.case.hash() for m in grid.members}) == len(grid.members) > 1
    assert all(m.case for m in grid.members)


# ---- running ---------------------------------------------------------------------------------------


def test_failed_cases_are_listed_and_the_others_done(finished: tuple[Path, Path, Result]) -> None:
    _, out, done = finished
    assert done.exit_code == 3
    table = rows(out)
    assert [row["status"] for row in table] == ["complete", "complete", "failed", "failed"]
    for row in table[:2]:
        assert RunFolder(out / row["name"]).status() == "complete"
    for row in table[2:]:
        assert "after 1 iterations" in row["error"]
        assert f"{row['name']}: {row['error']}" in done.stderr.splitlines()
    assert done.stderr.splitlines()[-1] == "2 of 4 cases failed"
    assert "Traceback" not in done.output


def test_progress_tells_every_case_once(finished: tuple[Path, Path, Result]) -> None:
    _, out, done = finished
    told = re.findall(r"^(\d) of 4  (\S+): (complete|FAILED)", done.stdout, re.MULTILINE)
    assert [number for number, _, _ in told] == ["1", "2", "3", "4"]
    assert {name for _, name, _ in told} == {row["name"] for row in rows(out)}


def test_the_table_holds_keys_and_single_values_of_every_summary(finished: tuple[Path, Path, Result]) -> None:
    _, out, _ = finished
    table = rows(out)
    assert [float(row["preload.pressure"]) for row in table] == [1e5, 3e4, 1e5, 3e4]
    for row in table[:2]:
        summary = json.loads((out / row["name"] / "summary.json").read_text())
        assert float(row["friction_energy_j"]) == summary["friction_energy_j"] > 0
        assert int(row["dofs"]) == summary["dofs"]
        assert "interface_pressure_mean_pa" not in row  # a list
    assert table[2]["friction_energy_j"] == ""
    with xr.open_dataset(out / "batch.nc", engine="h5netcdf") as data:
        work = data["friction_energy_j"]
        assert work.attrs["units"] == "J"
        np.testing.assert_array_equal(work.values[:2], [float(row["friction_energy_j"]) for row in table[:2]])
        assert np.isnan(work.values[2:]).all()
        assert list(data["name"].values) == [row["name"] for row in table]


def test_a_finished_case_is_not_run_again(finished: tuple[Path, Path, Result], monkeypatch: pytest.MonkeyPatch) -> None:
    path, out, _ = finished
    started: list[str] = []

    def record(self: object, job: Job) -> Ended:
        started.append(job.folder.name)
        return Ended(3, "stand-in")

    monkeypatch.setattr(LocalPool, "_run", record)
    progress = SilentProgress()
    before = rows(out)
    outcomes = run_grid(load_grid(path), out, progress=progress)
    assert started == []  # what failed stays so, too
    assert rows(out) == before
    outcomes = run_grid(load_grid(path), out, retry=True, progress=progress)
    assert [o.status for o in outcomes] == ["already done", "already done", "failed", "failed"]
    assert started == [o.member.name for o in outcomes[2:]]
    assert [row["status"] for row in rows(out)] == ["complete", "complete", "failed", "failed"]
    assert sum("already done" in text for text in progress.infos) == 4


def test_a_second_call_reports_what_failed_and_names_the_way_on(finished: tuple[Path, Path, Result]) -> None:
    path, out, first = finished
    again = wroll("batch", path, "--out", out)
    assert again.exit_code == first.exit_code == 3
    told = again.stderr.splitlines()
    assert told[:2] == first.stderr.splitlines()[:2]  # the same failures in the same words
    assert told[2:] == ["2 of these failed in an earlier call; run them again with --retry", "2 of 4 cases failed"]


def test_a_folder_of_another_case_is_left_alone_and_reported(
    finished: tuple[Path, Path, Result], tmp_path: Path
) -> None:
    path, out, _ = finished
    first = load_grid(path).members[0].name
    before = (out / first / "summary.json").read_text()
    text = path.read_text().replace("base:", "base: ").replace("[3]", "[2.5]").replace("[30, 1]", "[30]")
    changed = load_grid(
        grid_file(tmp_path, text.replace("preload.pressure: [1.0e5, 3e4]", "preload.pressure: [1.0e5]"))
    )
    member = changed.members[0]
    renamed = batch.Member(first, member.file, member.values, member.overrides, member.case)
    outcome = run_grid(batch.Grid(changed.source, [renamed], []), out)[0]
    assert (outcome.status, outcome.exit_code) == ("failed", 2)
    assert "contains results of another case" in outcome.error
    assert (out / first / "summary.json").read_text() == before


def test_a_folder_of_another_batch_is_refused(finished: tuple[Path, Path, Result], tmp_path: Path) -> None:
    _, out, _ = finished
    before = (out / "batch.csv").read_text()
    path = grid_file(tmp_path, f"base: {TINY}\ngrid: {{mesh.axial: [4, 6]}}")
    done = wroll("batch", path, "--out", out)
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "contains another batch" in done.stderr
    assert (out / "batch.csv").read_text() == before


def test_fewer_than_one_worker_is_refused(tmp_path: Path) -> None:
    path = grid_file(tmp_path, f"base: {TINY}\ngrid: {{mesh.axial: [4, 6]}}")
    done = wroll("batch", path, "--out", tmp_path / "out", "--workers", "0")
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "--workers" in done.stderr


def test_a_process_that_dies_is_a_failed_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    killer = tmp_path / "python"
    killer.write_text("#!/bin/sh\nkill -9 $$\n")
    killer.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(killer))
    path = grid_file(tmp_path, f"base: {TINY}\ngrid: {{mesh.axial: [4, 6]}}")
    outcomes = run_grid(load_grid(path), tmp_path / "out")
    assert [(o.status, o.error, o.exit_code) for o in outcomes] == [("failed", "the process ended with code -9", 1)] * 2


def test_a_figure_that_lacks_failed_cases_does_not_hide_them(
    finished: tuple[Path, Path, Result], tmp_path: Path
) -> None:
    path, out, first = finished
    again = wroll("batch", grid_file(tmp_path, f"{path.read_text()}figure: layer_count\n"), "--out", out)
    assert again.exit_code == first.exit_code == 3
    assert "2 of 4 cases failed" in again.stderr
    assert "needs cases with values of preload.pressure and coil.layers" in again.stderr.splitlines()[-1]


def test_a_case_that_the_cluster_gave_up_names_the_scheduler(tmp_path: Path) -> None:
    """As distributed tells that a scheduler has died (tried with a real one): the futures are cancelled."""
    member = load_grid(grid_file(tmp_path, f"base: {TINY}\ngrid: {{mesh.axial: [4, 6]}}")).members[0]
    lost: Future[Ended] = Future()
    lost.cancel()
    outcome = batch._outcome(member, lost)
    assert (outcome.status, outcome.exit_code) == ("failed", 1)
    assert "check that the scheduler still runs" in outcome.error


# ---- tables and figures ----------------------------------------------------------------------------


def test_units_of_the_table_follow_the_names() -> None:
    data = table_dataset(
        [
            {"f_n_hz": 150.0, "zeta": 0.02, "steady_amplitude_m_s2": 3, "tension_n": 40.0, "note": "a"},
            {"f_n_hz": None, "note": None},
        ]
    )
    units = {str(name): data[name].attrs.get("units") for name in data}
    assert units == {"f_n_hz": "Hz", "zeta": "1", "steady_amplitude_m_s2": "m s-2", "tension_n": "N", "note": None}
    np.testing.assert_array_equal(data["f_n_hz"], [150.0, np.nan])
    assert list(data["note"].values) == ["a", ""]


def test_an_empty_table_is_written(tmp_path: Path) -> None:
    write_tables([], tmp_path)
    assert rows(tmp_path) == []


def test_a_spreadsheet_finds_no_formula_in_the_table(tmp_path: Path) -> None:
    """Names of cases come from file names, errors from anywhere."""
    (tmp_path / "=cmd|x.yaml").write_text(TINY.read_text())
    path = grid_file(tmp_path, "cases: ['=cmd|x.yaml']\ngrid: {mesh.axial: [4]}")
    [member] = load_grid(path).members
    write_tables([batch.Outcome(member, "failed", "=1+1", 2)], tmp_path)
    [row] = rows(tmp_path)
    assert row["error"] == "'=1+1"
    assert not [cell for cell in row.values() if cell.startswith(("=", "+", "-", "@"))]


def test_nothing_is_drawn_from_nothing(tmp_path: Path) -> None:
    text = f"base: {TINY}\ngrid: {{preload.pressure: [1, 2]}}\nfigure: friction_over_preload"
    grid = load_grid(grid_file(tmp_path, text))
    assert draw_figures(grid, tmp_path) == []


def test_a_figure_that_the_results_cannot_fill_says_so(finished: tuple[Path, Path, Result]) -> None:
    path, out, _ = finished
    grid = load_grid(path)
    with pytest.raises(InputError, match=r"values of preload\.pressure and coil\.layers"):
        draw_figures(batch.Grid(path, grid.members, ["layer_count"]), out)


def test_results_of_another_case_are_no_part_of_a_series(finished: tuple[Path, Path, Result]) -> None:
    path, out, _ = finished
    grid = load_grid(path)
    done = load_series(grid, out)
    assert done
    first = next(member for member in grid.members if member.name == done[0].name)
    other = replace(first, case=first.case.changed("contact.friction.mu=0.4"))  # the folder's name is the same
    changed = replace(grid, members=[other if member is first else member for member in grid.members])
    assert [one.name for one in load_series(changed, out)] == [one.name for one in done[1:]]
