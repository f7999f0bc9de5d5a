"""Parts of summary.json that analyses share: flat, SI, the unit in the name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.structure.mode_shapes import main_bending

if TYPE_CHECKING:
    from wroll_fem.case import Case

_READINGS = (
    "f_n_hz", "zeta", "zeta_method", "f_n_error_hz", "zeta_error", "zeta_lower_bound", "zeta_misfit", "zeta_reason",
    "peak_transmissibility", "half_power_low_hz", "half_power_high_hz", "skewness",
    "dofs", "interface_points", "reduced_coordinates", "reduction_error_estimate", "training_time_s",
    "reduction_tip_error_estimate", "folds", "branch_points", "f_stuck_hz", "f_largest_amplitude_hz", "zeta_max",
    "tip_amplitude_at_zeta_max_m", "base_acceleration_at_zeta_max_m_s2", "memory_change", "steps", "step_cuts",
    "newton_iterations_mean", "solver_time_s", "mass_total_kg",
    "pressure_mandrel_pa", "capacity_mandrel_pa", "mandrel_stiffness_pa", "pressure_mandrel_error_estimate",
    "pressure_mandrel_wrap_grid_pa", "capacity_mandrel_wrap_grid_pa", "hoop_bound_pa", "hoop_stress_min_pa",
    "tension_stress_pa", "tension_n", "outer_radius_m",
)  # fmt: skip
"""Attributes of a Dataset that go into its summary under their own names."""


def readings(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Numbers that the analysis left in the attributes of its Dataset."""
    attrs = dataset.attrs
    found = {key: attrs[key] for key in _READINGS if key in attrs}
    return found | {str(key): value for key, value in attrs.items() if str(key).startswith("steady_")}


def interfaces(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Pressure of every interface, inner first, and what was asked for; nothing of a roll without interfaces."""
    found: dict[str, Any] = {}
    if "pressure" in dataset:
        area, pressure = dataset["area"], dataset["pressure"]
        found["interface_pressure_mean_pa"] = ((pressure * area).sum("point") / area.sum("point")).values.tolist()
    if "external_pressure" in dataset:
        found["external_pressure_pa"] = dataset["external_pressure"].values.tolist()
    if case.preload.kind == "winding_tension" and case.coil.model == "layers":
        from wroll_fem.winding.interface import target_pressures

        found["winding_pressure_pa"] = target_pressures(case).tolist()
    return found


def energy_balance_error(dataset: xr.Dataset) -> float:
    """|input - kinetic - strain - contact - friction - modulation - numerical| / largest input, at its worst time.

    Dimensionless; every term is computed on its own (the scheme's dissipation from its closed form), so this
    sees unconverged steps, lost slip and wrong bookkeeping.
    """
    stored = dataset["kinetic_energy"] + dataset["strain_energy"] + dataset["contact_energy"]
    spent = dataset["friction_energy"] + dataset["pressure_modulation_work"] + dataset["numerical_dissipation"]
    for name in ("viscous_energy", "impact_dissipation"):
        if name in dataset:
            spent = spent + dataset[name]
    gap = np.abs((dataset["input_work"] - stored - spent).values)
    scale = float(np.abs(dataset["input_work"].values).max())
    return float(gap.max() / scale) if scale > 0 else 0.0


def ledger(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Energies at the end of a time history."""
    last = dataset.isel(time=-1)
    names = ("friction_energy", "input_work", "numerical_dissipation", "pressure_modulation_work", "impact_dissipation")
    found = {f"{name}_j": float(last[name]) for name in names if name in last}
    return found | {"energy_balance_error": energy_balance_error(dataset)}


def work_per_cycle(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Work of a period where the response, or the damping of a backbone, is largest."""
    if "modal_damping" in dataset:
        at = int(dataset["modal_damping"].values.argmax())
    else:
        at = int(np.hypot(dataset["transmissibility_real"].values, dataset["transmissibility_imag"].values).argmax())
    names = [f"{part}_work_per_cycle" for part in ("input", "friction", "modulation", "viscous")]
    found: dict[str, Any] = {f"{name}_j": float(dataset[name].values[at]) for name in names}
    return found | {"energy_balance_error": dataset.attrs.get("energy_balance_error")}


def slip(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Largest slip, and the share of every interface that slipped; nothing of a roll without interfaces."""
    if "cumulative_slip" not in dataset:
        return {}
    from wroll_fem.results.interface_slip import slipping_area_fraction

    fraction = slipping_area_fraction(dataset).values.tolist()
    return {"max_slip_m": float(dataset["max_slip"].max()), "slipping_area_fraction": fraction}


def modes(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Frequencies, effective mass along the excitation, and names where the model has them."""
    found: dict[str, Any] = {}
    fraction = dataset["effective_mass_fraction"]
    if "component" in fraction.dims:
        fraction = fraction.sel(component=case.excitation.direction)
    if "mode_kind" in dataset:
        found["mode_kinds"] = [str(kind) for kind in dataset["mode_kind"].values]
        index = main_bending(found["mode_kinds"], fraction.values)
        if index is not None:
            found["bending_hz"] = float(dataset["mode_frequency"].values[index])
    found["modes_hz"] = dataset["mode_frequency"].values.tolist()
    found["effective_mass_fraction"] = fraction.values.ravel().tolist()
    return found
