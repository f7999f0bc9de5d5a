"""Layers that stand for the wraps of a short roll (`coil.per_wrap`) tend to the coil whose wraps slide."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.paths import ROOT

LEVELS = (10.0, 20.0)
COARSE = {"circumferential": 12, "axial": 6, "grading": 10.0}


@pytest.fixture
def rolls(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import resolved_layers

    return resolved_layers


def worst(found: Any, limit: Any) -> dict[str, float]:
    """Largest relative difference over the levels."""
    names = ("stuck", "frequency", "damping", "work")
    return {name: float(np.abs(np.asarray(getattr(found, name)) / getattr(limit, name) - 1.0).max()) for name in names}


@pytest.mark.slow
def test_five_layers_are_near_the_slipping_continuum(rolls: Any) -> None:
    """First order in 1/n: four times the differences asked of twenty layers (f 0.2 %); damping and work 5 %.

    Sticking layers differ more, by 1 %: all of their shear is elastic.
    """
    limit = rolls.response(*rolls.continuum(COARSE, 4, 30.0), LEVELS)
    assert limit.damping.min() > 0.03  # slip matters
    differences = worst(rolls.response(*rolls.layered(5, COARSE), LEVELS), limit)
    assert differences["stuck"] < 0.0125
    assert differences["frequency"] < 0.008
    assert differences["damping"] < 0.05
    assert differences["work"] < 0.05


def test_interfaces_of_one_wrap_are_far_from_it(rolls: Any) -> None:
    """Five of five hundred interfaces: the frequency without slip is that of a coil a hundred times stiffer."""
    mesh = {"circumferential": 8, "axial": 3, "grading": 5.0}
    per_wrap, of_one = (rolls.first_mode(*rolls.layered(5, mesh, per_wrap=flag))[2] for flag in (True, False))
    assert of_one > 1.1 * per_wrap


@pytest.mark.slow
def test_layers_tend_to_the_slipping_continuum(rolls: Any) -> None:
    mesh = {"circumferential": 16, "axial": 8, "grading": 10.0}
    limit = rolls.response(*rolls.continuum(mesh, 8))
    five, ten, twenty = (worst(rolls.response(*rolls.layered(n, mesh)), limit) for n in (5, 10, 20))
    assert twenty["stuck"] < 0.7 * ten["stuck"] < 0.5 * five["stuck"]
    assert twenty["frequency"] < 2e-3
    assert twenty["damping"] < 0.05
    assert twenty["work"] < 0.05
