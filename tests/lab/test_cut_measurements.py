"""Measurements that are cut off anywhere are refused; every byte: `python -m tests.fuzz.cut_files`."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.cut_files import available, cut

BETWEEN = ("csv", "raw")
"""Formats that do not state the number of their rows or frames."""

WHOLE = ("uff", "tiff", "tiff compressed")
"""Formats with bytes after the last number."""

EVERY = {"results": 30000, "npz": 40, "npz compressed": 40, "uff": 60}
"""Bytes per cut, 30 by default: some hundred cuts per format, 6 of results."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name == "results" else name for name in available()]
)
def test_a_measurement_that_is_cut_off_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    found = cut(name, tmp_path, every=EVERY.get(name, 30), seed=4)
    assert found.defects == []
    assert found.refused > (5 if name == "results" else 60)
    assert found.between == 0 or name in BETWEEN
    assert found.whole == 0 or name in WHOLE
