"""Pressure between mandrel and solid coil under an external pressure: closed form against integration."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.paths import CONFIGS

from wroll_fem import load_case
from wroll_fem.winding.interface import transmitted_pressure


@pytest.mark.parametrize("file", ["habex_friction.yaml", "kapton_roll.yaml", "irosa_friction.yaml"])
def test_a_ring_passes_on_the_pressure_that_integration_gives(file: str) -> None:
    """Radial equilibrium of an orthotropic ring in plane stress, from the mandrel (sigma_r = E t / a^2 u) outwards."""
    case = load_case(CONFIGS / file)
    web, mandrel = case.coil.solid(), case.mandrel.material.in_plane
    a = case.geometry.mandrel_outer_diameter / 2
    core = mandrel.E_theta * case.geometry.mandrel_thickness / a**2

    def slopes(r: float, state: np.ndarray) -> list[float]:
        u, radial = state
        hoop = web.E_theta * u / r + web.nu_theta_r * radial
        return [radial / web.E_r - web.nu_theta_r * hoop / web.E_theta, (hoop - radial) / r]

    u = -1e-6
    path = solve_ivp(slopes, (a, a + case.coil.total_thickness), [u, core * u], rtol=1e-10, atol=[1e-18, 1e-4])
    exact = core * u / path.y[1, -1]
    assert 0.0 < exact < 2.0
    # the integration is good to 1e-8
    assert transmitted_pressure(case) == pytest.approx(exact, rel=1e-6)
