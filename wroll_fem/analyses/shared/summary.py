"""Shared entries of summary.json; `results.summary.SUMMARY` has names, units and labels."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from wroll_fem.bodies.mode_shapes import main_bending
from wroll_fem.results.energy import energy_balance_error
from wroll_fem.results.summary import SUMMARY
from wroll_fem.signals.transmissibility import magnitude

ROUNDING = 1e-12
"""Energy, relative to the largest energy of a run, up to which a value is rounding error and is stated as zero."""

_LARGE = ("input_work", "kinetic_energy", "strain_energy")


def attributes(dataset: xr.Dataset) -> dict[str, Any]:
    """Summary entries from the attributes of the Dataset."""
    found = {name: dataset.attrs[name] for name in SUMMARY if name in dataset.attrs}
    for name in ("warnings", "zeta_doubts", "down_zeta_doubts", "averaging_doubts"):
        if name in found:
            found[name] = [text for text in str(found[name]).split("\n") if text]
    return found


def interfaces(dataset: xr.Dataset) -> dict[str, Any]:
    """Pressure of every interface, inner first; empty without interfaces."""
    found: dict[str, Any] = {}
    if "pressure" in dataset:
        area, pressure = dataset["area"], dataset["pressure"]
        found["interface_pressure_mean_pa"] = ((pressure * area).sum("point") / area.sum("point")).values.tolist()
    if "external_pressure" in dataset:
        found["external_pressure_pa"] = dataset["external_pressure"].values.tolist()
    return found


def ledger(dataset: xr.Dataset) -> dict[str, Any]:
    """Energies at the end of a time history."""
    last = dataset.isel(time=-1)
    names = (
        "friction_energy", "material_damping", "input_work", "numerical_dissipation", "pressure_modulation_work",
        "impact_dissipation",
    )  # fmt: skip
    noise = ROUNDING * float(max(np.abs(dataset[name].values).max() for name in _LARGE if name in dataset))
    found = {f"{name}_j": _without_noise(float(last[name]), noise) for name in names if name in last}
    if not found.get("material_damping_j"):
        found.pop("material_damping_j", None)
    return found | {"energy_balance_error": energy_balance_error(dataset)}


def _without_noise(energy: float, noise: float) -> float:
    return 0.0 if abs(energy) <= noise else energy


def work_per_cycle(dataset: xr.Dataset) -> dict[str, Any]:
    """Work per period at the largest response, or at the largest damping of a backbone."""
    if "modal_damping" in dataset:
        at = int(dataset["modal_damping"].values.argmax())
    else:
        at = int(magnitude(dataset).values.argmax())
    names = [f"{part}_work_per_cycle" for part in ("input", "friction", "modulation", "material_damping")]
    least = 1e-9 * dataset.attrs.get("least_work_per_cycle_j", 0.0)  # about ROUNDING times the kinetic energy
    noise = max(least, ROUNDING * float(np.abs(dataset[names[0]].values).max()))
    found: dict[str, Any] = {f"{name}_j": _without_noise(float(dataset[name].values[at]), noise) for name in names}
    return found | {"energy_balance_error": dataset.attrs.get("energy_balance_error")}


def slip(dataset: xr.Dataset) -> dict[str, Any]:
    """Relative displacement, accumulated slip, slipping area and opening; empty without interfaces."""
    if "cumulative_slip" not in dataset:
        return {}
    from wroll_fem.results.interface_slip import least_pressure_ratio, open_area_fraction, slipping_area_fraction

    largest = float(dataset["max_slip"].max())
    found = {
        "max_relative_displacement_m": largest,
        "max_slip_m": largest,
        "max_accumulated_slip_m": float(dataset["cumulative_slip"].max()),
        "slipping_area_fraction": slipping_area_fraction(dataset).values.tolist(),
    }
    if "wrap_interfaces" in dataset.attrs:
        wraps = xr.DataArray(dataset.attrs["wrap_interfaces"], dims="interface")
        for name, entry in (("max_slip", "max_relative_displacement"), ("cumulative_slip", "max_accumulated_slip")):
            found[f"{entry}_per_wrap_m"] = float((dataset[name] / wraps).max())
    if "open_time_fraction" not in dataset:  # results of an earlier version
        return found
    return found | {
        "open_area_fraction": open_area_fraction(dataset).values.tolist(),
        "open_time_fraction": dataset["open_time_fraction"].max("point").values.tolist(),
        "min_pressure_over_preload": least_pressure_ratio(dataset).values.tolist(),
    }


def base_loads(dataset: xr.Dataset) -> dict[str, Any]:
    """Largest base shear and base moment, of the fundamental for steady motions; only those that were computed."""
    found = {}
    for name, unit in (("base_shear", "n"), ("base_moment", "nm")):
        for variable in (name, f"{name}_amplitude"):
            if variable in dataset:
                found[f"{name}_max_{unit}"] = float(np.abs(dataset[variable].values).max())
    return found


def modes(dataset: xr.Dataset) -> dict[str, Any]:
    """Frequencies, effective masses along the excitation and, if available, kinds of modes."""
    found: dict[str, Any] = {}
    fraction = dataset["effective_mass_fraction"]
    if "component" in fraction.dims:
        fraction = fraction.sel(component=dataset.attrs["excitation_direction"])
    if "mode_kind" in dataset:
        found["mode_kinds"] = [str(kind) for kind in dataset["mode_kind"].values]
        index = main_bending(found["mode_kinds"], fraction.values)
        if index is not None:
            found["bending_hz"] = float(dataset["mode_frequency"].values[index])
    found["modes_hz"] = dataset["mode_frequency"].values.tolist()
    if "mode_damping_ratio" in dataset:
        found["mode_damping_ratios"] = dataset["mode_damping_ratio"].values.tolist()
    found["effective_mass_fraction"] = fraction.values.ravel().tolist()
    return found
