"""Every fit of the laboratory: its 95 % intervals hold the truth as often as they promise."""

from __future__ import annotations

import pytest
from support.coverage import misses
from support.lab_experiments import EXPERIMENTS, repeated

FEWER = {"ageing": 4, "slip": 3, "rate_table": 5, "elastic_slip": 6, "trials": 8}
"""Repetitions of the experiments that take longer; 20 of the others."""


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_intervals_hold_the_truth_as_often_as_they_promise(name: str) -> None:
    found = repeated(name, FEWER.get(name, 20), seed=1)
    wrong = {key: misses(hits) for key, hits in found.items() if "preferred" not in key}
    assert not any(wrong.values()), wrong
    assert all(all(hits) for key, hits in found.items() if "preferred" in key)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXPERIMENTS)
def test_intervals_hold_the_truth_in_90_to_99_of_100_repetitions(name: str) -> None:
    found = repeated(name, 100, seed=2)
    counts = {key: sum(hits) for key, hits in found.items() if "preferred" not in key}
    assert all(90 <= count <= 99 for count in counts.values()), counts
    assert all(all(hits) for key, hits in found.items() if "preferred" in key)
