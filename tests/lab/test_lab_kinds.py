"""Every kind of the laboratory: its example runs through the command, its names are declared, bad input is one line."""

from __future__ import annotations

import base64
import hashlib
import json
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
import yaml
from matplotlib.layout_engine import ConstrainedLayoutEngine
from pydantic import BaseModel
from support.report_pages import parsed
from typer.testing import CliRunner

import wroll_fem as wf
from tools.reference.case import type_name
from wroll_fem.case.descriptions import sections, unit_of
from wroll_fem.cli import app
from wroll_fem.errors import InputError
from wroll_fem.lab.examples import example_files
from wroll_fem.lab.kinds import KINDS, find_kind
from wroll_fem.lab.settings import read_settings
from wroll_fem.lab.slip_images import example as slip_example
from wroll_fem.report.lab import CAPTIONS
from wroll_fem.results.dataset import FIELDS, load_dataset
from wroll_fem.results.summary import SUMMARY

ARRANGED = ConstrainedLayoutEngine.execute
QUICK_DRAWING = [kind if kind == "tension" else pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS]
"""Kinds; all but the one whose figures are drawn fastest are slow."""


@pytest.fixture(scope="module")
def examples(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Path]]:
    folder = tmp_path_factory.mktemp("examples")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(slip_example, "FRAMES", 150)  # its numbers are looked at in test_slip_command.py
        patch.setattr(slip_example, "LAYERS", slip_example.LAYERS[:3])
        patch.setattr(slip_example, "DIAMETERS", slip_example.DIAMETERS[:3])
        return {name: example_files(name, folder / name) for name in KINDS}


def settings_of(files: list[Path]) -> list[str]:
    file = files[0].parent / "settings.yaml"
    return ["--settings", str(file)] if file.is_file() else []


def command_of(kind: str, files: list[Path]) -> list[str]:
    """Words of the command that evaluates the example of a kind into the folder `out` beside it."""
    return ["lab", kind, *map(str, files), *settings_of(files), "--out", str(files[0].parents[1] / f"{kind}_out")]


@pytest.fixture(scope="module")
def evaluated(examples: dict[str, list[Path]]) -> Callable[[str], Path]:
    """Function that returns the folder of the evaluated example of a kind."""

    @cache
    def folder(kind: str) -> Path:
        words = command_of(kind, examples[kind])
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, done.output
        return Path(words[-1])

    return folder


@pytest.mark.parametrize("kind", KINDS)
def test_the_example_of_a_kind_runs_into_a_complete_folder(
    kind: str, examples: dict[str, list[Path]], evaluated: Callable[[str], Path]
) -> None:
    out, files = evaluated(kind), examples[kind]
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert summary["evaluation"] == kind
    assert summary["files"] == len(files)
    assert set(summary) <= set(SUMMARY)
    data = load_dataset(out / "results.nc")
    assert {str(name) for name in data.variables} <= set(FIELDS)
    for dims, names in find_kind(kind).variables.items():
        for name in names:
            assert ", ".join(map(str, data[name].dims)) == dims, name
    assert {path.stem for path in (out / "figures").glob("*.png")} <= set(find_kind(kind).figures)
    assert any((out / "figures").glob("*.png"))
    assert (out / "run.log").stat().st_size > 0
    record = json.loads((out / "provenance.json").read_text(encoding="utf-8"))
    assert record["status"] == "complete"
    assert record["command"].startswith(f"wroll lab {kind} ")
    if files[0].is_file():
        assert record["inputs"][0]["sha256"] == hashlib.sha256(files[0].read_bytes()).hexdigest()
    model = find_kind(kind).settings
    given = settings_of(files)
    assert read_settings(model, out / "settings.yaml") == read_settings(model, given[1] if given else None)
    again = CliRunner().invoke(app, command_of(kind, files))
    assert again.exit_code == 2
    assert "is not empty; choose another --out" in again.output


def figures_of(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (out / "figures").glob("*.png")}


def check_report(out: Path, figures: dict[str, bytes]) -> None:
    done = CliRunner().invoke(app, ["report", str(out)])
    assert (done.exit_code, done.output) == (0, f"{out / 'report.html'}\n")
    shown = [image.get("src", "").partition("base64,")[2] for image in parsed(out / "report.html").iter("img")]
    assert {base64.b64decode(text) for text in shown} == set(figures.values())


@pytest.mark.parametrize("kind", [pytest.param(k, marks=pytest.mark.slow) if k == "slip" else k for k in KINDS])
def test_figures_are_drawn_again_from_the_results_and_stand_in_the_report(
    kind: str, evaluated: Callable[[str], Path], tmp_path: Path
) -> None:
    first, out = figures_of(evaluated(kind)), tmp_path / "out"
    shutil.copytree(evaluated(kind), out, ignore=shutil.ignore_patterns("figures"))
    redrawn = CliRunner().invoke(app, ["plot", str(out)])
    assert redrawn.exit_code == 0, redrawn.output
    assert figures_of(out) == first
    assert {line.rpartition("/")[2] for line in redrawn.output.splitlines()} == set(first)
    assert {name.removesuffix(".png") for name in first} <= set(CAPTIONS)
    check_report(out, first)


@pytest.mark.parametrize("kind", QUICK_DRAWING)
def test_the_report_draws_the_figures_that_the_folder_has_not(
    kind: str, evaluated: Callable[[str], Path], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    shutil.copytree(evaluated(kind), out, ignore=shutil.ignore_patterns("figures"))
    check_report(out, figures_of(evaluated(kind)))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", QUICK_DRAWING)
def test_figures_of_a_kind_are_arranged_without_a_warning(
    kind: str, evaluated: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, out = figures_of(evaluated(kind)), tmp_path / "out"
    shutil.copytree(evaluated(kind), out, ignore=shutil.ignore_patterns("figures"))
    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", ARRANGED)
    done = CliRunner().invoke(app, ["plot", str(out)])
    assert done.exit_code == 0, done.output
    assert set(figures_of(out)) == set(first)


def inner(model: type[BaseModel]) -> list[type[BaseModel]]:
    return [model, *(m for f in model.model_fields.values() for s in sections(f.annotation) for m in inner(s))]


@pytest.mark.parametrize("kind", KINDS)
def test_every_setting_is_described_and_every_number_has_a_unit(kind: str) -> None:
    for model in inner(find_kind(kind).settings):
        for name, field in model.model_fields.items():
            assert field.description, f"{model.__name__}.{name}"
            if "number" in type_name(field.annotation):
                assert unit_of(field.description) or "as the enclosing key" in field.description, name


@pytest.mark.parametrize("kind", KINDS)
def test_the_help_of_a_kind_has_its_sentence_and_settings(kind: str) -> None:
    group = CliRunner().invoke(app, ["lab", "--help"], terminal_width=200)
    assert KINDS[kind].sentence in " ".join(group.output.split())
    own = CliRunner().invoke(app, ["lab", kind, "--help"], terminal_width=200)
    assert own.exit_code == 0
    assert all(f"  {name}" in own.output for name in find_kind(kind).settings.model_fields)


def test_wrong_input_is_one_line_and_leaves_no_folder(examples: dict[str, list[Path]], tmp_path: Path) -> None:
    file, out = str(examples["transmissibility"][0]), tmp_path / "out"
    settings = tmp_path / "mine.yaml"
    settings.write_text(yaml.safe_dump({"figurs": True}), encoding="utf-8")
    wrong = {
        "unknown key": [file, "--set", "figurs=1"],
        f"{settings}:1: figurs: unknown key, got true; did you mean figures?": [file, "--settings", str(settings)],
        "file not found; give the path of a measurement": [f"{file}x"],
        "is given twice": [file, file],
        "is a folder, not a file": [str(tmp_path)],
        "write true or false": [file, "--set", "figures=3"],
    }
    for message, words in wrong.items():
        units = ["--set=base_unit=g", "--set=tip_unit=m/s"]
        done = CliRunner().invoke(app, ["lab", "transmissibility", *words, *units, "--out", str(out)])
        assert done.exit_code == 2
        assert message in done.output
        assert done.output.count("\n") == 1, done.output
        assert not out.exists()


def test_a_folder_of_an_interrupted_evaluation_can_be_used_again(
    examples: dict[str, list[Path]], tmp_path: Path
) -> None:
    file, out = str(examples["transmissibility"][0]), tmp_path / "out"
    out.mkdir()
    (out / "provenance.json").write_text('{"status": "failed"}', encoding="utf-8")
    chosen = [f"--set={text}" for text in ("figures=false", "resolution=1", "base_unit=g", "tip_unit=m/s")]
    words = ["lab", "transmissibility", file, *chosen, "--out", str(out)]
    assert CliRunner().invoke(app, words).exit_code == 0
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").touch()
    other = CliRunner().invoke(app, [*words[:-1], str(tmp_path / "full")])
    assert other.exit_code == 2
    assert "is not empty" in other.output


def test_the_python_call_gives_the_result_of_the_command(examples: dict[str, list[Path]]) -> None:
    files = examples["fit"]
    found = wf.lab.evaluate("fit", files, settings_file=files[0].parent / "settings.yaml")
    assert found.kind == "fit"
    assert found.inputs[0]["bytes"] > 0
    assert found.warnings == []
    assert found.data.attrs["evaluation"] == "fit"
    with pytest.raises(InputError, match="use one of"):
        found.plot("nonsense")
    with pytest.raises(InputError, match="unknown kind 'nonsense' of evaluation; use one of"):
        wf.lab.evaluate("nonsense", files)
