"""Damaged measurements are refused in one line or evaluated; the long search is `tests/fuzz/laboratory_files.py`."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from tests.fuzz.laboratory_files import run
from tests.fuzz.laboratory_originals import ORIGINALS

COUNT = {"fit": 10, "table of targets": 20, "frames tiff": 5, "frames png": 5, "frames raw": 5}
"""Copies of the readers that take longer, or shorter; 8 of the others."""


@pytest.mark.parametrize("name", [name for name in ORIGINALS if name != "shaker uff" or find_spec("pyuff")])
def test_a_damaged_measurement_ends_neither_in_a_traceback_nor_in_a_hang(name: str) -> None:
    outcomes, defects, slowest = run([name], COUNT.get(name, 8), seed=2)
    assert not defects
    assert sum(outcomes.values()) == COUNT.get(name, 8)
    assert outcomes[name, "refused"]  # the damage reaches the reader
    assert slowest < 5.0


def test_a_record_whose_fit_has_numbers_that_are_not_finite_is_read() -> None:
    """Number 8950 of the first seed: LAPACK ended in a SystemError."""
    outcomes, defects, _ = run(["shaker npz"], 1, seed=1, first=8950)
    assert not defects
    assert outcomes["shaker npz", "read"] == 1


def test_whole_measurements_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.fuzz.laboratory_originals.changed", lambda columns, chance: columns)
    outcomes, defects, _ = run(["tension", "shaker npz"], 8, seed=3)
    assert not defects
    assert outcomes["tension", "read"] >= 3
    assert outcomes["shaker npz", "read"] >= 3
