"""Names, units and labels of all variables and coordinates of results.

Every variable and coordinate that the program stores has an entry in `FIELDS`; their units and labels are written
nowhere else.
"""

from __future__ import annotations

from wroll_fem.errors import InputError
from wroll_fem.results.entry import Field
from wroll_fem.results.lab.tables import LAB_FIELDS

__all__ = ["AXES", "FIELDS", "Field", "field", "label"]

_ACCELERATION, _ENERGY = "m s-2", "J"

FIELDS: dict[str, Field] = {
    # coordinates
    "time": Field("s", "time"),
    "frequency": Field("Hz", "frequency"),
    "mode": Field("1", "mode number"),
    "component": Field("1", "direction (x, y, z)"),
    "interface": Field("1", "interface, inner first"),
    "interface_name": Field("1", "bodies on both sides of an interface"),
    "step": Field("1", "step"),
    "theta_rad": Field("rad", "angle from the x axis"),
    "z_m": Field("m", "height above the base"),
    "radius": Field("m", "radius of the interface"),
    "area": Field("m2", "area of a contact point"),
    # histories
    "base_acceleration": Field(_ACCELERATION, "base acceleration"),
    "instantaneous_frequency": Field("Hz", "instantaneous frequency of the base motion"),
    "tip_displacement": Field("m", "tip displacement relative to the base"),
    "tip_velocity": Field("m s-1", "tip velocity relative to the base"),
    "tip_acceleration": Field(_ACCELERATION, "tip acceleration relative to the base"),
    "probe": Field("1", "probe: the tip, then the named points of the case"),
    "probe_displacement": Field("m", "displacement at the probe relative to the base"),
    "probe_velocity": Field("m s-1", "velocity at the probe relative to the base"),
    "probe_acceleration": Field(_ACCELERATION, "acceleration at the probe relative to the base"),
    "tip_acceleration_absolute": Field(_ACCELERATION, "absolute tip acceleration"),
    "newton_iterations": Field("1", "Newton iterations of the step"),
    "open_fraction": Field("1", "fraction of the contact points that are open"),
    "slipping_fraction": Field("1", "fraction of the contact points that slip"),
    # energy ledger, cumulative from the start of the motion
    "input_work": Field(_ENERGY, "work put in by the base motion"),
    "kinetic_energy": Field(_ENERGY, "kinetic energy relative to the base"),
    "strain_energy": Field(_ENERGY, "strain energy of the bodies"),
    "contact_energy": Field(_ENERGY, "energy stored in the contact springs"),
    "friction_energy": Field(_ENERGY, "energy dissipated by friction"),
    "pressure_modulation_work": Field(_ENERGY, "work exchanged with the pressure-dependent stick stiffness"),
    "interface_work": Field(_ENERGY, "work done on the interfaces"),
    "material_damping": Field(_ENERGY, "energy dissipated by material damping (dashpots)"),
    "impact_dissipation": Field(_ENERGY, "energy dissipated in closing and opening contact"),
    "numerical_dissipation": Field(_ENERGY, "energy dissipated by the time integration scheme"),
    # interfaces
    "cumulative_slip": Field("m", "accumulated slip"),
    "max_slip": Field("m", "largest relative tangential displacement"),
    "slipped": Field("1", "slipped at any time"),
    "peak_slip_hoop": Field("m", "hoop relative displacement at its largest"),
    "peak_slip_axial": Field("m", "axial relative displacement at its largest"),
    "friction_work_density": Field("J m-2", "friction work per area"),
    "open_time_fraction": Field("1", "fraction of the time, or of the cycle, during which the point is open"),
    "least_pressure": Field("Pa", "lowest contact pressure of the motion"),
    "pressure": Field("Pa", "contact pressure at the start of the motion"),
    "traction_hoop": Field("Pa", "hoop friction traction at the start of the motion"),
    "traction_axial": Field("Pa", "axial friction traction at the start of the motion"),
    "slipping_area_fraction": Field("1", "fraction of the interface's area that slipped at any time"),
    "snapshot_time": Field("s", "time of a stored field"),
    "relative_displacement_hoop": Field("m", "hoop relative displacement since the preload"),
    "relative_displacement_axial": Field("m", "axial relative displacement since the preload"),
    # frequency domain; "transmissibility" alone is the demodulated envelope
    "transmissibility_real": Field("1", "transmissibility, real part (demodulated envelope)"),
    "transmissibility_imag": Field("1", "transmissibility, imaginary part (demodulated envelope)"),
    "transmissibility_magnitude": Field("1", "transmissibility |T| (demodulated envelope)"),
    "transmissibility_spectrum_real": Field("1", "transmissibility, real part (spectrum ratio)"),
    "transmissibility_spectrum_imag": Field("1", "transmissibility, imaginary part (spectrum ratio)"),
    "transmissibility_spectrum_magnitude": Field("1", "transmissibility |T| (spectrum ratio)"),
    "down_transmissibility_real": Field("1", "transmissibility of the downward sweep, real part"),
    "down_transmissibility_imag": Field("1", "transmissibility of the downward sweep, imaginary part"),
    "down_transmissibility_magnitude": Field("1", "transmissibility |T| of the downward sweep"),
    "down_transmissibility_spectrum_real": Field("1", "transmissibility of the downward sweep, real (spectrum ratio)"),
    "down_transmissibility_spectrum_imag": Field("1", "transmissibility of the downward sweep, imag. (spectrum ratio)"),
    # averaged spectra of a random motion; its "transmissibility" is H1
    "base_psd": Field("m2 s-3", "PSD of the base acceleration"),
    "tip_psd": Field("m2 s-3", "PSD of the absolute tip acceleration"),
    "coherence": Field("1", "coherence of base and tip acceleration"),
    "h1_error": Field("1", "relative standard deviation of |H1|"),
    "hv_real": Field("1", "transmissibility Hv, real part"),
    "hv_imag": Field("1", "transmissibility Hv, imaginary part"),
    # shocks
    "natural_frequency": Field("Hz", "natural frequency of the system with one degree of freedom"),
    "srs_base": Field(_ACCELERATION, "shock response spectrum of the base (absolute acceleration, maximax)"),
    "srs_tip": Field(_ACCELERATION, "shock response spectrum of the tip (absolute acceleration, maximax)"),
    "interval": Field("1", "during the record (primary), after it (residual), or the larger of both (maximax)"),
    "srs_base_absolute_acceleration": Field(
        _ACCELERATION, "shock response spectrum of the base, absolute acceleration"
    ),
    "srs_base_relative_displacement": Field("m", "shock response spectrum of the base, relative displacement"),
    "srs_base_pseudo_velocity": Field("m s-1", "shock response spectrum of the base, pseudo velocity"),
    "srs_tip_absolute_acceleration": Field(_ACCELERATION, "shock response spectrum of the tip, absolute acceleration"),
    "srs_tip_relative_displacement": Field("m", "shock response spectrum of the tip, relative displacement"),
    "srs_tip_pseudo_velocity": Field("m s-1", "shock response spectrum of the tip, pseudo velocity"),
    "decay_amplitude": Field("m", "amplitude of the tip displacement in the decay (0-peak)"),
    "decay_frequency": Field("Hz", "frequency of the decay at this amplitude"),
    "decay_damping": Field("1", "damping ratio of the decay at this amplitude"),
    "decay_time": Field("s", "time at which the decay has this amplitude"),
    # periodic motions
    "branch_point": Field("1", "point along the branch"),
    "base_shear": Field("N", "force of the roll on its base along the excitation"),
    "base_moment": Field("N m", "moment of the roll on its base, about the axis normal to roll axis and excitation"),
    "base_shear_amplitude": Field("N", "amplitude of the base shear (fundamental, 0-peak)"),
    "base_moment_amplitude": Field("N m", "amplitude of the base moment (fundamental, 0-peak)"),
    "probe_amplitude": Field("m", "amplitude of the displacement at the probe (fundamental, 0-peak)"),
    "probe_transmissibility_real": Field(
        "1", "absolute acceleration at the probe divided by base acceleration, real part"
    ),
    "probe_transmissibility_imag": Field(
        "1", "absolute acceleration at the probe divided by base acceleration, imaginary part"
    ),
    "tip_amplitude": Field("m", "amplitude of the tip's displacement (fundamental, 0-peak)"),
    "resonance_frequency": Field("Hz", "resonance frequency"),
    "modal_damping": Field("1", "modal damping ratio"),
    "material_modal_damping": Field("1", "modal damping ratio due to material damping"),
    "friction_modal_damping": Field("1", "modal damping ratio due to friction"),
    "resonant_base_acceleration": Field(_ACCELERATION, "base acceleration at resonance (0-peak)"),
    "stable": Field("1", "outside the folds of the branch"),
    "input_work_per_cycle": Field(_ENERGY, "work of the base per cycle"),
    "friction_work_per_cycle": Field(_ENERGY, "energy dissipated by friction per cycle"),
    "modulation_work_per_cycle": Field(_ENERGY, "work exchanged with the pressure-dependent stick stiffness per cycle"),
    "material_damping_work_per_cycle": Field(_ENERGY, "energy dissipated by material damping (dashpots) per cycle"),
    "interface_work_per_cycle": Field(_ENERGY, "work done on the interfaces per cycle"),
    "slip_amplitude": Field("m", "largest relative tangential displacement in the cycle"),
    "phase": Field("degree", "phase of the excitation"),
    "loop_displacement": Field("m", "relative displacement of a joint at the peak"),
    "loop_force": Field("N", "force of a joint at the peak"),
    "memory_change": Field("1", "change of the elastic slip per cycle, relative to its largest value"),
    "kinetic_energy_amplitude": Field(_ENERGY, "amplitude of the kinetic energy, sum of all harmonics"),
    "mass_displacement_amplitude": Field("kg m", "mass times displacement along the base motion (fundamental, 0-peak)"),
    # random response of a nonlinear mode
    "tip_displacement_psd": Field("m2 s", "PSD of the tip displacement"),
    "amplitude_density": Field("m-1", "probability density of the tip amplitude"),
    "level_db": Field("dB", "level of the PSD relative to the case"),
    "base_rms_at_level": Field("m s-2", "rms of the base acceleration"),
    "tip_displacement_rms_at_level": Field("m", "rms of the tip displacement"),
    "tip_rms_at_level": Field("m s-2", "rms of the absolute tip acceleration"),
    "level": Field("1", "factor of the record"),
    "seed": Field("1", "seed of the record"),
    "base_shear_rms_at_level": Field("N", "rms of the base shear"),
    "base_moment_rms_at_level": Field("N m", "rms of the base moment"),
    "tip_rms_error_at_level": Field("1", "standard error of the rms of the tip acceleration, relative"),
    "tip_kurtosis_at_level": Field("1", "kurtosis of the tip acceleration"),
    "frequency_error_at_level": Field("Hz", "standard error of the resonance frequency"),
    "damping_error_at_level": Field("1", "standard error of the damping ratio at this level"),
    "frequency_scatter_at_level": Field("Hz", "scatter of the resonance frequency between records, of their mean"),
    "damping_scatter_at_level": Field("1", "scatter of the damping ratio between records, of their mean"),
    "damping_quality_at_level": Field("1", "quality of the damping ratio"),
    "input_work_at_level": Field(_ENERGY, "work put in by the base motion in a record"),
    "friction_energy_at_level": Field(_ENERGY, "energy dissipated by friction in a record"),
    "base_rms_of_record": Field("m s-2", "rms of the base acceleration of a record"),
    "tip_rms_of_record": Field("m s-2", "rms of the absolute tip acceleration of a record"),
    "tip_displacement_rms_of_record": Field("m", "rms of the tip displacement of a record"),
    "base_shear_rms_of_record": Field("N", "rms of the base shear of a record"),
    "base_moment_rms_of_record": Field("N m", "rms of the base moment of a record"),
    "frequency_of_record": Field("Hz", "resonance frequency of a record"),
    "damping_of_record": Field("1", "damping ratio of a record"),
    "f_effective_at_level": Field("Hz", "mean frequency"),
    "zeta_effective_at_level": Field("1", "damping ratio from power and energy"),
    "dissipated_power_at_level": Field("W", "dissipated power"),
    "backbone_exceeded_at_level": Field("1", "part of the mean square beyond the backbone"),
    "other_frequency": Field("Hz", "natural frequency of another mode"),
    "other_damping": Field("1", "damping ratio of another mode"),
    "other_participation": Field("1", "participation of another mode at the tip"),
    "vibration_von_mises": Field("Pa", "largest von Mises stress of the vibration alone (0-peak)"),
    # margins
    "shell": Field("1", "shell of the roll, innermost first"),
    "von_mises_max": Field("Pa", "largest von Mises stress of the shell"),
    "von_mises_height": Field("m", "height of the largest von Mises stress above the base"),
    "yield_stress": Field("Pa", "yield stress of the shell"),
    "ply": Field("1", "ply of the shell, innermost first"),
    "ply_component": Field("1", "component of the stress of a ply: along its fibres (1), across them (2), shear (12)"),
    "ply_stress_max": Field("Pa", "stress of largest magnitude in the ply, with its sign"),
    # modes
    "mode_frequency": Field("Hz", "natural frequency"),
    "load_factor": Field("1", "buckling load divided by preload"),
    "critical_pressure": Field("Pa", "total external pressure at buckling"),
    "mode_kind": Field("1", "kind of the mode"),
    "mode_harmonic": Field("1", "circumferential wave number of the mode"),
    "mode_damping_ratio": Field("1", "damping ratio of the mode due to material damping"),
    "mode_residual": Field("1", "relative residual of the eigenpair"),
    "effective_mass_fraction": Field("1", "effective mass divided by total mass"),
    "mode_at_probe": Field("kg-1/2", "displacement at the probe in the mode of unit modal mass"),
    "tip_participation": Field("1", "participation of the mode in the tip motion under base motion"),
    "mode_shape": Field("1", "mode shape, largest displacement 1"),
    "node_position": Field("m", "node coordinates"),
    "cell_nodes": Field("1", "nodes of each quadratic quad"),
    "solid_cell_nodes": Field("1", "nodes of each quadratic hexahedron of the coil"),
    # solid coil under a steady sine
    "amplitude_g": Field("1", "base acceleration divided by 9.80665 m/s² (0-peak)"),
    "cycle": Field("1", "cycle of the base motion"),
    "change_per_cycle": Field("1", "change of the tip's motion per cycle, relative to its steady amplitude"),
    "r_m": Field("m", "distance from the axis"),
    "volume": Field("m3", "volume of a quadrature point"),
    "shear_rz": Field("Pa", "axial shear stress at 1 g (amplitude)"),
    "shear_rt": Field("Pa", "hoop shear stress at 1 g (amplitude)"),
    "shear_resultant": Field("Pa", "shear resultant at 1 g (largest in the steady cycle)"),
    "shear_resultant_history": Field("Pa", "shear resultant where slip starts"),
    "friction_capacity": Field("Pa", "friction capacity"),
    "capacity_radius": Field("m", "radius of the capacity profile"),
    "capacity_profile": Field("Pa", "friction capacity versus radius"),
    "slip_onset": Field("1", "base acceleration in g above which a point slips"),
    "slipping_volume_fraction": Field("1", "fraction of the coil's volume that slips"),
    "slip_zone_height": Field("m", "height above the base of the highest slipping point"),
    "slip_zone_depth": Field("m", "distance from the mandrel of the outermost slipping point"),
    # solid coil whose wraps slide
    "tip_at_level": Field("m", "tip displacement at resonance (0-peak)"),
    "tip_at_level_without_slip": Field("m", "tip displacement at resonance without slip (0-peak)"),
    "frequency_at_level": Field("Hz", "resonance frequency at this base acceleration"),
    "damping_at_level": Field("1", "damping ratio at this base acceleration, that without slip included"),
    "friction_damping_at_level": Field("1", "damping ratio due to friction at this base acceleration"),
    "slipping_volume_fraction_at_level": Field("1", "fraction of the coil's volume that slips at this level"),
    "friction_work_at_level": Field(_ENERGY, "energy dissipated by friction per cycle at this level"),
    "friction_work_rt_at_level": Field(_ENERGY, "part of it by slip around the roll"),
    "friction_work_rz_at_level": Field(_ENERGY, "part of it by slip along the axis"),
    "pressure_change_max": Field("1", "largest ratio of radial stress to pressure at the sliding points"),
    "pressure_change_volume_fraction": Field("1", "fraction of the sliding volume with a ratio above one half"),
    "tip_amplitude_at_slip": Field("m", "tip displacement at which a point starts to slip"),
    "slip_work_density": Field("J m-3", "energy dissipated per cycle and volume at the largest amplitude"),
    "slip_work_density_rt": Field("J m-3", "energy dissipated by slip around the roll, per cycle and volume"),
    "slip_work_density_rz": Field("J m-3", "energy dissipated by slip along the axis, per cycle and volume"),
    "friction_work_rt_per_cycle": Field(_ENERGY, "energy dissipated by slip around the roll per cycle"),
    "friction_work_rz_per_cycle": Field(_ENERGY, "energy dissipated by slip along the axis per cycle"),
    "interlayer_shear_modulus": Field("Pa", "shear modulus between the wraps"),
    "interlayer_radial_modulus": Field("Pa", "radial modulus of the stack of wraps"),
    # the wound roll
    "r": Field("m", "radius"),
    "pressure_pa": Field("Pa", "pressure between the wraps"),
    "capacity_pa": Field("Pa", "friction capacity between the wraps"),
    "hoop_stress_pa": Field("Pa", "stress along the web"),
    "radial_modulus_pa": Field("Pa", "radial modulus of the stack"),
    "winding_tension_pa": Field("Pa", "tension stress of the web in winding"),
    "wrap": Field("1", "wrap, inner first (wrap grid of the thesis)"),
    "wrap_radius": Field("m", "radius under the wrap"),
    "wrap_pressure_pa": Field("Pa", "pressure under the wrap, wrap grid of the thesis"),
    "wrap_capacity_pa": Field("Pa", "friction capacity under the wrap, wrap grid of the thesis"),
    "wrap_hoop_stress_pa": Field("Pa", "mean stress along the wrap, wrap grid of the thesis"),
    # map of mandrels
    "mandrel_radius": Field("m", "outer radius of the mandrel"),
    "mandrel_thickness": Field("m", "wall of the mandrel"),
    "frequency_tightest": Field("Hz", "bending frequency with the stiffest coil"),
    "frequency_loosest": Field("Hz", "bending frequency with the softest coil"),
    "frequency_mandrel": Field("Hz", "bending frequency of the mandrel alone"),
    "frequency_disparity": Field("Hz", "bending frequency, stiffest minus softest coil"),
    "loosest_shear_modulus": Field("Pa", "shear modulus between the wraps of the softest coil"),
    "limit_kind": Field("1", "mode that is lower than bending in a softer coil"),
    # sizing of a mandrel
    "reading": Field("1", "reading of the largest stress"),
    "margin": Field("1", "margin against yield"),
    "wall_thickness": Field("m", "wall of the mandrel of each reading"),
    "peak_stress": Field("Pa", "largest von Mises stress with this wall"),
    "peak_z": Field("m", "height of the largest stress above the base"),
    "peak_theta": Field("rad", "angle of the largest stress from the direction of the inertial load"),
    "peak_surface": Field("1", "surface of the largest stress"),
    # two masses
    "omega": Field("rad s-1", "angular frequency of the base"),
    "transmissibility": Field("1", "largest displacement of the primary mass divided by that of the base"),
    "zeta": Field("1", "damping ratio"),
    "zeta_error": Field("1", "standard error of the damping ratio"),
    "zeta_lower_bound": Field("1", "lower end of the error bar of the damping ratio"),
    "zeta_method": Field("1", "estimator of the damping ratio"),
    "omega_peak": Field("rad s-1", "angular frequency of the peak"),
    "peak_transmissibility": Field("1", "transmissibility of the peak"),
    "omega_low": Field("rad s-1", "lower half-power frequency"),
    "omega_high": Field("rad s-1", "upper half-power frequency"),
    "skewness": Field("1", "upper half of the half-power width divided by the lower half, minus 1"),
    "omega_stuck": Field("rad s-1", "resonance frequency with sticking masses"),
    "reading_note": Field("1", "remark on the half-power estimate"),
    "viscous_work_primary": Field(_ENERGY, "energy lost in the primary's dashpot per cycle"),
    "viscous_work_secondary": Field(_ENERGY, "energy lost in the secondary's dashpot per cycle"),
    "harmonics": Field("1", "highest harmonic kept"),
    "m2": Field("kg", "mass of the secondary"),
    "k2": Field("N m-1", "stiffness of the secondary"),
    "zeta_over_design": Field("1", "half-power damping ratio of each design"),
    "omega_peak_over_design": Field("rad s-1", "angular frequency of the peak of each design"),
    "peak_over_design": Field("1", "transmissibility at the peak of each design"),
    "zeta_max": Field("1", "largest half-power damping ratio of all friction capacities"),
    "capacity_at_zeta_max": Field("N", "friction capacity of the largest damping"),
    # statics
    "external_pressure": Field("Pa", "external pressure on the layer outside the interface"),
    # bench experiments
    "actuator_displacement": Field("m", "displacement of the actuator"),
    "platen_displacement": Field("m", "displacement of the platen"),
    "platen_slip": Field("m", "sliding at the platen"),
    "shear_force": Field("N", "shear force on both stacks"),
    "friction_coefficient": Field("1", "coefficient of friction"),
    "slip_rate": Field("m s-1", "slip rate"),
    "slip_distance": Field("m", "slip"),
    "state_variable": Field("s", "state of rate-and-state friction"),
    # evaluations of measurements
    **{name: entry for fields in LAB_FIELDS.values() for name, entry in fields.items()},
}


AXES: dict[str, Field] = {
    "friction_capacity": Field("N", "friction capacity of the two masses"),
}
"""Names whose meaning as an axis differs from their meaning as a variable."""


def field(name: str) -> Field:
    """Return unit and label of a variable or coordinate.

    Raises
    ------
    InputError
        If `FIELDS` has no such name.
    """
    try:
        return FIELDS[name]
    except KeyError:
        raise InputError(
            f"unknown field {name!r}",
            remedy="add its unit and label to FIELDS in wroll_fem/results/fields.py",
        ) from None


def label(name: str, unit: str | None = None) -> str:
    """Axis label "long name (unit)". A scaled axis needs `unit`, otherwise the unit is SI; "" or "1" omits the unit."""
    entry = field(name)
    shown = (entry.units if unit is None else unit).replace("m s-2", "m/s²").replace("m s-1", "m/s")
    text = entry.long_name[0].upper() + entry.long_name[1:]
    return text if shown in ("1", "") else f"{text} ({shown})"
