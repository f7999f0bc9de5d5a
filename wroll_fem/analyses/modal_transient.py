"""Solid coil under steady sinusoidal base motion: where the shear stress exceeds the friction capacity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_modes
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures, summary
from wroll_fem.analyses.slip_model import SlipModel
from wroll_fem.coiled_stiff.slip_criterion import slips

if TYPE_CHECKING:
    from wroll_fem.case import ModalTransientCase
    from wroll_fem.progress import Progress


def run_modal_transient(case: ModalTransientCase, *, progress: Progress) -> xr.Dataset:
    """Compute modes, their stress, winding pressure, steady response and slip; see `transient_dataset`."""
    return SlipModel.of(case, progress=progress).run(progress=progress)


def slip_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Slip onset and slip zone for summary.json; lists have one entry per level of `amplitude_g`."""
    onset, levels = dataset["slip_onset"].values, dataset["amplitude_g"].values
    first = int(np.argmin(onset))
    found: dict[str, Any] = {
        "amplitude_g": levels.tolist(),
        "shear_resultant_max_pa": (levels * float(dataset["shear_resultant"].max())).tolist(),
        "slipping_volume_fraction": dataset["slipping_volume_fraction"].values.tolist(),
        "slip_zone_height_m": dataset["slip_zone_height"].values.tolist(),
        "slip_zone_depth_m": dataset["slip_zone_depth"].values.tolist(),
        "slip_statement": slip_statement(dataset),
    }
    if np.isfinite(onset[first]):
        found |= {
            "slip_onset_g": float(onset[first]),
            "slip_onset_radius_m": float(dataset["r_m"][first]),
            "slip_onset_height_m": float(dataset["z_m"][first]),
            "slip_onset_theta_rad": float(dataset["theta_rad"][first]),
        }
    return found


def slip_statement(dataset: xr.Dataset) -> str:
    """Sentence that states onset, location and extent of slip in the coil."""
    onset, top = dataset["slip_onset"].values, float(dataset["amplitude_g"].values[-1])
    first = int(np.argmin(onset))
    if not np.isfinite(onset[first]):
        return "no slip at any level: the coil has no shear stress"
    depth = 1e3 * (float(dataset["r_m"][first]) - float(dataset.attrs["mandrel_radius_m"]))
    place = (
        f"{depth:.2f} mm from the mandrel, {1e3 * float(dataset['z_m'][first]):.1f} mm above the base, at "
        f"{abs(np.degrees(float(dataset['theta_rad'][first]))):.0f} degrees from x"
    )
    if not slips(top * dataset["shear_resultant"].values, dataset["friction_capacity"].values).any():
        return f"no slip up to {top:g} g; slip would start above {onset[first]:.3g} g, {place}"
    share = 100 * float(dataset["slipping_volume_fraction"].values[-1])
    return f"slip starts above {onset[first]:.3g} g, {place}; at {top:g} g {share:.3g} % of the coil's volume slips"


ANALYSIS = Analysis(
    name="modal_transient",
    sentence="Solid coil under steady sinusoidal base motion: where the shear stress exceeds the friction capacity.",
    sections=("geometry", "mandrel", "coil", "winding", "excitation", "damping_ratio"),
    run=run_modal_transient,
    summary=(slip_summary, summary.modes),
    figures=(
        figures.figure("steady_response", "steady_response"),
        figures.figure("shear_distribution", "shear_distribution"),
        figures.coil_sections,
        figures.figure("modes", "modes"),
        figures.coil_in_space,
    ),
    fields=(figures.write_coil,),
    variables={
        "point": ("shear_resultant", "friction_capacity", "slip_onset"),
        "amplitude_g": ("slipping_volume_fraction", "slip_zone_height", "slip_zone_depth"),
        "time": ("tip_displacement", "tip_acceleration_absolute"),
        "mode": ("mode_frequency", "effective_mass_fraction"),
    },
    plots=(
        "steady_response",
        "shear_along",
        "shear_distribution",
        "root_section",
        "root_sections",
        "slip_zone",
        "slip_scene",
        "slip_in_coil",
    ),
    estimate=estimate_modes,
)
