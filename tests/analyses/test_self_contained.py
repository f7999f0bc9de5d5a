"""Results need nothing but themselves: not the case's files, not the run folder."""

from __future__ import annotations

import shutil
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
import xarray as xr
import yaml
from support.empty_figures import empty_figures
from support.paths import CONFIGS
from typer.testing import CliRunner

import wroll_fem as wf
from wroll_fem.analyses.shared.self_contained import described
from wroll_fem.cli import app
from wroll_fem.errors import InputError
from wroll_fem.plotting import style

QUICK = [
    "excitation.rate_oct_per_min=20", "integrator.steps_per_cycle=20", "solver.allow_coarse=true",
    "output.figures=false",
]  # fmt: skip


@pytest.fixture(autouse=True)
def _few_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(style, "DPI", 30)


@pytest.fixture(scope="module")
def mailed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of a case of matrices from a file that is no longer there."""
    place = tmp_path_factory.mktemp("mailed")
    shutil.copy(CONFIGS / "oscillator.yaml", place)
    matrices = yaml.safe_load((CONFIGS / "oscillator.yaml").read_text())["structure"]["file"]
    (place / matrices).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(CONFIGS / matrices, place / matrices)
    with pytest.warns(wf.CaseWarning, match="ISO 7626-2"):
        wf.run(wf.load_case(place / "oscillator.yaml", QUICK), out=place / "run", progress=False)
    (place / matrices).unlink()
    return place / "run"


def test_a_result_is_summarised_and_drawn_without_the_files_of_its_case(mailed: Path, tmp_path: Path) -> None:
    result = wf.load_result(shutil.copy(mailed / "results.nc", tmp_path / "mailed.nc"))
    with pytest.raises(InputError, match="structure file not found"):
        wf.case_of(result)
    summary = wf.summarise(result)
    assert summary["analysis"] == "sweep"
    assert summary["f_n_hz"] == result.attrs["f_n_hz"] > 0.0
    wf.plot.transmissibility(result)
    plt.close("all")


def test_plot_and_report_work_without_the_files_of_the_case(mailed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        empty_figures(patch)
        done = CliRunner().invoke(app, ["plot", str(mailed)])
    assert done.exit_code == 0, done.output
    assert (mailed / "figures" / "transmissibility.png").is_file()
    shutil.rmtree(mailed / "figures")
    done = CliRunner().invoke(app, ["report", str(mailed)])
    assert done.exit_code == 0, done.output
    assert "data:image/png;base64," in (mailed / "report.html").read_text(encoding="utf-8")


def test_a_results_file_alone_is_drawn_and_reported(
    mailed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = Path(shutil.copy(mailed / "results.nc", tmp_path / "mailed.nc"))
    with monkeypatch.context() as patch:
        empty_figures(patch)
        assert CliRunner().invoke(app, ["plot", str(file)]).exit_code == 0
    assert (tmp_path / "figures" / "transmissibility.png").is_file()
    done = CliRunner().invoke(app, ["report", str(file)])
    assert done.exit_code == 0, done.output
    page = (tmp_path / "mailed.html").read_text(encoding="utf-8")
    for words in ("Run mailed.nc", "Resonance frequency f_n", "data:image/png;base64,", "excitation.f_start"):
        assert words in page


def test_results_of_version_0_1_0_know_their_analysis_from_the_text_of_their_case(mailed: Path) -> None:
    result = wf.load_result(mailed)
    old = result.drop_attrs(deep=False).assign_attrs({k: v for k, v in result.attrs.items() if k != "analysis"})
    assert wf.summarise(old) == wf.summarise(result)


def test_what_summaries_take_from_the_case_is_kept() -> None:
    case = wf.load_case(CONFIGS / "winding_sweep.yaml", ["excitation.direction=y", "output.every=7"])
    data = described(xr.Dataset(coords={"component": ["x", "y", "z"], "snapshot_time": [0.1]}), case)
    assert data.attrs["analysis"] == "sweep"
    assert data.attrs["excitation_direction"] == "y"
    assert data.attrs["output_every"] == 7
    assert len(data.attrs["winding_pressure_pa"]) == case.coil.layers
    bare = xr.Dataset(attrs={"case_yaml": case.resolved_yaml()})
    from wroll_fem.analyses.shared.self_contained import completed

    assert completed(bare).attrs == bare.attrs | data.attrs
