"""Parts of a damping ratio due to material damping and due to friction, in proportion to their work."""

from __future__ import annotations

import numpy as np
import xarray as xr

from wroll_fem.signals.transmissibility import magnitude


def parts_of_curve(dataset: xr.Dataset, zeta: float) -> dict[str, float]:
    """Attributes `zeta_material` and `zeta_friction` of a curve of periodic motions, from the work at its peak.

    Empty without material damping or without a damping ratio.
    """
    at = int(magnitude(dataset).values.argmax())
    lost, given = (float(dataset[f"{name}_work_per_cycle"].values[at]) for name in ("material_damping", "input"))
    return _parts(zeta, lost, given)


def parts_of_sweep(dataset: xr.Dataset, zeta: float, band: tuple[float, float]) -> dict[str, float]:
    """Attributes `zeta_material` and `zeta_friction` of a sweep, from the work while it passes ``band`` (Hz).

    The dissipation of the integration scheme is divided in the same proportion. Empty without material damping or
    without a damping ratio.
    """
    frequency = dataset["instantaneous_frequency"].values
    low, high = min(band), max(band)
    passed = np.flatnonzero((frequency >= low) & (frequency <= high))
    if len(passed) < 2:
        return {}
    ends = dataset.isel(time=[passed[0], passed[-1]])
    lost = float(np.diff(ends["material_damping"].values)[0])
    rubbed = ends["friction_energy"] + ends["pressure_modulation_work"] + ends["impact_dissipation"]
    return _parts(zeta, lost, lost + float(np.diff(rubbed.values)[0]))


def _parts(zeta: float, material: float, both: float) -> dict[str, float]:
    if not (material > 0.0 and both > 0.0 and np.isfinite(zeta)):
        return {}
    share = min(material / both, 1.0)
    return {"zeta_material": zeta * share, "zeta_friction": zeta * (1.0 - share)}
