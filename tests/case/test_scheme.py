"""The trigonometric scheme in a case file."""

from __future__ import annotations

import pytest
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.errors import InputError

SWEEP = CONFIGS / "lab_sweep.yaml"


@pytest.mark.parametrize("method", ["condensed", "full"])
def test_the_trigonometric_scheme_is_for_reduced_alone(method: str) -> None:
    words = ["integrator={scheme: trigonometric}", f"solver.method={method}"]
    with pytest.raises(InputError, match=rf"solver.method {method} does not propagate modes.*use solver.method: reduc"):
        load_case(SWEEP, words)
    case = load_case(SWEEP, words[:1])
    assert (case.integrator.scheme, case.integrator.alpha, case.integrator.steps) == ("trigonometric", 0.0, 40)


def test_the_trigonometric_scheme_has_no_alpha() -> None:
    with pytest.raises(InputError, match=r"scheme trigonometric has a fixed alpha, got -0\.1"):
        load_case(SWEEP, ["integrator={scheme: trigonometric, alpha: -0.1}"])
