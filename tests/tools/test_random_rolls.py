"""The random rolls of the benchmark are valid cases, the same in every run."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from wroll_fem.case.loader import build_case


@pytest.fixture(scope="module")
def rolls(root: Path):
    spec = importlib.util.spec_from_file_location("random_rolls", root / "benchmarks" / "random_rolls.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_random_roll_is_a_valid_case(rolls) -> None:
    seen = set()
    for index in range(40):
        for analysis in rolls.ANALYSES:
            case = build_case(rolls.random_case(index, analysis))
            assert case.analysis == analysis
        seen.add((case.coil.base, case.mandrel.tip, case.coil.layers))
        assert 5e3 <= case.preload.pressure <= 2e5
        assert 0.05 <= case.friction.mu <= 1.0
        assert 0.049 <= case.excitation.amplitude / rolls.EARTH <= 3.01
    assert {base for base, _, _ in seen} == {"free", "clamped", "inner_edge"}
    assert {tip for _, tip, _ in seen} == {"rigid", "free"}
    assert {layers for _, _, layers in seen} == {1, 2, 3, 4}


def test_a_roll_is_the_same_in_every_run(rolls) -> None:
    assert rolls.random_roll(7) == rolls.random_roll(7)
    assert rolls.random_roll(7) != rolls.random_roll(8)
