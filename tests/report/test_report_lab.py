"""`wroll report` and `wroll plot` of a laboratory evaluation: content of the page, unfinished and foreign folders."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from xml.etree.ElementTree import Element

import pytest
from support.report_pages import NASTY, parsed, rows, section, words
from typer.testing import CliRunner

from wroll_fem import cli
from wroll_fem.errors import InputError
from wroll_fem.jobs.lab_folder import LabFolder
from wroll_fem.jobs.lab_run import run_lab
from wroll_fem.lab.examples import example_files
from wroll_fem.lab.kinds import find_kind
from wroll_fem.lab.settings import read_settings
from wroll_fem.report import write_report
from wroll_fem.results.dataset import load_dataset, save_dataset


@pytest.fixture(scope="module")
def shear(tmp_path_factory: pytest.TempPathFactory) -> LabFolder:
    """Folder of the evaluated example of the shear tests, without figures."""
    place = tmp_path_factory.mktemp("lab")
    files = example_files("shear", place / "measured")
    settings = read_settings(find_kind("shear").settings, place / "measured" / "settings.yaml", ["figures=false"])
    run_lab("shear", files, settings, place / "result", command="wroll lab shear")
    return LabFolder(place / "result")


@pytest.fixture(scope="module")
def page(shear: LabFolder, tmp_path_factory: pytest.TempPathFactory) -> Element:
    return parsed(write_report(shear.path, tmp_path_factory.mktemp("page") / "r.html"))


def test_the_report_holds_settings_inputs_numbers_and_figures(shear: LabFolder, page: Element) -> None:
    root = page
    assert [h.text for h in root.iter("h2")] == [
        "What was evaluated", "Warnings", "Metrics", "Figures", "Versions and provenance", "Files",
    ]  # fmt: skip
    what = section(root, "What was evaluated")
    assert "Capacity, stiffness, modulus, loops" in words(what)
    assert "force drop at the onset of slip1 Nevent_drop" in words(what)
    record = shear.provenance()["inputs"][0]
    assert rows(what)[record["path"]] == [str(record["bytes"]), record["sha256"]]
    assert "wroll lab shear" in words(section(root, "Versions and provenance"))
    assert len(list(root.iter("img"))) == 3
    assert not shear.figures.exists()


def test_the_interval_of_one_number_is_not_spread_over_a_series(shear: LabFolder, page: Element) -> None:
    found = rows(section(page, "Metrics"))
    low, high = shear.summary()["capacity_coefficient_interval"]
    assert found["Interval of this coefficient"] == [f"{low:.4g}, {high:.4g}", "capacity_coefficient_interval"]


def test_a_results_file_alone_gives_the_numbers_of_its_folder(shear: LabFolder, page: Element, tmp_path: Path) -> None:
    alone = tmp_path / "taken.nc"
    shutil.copy(shear.results_file, alone)
    whole = section(page, "Metrics")
    taken = parsed(write_report(alone))
    assert (tmp_path / "taken.html").is_file()
    assert words(section(taken, "Metrics")) == words(whole)
    assert "area" in words(section(taken, "What was evaluated"))
    done = CliRunner().invoke(cli.app, ["plot", str(alone)])
    assert done.exit_code == 0, done.output
    assert sorted(path.stem for path in (tmp_path / "figures").iterdir()) == [
        "capacity", "coefficient", "force_displacement",
    ]  # fmt: skip


def test_values_per_parameter_share_one_table(tmp_path: Path) -> None:
    folder = LabFolder(tmp_path)
    folder.input_file.write_text("figures: true\nmodel: {kind: backbones, grid: here}\n", encoding="utf-8")
    fitted = {"elastic_slip_m": 2e-6, "frequency_factor": 1.0}
    low = {"elastic_slip_m": 1e-6, "frequency_factor": 0.5}
    summary = {"evaluation": "fit", "parameters": fitted, "parameters_low": low, "undetermined": []}
    folder.write_json(folder.summary_file, summary)
    root = parsed(write_report(tmp_path))
    found = rows(section(root, "Metrics"))
    assert found["elastic_slip_m"] == ["2 µm", "1 µm"]
    assert found["frequency_factor"] == ["1", "0.5"]
    assert "none" in next(cells for name, cells in found.items() if "undetermined" in cells)
    assert "the evaluation did not end" in words(section(root, "Warnings"))


def test_an_unfinished_evaluation_is_reported_and_not_drawn(tmp_path: Path) -> None:
    folder = LabFolder(tmp_path / "out")
    folder.path.mkdir()
    folder.input_file.write_text(f"other: {NASTY!r}\n", encoding="utf-8")
    folder.log_file.write_text(f"now warning: {NASTY}\n", encoding="utf-8")
    folder.write_json(folder.provenance_file, {"status": "failed", "error": "no such column", "evaluation": NASTY})
    (folder.path / "tension.csv").write_text(NASTY, encoding="utf-8")
    root = parsed(write_report(folder.path))
    assert not {"script"} & {element.tag for element in root.iter()}
    said = words(section(root, "Warnings"))
    for part in ("stopped by an error", "no such column", "alert", "has no results"):
        assert part in said
    assert "alert" in words(section(root, "Tables"))
    done = CliRunner().invoke(cli.app, ["plot", str(folder.path)])
    assert done.exit_code == 2
    assert done.output == (
        f"{folder.path}: has no results (results.nc): the evaluation did not end; "
        "delete the folder and run `wroll lab` again\n"
    )


def test_a_result_of_a_kind_of_another_version_is_refused_in_one_line(shear: LabFolder, tmp_path: Path) -> None:
    data = load_dataset(shear.results_file)
    save_dataset(data.assign_attrs(evaluation="x_rays"), tmp_path / "new.nc")
    for command in ("plot", "report"):
        done = CliRunner().invoke(cli.app, [command, str(tmp_path / "new.nc")])
        assert done.exit_code == 2
        assert "contains no evaluation of this version (x_rays); give a result of `wroll lab`" in done.output
        assert done.output.count("\n") == 1
    folder = LabFolder(tmp_path / "damaged")
    shutil.copytree(shear.path, folder.path)
    folder.summary_file.write_text(json.dumps({"shear_capacity_n": "much"}), encoding="utf-8")
    with pytest.raises(InputError, match="shear_capacity_n has a wrong type"):
        write_report(folder.path)
