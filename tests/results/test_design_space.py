"""The tuned secondary of a design space, against the masses and stiffness of the two-mass model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from wroll_fem.results.design_space import tuned_stiffness
from wroll_fem.results.pressure_profile import middle_slope
from wroll_fem.two_dof import TwoMasses


def space(**attrs: object) -> xr.Dataset:
    best = np.array([[2.0, 2.0, np.nan], [5.0, 2.0, 5.0]])
    given = {
        "arrangement": "both_on_base", "primary_mass_kg": 1.3, "primary_stiffness_n_m": 0.9, "preload_dependent": True,
    } | attrs  # fmt: skip
    return xr.Dataset({"capacity_at_zeta_max": (("m2", "k2"), best)}, {"m2": [0.5, 0.9], "k2": [1.0, 1.2, 1.4]}, given)


@pytest.mark.parametrize("dependent", [True, False])
def test_the_tuned_secondary_has_the_frequency_of_the_primary(dependent: bool) -> None:
    found = tuned_stiffness(space(preload_dependent=dependent))
    assert found is not None
    assert found[0] == 2.0
    for m2, k2 in zip((0.5, 0.9), found[1], strict=True):
        masses = replace(TwoMasses(m1=1.3, k1=0.9), m2=m2, k2=float(k2), preload_dependent=dependent).preloaded(2.0)
        assert masses.k2 / masses.m2 == pytest.approx(masses.k1 / masses.m1, rel=1e-12)


def test_a_secondary_off_the_base_has_no_tuned_stiffness() -> None:
    assert tuned_stiffness(space(arrangement="secondary_on_primary")) is None


def test_the_pressure_gradient_of_the_middle_half() -> None:
    r = np.linspace(1.0, 3.0, 9)
    roll = xr.Dataset({"pressure_pa": ("r", 100.0 - 7.0 * r + np.where(r > 2.6, 50.0, 0.0))}, {"r": r})
    assert middle_slope(roll) == pytest.approx(7.0)
