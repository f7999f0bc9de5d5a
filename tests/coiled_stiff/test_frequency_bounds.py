"""Search for the interlayer shear modulus at which another mode falls to the bending frequency."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.coiled_stiff.frequency_bounds import _crossing
from wroll_fem.errors import ConvergenceError


def shear_frequency(x: float) -> float:
    """Gap of a coil whose frequency grows as sqrt(G) at first and then levels off; zero at ln G = 7."""
    return float(-0.5 * np.log(0.5 * np.exp(7.0 - x) + 0.5))


@pytest.mark.parametrize("start", [7.4, 6.9, 7.0, 2.0, 15.0, 40.0])
def test_crossing_is_found_from_either_side(start: float) -> None:
    asked: list[float] = []

    def gap(x: float) -> float:
        asked.append(x)
        return shear_frequency(x)

    found = _crossing(gap, start, 20.0)
    assert found == pytest.approx(7.0, abs=1e-8)
    assert min(asked) >= 0.0
    assert max(asked) <= 20.0


def test_a_gap_that_never_closes_gives_the_lowest_modulus() -> None:
    assert _crossing(lambda x: 1.0 + 0.01 * x, 7.0, 20.0) == 0.0


def test_a_gap_that_is_still_open_at_the_top_is_an_error() -> None:
    with pytest.raises(ConvergenceError, match="not the fundamental mode at the interlayer shear modulus"):
        _crossing(lambda x: 0.5 * (x - 30.0), 7.0, 20.0)


@pytest.mark.parametrize("start", [7.4, 6.9, 2.0, 15.0])
def test_bending_is_the_fundamental_mode_at_the_crossing(start: float) -> None:
    assert shear_frequency(_crossing(shear_frequency, start, 20.0)) >= 0.0
