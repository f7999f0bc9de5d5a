"""Columns of a file as series of equal times."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wroll_fem.signals.records.series import read_series


def test_columns_without_times_have_those_of_the_sampling_rate(tmp_path: Path) -> None:
    values = np.random.default_rng(3).standard_normal((40, 2))
    path = tmp_path / "record.csv"
    path.write_text("tip,base\n" + "\n".join(f"{a!r},{b!r}" for a, b in values.tolist()) + "\n", encoding="utf-8")
    series = read_series(path, {"response": "tip", "base": 2}, sampling_rate=250.0)
    assert series.dt == 1.0 / 250.0
    np.testing.assert_array_equal(series.values["response"], values[:, 0])
    np.testing.assert_array_equal(series.values["base"], values[:, 1])
