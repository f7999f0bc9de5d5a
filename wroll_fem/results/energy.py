"""Energy balance of a time history."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from wroll_fem.typing import FloatArray

MATERIAL = ("material_damping", "viscous_energy")
"""Present and former name of the energy dissipated by dashpots; a Dataset has one of them at most."""


def energy_balance_error(dataset: xr.Dataset) -> float:
    """Largest residual of the energy balance at any time, divided by the largest input work; dimensionless.

    The residual is |input - kinetic - strain - contact - friction - modulation - numerical|; material damping and
    impact dissipation are also subtracted if they exist. Each term is computed independently (the dissipation of the
    scheme from its closed form). The residual therefore reveals unconverged steps, lost slip and wrong energy terms.
    """
    stored = dataset["kinetic_energy"] + dataset["strain_energy"] + dataset["contact_energy"]
    spent = dataset["friction_energy"] + dataset["pressure_modulation_work"] + dataset["numerical_dissipation"]
    for name in (*MATERIAL, "impact_dissipation"):
        if name in dataset:
            spent = spent + dataset[name]
    gap = np.abs((dataset["input_work"] - stored - spent).values)
    scale = float(np.abs(dataset["input_work"].values).max())
    return float(gap.max() / scale) if scale > 0 else 0.0


class EnergyLedger(NamedTuple):
    """Terms of the energy balance, cumulative from the start, J, (n_time,) each.

    Attributes
    ----------
    input_work
        Work of the base motion.
    friction, material
        Energy dissipated by friction, and by material damping, the dashpots (zero without them).
    stored
        Change of kinetic, strain and contact energy, plus the work of the pressure modulation.
    numerical
        Dissipation of the integration scheme, and of the time steps in which contact closes or opens.
    """

    input_work: FloatArray
    friction: FloatArray
    material: FloatArray
    stored: FloatArray
    numerical: FloatArray

    @property
    def gap(self) -> FloatArray:
        """Residual of the energy balance."""
        return self.input_work - self.friction - self.material - self.stored - self.numerical


def energy_ledger(dataset: xr.Dataset) -> EnergyLedger:
    """Terms of the energy balance of a time history; missing terms are zero."""

    def total(*names: str) -> FloatArray:
        zero = np.zeros_like(dataset["input_work"].values)
        return sum((dataset[name].values for name in names if name in dataset), zero)

    stored = total("kinetic_energy", "strain_energy", "contact_energy", "pressure_modulation_work")
    return EnergyLedger(
        dataset["input_work"].values,
        dataset["friction_energy"].values,
        total(*MATERIAL),
        stored - stored[0],
        total("numerical_dissipation", "impact_dissipation"),
    )
