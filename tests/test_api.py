"""The public names of `import wroll_fem as wf`: there, quick to import, and doing what a run folder does."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot as plt
from support.paths import ROOT

import wroll_fem as wf
from wroll_fem.case import ANALYSES
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.progress import SilentProgress
from wroll_fem.results.dataset import FIELDS, annotate

TWO = {"friction_capacity": [2, 20], "omega": {"start": 0.8, "stop": 1.2, "points": 9}}


def two_masses(**changes) -> wf.Case:
    return wf.Case(analysis="two_dof", two_dof=TWO | changes)


FEW = {"friction_capacity": [2], "omega": {"start": 0.8, "stop": 1.2, "points": 5}}


@pytest.fixture(scope="module")
def dwell() -> wf.Case:
    """A short dwell on a coarse mesh with the root resolved: nothing to warn of, and it slips."""
    text = ["mesh.circumferential=8", "mesh.axial=10", "mesh.grading=6", "excitation.cycles=8", "solver.method=reduced"]
    return wf.load_case(ROOT / "configs" / "tiny.yaml", text)


@pytest.fixture(scope="module")
def dwelt(dwell: wf.Case) -> xr.Dataset:
    return wf.run(dwell)


def test_import_loads_no_library_and_every_name_is_there() -> None:
    code = (
        "import sys, time; began = time.process_time(); import wroll_fem as wf; took = time.process_time() - began; "
        "heavy = {'numpy', 'pydantic', 'matplotlib', 'dolfinx', 'xarray', 'yaml'} & set(sys.modules); "
        "assert not heavy, heavy; assert took < 0.05, took; "
        "assert dir(wf) == sorted(wf.__all__); "
        "wf.load_case, wf.Case; assert not {'dolfinx', 'matplotlib'} & set(sys.modules); "
        "[getattr(wf, name) for name in wf.__all__]; assert 'dolfinx' not in sys.modules; "
        "[getattr(wf.plot, name) for name in wf.plot.__all__]; assert dir(wf.plot) == sorted(wf.plot.__all__)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, timeout=600)


def test_type_checkers_see_every_name() -> None:
    tree = ast.parse((ROOT / "wroll_fem" / "__init__.py").read_text(encoding="utf-8"))
    (guarded,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = {
        alias.asname or alias.name for node in guarded.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    assert seen | {"__version__"} == set(wf.__all__)


def test_a_name_that_does_not_exist_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'wroll_fem' has no attribute 'rnu'"):
        wf.rnu  # noqa: B018
    with pytest.raises(AttributeError, match=r"no attribute 'slipmap'; it has .*slip_map"):
        wf.plot.slipmap  # noqa: B018
    assert wf.plot.plot_slip_map is wf.plot.slip_map  # the long names work too
    assert wf.two_dof.TwoMasses is not None


def test_a_result_says_where_it_comes_from_and_reads_back_as_it_was(tmp_path: Path) -> None:
    case = two_masses()
    result = wf.run(case)
    assert wf.case_of(result) == case
    assert result.attrs["case_hash"] == case.hash()
    numbers = wf.summarise(result)
    assert numbers == wf.summarise(result, case)
    assert numbers["friction_capacity_n"] == [2.0, 20.0]
    path = wf.save_result(result, tmp_path / "two.nc")
    xr.testing.assert_identical(wf.load_result(path).drop_attrs(), annotate(result).drop_attrs())
    assert wf.case_of(wf.load_result(path)) == case
    assert wf.transmissibility(result).dims == ("friction_capacity", "omega")


def test_a_run_into_a_folder_is_that_of_the_command_and_is_read_the_second_time(
    tmp_path: Path, dwell: wf.Case, dwelt: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = wf.run(dwell, out=tmp_path / "run")
    for name in ("case.yaml", "summary.json", "results.nc", "provenance.json", "figures/slip_map_01.png"):
        assert (tmp_path / "run" / name).is_file(), name
    assert "time integration" in (tmp_path / "run" / "run.log").read_text()  # also where nothing was shown
    for name in ("tip_acceleration", "friction_energy", "cumulative_slip"):
        np.testing.assert_array_equal(dwelt[name], kept[name])
    assert dwelt["friction_energy"][-1] > 0

    def forbidden(*args, **keywords):
        raise AssertionError("computed again")

    monkeypatch.setattr("wroll_fem.analyses.run_analysis", forbidden)
    xr.testing.assert_identical(wf.run(dwell, out=tmp_path / "run"), kept)
    xr.testing.assert_identical(wf.load_result(tmp_path / "run"), kept)
    with pytest.raises(wf.InputError, match="contains results of another case"):
        wf.run(two_masses(), out=tmp_path / "run")


class StopAt(SilentProgress):
    """Interrupts the time integration after some steps."""

    def __init__(self, steps: int):
        super().__init__()
        self.steps, self.first = steps, None

    @contextmanager
    def stage(self, name: str, total: float, unit: str = "") -> Iterator[StopAt]:
        self.name = name
        yield self

    def update(self, done: float, note: str = "") -> None:
        if self.name == "time integration":
            self.first = done if self.first is None else self.first
            if done >= self.steps:
                raise KeyboardInterrupt


@pytest.mark.slow
def test_an_interrupted_run_goes_on_where_it_was(tmp_path: Path, dwell: wf.Case) -> None:
    with pytest.raises(KeyboardInterrupt):
        wf.run(dwell, out=tmp_path / "run", progress=StopAt(200))
    watched = StopAt(10**9)
    resumed = wf.run(dwell, out=tmp_path / "run", progress=watched)
    assert watched.first is not None
    assert watched.first > 150
    np.testing.assert_allclose(resumed["tip_acceleration"], wf.run(dwell)["tip_acceleration"], rtol=1e-12, atol=1e-12)


def test_progress_is_shown_where_it_is_wanted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    case = two_masses(**FEW)
    wf.run(case)
    assert capsys.readouterr().out == ""  # no terminal
    wf.run(case, progress=True)
    assert "two masses: done" in capsys.readouterr().out
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    wf.run(case)
    assert "two masses: done" in capsys.readouterr().out
    wf.run(case, progress=False)
    assert capsys.readouterr().out == ""


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_doubts_are_python_warnings_that_point_to_the_callers_line(dwell: wf.Case) -> None:
    narrow = two_masses(omega={"start": 0.4, "stop": 0.7, "points": 9})
    with pytest.warns(wf.CaseWarning, match="friction capacity 2 N: .*no resonance inside") as told:
        wf.run(narrow)
    doubts = [one for one in told if issubclass(one.category, wf.CaseWarning)]  # Python 3.12 has doubts about fork, too
    assert {Path(one.filename) for one in doubts} == {Path(__file__)}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wf.run(narrow, progress=True)  # printed, not warned of


def test_an_unfinished_result_is_told(tmp_path: Path) -> None:
    result = wf.run(two_masses(**FEW)).assign_attrs(complete=False)
    path = wf.save_result(result, tmp_path / "half.nc")
    with pytest.warns(wf.CaseWarning, match=r"half\.nc: results of an incomplete run"):
        wf.load_result(path)


def test_wrong_input_is_one_line(tmp_path: Path, dwell: wf.Case) -> None:
    bare = xr.Dataset()
    for call, words in (
        (lambda: wf.run("configs/tiny.yaml"), "case: is not a case but a str; load it first: run(load_case(path))"),
        (lambda: wf.Case(analysis="modal"), "geometry: required section is missing"),
        (lambda: dwell.changed({"preload.presure": 1}), "preload.presure: unknown key, got 1; did you mean pressure?"),
        (lambda: dwell.changed(3), "cannot change a case with 3; give"),
        (lambda: wf.load_result(tmp_path), "results file not found"),
        (lambda: wf.case_of(bare), "result: does not contain its case"),
        (lambda: wf.transmissibility(bare), "result: has no transmissibility versus frequency"),
        (lambda: wf.batch_table(tmp_path), "table of a batch not found"),
        (lambda: wf.run_grid(tmp_path / "no.yaml", tmp_path), "file not found"),
        (lambda: wf.run_series(two_masses(), {"two_dof.m3": [1]}), "two_dof.m3: unknown key"),
        (lambda: wf.slip_model(two_masses()), "analysis: SlipModel needs analysis: modal_transient, got two_dof"),
        (lambda: wf.plot.study_figure("nothing", []), "figure: no figure 'nothing'; use one of"),
    ):
        with pytest.raises(wf.InputError) as told:
            call()
        assert words in str(told.value)
        assert "\n" not in str(told.value)
        assert "--set" not in str(told.value)


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_a_series_runs_every_combination_and_the_reference() -> None:
    keys = {"two_dof.m2": [0.5, 1.0], "two_dof.k2": [1.0, 2.0, 3.0]}
    members = wf.run_series(two_masses(**FEW), keys, reference=two_masses(**FEW, m2=2.0))
    assert [tuple(member.values.values()) for member in members[:-1]] == [
        (m, k) for m in keys["two_dof.m2"] for k in keys["two_dof.k2"]
    ]
    assert [member.reference for member in members] == 6 * [False] + [True]
    stuck = [float(member.data["omega_stuck"][0]) for member in members[:-1]]
    share = np.tanh(1.0)  # equations 5.6 and 5.7 at 2 N
    exact = [np.sqrt((1 + k * share) / (1 + m)) for m, k in (member.values.values() for member in members[:-1])]
    np.testing.assert_allclose(stuck, exact, rtol=1e-12)


@pytest.mark.slow
def test_a_grid_is_run_and_read_from_python(tmp_path: Path) -> None:
    base = tmp_path / "base.yaml"
    base.write_text(two_masses().resolved_yaml(), encoding="utf-8")
    grid = tmp_path / "grid.yaml"
    grid.write_text("base: base.yaml\ngrid: {two_dof.m2: [0.5, 1.0]}\n", encoding="utf-8")
    outcomes = wf.run_grid(grid, tmp_path / "out")
    assert [outcome.status for outcome in outcomes] == ["complete", "complete"]
    table = wf.batch_table(tmp_path / "out")
    assert table["zeta_max"].sizes == {"case": 2}
    members = wf.load_series(wf.load_grid(grid), tmp_path / "out")
    assert [member.values["two_dof.m2"] for member in members] == [0.5, 1.0]
    for member, zeta in zip(members, table["zeta_max"].values, strict=True):
        assert wf.summarise(member.data)["zeta_max"] == zeta
    folder = RunFolder(tmp_path / "out" / "m2_0.5")
    folder.results_file.unlink()
    assert len(wf.load_series(grid, tmp_path / "out")) == 1
    folder.record("failed", error="no luck", exit_code=1)
    with pytest.warns(wf.CaseWarning, match=r"1 of 2 cases failed; m2_0\.5: no luck"):
        assert [outcome.status for outcome in wf.run_grid(grid, tmp_path / "out")] == ["failed", "already done"]
    outcomes = wf.run_grid(grid, tmp_path / "out", retry=True)
    assert [outcome.status for outcome in outcomes] == ["complete", "already done"]


def test_a_slip_model_answers_as_the_analysis_does() -> None:
    coarse = ["mesh.discretisation=fourier", "mesh.axial=6", "mesh.radial=1", "mesh.circumferential=8", "modal.count=4"]
    case = wf.load_case(ROOT / "configs" / "case_study.yaml", coarse)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wf.CaseWarning)
        model = wf.slip_model(case)
        other = case.changed(
            {"excitation.amplitude_g": [2.0, 4.0], "winding.tension_stress": 2e7, "damping_ratio": 0.05}
        )
        found, expected = model.run(other), wf.run(other)
    for name in expected.variables:
        np.testing.assert_array_equal(found[name], expected[name], err_msg=str(name))
    assert wf.summarise(found, other)["slip_statement"] == wf.summarise(expected)["slip_statement"]
    with pytest.raises(wf.InputError, match="coil: changes the modes of the slip model"):
        model.run(case.changed({"coil.material.G_r_z": 5e8}))
    with pytest.raises(wf.InputError, match=r"excitation\.direction: changes the modes of the slip model"):
        model.run(case.changed("excitation.direction=y"))


def test_scenes_of_slip_can_be_made_without_a_display(dwelt: xr.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pyvista")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert wf.plot.jupyter_backend() == "static"
    scene = wf.plot.slip_scene(dwelt)
    picture = scene.screenshot(return_img=True)
    scene.close()
    red, _, blue = picture.reshape(-1, 3).astype(int).T
    assert np.count_nonzero((red > 150) & (blue < 120)) > 20  # the yellow end of the colours: where it slipped most
    assert np.count_nonzero((red < 90) & (blue > 60)) > 1000  # the dark end: the rest of the cylinder
    with pytest.raises(wf.InputError, match="scene of the slip needs cumulative_slip"):
        wf.plot.slip_scene(xr.Dataset())


def test_the_short_names_draw_in_the_axes_given() -> None:
    result = wf.run(two_masses(**FEW))
    _, ax = plt.subplots()
    assert wf.plot.two_dof(result, ax) is ax
    plt.close("all")


PAGE = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
@pytest.mark.slow
def test_the_page_runs_as_it_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    monkeypatch.chdir(tmp_path)
    first, many, models = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    names: dict[str, Any] = {}
    for block in (first, models):
        exec(compile(block, "docs/api.md", "exec"), names)
    assert wf.load_result("loose.nc").identical(wf.load_result(wf.save_result(names["result"], "again.nc")))
    assert 0.0 < float(names["onset"]) < 1.0
    # minutes: its cases are run by other tests, here only its calls are made
    called: list[str] = []
    for name in ("run_series", "run_grid", "batch_table", "load_series"):
        monkeypatch.setattr(wf, name, lambda *args, name=name, **keywords: called.append(name))
    monkeypatch.setattr(wf.plot, "damping_over_frequency", lambda members: None)
    exec(compile(many, "docs/api.md", "exec"), {})
    assert called == ["run_series", "run_grid", "batch_table", "load_series"]
    plt.close("all")


def test_the_page_has_every_analysis_and_names_that_exist() -> None:
    table = PAGE.partition("## From analysis to figure")[2].partition("##")[0]
    for analysis in ANALYSES:
        assert f"`{analysis}`" in table, analysis
    for row in re.findall(r"^\| (.*) \|$", table, flags=re.MULTILINE)[1:]:
        cells = [re.findall(r"`([a-z]\w+)[`(]", cell) for cell in row.split(" | ")]
        for name in cells[2]:
            assert name in wf.plot.__all__, name
        if "run_series" not in cells[0]:
            assert set(cells[1]) <= set(FIELDS), set(cells[1]) - set(FIELDS)
    drawn = {name for name in re.findall(r"`(\w+)[`(]", table) if name in wf.plot.__all__}
    assert set(wf.plot.__all__) - drawn == {"jupyter_backend", "mode_shapes", "save", "write_slip_vtu"}
    for name in re.findall(r"\bwf\.(\w+)", PAGE):
        assert name in wf.__all__, name


def test_times_of_the_notebooks_are_told_for_every_one() -> None:
    told = set(re.findall(r"\(notebooks/(\w+)\.md\)", PAGE))
    assert told == {path.stem for path in (ROOT / "notebooks").glob("*.ipynb")}
