"""Figures from Datasets only.

Every function of matplotlib takes a Dataset and an `ax` and returns the `ax`; nothing is shown or recomputed.
`save_figure(ax, path)` writes 150 dpi and closes. Pictures in space write a file (those of modes by pyvista).
"""

from wroll_fem.plotting.backbone import plot_backbone, plot_harmonic_response
from wroll_fem.plotting.cylinder import plot_slip_on_cylinder, write_slip_vtu
from wroll_fem.plotting.design_map import plot_design_map
from wroll_fem.plotting.history import plot_energy_ledger, plot_response
from wroll_fem.plotting.mode_shapes import plot_mode_shapes
from wroll_fem.plotting.modes import plot_modes
from wroll_fem.plotting.slip import plot_peak_slip_vectors, plot_pressure_map, plot_slip_map
from wroll_fem.plotting.style import save_figure
from wroll_fem.plotting.transmissibility import plot_comparison, plot_transmissibility
from wroll_fem.plotting.two_dof import plot_two_dof, plot_two_dof_design_space, plot_two_dof_readings
from wroll_fem.plotting.winding import plot_winding

__all__ = [
    "plot_backbone",
    "plot_comparison",
    "plot_design_map",
    "plot_energy_ledger",
    "plot_harmonic_response",
    "plot_mode_shapes",
    "plot_modes",
    "plot_peak_slip_vectors",
    "plot_pressure_map",
    "plot_response",
    "plot_slip_map",
    "plot_slip_on_cylinder",
    "plot_transmissibility",
    "plot_two_dof",
    "plot_two_dof_design_space",
    "plot_two_dof_readings",
    "plot_winding",
    "save_figure",
    "write_slip_vtu",
]
