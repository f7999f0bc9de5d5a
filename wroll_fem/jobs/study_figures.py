"""Names of the figures that a grid file can request; `plotting.series.FIGURES` has the functions that draw them.

The names are listed separately, so that reading a grid file does not load matplotlib. A test compares both lists.
"""

STUDY_FIGURES = (
    "transmissibility_over_preload", "damping_over_frequency", "damping_over_preload", "friction_along_sweep",
    "friction_over_preload", "friction_over_damping", "slip_extent", "slip_vectors", "layer_count", "layer_modulus",
    "elastic_slip", "integrators", "mesh_friction", "mesh_frequency", "friction_laws", "transmissibility_over_tension",
    "shear_stiffness", "shear_stiffness_band", "winding_hardness", "winding_tension",
    "damping_over_level",
)  # fmt: skip
