"""Entries of summary.json: table of names, units, labels, formats and groups.

Each name ends in its unit. Console, report, batch.nc and reference page take units and labels from `SUMMARY`. This
module imports no large library.
"""

from __future__ import annotations

from wroll_fem.results.entries.random import RANDOM
from wroll_fem.results.entries.random_response import RANDOM_RESPONSE
from wroll_fem.results.entries.resonance import DOWNWARD, RESONANCE
from wroll_fem.results.entries.shock import SHOCK
from wroll_fem.results.entries.sizing import SIZING
from wroll_fem.results.entry import Entry, number, share
from wroll_fem.results.lab.tables import LAB_ENTRIES

__all__ = ["EFFORT", "GROUPS", "SUMMARY", "Entry", "label", "netcdf_unit", "split_unit", "unit_of"]


EFFORT = "Size and effort"
"""Group of the entries about computing effort."""

GROUPS: dict[str, dict[str, Entry]] = {
    "Every run": {
        "analysis": Entry("", "analysis", "value of `analysis` in the case"),
        "mass_total_kg": Entry("kg", "mass in motion"),
        "warnings": Entry("", "warnings", "before, during and at the end of the run, each with its remedy"),
    },
    "Resonance of a curve (sweep, random, harmonic)": RESONANCE,
    "Downward branch (sweep with sweep_direction: up_down)": DOWNWARD,
    "Steady response of a dwell": {
        "steady_magnitude": number("", "steady transmissibility", "during the last whole cycles"),
        "steady_phase_rad": number("rad", "steady phase", "of the absolute tip acceleration to the base acceleration"),
        "steady_amplitude_m_s2": number("m/s²", "steady tip acceleration (0-peak)"),
        "steady_residual": share("residual harmonics and transients, relative to the fundamental"),
        "steady_drift": share("change of the fundamental within the window"),
        "steady_doubt": Entry(
            "", "doubt about the steady response", "reason, where drift or residual exceed 2 %; else empty"
        ),
    },
    "Random motion": RANDOM,
    "Random response of a backbone (random_response)": RANDOM_RESPONSE,
    "Shock": SHOCK,
    "Energy over the whole motion (sweep, dwell, random, shock)": {
        "energy_balance_error": share(
            "energy balance error",
            "largest residual of the energy balance divided by the largest input; of a period for harmonic and "
            "backbone (input = interface + viscous work) and for two_dof",
            "{:.2%}",
        ),
        "input_work_j": Entry("J", "work put in by the base motion"),
        "friction_energy_j": Entry("J", "energy dissipated by friction", console="{:.4g} J"),
        "material_damping_j": Entry("J", "energy dissipated by material damping", console="{:.4g} J"),
        "numerical_dissipation_j": Entry("J", "energy dissipated by the integration scheme"),
        "pressure_modulation_work_j": Entry("J", "work exchanged with the pressure-dependent stick stiffness"),
        "impact_dissipation_j": Entry("J", "energy dissipated in closing and opening contact"),
    },
    "Energy of a period (harmonic, backbone)": {
        "input_work_per_cycle_j": Entry(
            "J", "work of the base per cycle", "where the response, or the damping of a backbone, is largest"
        ),
        "friction_work_per_cycle_j": Entry("J", "energy dissipated by friction per cycle"),
        "modulation_work_per_cycle_j": Entry("J", "work of the pressure-dependent stick stiffness per cycle"),
        "work_quadrature_error": share(
            "quadrature error of the friction work",
            "input minus friction, modulation and viscous work, divided by the largest input; decreases with more "
            "`harmonic.samples`",
        ),
        "material_damping_work_per_cycle_j": Entry("J", "energy dissipated by material damping per cycle"),
        "memory_change": number("", "change of the elastic slip per cycle, relative to its largest value"),
    },
    "Buckling (buckling, modal with geometric stiffness)": {
        "buckling_load_factor": number(
            "", "buckling load divided by preload", "lowest factor of the preload at which the roll buckles", "{:.4g}"
        ),
        "buckling_pressure_pa": Entry("Pa", "total external pressure at buckling", console="{:.4g} Pa"),
        "buckling_wave_number": number("", "circumferential waves of the buckling mode", console="{:d}"),
    },
    "Stress (sweep, dwell, harmonic)": {
        "von_mises_max_pa": Entry(
            "Pa", "largest von Mises stress",
            "of mandrel and layers, inner first, from preload and vibration: at the largest tip displacement (sweep, "
            "dwell), or during the period of the highest motion (harmonic); `null` for orthotropic plies", "si",
            "{:.3g} Pa",
        ),
        "ply_stress_1_max_pa": Entry(
            "Pa", "largest ply stress along the fibres", "of each shell with plies, inner first, with its sign; `null` "
            "for isotropic shells", "si", "{:.3g} Pa",
        ),
        "ply_stress_2_max_pa": Entry(
            "Pa", "largest ply stress across the fibres", "as `ply_stress_1_max_pa`", "si", "{:.3g} Pa"
        ),
        "ply_stress_12_max_pa": Entry("Pa", "largest ply shear stress", "as `ply_stress_1_max_pa`", "si", "{:.3g} Pa"),
        "yield_margin": Entry(
            "", "margin against yield", "`yield_stress` divided by the largest von Mises stress, minus 1; negative: "
            "yields; `null` without a yield stress", "number", "{:.2f}",
        ),
    },
    "Loads at the base (sweep, dwell, harmonic)": {
        "base_shear_max_n": Entry(
            "N", "largest base shear",
            "force of the roll on its base along the excitation; amplitude of the fundamental with harmonic", "si",
            "{:.4g} N",
        ),
        "base_moment_max_nm": Entry(
            "N m", "largest base moment",
            "about the axis through the centre of the base, normal to roll axis and excitation; not for solid coils or "
            "matrices", "si", "{:.4g} N m",
        ),
    },
    "Interfaces": {
        "interface_pressure_mean_pa": Entry(
            "Pa", "mean interface pressure", "after the preload, area mean", console="{:.4g} Pa"
        ),
        "external_pressure_pa": Entry("Pa", "external pressure on the layer outside"),
        "winding_pressure_pa": Entry(
            "Pa", "interface pressure of the wound roll", "with `preload.kind: winding_tension`"
        ),
        "max_relative_displacement_m": Entry(
            "m", "largest relative displacement",
            "tangential, since the preload, including the elastic part; maximum over times and points",
        ),
        "max_slip_m": Entry(
            "m", "largest relative displacement (second name)",
            "the same as `max_relative_displacement_m`: it includes the elastic part, so it is above zero in sticking",
        ),
        "max_accumulated_slip_m": Entry(
            "m", "largest accumulated slip",
            "length of the plastic slip path during the motion; during one period for harmonic and backbone",
        ),
        "wrap_interfaces": number(
            "", "wrap interfaces of an interface",
            "per interface, inner first, with `coil.per_wrap`: every slip and relative displacement of the run is the "
            "sum over them", "{:.4g}",
        ),
        "max_relative_displacement_per_wrap_m": Entry(
            "m", "largest relative displacement of two wraps",
            "with `coil.per_wrap`: `max_relative_displacement_m` of each interface divided by its `wrap_interfaces`",
        ),
        "max_accumulated_slip_per_wrap_m": Entry(
            "m", "largest accumulated slip of two wraps", "with `coil.per_wrap`, likewise"
        ),
        "slipping_area_fraction": share("area that slipped", "share of the area that slipped at any time"),
        "open_area_fraction": share("area that opened", "share of the area that was open at any time of the motion"),
        "open_time_fraction": share(
            "open longest", "largest share of the time, or of the cycle, that a contact point was open"
        ),
        "min_pressure_over_preload": share(
            "lowest pressure", "smallest ratio of the pressure in the motion to the preload at the same point"
        ),
    },
    "Modes": {
        "bending_hz": number("Hz", "first bending frequency"),
        "modes_hz": number("Hz", "frequency", "natural frequencies, rising"),
        "mode_damping_ratios": share("damping ratio", "of each mode, due to material damping"),
        "mode_kinds": Entry("", "kind", "bending, torsion, axial, ovalling-n, ..."),
        "effective_mass_fraction": share("effective mass", "along the excitation, divided by the total mass"),
    },
    "Backbone": {
        "f_stuck_hz": number("Hz", "resonance frequency with sticking contact"),
        "f_largest_amplitude_hz": number("Hz", "resonance frequency at the largest amplitude"),
        "zeta_max": share("largest damping ratio"),
        "tip_amplitude_at_zeta_max_m": Entry("m", "tip amplitude there (0-peak)"),
        "base_acceleration_at_zeta_max_m_s2": number("m/s²", "base acceleration there (0-peak)"),
    },
    "Wound roll": {
        "pressure_mandrel_pa": Entry("Pa", "pressure at the mandrel", "under the first wrap", console="{:.4g} Pa"),
        "pressure_mandrel_wrap_grid_pa": Entry(
            "Pa", "pressure at the mandrel, wrap grid of the thesis", console="{:.4g} Pa"
        ),
        "capacity_mandrel_pa": Entry("Pa", "friction capacity at the mandrel", "mu x pressure", console="{:.4g} Pa"),
        "capacity_mandrel_wrap_grid_pa": Entry("Pa", "friction capacity at the mandrel, wrap grid of the thesis"),
        "mandrel_stiffness_pa": Entry(
            "Pa", "mandrel stiffness", "pressure divided by hoop strain at its surface", console="{:.4g} Pa"
        ),
        "pressure_mandrel_error_estimate": share(
            "estimated error of the pressure at the mandrel", "change by extrapolation, divided by the pressure"
        ),
        "hoop_bound_pa": Entry("Pa", "pressure at the mandrel if no wrap relaxed"),
        "hoop_stress_min_pa": Entry("Pa", "lowest stress along the web"),
        "web_modulus_pa": Entry("Pa", "Young's modulus along the web"),
        "tension_stress_pa": Entry("Pa", "tension stress"),
        "tension_n": Entry("N", "tension"),
        "outer_radius_m": Entry("m", "outer radius"),
    },
    "Slip of a solid coil (modal_transient)": {
        "driven_mode": number("", "driven mode", "number of the mode excited at its natural frequency"),
        "excitation_frequency_hz": number("Hz", "excitation frequency"),
        "participating_mass_fraction": share(
            "participating mass", "share of the mass along the excitation that the modes carry"
        ),
        "transmissibility": number("", "transmissibility", "steady, exact", "{:.2f}"),
        "transmissibility_last_cycle": number("", "transmissibility of the last simulated cycle"),
        "steady_cycles": number("", "cycles until steady", "until the motion repeats"),
        "amplitude_g": number("g", "base acceleration (0-peak)", "levels, divided by 9.80665 m/s²"),
        "shear_resultant_max_pa": Entry("Pa", "largest shear resultant", "per level"),
        "slipping_volume_fraction": share("volume that slips", "per level"),
        "slip_zone_height_m": Entry("m", "slip zone height", "per level, above the base"),
        "slip_zone_depth_m": Entry("m", "slip zone depth", "per level, from the mandrel"),
        "slip_onset_g": number(
            "g", "base acceleration at which slip starts (0-peak)",
            "at the first point; missing if no level causes slip (modal_transient); falls with the size of the "
            "elements where the stress is singular",
        ),
        "slip_onset_radius_m": Entry("m", "slip onset radius"),
        "slip_onset_height_m": Entry("m", "slip onset height"),
        "slip_onset_theta_rad": number("rad", "slip onset angle"),
        "slip_statement": Entry("", "coil", "sentence on onset and extent of slip", console="{}"),
    },
    "Coil whose wraps slide (slip_damping)": {
        "tip_displacement_m": Entry("m", "tip displacement at resonance (0-peak)", "per level"),
        "tip_displacement_without_slip_m": Entry("m", "tip displacement without slip (0-peak)", "per level"),
        "f_resonance_hz": number("Hz", "resonance frequency", "per level"),
        "zeta_total": share("damping ratio", "per level, that without slip included"),
        "slip_work_per_cycle_j": Entry("J", "energy dissipated by slip per cycle", "per level"),
        "slip_work_rt_per_cycle_j": Entry("J", "part of it by slip around the roll", "per level"),
        "slip_work_rz_per_cycle_j": Entry("J", "part of it by slip along the axis", "per level"),
        "followed_mode": Entry("", "followed mode", "bending, torsion or axial"),
        "cycle_closure": share("gap of the cycles", "difference of the ends over the amplitude, pressure: varying"),
        "interlayer_shear_modulus_min_pa": Entry("Pa", "smallest shear modulus between the wraps"),
        "interlayer_shear_modulus_max_pa": Entry("Pa", "largest shear modulus between the wraps"),
        "slip_onset_averaged_g": number(
            "g", "base acceleration at which slip starts, averaged over a length (0-peak)",
            "mean stress over `slip_onset_length_m` in height and depth reaches the mean friction limit; does not "
            "depend on the mesh",
        ),
        "slip_onset_length_m": Entry("m", "length over which the onset is averaged", "wall thickness of the mandrel"),
        "slip_onset_statement": Entry("", "onset of slip", "sentence on both onsets", console="{}"),
        "slip_damping_statement": Entry("", "coil", "sentence on what slip changes", console="{}"),
    },
    "Map of mandrels": {
        "disparity_hz": number("Hz", "frequency disparity of this mandrel", "stiffest minus softest coil"),
        "f_tightest_hz": number("Hz", "bending frequency of this mandrel, stiffest coil"),
        "f_loosest_hz": number("Hz", "bending frequency of this mandrel, softest coil"),
        "f_mandrel_hz": number("Hz", "bending frequency of this mandrel, no coil"),
        "loosest_shear_modulus_pa": Entry("Pa", "shear modulus of the softest coil"),
        "designs": number("", "designs", "number of mandrels on the map"),
        "designs_without_disparity": number(
            "", "designs without disparity", "mandrels whose fundamental mode is not bending"
        ),
        "disparity_largest_hz": number("Hz", "largest disparity on the map"),
        "disparity_largest_mandrel_radius_m": Entry("m", "mandrel radius there"),
        "disparity_largest_mandrel_thickness_m": Entry("m", "mandrel wall there"),
        "disparity_smallest_hz": number("Hz", "smallest disparity on the map"),
        "disparity_smallest_mandrel_radius_m": Entry("m", "mandrel radius of the smallest"),
        "disparity_smallest_mandrel_thickness_m": Entry("m", "mandrel wall of the smallest"),
    },
    "Sizing of a mandrel": SIZING,
    "Two masses": {
        "friction_capacity_n": Entry("N", "friction capacity", "one curve each"),
        "omega_peak_rad_s": number("rad/s", "frequency of the peak", "per capacity"),
        "friction_capacity_lowest_peak_n": Entry("N", "friction capacity of the lowest peak"),
        "friction_capacity_at_zeta_max_n": Entry("N", "friction capacity of the largest damping ratio"),
        "zeta_max_over_design": share("largest damping ratio in the design space"),
        "m2_at_zeta_max_kg": Entry("kg", "secondary mass there"),
        "k2_at_zeta_max_n_m": number("N/m", "secondary stiffness there"),
    },
    EFFORT: {
        "method": Entry("", "method", "method of time integration or of the periodic solution"),
        "dofs": number("", "degrees of freedom", "of the solved structure (half a roll under symmetry)", "{:d}"),
        "interface_points": number("", "contact points"),
        "reduced_coordinates": number("", "reduced coordinates", "basis vectors of the reduced model at the end"),
        "reduction_error_estimate": share(
            "estimated error of the reduction", "relative root mean square of the projection error"
        ),
        "reduction_tip_error_estimate": share(
            "estimated error of the reduction at the tip", "projection error at the tip (harmonic, backbone)"
        ),
        "span_error_estimate": share(
            "part of the motion outside the modes",
            "of a coil whose wraps slide (those of a quasi-static path), relative energy norm",
        ),
        "sampled_points": number("", "contact points of the subset", "on which the motion was followed", "{:d}"),
        "sampling_force_error": share("error of the contact forces of the subset", "before the other points are added"),
        "sampling_work_error": share(
            "error of the work of the subset", "per cycle, before the other points are added; of a history: in all"
        ),
        "sampling_motion_error": share(
            "error of the motion of the subset", "energy norm, likewise; of a history: static, to what the force lacks"
        ),
        "training_time_s": Entry("s", "training time", "CPU time spent on building the basis"),
        "steps": number("", "time steps", console="{:d}"),
        "steps_per_cycle": number("", "steps per cycle of the highest excitation frequency"),
        "excited_to_hz": number(
            "Hz", "highest frequency with energy of the base motion",
            "99.99 % of the mean square of a random motion and 99 % of the energy of a shock lie below it",
        ),
        "period_error_at_highest": share("lengthening of the period at this frequency by the time step"),
        "time_step_error": share(
            "estimated error by the time step",
            "of a dwell: largest error of the tip's history divided by its largest displacement; of a sweep: error of "
            "|T| divided by its peak; `null` if no oscillator describes the history",
            "{:.2%}",
        ),
        "sweep_attainment": share(
            "part of the steady peak that the sweep reaches",
            "for a linear resonance with the damping read from the sweep; `null` without a resonance",
            "{:.1%}",
        ),
        "step_cuts": number("", "step cuts", "halvings of steps that did not converge at once"),
        "newton_iterations_mean": number("", "Newton iterations per step (mean)"),
        "branch_points": number("", "branch points", "points of the curve"),
        "folds": number("", "folds", "turning points of the curve"),
        "solver_time_s": Entry("s", "solver time", "CPU time of the time loop or of the continuation"),
        "wall_time_s": Entry("s", "wall time", console="{:.1f} s"),
    },
    **LAB_ENTRIES,
}  # fmt: skip
"""Heading -> name -> entry, in the order of summary.json."""

SUMMARY: dict[str, Entry] = {name: entry for entries in GROUPS.values() for name, entry in entries.items()}
"""Name in summary.json -> its entry."""

_SUFFIXES = {
    "m_s2": "m/s²", "m_s": "m/s", "n_per_m": "N/m", "m_per_n": "m/N", "n_m": "N/m", "rad_s": "rad/s",
    "hz": "Hz", "j": "J", "pa": "Pa", "m": "m", "s": "s", "kg": "kg",
    "n": "N", "nm": "N m", "rad": "rad", "g": "g", "w": "W", "v": "V", "ampere": "A", "db": "dB", "px": "px",
}  # fmt: skip
"""Suffix of a name -> unit. The suffix `_g` marks an acceleration divided by 9.80665 m/s²."""

_NETCDF = {"": "1", "m/s²": "m s-2", "rad/s": "rad s-1", "N/m": "N m-1", "m/N": "m N-1", "m/s": "m s-1"}
"""Unit -> its spelling in NetCDF, where this differs."""


def split_unit(name: str) -> tuple[str, str]:
    """Name without its unit suffix, and the unit ("" if dimensionless)."""
    words = name.split("_")
    for n in (3, 2, 1):
        unit = _SUFFIXES.get("_".join(words[-n:])) if len(words) > n else None
        if unit is not None:
            return "_".join(words[:-n]), unit
    return name, ""


def unit_of(name: str) -> str:
    """Unit of an entry, from the table or from the suffix of its name ("" if dimensionless)."""
    return SUMMARY[name].unit if name in SUMMARY else split_unit(name)[1]


def netcdf_unit(name: str) -> str:
    """Unit of an entry in NetCDF spelling ("1" if dimensionless)."""
    unit = unit_of(name)
    return _NETCDF.get(unit, unit)


def label(name: str) -> str:
    """Label of an entry, capitalised."""
    words = SUMMARY[name].label if name in SUMMARY else split_unit(name)[0].replace("_", " ")
    return words[:1].upper() + words[1:]
