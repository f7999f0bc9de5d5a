"""Tension profile: tension stress in the web as a function of the winding radius."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case.winding import Winding


def tension_stress(section: Winding, radius: FloatArray) -> FloatArray:
    """Tension stress at which the web is wound at given radii.

    The profile is constant, a taper T (1 - taper (r - r_m)/(R - r_m)), or a table of factors of T with linear
    interpolation.

    Parameters
    ----------
    section
        Case section `winding`.
    radius
        Winding radii, m.

    Returns
    -------
    Tension stress, Pa, in the shape of `radius`
    """
    profile, whole = section.tension_profile, section.stress
    if profile.kind == "table":
        return whole * np.interp(radius, profile.radius, profile.factor)
    if profile.kind == "taper":
        return whole * (1.0 - profile.taper * (radius - section.core.outer_radius) / section.build_up)
    return np.full(np.shape(radius), whole)
