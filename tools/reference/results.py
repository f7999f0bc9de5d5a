"""Reference of what a run leaves behind: names of summary.json, variables of results.nc."""

from __future__ import annotations

from tools.reference.markdown import GENERATED, code, prose, table
from wroll_fem.report.values import label, split_unit
from wroll_fem.results.dataset import AXES, FIELDS

_INTRO = """# Results

A run folder holds

| file | what |
|---|---|
| `case.yaml` | the case with all defaults filled in |
| `summary.json` | the numbers of the table below: flat, SI, the unit in the name |
| `results.nc` | NetCDF of all curves and fields, `units` and `long_name` on each; `wf.load_result` reads it |
| `fields/*.vtu` | slip maps, mode shapes, stress points, for ParaView or pyvista |
| `figures/*.png` | figures of the analysis |
| `run.log` | progress and warnings |
| `provenance.json` | versions, machine, command, wall time |
| `checkpoint*` | while a sweep or dwell runs: what `--resume` goes on from |

A batch adds `batch.csv` and `batch.nc`, one row per case. Amplitudes are 0-peak. Lists run over interfaces or layers
(inner first), over modes, or over the levels of the case; `null` stands where there is nothing to read.
"""

#: Groups of summary.json: heading, names, and what the label alone does not tell.
SUMMARY: dict[str, dict[str, str]] = {
    "Every run": {
        "analysis": "the case's `analysis`",
        "dofs": "of the structure that was solved (half a roll where symmetry allows)",
        "interface_points": "",
        "mass_total_kg": "",
        "wall_time_s": "",
        "solver_time_s": "CPU time of the time loop or of the continuation",
    },
    "Resonance of a curve (sweep, harmonic)": {
        "f_n_hz": "frequency of the peak",
        "zeta": "(f2 - f1)/(2 f_n) by default; missing where a half-power point lies outside the band",
        "zeta_method": "estimator (`output.damping`) and curve",
        "zeta_error": "of estimators that have one",
        "zeta_lower_bound": "",
        "zeta_misfit": "",
        "zeta_reason": "",
        "f_n_error_hz": "",
        "peak_transmissibility": "|A_tip + A_g|/|A_g|; of the displacements with two_dof",
        "half_power_low_hz": "f1, where T is its peak over sqrt 2",
        "half_power_high_hz": "f2",
        "skewness": "(f2 - f_n)/(f_n - f1) - 1; positive: long tail to the right",
    },
    "Steady end of a dwell": {
        "steady_magnitude": "over the last whole cycles",
        "steady_phase_rad": "of the tip's absolute acceleration against the base's",
        "steady_amplitude_m_s2": "",
        "steady_residual": "",
        "steady_drift": "",
    },
    "Energy over the whole motion (sweep, dwell)": {
        "input_work_j": "",
        "friction_energy_j": "",
        "numerical_dissipation_j": "",
        "pressure_modulation_work_j": "",
        "impact_dissipation_j": "",
        "energy_balance_error": "largest violation of the energy identity over the largest input",
    },
    "Energy of a period (harmonic, backbone)": {
        "input_work_per_cycle_j": "where the response, or the damping of a backbone, is largest",
        "friction_work_per_cycle_j": "",
        "modulation_work_per_cycle_j": "",
        "viscous_work_per_cycle_j": "",
        "memory_change": "",
    },
    "Interfaces": {
        "interface_pressure_mean_pa": "after the preload, area mean",
        "external_pressure_pa": "",
        "winding_pressure_pa": "with `preload.kind: winding_tension`",
        "max_slip_m": "largest relative tangential displacement at any time and point",
        "slipping_area_fraction": "share of the area that slipped at any time",
    },
    "Modes": {
        "modes_hz": "natural frequencies, rising",
        "mode_kinds": "bending, torsion, axial, ovalling-n, ...",
        "effective_mass_fraction": "along the excitation, over the total mass",
        "bending_hz": "",
    },
    "Backbone": {
        "f_stuck_hz": "",
        "f_largest_amplitude_hz": "",
        "zeta_max": "",
        "tip_amplitude_at_zeta_max_m": "",
        "base_acceleration_at_zeta_max_m_s2": "",
    },
    "Wound roll": {
        "pressure_mandrel_pa": "under the first wrap",
        "capacity_mandrel_pa": "mu times it",
        "mandrel_stiffness_pa": "pressure over hoop strain at its surface",
        "pressure_mandrel_error_estimate": "what extrapolation changes, over the pressure",
        "pressure_mandrel_wrap_grid_pa": "",
        "capacity_mandrel_wrap_grid_pa": "",
        "hoop_bound_pa": "",
        "hoop_stress_min_pa": "",
        "tension_stress_pa": "",
        "tension_n": "",
        "outer_radius_m": "",
    },
    "Slip of a solid coil (modal_transient)": {
        "driven_mode": "number of the mode whose frequency is driven",
        "excitation_frequency_hz": "",
        "participating_mass_fraction": "share of the mass along the excitation that the modes carry",
        "transmissibility": "steady, exact",
        "transmissibility_last_cycle": "of the last cycle simulated",
        "steady_cycles": "cycles until the motion repeats",
        "amplitude_g": "levels",
        "shear_resultant_max_pa": "per level",
        "slipping_volume_fraction": "per level",
        "slip_zone_height_m": "per level, above the base",
        "slip_zone_depth_m": "per level, from the mandrel",
        "slip_onset_g": "missing where nothing would slip at any level",
        "slip_onset_radius_m": "",
        "slip_onset_height_m": "",
        "slip_onset_theta_rad": "",
        "slip_statement": "the same in a sentence",
    },
    "Map of mandrels": {
        "disparity_hz": "bending frequency of the case's own mandrel, tightest less loosest coil",
        "f_tightest_hz": "",
        "f_loosest_hz": "",
        "f_mandrel_hz": "mandrel alone",
        "loosest_shear_modulus_pa": "",
        "designs": "number of mandrels on the map",
        "designs_without_disparity": "",
        "disparity_largest_hz": "",
        "disparity_largest_mandrel_radius_m": "",
        "disparity_largest_mandrel_thickness_m": "",
        "disparity_smallest_hz": "",
        "disparity_smallest_mandrel_radius_m": "",
        "disparity_smallest_mandrel_thickness_m": "",
    },
    "Two masses": {
        "method": "periodic or time",
        "friction_capacity_n": "one curve each",
        "omega_peak_rad_s": "per capacity",
        "friction_capacity_lowest_peak_n": "capacity with the lowest peak",
        "friction_capacity_at_zeta_max_n": "capacity with the largest damping",
        "zeta_max_over_design": "largest on the design map",
        "m2_at_zeta_max_kg": "",
        "k2_at_zeta_max_n_m": "",
    },
    "How it was computed": {
        "steps": "",
        "step_cuts": "halvings of steps that did not converge at once",
        "newton_iterations_mean": "",
        "reduced_coordinates": "shapes in the span of `solver.method: reduced` at the end",
        "reduction_error_estimate": "root mean square of what the shapes missed, relative",
        "reduction_tip_error_estimate": "the same seen at the tip (harmonic, backbone)",
        "training_time_s": "CPU time spent on finding shapes",
        "branch_points": "points of the curve",
        "folds": "turning points of the curve",
    },
}

_GROUPS = (
    ("Axes and places", ("time", "area")),
    ("Histories", ("base_acceleration", "step_cuts")),
    ("Energies, cumulative from the start of the motion", ("input_work", "numerical_dissipation")),
    ("Interfaces", ("cumulative_slip", "relative_displacement_axial")),
    ("Curves over frequency", ("transmissibility_real", "transmissibility_spectrum_magnitude")),
    ("Periodic motions", ("branch_point", "memory_change")),
    ("Modes", ("mode_frequency", "corner")),
    ("Solid coil under a steady sine", ("amplitude_g", "slip_zone_depth")),
    ("The wound roll", ("r", "wrap_hoop_stress_pa")),
    ("Map of mandrels", ("mandrel_radius", "limit_kind")),
    ("Two masses", ("omega", "capacity_at_zeta_max")),
)
"""Heading, first and last name in `FIELDS`; what stands behind them all is told last."""


def results_page() -> str:
    """Markdown of run folder, summary.json and results.nc."""
    parts = [GENERATED, _INTRO, "## summary.json"]
    for heading, names in SUMMARY.items():
        rows = ((code(name), split_unit(name)[1], _words(name, note)) for name, note in names.items())
        parts += [f"### {heading}", table(("name", "unit", "meaning"), rows)]
    parts += [
        "## results.nc",
        "One Dataset per run, with those of these variables that its analysis has; complex curves as real and "
        "imaginary parts.",
    ]
    for heading, fields in _grouped():
        rows = ((code(name), _unit(FIELDS[name].units), prose(FIELDS[name].long_name)) for name in fields)
        parts += [f"### {heading}", table(("variable", "unit", "meaning"), rows)]
    rows = ((code(name), entry.units, prose(entry.long_name)) for name, entry in AXES.items())
    parts += ["### Axes with a meaning of their own", table(("axis", "unit", "meaning"), rows)]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _words(name: str, note: str) -> str:
    words = label(name)
    return prose(f"{words}: {note}" if note else words)


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _grouped() -> list[tuple[str, list[str]]]:
    names, groups, at = list(FIELDS), [], 0
    for heading, (_, last) in _GROUPS:
        end = names.index(last) + 1
        groups.append((heading, names[at:end]))
        at = end
    return [*groups, ("Statics and others", names[at:])]
