"""Solid coil whose wraps slide: frequency and damping of its resonance versus amplitude, and the response at levels."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.constants import g as GRAVITY
from scipy.interpolate import PchipInterpolator
from threadpoolctl import threadpool_limits

from wroll_fem.analyses.forecasts.computing_time import estimate_modes
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures
from wroll_fem.analyses.slip_structure import BetweenWraps, WoundCoil, slipping_structure
from wroll_fem.bodies.body import Body
from wroll_fem.coiled_stiff.shear_points import ShearPoints, radial_stress
from wroll_fem.coiled_stiff.wrap_stiffness import radial_change
from wroll_fem.contact.kernels import SLIP
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.dynamics.statics.modal_path import ModalPath, modal_path
from wroll_fem.results.dataset import annotate
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import SlipDampingCase
    from wroll_fem.dynamics.system.system import System
    from wroll_fem.progress import Progress

JUST_BELOW = 1.0 - 1e-6
"""First load, relative to that of the first slip: nothing slides yet."""

LEAST_SHARE = 0.4
"""Effective mass of the followed mode, relative to the total mass, below which the run warns; 0.6 for a cantilever."""

STRONG, STRONG_SHARE = 0.5, 0.01
"""Radial stress, relative to the pressure, that counts as a strong change of the pressure; fraction of the sliding
volume with a strong change above which the run warns."""

GROWTH, BEYOND, MOST_LEVELS = 1.18, 1.05, 80
"""Ratio of successive loads; the loads end where the base acceleration exceeds `BEYOND` times the highest level; most
of them."""


def run_slip_damping(case: SlipDampingCase, *, progress: Progress) -> xr.Dataset:
    """Follow the main bending mode from the first slip to the amplitude at the highest base acceleration.

    Raises
    ------
    ConvergenceError
        If a load has no equilibrium.
    InputError
        If a point of the coil has no friction capacity.
    """
    started = time.process_time()
    with progress.stage("mesh and matrices", 1) as stage:
        body, points, system, start = slipping_structure(case)
        stage.update(1, f"{system.n_dofs} DOFs, {system.n_points} points")
    with threadpool_limits(1, "blas"), progress.stage("slip path", MOST_LEVELS) as stage:
        path = LoadPath(system, start)
        mode = main_mode(system, path)
        levels = [JUST_BELOW]
        found = modal_path(path, mode, levels, keep=True)
        highest = BEYOND * GRAVITY * case.excitation.amplitude_g[-1]
        while len(levels) < MOST_LEVELS:
            if base_acceleration(path, found, mode, case.damping_ratio)[-1] > highest:
                break
            levels.append(GROWTH * levels[-1])
            found = found.joined(modal_path(path, mode, levels[-1:], keep=True, after=found))
            stage.update(len(levels), f"{len(path.vectors)} basis vectors")
        stage.update(MOST_LEVELS, f"{len(levels)} amplitudes, {len(path.vectors)} basis vectors")
    between = WoundCoil(case).at(points.points[:, 2])
    dataset = slip_dataset(system, points, path, found, mode, case).merge(
        pressure_change(body, points, path, found, case.coil.solid().stiffness(), between.radial_modulus)
    )
    if case.coil.wrap_interfaces is not None:
        dataset = with_moduli(dataset, between)
    _warn_of_pressure(dataset, progress)
    if bool(dataset["tip_at_level"].isnull().any()):
        progress.warning(
            f"the path ends at {float(dataset['resonant_base_acceleration'][-1]) / GRAVITY:.3g} g, after {len(levels)} "
            "loads: higher levels have no result; lower excitation.amplitude_g"
        )
    share = float(mode @ (system.mass @ system.influence)) ** 2 / body.mass_total
    if share < LEAST_SHARE:
        progress.warning(
            f"the lowest mode that the base excites, {dataset.attrs['f_stuck_hz']:.4g} Hz, carries {100 * share:.2g} % "
            "of the mass, so that bending is not its main motion: other modes matter as much; use a stiffer shear "
            "modulus between the wraps, or modal_transient"
        )
    dataset.attrs |= {"solver_time_s": time.process_time() - started, "excitation_direction": case.direction}
    return annotate(dataset)


def main_mode(system: System, path: LoadPath) -> FloatArray:
    """(n,) lowest mode that the base excites, with sticking wraps; unit modal mass. By inverse iteration."""
    mode, before = path.stuck(system.mass @ system.influence), np.inf
    while True:
        mode = path.stuck(system.mass @ mode)
        mode /= np.sqrt(mode @ (system.mass @ mode))
        square = float(mode @ (path.stiffness @ mode))
        if before - square <= 1e-13 * square:
            return mode
        before = square


def viscous_work(path: LoadPath, found: ModalPath, mode: FloatArray, damping_ratio: float) -> FloatArray:
    """(k,) energy that the dashpot of the mode dissipates in a cycle, J; ``damping_ratio`` is that without slip."""
    natural = np.sqrt(mode @ (path.stiffness @ mode))
    return np.asarray(2.0 * np.pi * damping_ratio * natural * found.frequency * found.amplitude**2)


def displacements(path: LoadPath, found: ModalPath) -> FloatArray:
    """(k, n) displacement of each state of a path from rest, m."""
    return np.array([state.displacement - path.start.displacement for state in found.states])


def base_acceleration(path: LoadPath, found: ModalPath, mode: FloatArray, damping_ratio: float) -> FloatArray:
    """(k,) base acceleration, m/s^2, whose work at resonance is the energy dissipated in a cycle of each amplitude."""
    dissipated = found.dissipation + viscous_work(path, found, mode, damping_ratio)
    moving = np.abs(displacements(path, found) @ (path.system.mass @ path.system.influence))
    return np.asarray(dissipated / (np.pi * moving))


def slip_dataset(
    system: System, points: ShearPoints, path: LoadPath, found: ModalPath, mode: FloatArray, case: SlipDampingCase
) -> xr.Dataset:
    """Dataset of frequency and damping versus `tip_amplitude`, response versus `amplitude_g`, and slip in the coil."""
    zeta = case.damping_ratio
    tip = np.abs(displacements(path, found) @ system.probes["tip"])
    base = base_acceleration(path, found, mode, zeta)
    viscous = viscous_work(path, found, mode, zeta)
    material = viscous / (2.0 * np.pi * (found.frequency * found.amplitude) ** 2)
    total = found.damping + material
    laws, start = system.laws, path.start
    limit = laws.mu * start.pressure
    slides = np.array([state.status == SLIP for state in found.states])
    slip = tangentials(found.states[-1].jump) - found.states[-1].elastic_slip.reshape(-1, 2)
    levels = np.array(case.excitation.amplitude_g)
    natural = float(np.sqrt(mode @ (path.stiffness @ mode)))
    participation = float((mode @ (system.mass @ system.influence)) * (system.probes["tip"] @ mode))
    linear = abs(participation) * GRAVITY * levels / (2.0 * zeta * natural**2)
    stuck = GRAVITY * levels <= base[0]
    at = np.where(stuck, linear, _between(0.0, base, 0.0, tip)(GRAVITY * levels))
    frequency = _between(0.0, tip, natural, found.frequency)(at) / (2.0 * np.pi)
    damping = np.where(stuck, zeta, _between(0.0, tip, zeta, total)(at))
    onset = np.where(slides.any(axis=0), tip[slides.argmax(axis=0)], np.nan)
    most = int(np.argmax(total))
    area = laws.area / points.volumes
    dataset = xr.Dataset(
        {
            "resonance_frequency": ("tip_amplitude", found.frequency / (2.0 * np.pi)),
            "modal_damping": ("tip_amplitude", total),
            "friction_modal_damping": ("tip_amplitude", found.damping),
            "material_modal_damping": ("tip_amplitude", material),
            "resonant_base_acceleration": ("tip_amplitude", base),
            "friction_work_per_cycle": ("tip_amplitude", found.dissipation),
            "material_damping_work_per_cycle": ("tip_amplitude", viscous),
            "slipping_volume_fraction": ("tip_amplitude", slides @ points.volumes / points.volumes.sum()),
            "tip_at_level": ("amplitude_g", at),
            "tip_at_level_without_slip": ("amplitude_g", linear),
            "frequency_at_level": ("amplitude_g", frequency),
            "damping_at_level": ("amplitude_g", damping),
            "theta_rad": ("point", points.points[:, 0]),
            "z_m": ("point", points.points[:, 1]),
            "r_m": ("point", points.points[:, 2]),
            "volume": ("point", points.volumes),
            "friction_capacity": ("point", limit),
            "tip_amplitude_at_slip": ("point", onset),
            "slip_work_density": ("point", 4.0 * limit * np.linalg.norm(slip, axis=1) * area),
        },
        coords={"tip_amplitude": tip, "amplitude_g": levels},
    )
    dataset.attrs |= {
        "f_stuck_hz": natural / (2.0 * np.pi),
        "f_largest_amplitude_hz": float(found.frequency[-1] / (2.0 * np.pi)),
        "zeta_max": float(total[most]),
        "tip_amplitude_at_zeta_max_m": float(tip[most]),
        "base_acceleration_at_zeta_max_m_s2": float(base[most]),
        "dofs": system.n_dofs,
        "interface_points": system.n_points,
        "reduced_coordinates": len(path.vectors),
        "reduction_error_estimate": float(found.error.max()),
        "branch_points": len(tip),
        "method": "quasi-static modal path, Masing's rule",
        "mandrel_radius_m": 0.5 * case.geometry.mandrel_outer_diameter,
        "coil_outer_radius_m": 0.5 * case.geometry.mandrel_outer_diameter + case.coil.total_thickness,
        "length_m": case.geometry.length,
    }
    return dataset


def pressure_change(
    body: Body, points: ShearPoints, path: LoadPath, found: ModalPath, stiffness: FloatArray, modulus: FloatArray
) -> xr.Dataset:
    """Radial stress of the motion relative to the pressure between the wraps, where they slide, versus `tip_amplitude`.

    The path takes the pressure as constant. ``stiffness`` (6, 6), Pa, is that of the coil with the radial modulus of
    its material, ``modulus`` (n,), Pa, the radial modulus at the points.
    """
    assert body.solid is not None
    rows = radial_stress(body.solid, stiffness)
    rows = rows[points.kept] if points.kept is not None else rows
    stress = (rows @ (body.solid.expand @ displacements(path, found).T)).T * radial_change(modulus, stiffness)
    change = np.abs(stress) / path.start.pressure
    slides = np.array([state.status == SLIP for state in found.states])
    strong = (slides & (change > STRONG)) @ points.volumes
    return xr.Dataset(
        {
            "pressure_change_max": ("tip_amplitude", np.where(slides, change, 0.0).max(axis=1)),
            "pressure_change_volume_fraction": (
                "tip_amplitude", strong / np.maximum(slides @ points.volumes, np.finfo(float).tiny),
            ),
        }
    )  # fmt: skip


def with_moduli(dataset: xr.Dataset, between: BetweenWraps) -> xr.Dataset:
    """Dataset with the moduli between the wraps at its points, and the range of the shear modulus as attributes."""
    shear, radial = between.shear_modulus, between.radial_modulus
    dataset = dataset.assign(interlayer_shear_modulus=("point", shear), interlayer_radial_modulus=("point", radial))
    return dataset.assign_attrs(
        interlayer_shear_modulus_min_pa=float(shear.min()), interlayer_shear_modulus_max_pa=float(shear.max())
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
            "most); the pressure is taken as constant, so that friction there changes during a cycle by as much"
        )


def _between(x_0: float, x: FloatArray, y_0: float, y: FloatArray) -> PchipInterpolator:
    """Function through (x_0, y_0) and the points ``x``, ``y`` (k,); NaN beyond the last one."""
    return PchipInterpolator(np.append(x_0, x), np.append(y_0, y), extrapolate=False)


def slip_damping_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Response per level for summary.json, and a sentence on what slip changes."""
    levels = dataset["amplitude_g"].values
    tip, linear = dataset["tip_at_level"].values, dataset["tip_at_level_without_slip"].values
    return {
        "amplitude_g": levels.tolist(),
        "tip_at_level_m": tip.tolist(),
        "tip_at_level_without_slip_m": linear.tolist(),
        "frequency_at_level_hz": dataset["frequency_at_level"].values.tolist(),
        "damping_at_level": dataset["damping_at_level"].values.tolist(),
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
    plots=("slip_damping", "slip_work", "backbone"),
    estimate=estimate_modes,
)  # fmt: skip
