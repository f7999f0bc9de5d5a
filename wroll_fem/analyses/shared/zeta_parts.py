"""Parts of a damping ratio due to material damping and due to friction."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.integrate import trapezoid

from wroll_fem.signals.transmissibility import magnitude
from wroll_fem.typing import FloatArray

ROUNDING = 1e-6
"""Friction work, relative to the whole work, up to which it is regarded as round-off."""


def parts_of_curve(dataset: xr.Dataset, zeta: float) -> dict[str, float]:
    """Attributes `zeta_material` and `zeta_friction` of a response curve, from the motion at its peak.

    Empty without material damping or without a damping ratio.
    """
    if "material_modal_damping" not in dataset:
        return {}
    at = int(magnitude(dataset).values.argmax())
    material = float(dataset["material_modal_damping"].values[at])
    lost, given = (float(dataset[f"{name}_work_per_cycle"].values[at]) for name in ("material_damping", "input"))
    return _parts(zeta, material, lost, given)


def parts_of_sweep(dataset: xr.Dataset, zeta: float, band: tuple[float, float]) -> dict[str, float]:
    """Attributes `zeta_material` and `zeta_friction` of a sweep, from the motion while it passes ``band`` (Hz).

    The rate of loss of a mode with damping ratio zeta is 4 zeta omega times its kinetic energy. Empty without material
    damping or without a damping ratio.
    """
    frequency = dataset["instantaneous_frequency"].values
    low, high = min(band), max(band)
    passed = np.flatnonzero((frequency >= low) & (frequency <= high))
    if len(passed) < 2:
        return {}
    inside = dataset.isel(time=slice(int(passed[0]), int(passed[-1]) + 1))

    def grown(name: str) -> float:
        return float(inside[name].values[-1] - inside[name].values[0])

    lost = grown("material_damping")
    rubbed = sum(grown(name) for name in ("friction_energy", "pressure_modulation_work", "impact_dissipation"))
    power = 4.0 * 2.0 * np.pi * inside["instantaneous_frequency"].values * inside["kinetic_energy"].values
    moved = float(trapezoid(power, inside["time"].values))
    return _parts(zeta, lost / moved if moved > 0.0 else np.nan, lost, lost + rubbed)


def parts_of_random(dataset: xr.Dataset, zeta: float, start: float) -> dict[str, float]:
    """Attributes `zeta_material` and `zeta_friction` of a random motion: shares of the energy lost after ``start`` (s).

    Empty without material damping or without a damping ratio.
    """
    steady = dataset.isel(time=dataset["time"].values >= start)

    def grown(name: str) -> float:
        return float(steady[name].values[-1] - steady[name].values[0])

    lost = grown("material_damping")
    both = lost + sum(grown(name) for name in ("friction_energy", "pressure_modulation_work", "impact_dissipation"))
    return _parts(zeta, zeta * lost / both if both > 0.0 else np.nan, lost, both)


def backbone_parts(zeta: FloatArray, material: FloatArray) -> FloatArray:
    """(p,) parts of the damping ratios ``zeta`` (p,) of a backbone due to friction, without round-off."""
    rest = zeta - material
    return np.asarray(np.where(np.abs(rest) <= ROUNDING * zeta, 0.0, rest))


def _parts(zeta: float, material: float, lost: float, both: float) -> dict[str, float]:
    if not (lost > 0.0 and both > 0.0 and np.isfinite(zeta) and np.isfinite(material)):
        return {}
    part = zeta if lost >= (1.0 - ROUNDING) * both else min(material, zeta)
    return {"zeta_material": part, "zeta_friction": zeta - part}
