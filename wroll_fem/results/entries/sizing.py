"""Entries of summary.json of the analysis sizing."""

from __future__ import annotations

from wroll_fem.results.entry import Entry, number, share

SIZING: dict[str, Entry] = {
    "wall_thickness_m": Entry("m", "wall with the wanted margin", "per reading of the stress; `null` without one"),
    "mandrel_material": Entry("", "material of the mandrel", "and which constants are defaults", console="{}"),
    "design_reading": Entry("", "design reading", "reading whose wall the other entries belong to"),
    "design_wall_m": Entry("m", "wall", "of the design reading, or the given one", console="{:.4g} m"),
    "wall_margins": share("margins against yield of this wall", "per reading"),
    "peak_stress_pa": Entry("Pa", "largest von Mises stress", "per reading, with its own wall"),
    "peak_stress_z_m": Entry("m", "height of the largest stress above the base", "per reading"),
    "peak_stress_theta_rad": number(
        "rad", "angle of the largest stress", "per reading, from the direction of the inertial load"
    ),
    "peak_stress_surface": Entry("", "surface of the largest stress", "per reading: inner, middle or outer"),
    "end_zone_m": Entry("m", "length of an end zone", "edge bending decays to 1 % in it"),
    "buckling_waves": number("", "waves of the buckling mode", "around the circumference, under pressure alone"),
    "buckling_factor_pressure": number("", "buckling pressure divided by the pressure", console="{:.3g}"),
    "buckling_factor_transverse": number("", "buckling factor of the acceleration", console="{:.3g}"),
    "buckling_factor_combined": number(
        "", "buckling factor of acceleration and pressure together", console="{:.3g}"
    ),
    "aspect_ratio": number("", "aspect ratio AR", "length divided by outer diameter of the mandrel"),
    "mass_ratio": number("", "mass ratio MR", "mass of the mandrel's tube divided by that of the coil"),
    "thickness_ratio": number("", "thickness ratio TR", "wall divided by the thickness of the coil"),
    "diameter_ratio": number("", "diameter ratio DR", "outer diameter of the mandrel divided by that of the coil"),
    "tip_stiffness_n_per_m": number(
        "N/m", "tip stiffness", "transverse force on the tip ring divided by its displacement", "{:.4g} N/m"
    ),
    "mandrel_hz": number("Hz", "bending frequency of the mandrel", "with end cap, without coil", "{:.2f} Hz"),
    "mandrel_with_coil_hz": number("Hz", "bending frequency with the mass of the coil", "with end cap"),
    "mandrel_mass_kg": Entry("kg", "mass of the mandrel", "without end cap"),
    "end_cap_mass_kg": Entry("kg", "mass of the end cap"),
}  # fmt: skip
"""Name -> entry, in the order of summary.json."""
