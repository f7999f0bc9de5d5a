"""Tension of the web while the roll grows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case.winding import Winding


def tension_stress(section: Winding, radius: FloatArray) -> FloatArray:
    """Tension over the web's section at the radius where it is laid, Pa, same shape as ``radius`` in m.

    constant; taper: T (1 - taper (r - r_m)/(R - r_m)); table: T times a factor, linear between its rows.
    """
    profile, whole = section.tension_profile, section.stress
    if profile.kind == "table":
        return whole * np.interp(radius, profile.radius, profile.factor)
    if profile.kind == "taper":
        assert section.mandrel is not None
        return whole * (1.0 - profile.taper * (radius - section.mandrel.outer_radius) / section.build_up)
    return np.full(np.shape(radius), whole)
