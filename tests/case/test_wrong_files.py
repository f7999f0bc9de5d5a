"""Seventy wrong case files (units, spelling, physics): each error names key, problem and remedy; exit code 2."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from support.paths import CONFIGS
from typer.testing import CliRunner

from wroll_fem import cli

WRONG = yaml.safe_load((Path(__file__).parent / "wrong_files.yaml").read_text(encoding="utf-8"))
SWEEP = yaml.safe_load((CONFIGS / "lab_sweep.yaml").read_text(encoding="utf-8"))


def written(folder: Path, changes: list[dict[str, Any]]) -> Path:
    content = yaml.safe_load(yaml.safe_dump(SWEEP))
    for change in changes:
        *sections, key = change["key"].split(".")
        place = content
        for section in sections:
            place = place.setdefault(section, {})
        place[key] = change["value"]
        if change["value"] is None:
            del place[key]
    path = folder / "case.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return path


def messages(path: Path) -> list[str]:
    """Lines on standard error of `wroll validate`, without the file; its exit code is 2."""
    told = CliRunner().invoke(cli.app, ["validate", str(path)])
    assert told.exit_code == 2
    return [re.sub(rf"^{re.escape(str(path))}(:\d+)?: ", "", line) for line in told.stderr.splitlines()]


@pytest.mark.parametrize("wrong", WRONG, ids=lambda wrong: f"{wrong['key']}={wrong['value']}")
def test_a_wrong_file_is_explained(wrong: dict[str, Any], tmp_path: Path) -> None:
    told = messages(written(tmp_path, [wrong]))
    assert told == wrong["says"]
    for line in told:
        assert re.fullmatch(r"[\w.]+: .+; .+", line), "key: problem; remedy"
        assert len(line) < 250


def test_all_errors_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    """One error in each section, at first; the last two are found by comparing valid sections with each other."""
    chosen: dict[str, dict[str, Any]] = {}
    for wrong in WRONG:
        chosen.setdefault(wrong["key"].split(".")[0] if "." in wrong["key"] else "", wrong)
    del chosen[""], chosen["excitation"], chosen["integrator"], chosen["solver"]
    chosen |= {wrong["key"]: wrong for wrong in WRONG if wrong["key"] in ("integrator.steps_per_cycle", "mandrel.base")}
    del chosen["mandrel"]
    told = messages(written(tmp_path, list(chosen.values())))
    assert sorted(told) == sorted(line for wrong in chosen.values() for line in wrong["says"])
    assert len(told) >= 8


def test_a_wrong_section_is_not_compared_with_others(tmp_path: Path) -> None:
    """The number of pressures cannot be judged without a valid number of layers."""
    told = messages(
        written(tmp_path, [{"key": "coil.layers", "value": 0}, {"key": "preload.pressure", "value": [1e5, 1e5]}])
    )
    assert len(told) == 1
    assert told[0].startswith("coil.layers: must be 1 or more")
