"""Case files that `wroll init` writes: valid, commented, changed by answers with units."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner, Result

from wroll_fem import cli, load_case
from wroll_fem.case.starter import QUESTIONS, STARTERS, questions, starter_text
from wroll_fem.errors import InputError


@pytest.mark.parametrize("analysis", STARTERS)
def test_every_key_has_a_comment_and_the_case_is_valid(analysis: str, tmp_path: Path) -> None:
    path = tmp_path / "new.yaml"
    path.write_text(starter_text(analysis), encoding="utf-8")
    assert load_case(path).analysis == analysis
    assert all("#" in line for line in path.read_text().splitlines() if not line.startswith("analysis"))
    asked = {key for key, description, _ in questions(analysis) if description}
    assert asked <= set(QUESTIONS)
    assert {"geometry.length", "coil.total_thickness"} <= asked


def test_changes_keep_their_units_in_the_file() -> None:
    text = starter_text("dwell", ["geometry.length=1.2 m", "excitation.frequency=1800 min^-1", "coil.layers=3"])
    content = yaml.safe_load(text)
    assert content["geometry"]["length"] == "1.2 m"
    assert content["excitation"]["frequency"] == "1800 min^-1"
    assert content["coil"]["layers"] == 3


def test_wrong_changes_and_unknown_analyses_are_refused() -> None:
    with pytest.raises(InputError, match=r"--set geometry.length: must be a length, not a mass, got '3 kg'"):
        starter_text("sweep", ["geometry.length=3 kg"])
    with pytest.raises(InputError, match=r"--analysis: there is no case to start from for analysis 'winding'; use one"):
        starter_text("winding")


def test_init_asks_and_overwrites_nothing(wroll: Callable[..., Result], tmp_path: Path) -> None:
    answers = "1200 mm\n" + "\n" * 30
    asked = CliRunner().invoke(cli.app, ["init", "new.yaml", "--ask", "--set", "coil.layers=2"], input=answers)
    assert asked.exit_code == 0
    assert "coil.layers (" not in asked.stdout
    case = load_case(tmp_path / "new.yaml")
    assert (case.geometry.length, case.coil.layers, case.analysis) == (1.2, 2, "sweep")
    again = wroll("init", "new.yaml")
    assert again.exit_code == 2
    assert "nothing is overwritten" in again.stderr
