"""Check of the energy ledger that a time history leaves behind."""

from __future__ import annotations

import numpy as np
import xarray as xr


def energy_balance_error(dataset: xr.Dataset) -> float:
    """|input - kinetic - strain - contact - friction - modulation - numerical| / largest input, at its worst time.

    Dimensionless. Every term is computed on its own (the scheme's dissipation from its closed form), so that
    unconverged steps, lost slip and wrong bookkeeping show.
    """
    stored = dataset["kinetic_energy"] + dataset["strain_energy"] + dataset["contact_energy"]
    spent = dataset["friction_energy"] + dataset["pressure_modulation_work"] + dataset["numerical_dissipation"]
    for name in ("viscous_energy", "impact_dissipation"):
        if name in dataset:
            spent = spent + dataset[name]
    gap = np.abs((dataset["input_work"] - stored - spent).values)
    scale = float(np.abs(dataset["input_work"].values).max())
    return float(gap.max() / scale) if scale > 0 else 0.0
