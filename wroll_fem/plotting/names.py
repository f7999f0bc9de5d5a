"""Public figure functions, for example `wf.plot.slip_map(result)`.

Each function takes a Dataset; a figure of a study takes a list of `StudyCase`. A figure of one panel also takes the
`ax` to draw in. Functions return the `ax` and open no window. `save(ax, path)` writes the figure at 150 dpi and closes
it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from wroll_fem.errors import InputError
from wroll_fem.plotting.backbone import plot_backbone as backbone
from wroll_fem.plotting.backbone import plot_harmonic_response as harmonic_response
from wroll_fem.plotting.coil_slip import plot_root_section as root_section
from wroll_fem.plotting.coil_slip import plot_root_sections as root_sections
from wroll_fem.plotting.coil_slip import plot_shear_along as shear_along
from wroll_fem.plotting.coil_slip import plot_shear_distribution as shear_distribution
from wroll_fem.plotting.coil_slip import plot_slip_zone as slip_zone
from wroll_fem.plotting.coil_slip import plot_steady_response as steady_response
from wroll_fem.plotting.coil_slip_space import plot_slip_in_coil as slip_in_coil
from wroll_fem.plotting.cylinder import plot_slip_on_cylinder as slip_on_cylinder
from wroll_fem.plotting.cylinder import write_slip_vtu
from wroll_fem.plotting.design_map import plot_design_map as design_map
from wroll_fem.plotting.history import plot_energy_ledger as energy_ledger
from wroll_fem.plotting.history import plot_response as response
from wroll_fem.plotting.hysteresis import plot_hysteresis as hysteresis
from wroll_fem.plotting.margin import plot_margin as margin
from wroll_fem.plotting.mode_shapes import plot_mode_shapes as mode_shapes
from wroll_fem.plotting.modes import plot_modes as modes
from wroll_fem.plotting.random_levels import plot_random_levels as random_levels
from wroll_fem.plotting.random_response import plot_random_response as random_response
from wroll_fem.plotting.scene import jupyter_backend, slip_scene
from wroll_fem.plotting.series import FIGURES
from wroll_fem.plotting.series import plot_curves as curves
from wroll_fem.plotting.shock import plot_shock as shock
from wroll_fem.plotting.slip import plot_peak_slip_vectors as peak_slip_vectors
from wroll_fem.plotting.slip import plot_pressure_map as pressure_map
from wroll_fem.plotting.slip import plot_slip_map as slip_map
from wroll_fem.plotting.slip_damping import plot_slip_damping as slip_damping
from wroll_fem.plotting.slip_work import plot_slip_work as slip_work
from wroll_fem.plotting.slip_work_section import plot_slip_work_section as slip_work_section
from wroll_fem.plotting.slip_work_section import plot_slip_work_sections as slip_work_sections
from wroll_fem.plotting.slip_work_space import plot_slip_work_in_coil as slip_work_in_coil
from wroll_fem.plotting.spectra import plot_spectra as spectra
from wroll_fem.plotting.style import save_figure as save
from wroll_fem.plotting.transmissibility import plot_comparison as comparison
from wroll_fem.plotting.transmissibility import plot_transmissibility as transmissibility
from wroll_fem.plotting.two_dof import plot_two_dof as two_dof
from wroll_fem.plotting.two_dof import plot_two_dof_arrangements as two_dof_arrangements
from wroll_fem.plotting.two_dof import plot_two_dof_design_space as two_dof_design_space
from wroll_fem.plotting.two_dof import plot_two_dof_readings as two_dof_readings
from wroll_fem.plotting.winding import plot_winding as winding
from wroll_fem.plotting.wrap_slip import plot_wrap_slip as wrap_slip

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from wroll_fem.plotting.study import StudyCase

_OLD = {
    "save_figure": "save",
    "family": "curves",
    "frequency_over_shear_stiffness": "shear_stiffness",
    "frequency_over_shear_stiffness_band": "shear_stiffness_band",
}
"""Old name of a figure function -> current name."""

__all__ = [
    "backbone", "comparison", "curves", "design_map", "energy_ledger", "harmonic_response", "hysteresis",
    "jupyter_backend", "margin", "mode_shapes", "modes", "peak_slip_vectors", "pressure_map", "random_levels",
    "random_response", "response", "root_section", "root_sections", "save", "shear_along", "shear_distribution",
    "shock", "slip_damping", "slip_in_coil", "slip_map", "slip_on_cylinder", "slip_scene", "slip_work",
    "slip_work_in_coil", "slip_work_section", "slip_work_sections", "slip_zone",
    "spectra", "steady_response", "study_figure", "transmissibility", "two_dof", "two_dof_arrangements",
    "two_dof_design_space", "two_dof_readings", "winding", "wrap_slip", "write_slip_vtu",
]  # fmt: skip
globals().update(FIGURES)  # figures of a study, by the names that a grid file gives them
__all__ += FIGURES


def study_figure(name: str, members: Sequence[StudyCase]) -> Axes:
    """Draw a figure of a study, given its name in grid files (key `figure`).

    Raises
    ------
    InputError
        If the name is unknown, or the cases lack what the figure needs.
    """
    if name not in FIGURES:
        raise InputError(f"no figure {name!r}", key="figure", remedy=f"use one of: {', '.join(FIGURES)}")
    return FIGURES[name](members)


def __dir__() -> list[str]:
    return __all__


def __getattr__(name: str) -> object:
    """Resolve old spellings: `plot_slip_map` for `slip_map`, and the names in `_OLD`."""
    short = name.removeprefix("plot_")
    short = _OLD.get(short, short)
    if short == name or short not in globals():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(sorted(__all__))}")
    return globals()[short]
