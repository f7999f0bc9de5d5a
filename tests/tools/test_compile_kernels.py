"""The runs with which the set-up compiles the kernels are valid cases: a refused one would compile nothing."""

from __future__ import annotations

import pytest

from tools.compile_kernels import CONFIGS, RUNS
from wroll_fem.case import load_case


@pytest.mark.parametrize(("name", "overrides"), RUNS, ids=[" ".join([name, *words[-1:]]) for name, words in RUNS])
def test_a_run_of_the_set_up_is_a_valid_case(name: str, overrides: list[str]) -> None:
    case = load_case(CONFIGS / f"{name}.yaml", overrides)
    assert case.analysis in ("dwell", "harmonic", "backbone", "winding", "two_dof")
