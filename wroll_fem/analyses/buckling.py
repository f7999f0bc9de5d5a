"""Linear buckling of a roll under its preload: load factors, wave numbers and shapes of the buckling modes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_modes
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.shared.mode_shapes import shape_variables
from wroll_fem.analyses.shared.prestress import body_pressures, contact_state, held_springs, prestressed_roll
from wroll_fem.analyses.shared.springs import linear_springs
from wroll_fem.bodies.mode_shapes import classify_mode
from wroll_fem.case.kinds import BucklingCase
from wroll_fem.errors import InputError
from wroll_fem.results.dataset import annotate

if TYPE_CHECKING:
    from wroll_fem.progress import Progress


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
    estimate=estimate_modes,
)
