"""Slip of the interfaces of a dwell: areas, and largest relative displacements."""

from __future__ import annotations

import numpy as np

from wroll_fem.plotting.study import StudyCase
from wroll_fem.results.interface_slip import slipping_area_fraction, surface
from wroll_fem.typing import FloatArray

AMPLITUDE = "excitation.amplitude"


def areas(member: StudyCase) -> FloatArray:
    """Area of each interface that slips at any time, m^2."""
    total = member.data["area"].values.sum(axis=-1)
    return np.asarray(slipping_area_fraction(member.data).values * total)


def outer_slips(member: StudyCase) -> FloatArray:
    """Largest relative displacement of each interface, m, inner first."""
    found = []
    for k in range(member.data.sizes["interface"]):
        points = surface(member.data, k, "peak_slip_hoop", "peak_slip_axial").values
        found.append(float(np.hypot(points["peak_slip_hoop"], points["peak_slip_axial"]).max()))
    return np.array(found)
