"""The mandrel under the wound roll."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wroll_fem.case.winding import WindingMandrel


def tube_stiffness(E: float, nu: float, outer_radius: float, wall: float) -> float:
    """Pressure over hoop strain at the surface of a tube under external pressure, plane stress, Pa (equation 2.8).

    K = E / ((a^2 + 1)/(a^2 - 1) - nu), a = outer over inner radius; a solid core (wall = radius) has E/(1 - nu).
    """
    hollow = (1.0 - wall / outer_radius) ** 2  # (r_i / r_m)^2
    return E / ((1.0 + hollow) / (1.0 - hollow) - nu)


def mandrel_stiffness(section: WindingMandrel) -> float:
    """K_m of the case file's mandrel, Pa."""
    if section.stiffness is not None:
        return section.stiffness
    assert section.E is not None
    assert section.wall is not None
    return tube_stiffness(section.E, section.nu, section.outer_radius, section.wall)
