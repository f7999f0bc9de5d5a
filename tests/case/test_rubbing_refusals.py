"""What a solid coil that rubs on its mandrel cannot have: one line and exit code 2 of the command."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.paths import CONFIGS
from typer.testing import CliRunner

from wroll_fem.cli import app


@pytest.mark.parametrize(
    ("changed", "key"),
    [
        (["contact=null"], "contact: required section is missing"),
        (["preload=null"], "preload: required section is missing"),
        (["coil.model=layers"], "coil.interface"),
        (["coil.model=bonded"], "coil.interface"),
        (["coil.model=nonstructural_mass"], "coil.interface"),
        (["coil={model: none, interface: friction}"], "coil.interface"),
        (["coil.base=inner_edge", "coil.base_width=5"], "coil.base_width"),
        (["coil.base=free", "coil.base_width=1e-3"], "coil.base_width"),
        (["coil.interface=bonded", "coil.base=inner_edge", "coil.base_width=1e-3"], "coil.base_width"),
        (["coil.base=inner_edge", "coil.base_width=-1e-3"], "coil.base_width"),
        (["preload.pressure=-1e4"], "preload.pressure"),
        (["mesh.discretisation=fourier"], "mesh.discretisation"),
    ],
)
@pytest.mark.parametrize("roll", ["irosa", "sspp"])
def test_a_wrong_case_is_refused_in_one_line(roll: str, changed: list[str], key: str, tmp_path: Path) -> None:
    words = [word for text in changed for word in ("--set", text)]
    out = tmp_path / "out"
    done = CliRunner().invoke(app, ["run", str(CONFIGS / f"{roll}_friction.yaml"), *words, "--out", str(out)])
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert key in done.stderr
    assert not out.exists()
