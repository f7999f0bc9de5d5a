"""Page of shock response spectra against pyyeti, for which recursions of straight lines by scipy stand in here."""

from __future__ import annotations

import importlib.util
import re
import shlex
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter
from support.page_commands import bare, commands
from support.paths import ROOT

from wroll_fem.typing import FloatArray


def srs(
    record: FloatArray, rate: float, frequencies: FloatArray, q: float, stype: str, rolloff: str, parallel: str
) -> FloatArray:
    """Largest samples of oscillators under a base acceleration that is straight between its samples."""
    found = []
    for w in 2.0 * np.pi * frequencies:
        outputs = {"absacce": [-w * w, -w / q], "reldisp": [1.0, 0.0], "pvelo": [w, 0.0]}
        system = ([[0.0, 1.0], [-w * w, -w / q]], [[0.0], [-1.0]], [outputs[stype]], [[0.0]])
        a, b, c, d, _ = cont2discrete(tuple(map(np.array, system)), 1.0 / rate, method="foh")
        poles = np.poly(a)
        found.append(np.abs(lfilter(np.poly(a - b @ c) + (d[0, 0] - 1.0) * poles, poles, record)).max())
    return np.array(found)


def test_the_command_writes_its_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Up to 0.012 % by the samples of the reference; 0.031 % on the page of random records."""
    page = "docs/tables/shock_spectra.md"
    (command,) = (line for line in commands(ROOT / page) if "shock_spectra.py" in line)
    pyyeti = ModuleType("pyyeti.srs")
    monkeypatch.setattr(pyyeti, "srs", srs, raising=False)
    monkeypatch.setitem(sys.modules, "pyyeti", ModuleType("pyyeti"))
    monkeypatch.setitem(sys.modules, "pyyeti.srs", pyyeti)
    spec = importlib.util.spec_from_file_location("shock_spectra", ROOT / "benchmarks" / "shock_spectra.py")
    assert spec is not None
    assert spec.loader is not None
    shock_spectra = importlib.util.module_from_spec(spec)  # not in sys.modules, as its reference is not pyyeti
    spec.loader.exec_module(shock_spectra)
    monkeypatch.setattr(shock_spectra, "RECORDS", 1)
    monkeypatch.setattr(shock_spectra, "version", lambda name: f"of {name}")
    monkeypatch.chdir(tmp_path)
    (tmp_path / page).parent.mkdir(parents=True)
    monkeypatch.setattr(sys, "argv", shlex.split(bare(command))[1:])
    shock_spectra.main()
    text = (tmp_path / page).read_text(encoding="utf-8")
    assert "`pyyeti.srs.srs` of pyyeti: 1 random records" in text
    rows = re.findall(r"^\| (\w+) \| (primary|maximax) \| (\d\.\d{3}) % \| (\d\.\d{3}) % \|$", text, flags=re.MULTILINE)
    assert [row[:2] for row in rows] == [(q, i) for q in shock_spectra.QUANTITIES for i in ("primary", "maximax")]
    assert all(0.0 < float(value) < 0.05 for row in rows for value in row[2:]), rows
