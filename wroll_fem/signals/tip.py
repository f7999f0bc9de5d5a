"""Absolute motion of the tip, with the base or with a force as the excitation."""

from __future__ import annotations

import xarray as xr

from wroll_fem.typing import FloatArray

EXCITED_BY = "excited_by"
"""Attribute of a result that is "force" if a force excites the structure in place of the base."""


def rigid_tip(history: xr.Dataset) -> float:
    """|T| of the rigid structure: 1, or 0 if a force excites it in place of the base."""
    return 0.0 if history.attrs.get(EXCITED_BY) == "force" else 1.0


def absolute_tip(history: xr.Dataset) -> FloatArray:
    """(n,) absolute tip acceleration of a history, m/s^2; without that of the base if a force is the excitation."""
    relative = history["tip_acceleration"].values
    return relative + history["base_acceleration"].values if rigid_tip(history) else relative
