"""Two masses coupled by friction: response curves, their damping estimates, and the map of the design space."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared.figures import figure
from wroll_fem.results.dataset import annotate
from wroll_fem.signals.estimators import CurveDamping, estimate_damping, lower_bound
from wroll_fem.two_dof import DesignSpace, Response, TwoMasses, design_space, response_map

if TYPE_CHECKING:
    from wroll_fem.case import TwoDofCase
    from wroll_fem.case.two_dof import TwoDof
    from wroll_fem.progress import Progress

SECONDS_PER_MOTION = {"periodic": 1.5e-3, "time": 1.0}
"""Method -> computing time per periodic motion on a 2.5 GHz core, s."""
SECONDS_PER_DESIGN = 0.2

_WORK = ("input", "primary", "secondary", "friction")


def two_masses(section: TwoDof) -> TwoMasses:
    """Two-mass model from the case section `two_dof`."""
    return TwoMasses(
        m1=section.m1, k1=section.k1, c1=section.c1, m2=section.m2, k2=section.k2, c2=section.c2,
        base_amplitude=section.Y0, smoothing=section.smoothing, arrangement=section.arrangement,
        preload_dependent=section.preload_dependent,
    )  # fmt: skip


def run_two_dof(case: TwoDofCase, *, progress: Progress) -> xr.Dataset:
    """Compute the response curves of a case, and the map of its design space.

    Returns
    -------
    xr.Dataset
        `transmissibility` and work per cycle over (friction_capacity, omega); `zeta`, `omega_peak`,
        `peak_transmissibility`, `omega_low`, `omega_high`, `skewness`, `omega_stuck`, `reading_note` over
        friction_capacity, read from curves refined around their peak (method periodic). With `design_space`:
        `zeta_over_design`, `omega_peak_over_design`, `peak_over_design` over (m2, k2, friction_capacity); `zeta_max`
        and `capacity_at_zeta_max` over (m2, k2).

    Raises
    ------
    ConvergenceError
        If a periodic motion is not found.
    """
    section = case.two_dof
    model, omegas = two_masses(section), np.array(section.omega.values)
    capacities = section.friction_capacity
    started = time.perf_counter()
    with progress.stage("two masses", len(capacities)) as stage:
        found = response_map(model, capacities, omegas, method=section.method, on_done=stage.update)
    reads = [estimate_damping(*response.refined, case.output.damping) for response in found]
    for capacity, read in zip(capacities, reads, strict=True):
        for text in () if read.damping.found else read.warnings:
            progress.warning(f"friction capacity {capacity:g} N: {text}".replace(" Hz", " rad/s"))
    dataset = _curves(model, section, omegas, found, reads)
    if section.design_space is not None:
        wanted = section.design_space
        designs = wanted.m2.points * wanted.k2.points * len(capacities)
        with progress.stage("design space", designs) as stage:
            space = design_space(
                model, wanted.m2.values, wanted.k2.values, capacities, points=wanted.points, on_done=stage.update
            )
        dataset = dataset.merge(design_dataset(space), combine_attrs="override")
    return annotate(dataset).assign_attrs(
        {
            "method": {"periodic": "harmonic balance", "time": "time integration"}[section.method],
            "arrangement": section.arrangement,
            "primary_mass_kg": section.m1,
            "primary_stiffness_n_m": section.k1,
            "preload_dependent": section.preload_dependent,
            "solver_time_s": time.perf_counter() - started,
        }
    )


def _curves(
    model: TwoMasses, section: TwoDof, omegas: np.ndarray, found: list[Response], read: list[CurveDamping]
) -> xr.Dataset:
    grid, line = ("friction_capacity", "omega"), "friction_capacity"
    shapes, damping = [r.shape for r in read], [r.damping for r in read]
    data: dict[str, Any] = {
        "transmissibility": (grid, np.array([r.transmissibility for r in found])),
        "zeta": (line, np.array([d.zeta for d in damping])),
        "zeta_error": (line, np.array([d.zeta_error for d in damping])),
        "zeta_lower_bound": (line, np.array([lower_bound(d) for d in damping])),
        "zeta_method": (line, np.array([d.method for d in damping])),
        "omega_peak": (line, np.array([r.f_n if r.resonant else np.nan for r in shapes])),
        "peak_transmissibility": (line, np.array([r.peak if r.resonant else np.nan for r in shapes])),
        "omega_low": (line, np.array([r.f_low for r in shapes])),
        "omega_high": (line, np.array([r.f_high for r in shapes])),
        "skewness": (line, np.array([r.skewness for r in shapes])),
        "omega_stuck": (line, np.array([model.preloaded(c).stuck_frequency for c in section.friction_capacity])),
        "reading_note": (line, np.array([(r.reason or r.note).replace(" Hz", " rad/s") for r in shapes])),
    }
    attrs: dict[str, Any] = {}
    if section.method == "periodic":
        work = {name: np.array([getattr(r, name) for r in found]) for name in _WORK}
        data |= {
            "input_work_per_cycle": (grid, work["input"]),
            "viscous_work_primary": (grid, work["primary"]),
            "viscous_work_secondary": (grid, work["secondary"]),
            "friction_work_per_cycle": (grid, work["friction"]),
            "harmonics": (grid, np.array([r.harmonics for r in found])),
        }
        gap = np.abs(work["input"] - work["primary"] - work["secondary"] - work["friction"]) / work["input"]
        attrs["energy_balance_error"] = float(gap.max())
    return xr.Dataset(data, {"friction_capacity": section.friction_capacity, "omega": omegas}, attrs)


def design_dataset(space: DesignSpace) -> xr.Dataset:
    """Map of the design space: damping ratio, its largest value per design, and the friction capacity at this value."""
    dims, flat = ("m2", "k2", "friction_capacity"), ("m2", "k2")
    known = np.where(np.isfinite(space.zeta), space.zeta, -np.inf)
    best = known.argmax(axis=2)
    largest = np.take_along_axis(known, best[:, :, None], axis=2)[:, :, 0]
    seen = np.isfinite(largest)
    return xr.Dataset(
        {
            "zeta_over_design": (dims, space.zeta),
            "omega_peak_over_design": (dims, space.omega_peak),
            "peak_over_design": (dims, space.transmissibility),
            "zeta_max": (flat, np.where(seen, largest, np.nan)),
            "capacity_at_zeta_max": (flat, np.where(seen, space.capacity[best], np.nan)),
        },
        {"m2": space.m2, "k2": space.k2, "friction_capacity": space.capacity},
    )


def summarise_two_dof(dataset: xr.Dataset) -> dict[str, Any]:
    """Flat summary; lists have one entry per friction capacity, null if the damping cannot be estimated."""

    def listed(name: str) -> list[float | None]:
        return [float(v) if np.isfinite(v) else None for v in dataset[name].values]

    peaks = dataset["peak_transmissibility"]
    lowest = int(np.nanargmin(peaks.values)) if peaks.notnull().any() else None
    summary: dict[str, Any] = {
        "friction_capacity_n": dataset["friction_capacity"].values.tolist(),
        "zeta": listed("zeta"),
        "zeta_method": dataset["zeta_method"].values.tolist(),
        **{name: listed(name) for name in ("zeta_error", "zeta_lower_bound")},
        "omega_peak_rad_s": listed("omega_peak"),
        "peak_transmissibility": listed("peak_transmissibility"),
        "skewness": listed("skewness"),
        "friction_capacity_lowest_peak_n": None if lowest is None else float(peaks["friction_capacity"][lowest]),
        "half_power_reason": [str(text) or None for text in dataset["reading_note"].values],
    }
    if dataset["zeta"].notnull().any():
        at = int(np.nanargmax(dataset["zeta"].values))
        summary["zeta_max"] = float(dataset["zeta"][at])
        summary["friction_capacity_at_zeta_max_n"] = float(dataset["friction_capacity"][at])
    if "zeta_max" in dataset and dataset["zeta_max"].notnull().any():
        top = dataset["zeta_max"].isel(dataset["zeta_max"].argmax(...))  # type: ignore[arg-type]
        summary |= {
            "zeta_max_over_design": float(top),
            "m2_at_zeta_max_kg": float(top["m2"]),
            "k2_at_zeta_max_n_m": float(top["k2"]),
        }
    return summary


def estimate_two_dof(case: TwoDofCase) -> dict[str, Any]:
    """Numbers of periodic motions and response curves, and approximate computing time."""
    import os

    section = case.two_dof
    motions = section.omega.points * len(section.friction_capacity)
    seconds = SECONDS_PER_MOTION[section.method] * motions
    result: dict[str, Any] = {"motions": motions}
    if section.design_space is not None:
        curves = section.design_space.m2.points * section.design_space.k2.points * len(section.friction_capacity)
        seconds += SECONDS_PER_DESIGN * curves
        result["curves_over_design"] = curves
    return result | {"estimated_seconds": 4.5 + seconds / len(os.sched_getaffinity(0))}


ANALYSIS = Analysis(
    name="two_dof",
    sentence="Two masses coupled by friction, under sinusoidal base motion.",
    sections=("two_dof",),
    run=run_two_dof,
    summary=(summarise_two_dof,),
    figures=(
        figure("two_dof", "two_dof"),
        figure("two_dof_readings", "two_dof_readings"),
        figure("two_dof_design_space", "two_dof_design_space", needs="zeta_max"),
    ),
    variables={
        "friction_capacity, omega": ("transmissibility", "friction_work_per_cycle"),
        "friction_capacity": ("zeta", "omega_peak", "peak_transmissibility", "skewness"),
        "m2, k2": ("zeta_max", "capacity_at_zeta_max"),
    },
    plots=("two_dof", "two_dof_readings", "two_dof_design_space", "two_dof_arrangements"),
    estimate=estimate_two_dof,
)
