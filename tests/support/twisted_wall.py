"""A mandrel of angle plies: stretch and shear, bending and twist are coupled, and the roll has no mirror plane."""

from __future__ import annotations

_CARBON = "{E_1: 142e+9, E_2: 10.3e+9, nu_12: 0.27, G_12: 7.2e+9, G_23: 3.7e+9, rho: 1580}"

TWISTED = (
    "mandrel.material={symmetric: true, plies: ["
    f"{{material: {_CARBON}, thickness: 0.5e-3, angle: 30}}, {{material: {_CARBON}, thickness: 0.25e-3, angle: -45}}]}}"
)
"""Override of a case of the lab roll, whose mandrel is 1.5 mm thick."""
