"""Linear buckling of a roll under its preload: load factors, wave numbers and shapes of the buckling modes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_modes
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures, preflight
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.shared.mode_shapes import shape_variables
from wroll_fem.analyses.shared.prestress import body_pressures, contact_state, held_springs, prestressed_roll
from wroll_fem.analyses.shared.resolution import edge_remark
from wroll_fem.analyses.shared.springs import linear_springs
from wroll_fem.bodies.mode_shapes import classify_mode
from wroll_fem.case.kinds import BucklingCase
from wroll_fem.errors import InputError
from wroll_fem.results.dataset import annotate

if TYPE_CHECKING:
    from wroll_fem.progress import Progress


WAVE_ERROR, LARGEST_ERROR = 0.28, 0.01
"""Relative error of a load factor, times the square of the number of elements per wave around, and error above which
the run warns. Measured on clamped tubes with R/t of 26 to 200 and 3 to 5 waves: 0.27 to 0.28 with five elements per
wave or more, 0.45 with three."""


def wave_remark(waves: int, circumferential: int) -> str:
    """Warning about a buckling mode with too few elements per wave around the roll; empty otherwise."""
    error = WAVE_ERROR * (waves / circumferential) ** 2
    if error <= LARGEST_ERROR:
        return ""
    return (
        f"the buckling mode has {waves} waves around the roll and {circumferential / waves:.2g} elements per wave: the "
        f"load factor is about {100 * error:.2g} % too high; raise mesh.circumferential to "
        f"{4 * math.ceil(0.25 * waves * math.sqrt(WAVE_ERROR / LARGEST_ERROR))}"
    )


def run_buckling(case: BucklingCase, *, progress: Progress) -> xr.Dataset:
    """Compute the lowest load factors at which the preload makes the roll buckle: (K + factor K_g) x = 0.

    The interfaces are held by the springs of `modal.interface` (frictionless: normal contact and a negligible
    stiffness along the surface). docs/geometric-stiffness.md defines the geometric stiffness K_g. Only motions
    symmetric about the x-z plane are computed; they contain one mode of every degenerate pair.

    Raises
    ------
    InputError
        If the preload destabilises no motion.
    """
    from wroll_fem.fem.prestress.buckling import load_factors

    with progress.stage("mesh and matrices", 2) as stage:
        roll = prestressed_roll(case, build_bodies(case))
        assert roll is not None  # every case of this analysis has geometric stiffness
        stage.update(1)
        system = build_system(case, roll.bodies)
        stage.update(2, f"{system.n_dofs} DOFs")
    with progress.stage("preload and geometric stiffness", 2) as stage:
        system, state = contact_state(case, roll, system)
        stage.update(1)
        geometric = roll.geometric_stiffness(system, state, body_pressures(case, system))
        stage.update(2)
    with progress.stage("buckling modes", 1) as stage:
        springs = np.zeros(0)
        if system.interfaces:
            weak = case.modal.interface == "frictionless" and case.coil.model == "layers"
            springs = linear_springs(case, system, state)
            springs = np.maximum(springs, held_springs(system, state, sticks=False)) if weak else springs
        factors, vectors = load_factors(system.with_interface_springs(springs), geometric, case.modal.count)
        stage.update(1)
    if not len(factors):
        raise InputError(
            "destabilises no motion: the roll does not buckle at any multiple of it", key="preload",
            remedy="for the effect of the preload on the natural frequencies, use analysis: modal with "
            "preload.geometric_stiffness: true",
        )  # fmt: skip
    kinds = [classify_mode(roll.bodies, vector) for vector in vectors.T]
    waves = "" if case.mesh.file is not None else wave_remark(kinds[0].wave_number, case.mesh.circumferential)
    for remark in (waves, edge_remark(case, system)):
        if remark:
            progress.warning(remark)
    dataset = xr.Dataset(
        {
            "load_factor": ("mode", factors),
            "mode_kind": ("mode", np.array([kind.kind for kind in kinds])),
            "mode_harmonic": ("mode", np.array([kind.wave_number for kind in kinds])),
            **shape_variables(roll.bodies, vectors),
        },
        coords={"mode": np.arange(1, len(factors) + 1), "component": ["x", "y", "z"]},
    )
    dataset.attrs |= {
        "dofs": system.n_dofs,
        "interface_points": system.n_points,
        "buckling_load_factor": float(factors[0]),
        "buckling_wave_number": kinds[0].wave_number,
    }
    total = sum(body_pressures(case, system))
    if not roll.web_tension:
        dataset["critical_pressure"] = ("mode", total * factors)
        dataset.attrs["buckling_pressure_pa"] = float(total * factors[0])
    return annotate(dataset)


ANALYSIS = Analysis(
    name="buckling",
    sentence="Linear buckling under the preload.",
    sections=("geometry", "mandrel", "coil", "contact", "preload"),
    run=run_buckling,
    figures=(figures.mode_shapes,),
    fields=(figures.write_modes,),
    variables={
        "mode": ("load_factor", "critical_pressure", "mode_kind", "mode_harmonic"),
        "mode, node, component": ("mode_shape",),
    },
    preflight=preflight.CHECKS["buckling"],
    estimate=estimate_modes,
)
