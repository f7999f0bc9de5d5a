"""Preload: static contact pressure and friction traction of the layers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_roll
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures, preflight, summary
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.dynamics.time_stepping.fields import interface_fields
from wroll_fem.results.dataset import annotate

if TYPE_CHECKING:
    from wroll_fem.case import PreloadCase
    from wroll_fem.progress import Progress


def run_preload(case: PreloadCase, *, progress: Progress) -> xr.Dataset:
    """Compute contact pressure and friction traction under the preload, and the displacement of the probes."""
    system, state = prepare(case, progress)
    dataset = interface_fields(system, state)
    if len(system.probe_names) > 1:
        at_probes = np.array([system.probes[name] @ state.displacement for name in system.probe_names])
        dataset = dataset.assign_coords(probe=list(system.probe_names)).assign(probe_displacement=("probe", at_probes))
    dataset.attrs |= {"dofs": system.n_dofs, "interface_points": system.n_points}
    return annotate(dataset)


ANALYSIS = Analysis(
    name="preload",
    sentence="Static contact pressure under the preload.",
    sections=("geometry", "mandrel", "coil", "contact", "preload"),
    run=run_preload,
    summary=(summary.interfaces,),
    figures=(figures.pressure_maps,),
    fields=(figures.write_slip,),
    variables={"interface, point": ("pressure", "traction_hoop", "traction_axial")},
    plots=("pressure_map",),
    preflight=preflight.CHECKS["preload"],
    estimate=estimate_roll,
)
