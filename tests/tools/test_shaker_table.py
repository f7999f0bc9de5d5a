"""Tables of the simulated shaker tests."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from support.page_commands import commands
from support.paths import ROOT

from reproduction import camera_slip, shaker_random, shaker_shock, shaker_sweeps
from reproduction.camera_slip import Seen


def test_tables_have_the_readings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sweep = shaker_sweeps.Reading(0.0, 150.4, 0.005, 126.0, 1.0, 151.0, np.nan, 0.7)
    roll = shaker_sweeps.Reading(30.0, 148.4, 0.0522, 18.0, 1.35, 145.9, 0.0439, 3.0)
    monkeypatch.setattr(shaker_sweeps, "readings", lambda _: [sweep, roll])
    hit = shaker_shock.Shocked(0.0, np.zeros(2), np.zeros(2), np.array([150.0, 151.0]), np.array([37.2, 2.0]), 0.488)
    monkeypatch.setattr(shaker_shock, "responses", lambda _: [hit, hit._replace(pressure=30.0, fade=0.12)])
    series = shaker_random.Series(20.0, *(np.array(x) for x in (
        [0.1, 1.0], [1.3, 13.0], [18.0, 70.0], [153.1, 145.1], [0.1, 0.1], [0.0061, 0.0434], [0.0, 0.0]
    )))  # fmt: skip
    monkeypatch.setattr(shaker_random, "readings", lambda _: [series])
    view = Seen(*(np.array([1, 2, 3, 3]), np.array([1, 1, 1, 11]), np.array([0, 0, 0, 6])), *(
        1e-6 * np.array(x) for x in ([8.6, 5.9, 4.7, 20.0], [1.0, 1.0, 1.0, 1.0])
    ), 1.7e-6)  # fmt: skip
    monkeypatch.setattr(camera_slip, "seen", lambda _: [{"axial": view}, {"axial": view}])
    command = ".venv/bin/python -m tools.shaker_table runs/reproduce"
    assert command in commands(ROOT / "docs" / "chapter3.md")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", command.split()[2:])
    runpy.run_module("tools.shaker_table", run_name="__main__")
    printed = capsys.readouterr().out
    assert (
        "| mandrel alone | 150.4 Hz, 0.50 %, 126.0, 1.00 | refused: too fast | 37.20 m/s at 150.0 Hz, 488 ms |"
        in printed
    )
    assert "| 30 kPa | 148.4 Hz, 5.22 %, 18.0, 1.35 | 145.9 Hz, 4.39 % | 37.20 m/s at 150.0 Hz, 120 ms |" in printed
    assert "| 1 | 145.1 Hz, 4.34 %, 70 m/s² |" in printed
    assert "| loose, 20 N, axial face | 8.6, 5.9, 4.7 | 1.7 |" in printed
