"""Names and values of summary.json as a reader wants them: words, and numbers with units."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any

_UNITS = {
    "m_s2": "m/s²", "n_m": "N/m", "rad_s": "rad/s", "hz": "Hz", "j": "J", "pa": "Pa", "m": "m", "s": "s", "kg": "kg",
    "n": "N", "rad": "rad", "g": "g",
}  # fmt: skip
"""Last words of a name -> unit, longest first; `_g` is an acceleration over 9.80665 m/s²."""

_AS_WRITTEN = ("Hz", "rad", "rad/s", "g", "m/s²", "N/m")  # units that are read without prefix
_SHARES = (
    "zeta",
    "zeta_max",
    "zeta_max_over_design",
    "zeta_error",
    "zeta_lower_bound",
    "zeta_misfit",
    "energy_balance_error",
    "_fraction",
    "_error_estimate",
    "steady_drift",
    "steady_residual",
)

EFFORT = (
    "dofs", "interface_points", "reduced_coordinates", "reduction_error_estimate", "reduction_tip_error_estimate",
    "training_time_s", "steps", "step_cuts", "newton_iterations_mean", "branch_points", "solver_time_s", "wall_time_s",
)  # fmt: skip
"""Names of summary.json that tell of the computation, not of the roll."""

_LABELS = {
    "f_n_hz": "resonance frequency f_n",
    "zeta": "damping ratio zeta",
    "zeta_method": "method of zeta",
    "zeta_error": "standard error of zeta",
    "f_n_error_hz": "standard error of f_n",
    "zeta_lower_bound": "zeta, lower end of its error bar",
    "zeta_misfit": "distance of fit and curve, over the peak",
    "zeta_reason": "why this method",
    "peak_transmissibility": "peak transmissibility",
    "half_power_low_hz": "lower half-power frequency",
    "half_power_high_hz": "upper half-power frequency",
    "skewness": "skewness of the peak",
    "energy_balance_error": "energy balance error, over the input",
    "friction_energy_j": "energy dissipated by friction",
    "input_work_j": "work put in by the base motion",
    "numerical_dissipation_j": "energy dissipated by the integration scheme",
    "pressure_modulation_work_j": "work exchanged with the pressure-dependent stick stiffness",
    "impact_dissipation_j": "energy lost where surfaces land and part",
    "interface_pressure_mean_pa": "mean pressure",
    "external_pressure_pa": "external pressure on the layer outside",
    "winding_pressure_pa": "pressure asked for by the winding",
    "slipping_area_fraction": "area that slipped",
    "max_slip_m": "largest slip",
    "dofs": "degrees of freedom",
    "interface_points": "contact points",
    "steps": "time steps",
    "step_cuts": "step cuts",
    "newton_iterations_mean": "Newton iterations per step (mean)",
    "modes_hz": "frequency",
    "mode_kinds": "kind",
    "effective_mass_fraction": "effective mass",
    "wall_time_s": "wall time",
    "solver_time_s": "solver time",
    "mass_total_kg": "mass in motion",
    "steady_magnitude": "steady transmissibility",
    "steady_phase_rad": "steady phase",
    "steady_amplitude_m_s2": "steady tip acceleration (0-peak)",
    "steady_residual": "harmonics and transients left, over the fundamental",
    "bending_hz": "first bending frequency",
    "f_stuck_hz": "resonance frequency, everything sticking",
    "f_largest_amplitude_hz": "resonance frequency at the largest amplitude",
    "zeta_max": "largest damping ratio",
    "tip_amplitude_at_zeta_max_m": "tip amplitude there (0-peak)",
    "base_acceleration_at_zeta_max_m_s2": "base acceleration there (0-peak)",
    "memory_change": "change of the elastic slip per cycle, over its largest",
    "input_work_per_cycle_j": "work of the base per cycle",
    "friction_work_per_cycle_j": "energy dissipated by friction per cycle",
    "modulation_work_per_cycle_j": "work of the pressure-dependent stick stiffness per cycle",
    "viscous_work_per_cycle_j": "energy dissipated by viscous damping per cycle",
    "pressure_mandrel_pa": "pressure at the mandrel",
    "capacity_mandrel_pa": "friction capacity at the mandrel",
    "pressure_mandrel_wrap_grid_pa": "pressure at the mandrel, source's grid",
    "capacity_mandrel_wrap_grid_pa": "friction capacity at the mandrel, source's grid",
    "hoop_stress_min_pa": "lowest stress along the web",
    "hoop_bound_pa": "pressure at the mandrel if no wrap relaxed",
    "tension_n": "tension",
    "slip_statement": "coil",
    "slip_onset_g": "base acceleration at which slip starts (0-peak)",
    "amplitude_g": "base acceleration (0-peak)",
    "friction_capacity_n": "friction capacity",
    "friction_capacity_lowest_peak_n": "friction capacity of the lowest peak",
    "friction_capacity_at_zeta_max_n": "friction capacity of the largest damping ratio",
    "zeta_max_over_design": "largest damping ratio over the design space",
    "m2_at_zeta_max_kg": "secondary mass there",
    "k2_at_zeta_max_n_m": "secondary stiffness there",
    "disparity_hz": "frequency disparity of this mandrel",
    "f_tightest_hz": "its bending frequency, tightest coil",
    "f_loosest_hz": "its bending frequency, loosest coil",
    "f_mandrel_hz": "its bending frequency, no coil",
    "loosest_shear_modulus_pa": "shear modulus of the loosest coil",
    "disparity_largest_hz": "largest disparity on the map",
    "disparity_largest_mandrel_radius_m": "mandrel radius there",
    "disparity_largest_mandrel_thickness_m": "mandrel wall there",
    "disparity_smallest_hz": "smallest disparity on the map",
    "disparity_smallest_mandrel_radius_m": "mandrel radius of the smallest",
    "disparity_smallest_mandrel_thickness_m": "mandrel wall of the smallest",
    "pressure_mandrel_error_estimate": "estimated error of the pressure at the mandrel",
    "omega_peak_rad_s": "frequency of the peak",
    "steady_drift": "change of the fundamental within the window",
}


def open_balance(summary: Mapping[str, Any]) -> float | None:
    """Energy balance error when it is larger than it should be: 0.1 % of a history, 1 % of a cycle of few harmonics."""
    gap = summary.get("energy_balance_error")
    limit = 1e-2 if summary.get("input_work_per_cycle_j") not in (None, "") else 1e-3
    return float(gap) if gap not in (None, "") and float(gap) > limit else None


def split_unit(name: str) -> tuple[str, str]:
    """Name without its unit, and the unit ("" for none)."""
    words = name.split("_")
    for n in (2, 1):
        unit = _UNITS.get("_".join(words[-n:])) if len(words) > n else None
        if unit is not None:
            return "_".join(words[:-n]), unit
    return name, ""


def label(name: str) -> str:
    """Name of a quantity in words, first letter large."""
    words = _LABELS.get(name) or split_unit(name)[0].replace("_", " ")
    return words[:1].upper() + words[1:]


def shown(name: str, value: Any) -> str:
    """Value with its unit: four digits, SI prefixes, shares in per cent; "none" where there is no number."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return ", ".join(shown(name, item) for item in value)
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {shown(str(key), item)}" for key, item in value.items())
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f") + _behind(split_unit(name)[1])
    if not isinstance(value, float):
        return str(value)
    if not isfinite(value):
        return "none"
    if any(name.endswith(share) for share in _SHARES):
        return f"{100.0 * value:.4g} %" if abs(value) > 1e-12 else "0 %"
    unit = split_unit(name)[1]
    if not unit or unit in _AS_WRITTEN:
        return f"{value:.6g}{_behind(unit)}" if unit == "Hz" else f"{value:.4g}{_behind(unit)}"
    return quantity(value, unit)


def quantity(value: float, unit: str) -> str:
    """Four significant digits with an SI prefix, "12.34 mJ"; seconds above a second and kilograms from 0.1 stay."""
    if unit == "kg" and abs(value) < 0.1:
        value, unit = 1e3 * value, "g"
    if value == 0.0 or unit == "kg" or (unit == "s" and abs(value) >= 1.0):
        return f"{abs(value) if value == 0.0 else value:.4g} {unit}"
    if abs(value) < 1e-15:  # rounding errors of what should be zero
        return f"{value:.1g} {unit}"
    digits = f"{abs(value):.3e}"
    exponent = max(-12, min(9, int(digits.split("e")[1]) // 3 * 3))
    prefix = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}[exponent]
    return f"{value / 10.0**exponent:.4g} {prefix}{unit}"


def _behind(unit: str) -> str:
    return f" {unit}" if unit else ""
