"""Radial stiffness of the mandrel under a wound roll."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wroll_fem.case.winding import WindingMandrel


def tube_stiffness(E: float, nu: float, outer_radius: float, wall: float) -> float:
    """Ratio of external pressure to hoop strain at the surface of a tube in plane stress, Pa (equation 2.8).

    K = E / ((a^2 + 1)/(a^2 - 1) - nu) with a = outer/inner radius; K = E/(1 - nu) for a solid core (wall = radius).

    Parameters
    ----------
    E, nu
        Young's modulus (Pa) and Poisson's ratio.
    outer_radius, wall
        Outer radius and wall thickness, m.
    """
    solid = wall / outer_radius * (2.0 - wall / outer_radius)  # 1 - (r_i / r_m)^2
    return E / ((2.0 - solid) / solid - nu)


def mandrel_stiffness(section: WindingMandrel) -> float:
    """Stiffness K_m, Pa, of the mandrel that the case section `winding` describes."""
    if section.stiffness is not None:
        return section.stiffness
    wall, E = section.tube
    return tube_stiffness(E, section.nu, section.outer_radius, wall)
