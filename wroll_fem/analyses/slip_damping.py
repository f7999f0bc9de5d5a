"""Solid coil whose wraps slide: frequency and damping of its resonance versus amplitude, and the response at levels."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.constants import g as GRAVITY

from wroll_fem.analyses.followed_mode import axisymmetric_mode, main_mode
from wroll_fem.analyses.forecasts.computing_time import estimate_modes
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures
from wroll_fem.analyses.shared.resolution import frequency_remark
from wroll_fem.analyses.slip_onset import slip_onset
from wroll_fem.analyses.slip_path import followed_path
from wroll_fem.analyses.slip_results import STRONG, base_acceleration, pressure_change, slip_dataset, with_moduli
from wroll_fem.analyses.slip_structure import WoundCoil, slipping_structure, stress_rows
from wroll_fem.blas import one_thread
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.results.dataset import annotate
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.bodies.body import Body
    from wroll_fem.case import SlipDampingCase
    from wroll_fem.progress import Progress

LARGEST_GAP = 0.01
"""Difference of the ends of a cycle, relative to its amplitude, above which the run warns."""

LEAST_SHARE = 0.4
"""Effective mass of the followed mode, relative to the total mass, below which the run warns; 0.6 for a cantilever."""

STRONG_SHARE = 0.01
"""Fraction of the sliding volume with a strong change of the pressure above which the run warns."""

BEYOND = 1.05
"""The loads end where the base acceleration exceeds the highest level by this factor."""


def run_slip_damping(case: SlipDampingCase, *, progress: Progress) -> xr.Dataset:
    """Follow the mode of a case from the first slip to the amplitude at the highest base acceleration.

    Raises
    ------
    ConvergenceError
        If the first load has no equilibrium.
    InputError
        If a point of the coil has no friction capacity.
    """
    started = time.process_time()
    with progress.stage("mesh and matrices", 1) as stage:
        body, points, system, start = slipping_structure(case)
        between = WoundCoil(case).at(points.points[:, 2])
        stress = stress_rows(body, points, case.coil.solid().stiffness(), between.radial_modulus)
        stage.update(1, f"{system.n_dofs} DOFs, {system.n_points} points")
    with one_thread():
        path = LoadPath(system, start, stress=stress if case.coil.pressure == "varying" else None)
        mode = (main_mode if case.excitation.mode == "bending" else axisymmetric_mode)(system, path)
        held = case.excitation.mode == "bending" or case.coil.base == "clamped"
        highest = BEYOND * GRAVITY * case.excitation.amplitude_g[-1]
        found = followed_path(
            path, mode, lambda found: bool(base_acceleration(path, found, mode, case.damping_ratio)[-1] > highest),
            progress, radius=None if held else points.points[:, 2],
        )  # fmt: skip
    dataset = slip_dataset(system, points, path, found, mode, case)
    dataset = dataset.merge(pressure_change(stress, points, path, found))
    if case.coil.wrap_interfaces is not None:
        dataset = with_moduli(dataset, between)
    _warn(dataset, case, effective_mass(body, path, mode, case), progress)
    if remark := frequency_remark(case, [case.excitation.mode], [dataset.attrs["f_stuck_hz"]], pairs=False):
        progress.warning(remark)
    dataset.attrs |= slip_onset(path, points, mode, case)
    dataset.attrs |= {"solver_time_s": time.process_time() - started, "excitation_direction": case.direction}
    return annotate(dataset)


def effective_mass(body: Body, path: LoadPath, mode: FloatArray, case: SlipDampingCase) -> float:
    """Effective mass of the mode divided by the total mass; in torsion, of moments of inertia."""
    inertia = path.system.mass @ path.system.influence
    total = float(path.system.influence @ inertia) if case.excitation.mode == "torsion" else body.mass_total
    return float(mode @ inertia) ** 2 / total


def _warn(dataset: xr.Dataset, case: SlipDampingCase, share: float, progress: Progress) -> None:
    if case.coil.pressure == "fixed":
        _warn_of_pressure(dataset, progress)
    if bool(dataset["tip_at_level"].isnull().any()):
        progress.warning(
            f"the path ends at {float(dataset['resonant_base_acceleration'][-1]) / GRAVITY:.3g} g, after "
            f"{dataset.sizes['tip_amplitude']} loads: higher levels have no result; lower excitation.amplitude_g"
        )
    gap = float(dataset.attrs.get("cycle_closure", 0.0))
    if gap > LARGEST_GAP:
        progress.warning(
            f"cycles close to {100 * gap:.2g} % of their amplitude only: the motion drifts where the pressure varies, "
            "and frequency and damping are those of a drifting cycle; lower excitation.amplitude_g"
        )
    if share < LEAST_SHARE:
        progress.warning(
            f"the lowest mode that the base excites, {dataset.attrs['f_stuck_hz']:.4g} Hz, carries {100 * share:.2g} % "
            f"of the mass, so that {case.excitation.mode} is not its main motion: other modes matter as much; use a "
            "stiffer shear modulus between the wraps, or modal_transient"
        )


def _warn_of_pressure(dataset: xr.Dataset, progress: Progress) -> None:
    """Warn if the radial stress exceeds half of the pressure in more than `STRONG_SHARE` of the sliding volume."""
    tip = float(np.nanmax(np.append(0.0, dataset["tip_at_level"].values)))
    row = int(np.searchsorted(dataset["tip_amplitude"].values[:-1], tip))
    share, most = (float(dataset[f"pressure_change_{name}"][row]) for name in ("volume_fraction", "max"))
    if share > STRONG_SHARE:
        progress.warning(
            f"at a tip motion of {1e3 * tip:.3g} mm the radial stress of the motion exceeds {100 * STRONG:g} % of the "
            f"pressure between the wraps in {100 * share:.2g} % of the sliding volume ({100 * most:.0f} % of it at "
            "most); the pressure is taken as constant, so that friction there changes during a cycle by as much: "
            "use coil.pressure: varying"
        )


def slip_damping_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Response per level for summary.json, and a sentence on what slip changes."""
    levels = dataset["amplitude_g"].values
    tip, linear = dataset["tip_at_level"].values, dataset["tip_at_level_without_slip"].values
    return {
        "amplitude_g": levels.tolist(),
        "tip_displacement_m": tip.tolist(),
        "tip_displacement_without_slip_m": linear.tolist(),
        "f_resonance_hz": dataset["frequency_at_level"].values.tolist(),
        "zeta_total": dataset["damping_at_level"].values.tolist(),
        "zeta_friction": dataset["friction_damping_at_level"].values.tolist(),
        "slipping_volume_fraction": dataset["slipping_volume_fraction_at_level"].values.tolist(),
        "slip_work_per_cycle_j": dataset["friction_work_at_level"].values.tolist(),
        "slip_work_rt_per_cycle_j": dataset["friction_work_rt_at_level"].values.tolist(),
        "slip_work_rz_per_cycle_j": dataset["friction_work_rz_at_level"].values.tolist(),
        "slip_damping_statement": statement(dataset),
    }


def statement(dataset: xr.Dataset) -> str:
    """Sentence: tip at the highest level with a result, with and without slip; frequency and damping there."""
    known = np.flatnonzero(dataset["tip_at_level"].notnull().values)
    if not known.size:
        return "no level has a result"
    top = dataset.isel(amplitude_g=int(known[-1]))
    g, tip, linear = (float(top[n]) for n in ("amplitude_g", "tip_at_level", "tip_at_level_without_slip"))
    if tip > 0.999 * linear:
        return f"no slip that matters up to {g:g} g: the tip moves by {1e3 * tip:.3g} mm"
    zeta, hertz = 100.0 * float(top["damping_at_level"]), float(top["frequency_at_level"])
    return (
        f"at {g:g} g the tip moves by {1e3 * tip:.3g} mm ({1e3 * linear:.3g} mm without slip), at {hertz:.4g} Hz "
        f"({dataset.attrs['f_stuck_hz']:.4g} Hz without slip), with a damping ratio of {zeta:.3g} %"
    )


ANALYSIS = Analysis(
    name="slip_damping",
    sentence="Solid coil whose wraps slide: frequency and damping of its resonance versus amplitude.",
    sections=("geometry", "mandrel", "coil", "winding", "excitation", "damping_ratio"),
    run=run_slip_damping,
    summary=(slip_damping_summary,),
    figures=(figures.figure("slip_damping", "slip_damping"), figures.slip_work),
    variables={
        "tip_amplitude": (
            "resonance_frequency", "modal_damping", "resonant_base_acceleration", "friction_work_per_cycle",
        ),
        "amplitude_g": ("tip_at_level", "tip_at_level_without_slip", "damping_at_level"),
        "point": ("tip_amplitude_at_slip", "slip_work_density", "friction_capacity"),
    },
    plots=("slip_damping", "slip_work", "slip_work_section", "slip_work_sections", "slip_work_in_coil", "backbone"),
    estimate=estimate_modes,
)  # fmt: skip
