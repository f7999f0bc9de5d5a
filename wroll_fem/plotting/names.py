"""Figures by short names: `wf.plot.slip_map(result)`.

Each takes a Dataset (those of a study a list of `SeriesMember`) and where it draws one panel the `ax` to draw in, and
returns the `ax`; nothing is shown or computed again. `save(ax, path)` writes at 150 dpi and closes. The same functions
stand under their long names in `wroll_fem.plotting`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from wroll_fem import plotting
from wroll_fem.errors import InputError
from wroll_fem.plotting import coil_slip, coil_slip_space, scene, series, shear_stiffness, study, style
from wroll_fem.plotting import two_dof as _two_dof

if TYPE_CHECKING:
    from matplotlib.axes import Axes

save = style.save_figure

# vibration
transmissibility = plotting.plot_transmissibility
comparison = plotting.plot_comparison
harmonic_response = plotting.plot_harmonic_response
backbone = plotting.plot_backbone
response = plotting.plot_response
energy_ledger = plotting.plot_energy_ledger
modes = plotting.plot_modes

# slip between layers
slip_map = plotting.plot_slip_map
peak_slip_vectors = plotting.plot_peak_slip_vectors
pressure_map = plotting.plot_pressure_map
slip_on_cylinder = plotting.plot_slip_on_cylinder
slip_scene = scene.slip_scene
jupyter_backend = scene.jupyter_backend

# solid coil
winding = plotting.plot_winding
steady_response = coil_slip.plot_steady_response
shear_along = coil_slip.plot_shear_along
root_section = coil_slip.plot_root_section
slip_zone = coil_slip.plot_slip_zone
slip_in_coil = coil_slip_space.plot_slip_in_coil
design_map = plotting.plot_design_map

# two masses
two_dof = plotting.plot_two_dof
two_dof_readings = plotting.plot_two_dof_readings
two_dof_design_space = plotting.plot_two_dof_design_space
two_dof_arrangements = _two_dof.plot_two_dof_arrangements

# studies
family = series.plot_family
damping_over_frequency = series.plot_damping_over_frequency
friction_over_preload = series.plot_friction_over_preload
friction_over_damping = series.plot_friction_over_damping
frequency_over_shear_stiffness = shear_stiffness.plot_shear_stiffness
frequency_over_shear_stiffness_band = shear_stiffness.plot_shear_stiffness_band


def study_figure(name: str, members: Sequence[study.SeriesMember]) -> Axes:
    """Draw a figure of a study by the name that a grid file gives it.

    Raises
    ------
    InputError
        For a name that is not known, or members that lack what the figure needs.
    """
    if name not in series.FIGURES:
        raise InputError(f"no figure {name!r}", key="figure", remedy=f"use one of: {', '.join(series.FIGURES)}")
    return series.FIGURES[name](members)


__all__ = [
    "backbone", "comparison", "damping_over_frequency", "design_map", "energy_ledger", "family",
    "frequency_over_shear_stiffness", "frequency_over_shear_stiffness_band", "friction_over_damping",
    "friction_over_preload", "harmonic_response", "jupyter_backend", "modes", "peak_slip_vectors", "pressure_map",
    "response", "root_section", "save", "shear_along", "slip_in_coil", "slip_map", "slip_on_cylinder", "slip_scene",
    "slip_zone", "steady_response", "study_figure", "transmissibility", "two_dof", "two_dof_arrangements",
    "two_dof_design_space", "two_dof_readings", "winding",
]  # fmt: skip


def __dir__() -> list[str]:
    return __all__


def __getattr__(name: str) -> object:
    """Long names of `wroll_fem.plotting` work here too."""
    try:
        return getattr(plotting, name)
    except AttributeError:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(__all__)}") from None
