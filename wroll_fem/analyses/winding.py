"""Stress in the wound roll of a case."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared.figures import figure
from wroll_fem.case.checks_winding import FIT
from wroll_fem.results.dataset import annotate
from wroll_fem.winding import WoundRoll, wound_roll

if TYPE_CHECKING:
    from wroll_fem.case import WindingCase
    from wroll_fem.case.winding import Winding
    from wroll_fem.progress import Progress

COARSE = 0.01
"""Estimated relative error of the pressure at the mandrel above which the run warns."""


def run_winding(case: WindingCase, *, progress: Progress) -> xr.Dataset:
    """Compute pressure, friction capacity and hoop stress versus radius, on a refined grid and on the thesis grid.

    Returns
    -------
    xr.Dataset
        `pressure_pa`, `capacity_pa`, `hoop_stress_pa`, `radial_modulus_pa`, `winding_tension_pa` over `r`. On the
        grid of the thesis, over `wrap`: the values under each wrap, and the mean hoop stress in it.
    """
    section = case.wound
    with progress.stage("wound roll", 1) as stage:
        roll = wound_roll(section)
        stage.update(1, f"{section.wraps} wraps, {section.cells} cells")
    for text in doubts(section, roll):
        progress.warning(text)
    wraps, mu = roll.wraps, section.friction_coefficient
    dataset = xr.Dataset(
        {
            "pressure_pa": ("r", roll.pressure),
            "capacity_pa": ("r", roll.capacity),
            "hoop_stress_pa": ("r", roll.hoop_stress),
            "radial_modulus_pa": ("r", roll.modulus(roll.pressure)),
            "winding_tension_pa": ("r", roll.tension),
            "wrap_radius": ("wrap", wraps.radius[:-1]),
            "wrap_pressure_pa": ("wrap", wraps.pressure[:-1]),
            "wrap_capacity_pa": ("wrap", mu * wraps.pressure[:-1]),
            "wrap_hoop_stress_pa": ("wrap", wraps.hoop_stress),
        },
        coords={"r": roll.radius, "wrap": np.arange(1, section.wraps + 1)},
    )
    dataset.attrs |= main_numbers(section, roll)
    return annotate(dataset)


def main_numbers(section: Winding, roll: WoundRoll) -> dict[str, Any]:
    """Return the entries of summary.json, flat and in SI."""
    first = {
        "pressure_mandrel_pa": float(roll.pressure[0]),
        "capacity_mandrel_pa": float(roll.capacity[0]),
        "mandrel_stiffness_pa": roll.mandrel_stiffness,
        "pressure_mandrel_error_estimate": roll.error_estimate,
        "pressure_mandrel_wrap_grid_pa": float(roll.wraps.pressure[0]),
        "capacity_mandrel_wrap_grid_pa": section.friction_coefficient * float(roll.wraps.pressure[0]),
        "hoop_bound_pa": roll.hoop_bound,
        "hoop_stress_min_pa": float(roll.hoop_stress.min()),
        "tension_stress_pa": section.stress,
        "web_modulus_pa": section.web.E_theta,
        "outer_radius_m": float(roll.radius[-1]),
    }
    if section.web_width is not None:
        first["tension_n"] = section.stress * section.web_width * section.wrap_thickness
    return first


def doubts(section: Winding, roll: WoundRoll) -> list[str]:
    """Warnings about the result, each with a remedy."""
    found = []
    if roll.error_estimate > COARSE:
        found.append(
            f"the pressure at the mandrel still changes by {100 * roll.error_estimate:.1f} % when the grid is "
            f"refined; raise winding.cells (now {section.cells})"
        )
    stiffest = float(roll.modulus(roll.pressure[0]))
    if stiffest > section.web.E_theta:
        found.append(
            f"under the pressure at the mandrel the radial modulus of the stack ({stiffest:.3g} Pa) exceeds the "
            "modulus along the web; check winding.web.radial_modulus"
        )
    profile = section.tension_profile
    if profile.kind == "table" and not (
        profile.radius[0] <= roll.radius[0] * (1.0 + FIT) and profile.radius[-1] >= roll.radius[-1] * (1.0 - FIT)
    ):
        found.append(
            f"winding.tension_profile covers {profile.radius[0]:.4g} to {profile.radius[-1]:.4g} m, the roll "
            f"{roll.radius[0]:.4g} to {roll.radius[-1]:.4g} m; beyond the table its end values apply"
        )
    law = section.web.radial_modulus
    if law.law == "table" and roll.pressure[0] > law.pressure[-1]:
        found.append(
            f"the pressure at the mandrel, {roll.pressure[0]:.3g} Pa, exceeds the last row of "
            "winding.web.radial_modulus; the modulus of this row is used"
        )
    return found


def estimate_winding(case: WindingCase) -> dict[str, Any]:
    """Numbers of wraps and cells, and approximate computing time."""
    cells, wraps = case.winding.cells, case.winding.wraps
    return {"wraps": wraps, "cells": cells, "estimated_seconds": 2.2 + 8e-9 * (0.6 * cells**2 + 0.5 * wraps**2)}


ANALYSIS = Analysis(
    name="winding",
    sentence="Stress in the wound roll: pressure between the wraps and friction capacity.",
    sections=("winding",),
    run=run_winding,
    figures=(figure("winding", "winding"),),
    variables={
        "r": ("pressure_pa", "capacity_pa", "hoop_stress_pa", "radial_modulus_pa", "winding_tension_pa"),
        "wrap": ("wrap_pressure_pa", "wrap_capacity_pa", "wrap_hoop_stress_pa"),
    },
    plots=("winding",),
    estimate=estimate_winding,
)
