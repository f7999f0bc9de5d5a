"""Table of the flight rolls over the preload: made-up results, and a coarse SSPP through its three studies."""

from __future__ import annotations

import csv
import re
import runpy
import sys
from pathlib import Path

import pytest
import yaml
from support.here_pool import HerePool
from support.page_commands import commands
from support.paths import ROOT
from typer.testing import CliRunner

from wroll_fem.cli import app
from wroll_fem.jobs import batch

COMMAND = ".venv/bin/python -m tools.flight_table runs/reproduce"
STUDIES = ("flight_preload", "flight_chirp", "flight_inner_edge")


def printed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> list[list[str]]:
    """Cells of the rows that the command of the page prints in the present folder."""
    assert COMMAND in commands(ROOT / "docs" / "chapter6.md")
    capsys.readouterr()
    monkeypatch.setattr(sys, "argv", COMMAND.split()[2:])
    runpy.run_module("tools.flight_table", run_name="__main__")
    head, rule, *rows = capsys.readouterr().out.splitlines()
    assert head in (ROOT / "docs" / "chapter6.md").read_text(encoding="utf-8")
    assert {line.count("|") for line in (rule, *rows)} == {head.count("|")}
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


def test_rows_are_in_the_order_of_rolls_and_preloads_and_say_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = {"f_n_hz": 48.21, "peak_transmissibility": 39.84, "zeta": 0.0179, "friction_energy_j": 9.86}
    cases = [
        ("habex", 2e4, {"friction_energy_j": 465.4}),
        ("habex", 1e5, {"f_n_hz": "", "peak_transmissibility": "", "zeta": ""}),
        ("irosa", 1e4, {"zeta_quality": "doubtful"}),
        ("sspp", 1e4, {}),
    ]
    for study in STUDIES:
        rows = [
            {
                "case": f"{roll}_friction", "preload.pressure": pressure, "zeta_quality": "ok", **found, **changes,
                "status": "failed" if study != "flight_chirp" and roll == "sspp" else "complete",
            }
            for roll, pressure, changes in cases
        ]  # fmt: skip
        folder = tmp_path / "runs" / "reproduce" / "studies" / study
        folder.mkdir(parents=True)
        with (folder / "batch.csv").open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, rows[0])
            table.writeheader()
            table.writerows(rows)
    monkeypatch.chdir(tmp_path)
    assert printed(monkeypatch, capsys) == [
        ["iROSA", "10", "48.2", "39.8", "1.8 % (doubtful)", "48.2; 39.8; 9.9", "48.2; 39.8; 1.8 % (doubtful)"],
        ["SSPP", "10", "none", "", "", "48.2; 39.8; 9.9", "none"],
        ["HabEx", "20", "48.2", "39.8", "1.8 %", "48.2; 39.8; 465", "48.2; 39.8; 1.8 %"],
        ["HabEx", "100", "none", "none", "", "none; none; 9.9", "none; none;"],
    ]


@pytest.mark.slow
def test_the_studies_have_what_the_table_reads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """SSPP at 1 MPa with 2 % of modal damping and little motion: a peak of the tip's participation, 1.026, over 2 zeta.

    The chirp passes 4 Hz, the width at half power, in 0.23 s, 23 cycles: its peak is later and lower.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(batch, "LocalPool", HerePool)
    case = yaml.safe_load((ROOT / "configs" / "sspp_friction.yaml").read_text(encoding="utf-8"))
    case |= {"mesh": {"circumferential": 8, "axial": 8, "radial": 3, "grading": 20}, "damping": {"modal": 0.02}}
    case["excitation"] |= {"amplitude_g": 0.02, "f_start": 90, "f_end": 110}
    case["harmonic"] = {"harmonics": 1}
    Path("sspp_friction.yaml").write_text(yaml.safe_dump(case), encoding="utf-8")
    for study in STUDIES:
        grid = yaml.safe_load((ROOT / "configs" / "studies" / f"{study}.yaml").read_text(encoding="utf-8"))
        grid["cases"] = ["sspp_friction.yaml"]
        grid["grid"] |= {"preload.pressure": [1e6]}
        for key in ("excitation.f_start", "excitation.f_end"):
            grid["grid"].pop(key, None)
        Path(f"{study}.yaml").write_text(yaml.safe_dump(grid), encoding="utf-8")
        words = ["batch", f"{study}.yaml", "--out", f"runs/reproduce/studies/{study}"]
        answer = CliRunner().invoke(app, words)
        assert answer.exit_code == 0, answer.output
    ((roll, pressure, f_n, peak, zeta, chirp, clamped),) = printed(monkeypatch, capsys)
    assert (roll, pressure) == ("SSPP", "1000")
    steady, chirped, held = (
        [float(number) for number in re.findall(r"\d+\.\d+", cells)]
        for cells in (f"{f_n} {peak} {zeta}", chirp, clamped)
    )
    assert 2.0 <= steady[2] < 2.1  # the rest is friction
    assert steady[1] == pytest.approx(1.026 / 0.04, rel=0.03)
    assert steady[0] < chirped[0] < 1.03 * steady[0]
    assert 0.8 * steady[1] < chirped[1] < steady[1]
    assert chirped[2] > 0.0  # J
    assert held[0] == pytest.approx(1.0374 * steady[0], rel=5e-3)  # 1.0374 from 8 x 12 x 8 to 24 x 12 x 8, 8 x 24 x 16
    assert held[1] == pytest.approx(1.05 / 0.04, rel=0.03)  # participation 1.049
