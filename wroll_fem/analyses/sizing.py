"""Wall of a mandrel for a margin against yield, with its buckling loads and ratios (thesis, sections 6.2 and 6.3)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.constants import g as GRAVITY

from wroll_fem.analyses.margins.mandrel_wall import (
    READINGS,
    MandrelStress,
    cap_mass,
    tube_of,
    unreachable,
    wall_for_margin,
    walls_of_search,
)
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared.figures import figure
from wroll_fem.errors import InputError
from wroll_fem.results.dataset import annotate

if TYPE_CHECKING:
    from wroll_fem.bodies.tube import Tube
    from wroll_fem.case import SizingCase
    from wroll_fem.case.sizing import Sizing
    from wroll_fem.progress import Progress

THIN_LIMIT = 0.1
"""Wall divided by the radius above which the shell model is a rough one."""
_PLACE = {"peak_stress": "stress", "peak_z": "z", "peak_theta": "theta", "peak_surface": "surface"}


def run_sizing(case: SizingCase, *, progress: Progress) -> xr.Dataset:
    """Compute margins versus wall, the wall of each reading, and the properties of the mandrel with one of these walls.

    Stresses are those of linear shell theory: pressure (wave number 0) and transverse acceleration (wave number 1) are
    superposed. With `sizing.wall`, this wall is evaluated and no wall is searched.

    Returns
    -------
    xr.Dataset
        `margin` (mandrel_thickness, reading); `wall_thickness`, and `peak_stress`, `peak_z`, `peak_theta`,
        `peak_surface` with this wall, over reading; entries of the summary in the attributes.

    Raises
    ------
    InputError
        If no wall between 2e-4 and 0.1 of the diameter has the wanted margin in the reading `sizing.reading`.
    """
    sizing = case.sizing
    stress = MandrelStress(sizing, case.mesh.axial)
    walls = walls_of_search(sizing)
    with progress.stage("margins", len(walls)) as stage:
        curve = []
        for number, wall in enumerate(walls, start=1):
            curve.append(stress.margins(float(wall)))
            stage.update(number)
    found: dict[str, float | None] = dict.fromkeys(READINGS, sizing.wall)
    if sizing.wall is None:
        with progress.stage("walls", len(READINGS)) as stage:
            for number, name in enumerate(READINGS, start=1):
                found[name] = wall_for_margin(partial(stress.margin, name), walls, sizing.margin)
                stage.update(number)
        missing = [name for name in READINGS if found[name] is None]
        for name in sorted(missing, key=lambda name: name != sizing.reading):  # the design reading first
            line = {float(wall): stress.margin(name, float(wall)) for wall in walls}
            _without_wall(case, name, unreachable(line, sizing.margin), progress)
    wall = found[sizing.reading]
    assert wall is not None  # otherwise the search was refused
    dataset = _dataset(stress, walls, curve, found)
    margins = stress.margins(wall)
    dataset.attrs |= {
        "structure": sizing.structure, "wanted_margin": sizing.margin, "searched": sizing.wall is None,
        "design_reading": sizing.reading, "design_wall_m": wall, "mandrel_material": _material(sizing),
        "wall_margins": {name: _or_none(margins[name]) for name in READINGS},
    }  # fmt: skip
    with progress.stage("buckling", 3) as stage:
        dataset.attrs |= _of_the_wall(case, wall, stage.update)
    for text in _doubts(case, dataset.attrs):
        progress.warning(text)
    return annotate(dataset)


def _without_wall(case: SizingCase, name: str, reason: str, progress: Progress) -> None:
    """Refuse the case if the design reading has no wall; warn about any other reading."""
    if name == case.sizing.reading:
        raise InputError(
            f"{name}: {reason}", key="sizing.margin", file=str(case.source) if case.source else None,
            remedy="change the margin, the loads or the material, or set sizing.wall to evaluate a known wall",
        )  # fmt: skip
    progress.warning(f"sizing: {name}: {reason}; its wall is left out (null)")


def _dataset(
    stress: MandrelStress, walls: np.ndarray, curve: list[dict[str, float]], found: dict[str, float | None]
) -> xr.Dataset:
    peaks = [None if (wall := found[name]) is None else stress.peaks(wall)[name] for name in READINGS]
    data: dict[str, Any] = {
        "margin": (
            ("mandrel_thickness", "reading"), np.array([[line[name] for name in READINGS] for line in curve])
        ),
        "wall_thickness": ("reading", np.array([math.nan if (t := found[n]) is None else t for n in READINGS])),
    }  # fmt: skip
    for name, part in _PLACE.items():
        missing = "" if part == "surface" else math.nan
        data[name] = ("reading", np.array([missing if peak is None else getattr(peak, part) for peak in peaks]))
    return xr.Dataset(data, coords={"mandrel_thickness": walls, "reading": list(READINGS)})


def _of_the_wall(case: SizingCase, wall: float, on_done: Any) -> dict[str, Any]:
    """Stiffness, frequencies, ratios and buckling loads of the mandrel with a wall (m)."""
    from wroll_fem.fem.fourier_shell.mandrel import ClampedMandrel, buckling_size, end_zone, graded_heights
    from wroll_fem.fem.fourier_shell.model import FourierShellModel

    sizing = case.sizing
    tube, cap = tube_of(sizing, wall), cap_mass(sizing, wall)
    diameter, inertia = sizing.mandrel_outer_diameter, cap * sizing.mandrel_outer_diameter**2 / 16.0
    model = FourierShellModel(case.mesh.axial)
    heights = graded_heights(tube, case.mesh.axial)
    with_coil = ClampedMandrel(model, tube, heights, cap)
    found = {
        "tip_stiffness_n_per_m": with_coil.tip_stiffness(),
        "mandrel_with_coil_hz": with_coil.bending_frequency(inertia),
        "mandrel_hz": ClampedMandrel(model, replace(tube, extra_mass=0.0), heights, cap).bending_frequency(inertia),
        "end_zone_m": end_zone(tube), "mandrel_mass_kg": tube.mass, "end_cap_mass_kg": cap,
        "aspect_ratio": sizing.length / diameter, "diameter_ratio": diameter / sizing.coil_outer_diameter,
        "thickness_ratio": 2.0 * wall / (sizing.coil_outer_diameter - diameter),
        "mass_ratio": tube.mass / sizing.coil_mass if sizing.coil_mass else None,
    }  # fmt: skip
    return found | _buckling(case, tube, cap, buckling_size(tube, case.mesh.axial), on_done)


def _buckling(case: SizingCase, tube: Tube, cap: float, size: tuple[int, int, bool], on_done: Any) -> dict[str, Any]:
    """Buckling pressure, and factors on the loads of the case."""
    from wroll_fem.fem.fourier_shell.mandrel import ClampedMandrel
    from wroll_fem.fem.fourier_shell.model import FourierShellModel

    cells, waves, resolved = size
    pressure, acceleration = case.sizing.pressure, GRAVITY * case.sizing.acceleration_g
    mandrel = ClampedMandrel(FourierShellModel(cells), tube, np.linspace(0.0, tube.length, cells + 1), cap)
    under_pressure = mandrel.pressure_buckling(waves)
    on_done(1)
    transverse = mandrel.combined_buckling(0.0, acceleration, waves) if resolved else None
    on_done(2)
    both = mandrel.combined_buckling(pressure, acceleration, waves) if resolved and pressure else transverse
    on_done(3)
    return {
        "buckling_pressure_pa": _or_none(under_pressure.factor),
        "buckling_waves": under_pressure.waves,
        "buckling_factor_pressure": _or_none(under_pressure.factor / pressure) if pressure else None,
        "buckling_factor_transverse": None if transverse is None else _or_none(transverse.factor),
        "buckling_factor_combined": None if both is None else _or_none(both.factor),
    }


def _doubts(case: SizingCase, entries: dict[str, Any]) -> Iterator[str]:
    """Warnings about the mandrel with the wall of the design reading."""
    sizing, wall = case.sizing, 1e3 * entries["design_wall_m"]
    factor = entries["buckling_factor_pressure"]
    if factor is not None and factor < 1.0:
        yield (
            f"sizing.pressure: {sizing.pressure:g} Pa exceeds the buckling pressure of the wall of {wall:.3g} mm, "
            f"{entries['buckling_pressure_pa']:.3g} Pa with {entries['buckling_waves']} waves (factor {factor:.2g}): "
            "the margin against yield does not apply; use a thicker wall (sizing.wall) or stiffeners"
        )
    for name, load in (("transverse", "the acceleration"), ("combined", "acceleration and pressure together")):
        value = entries[f"buckling_factor_{name}"]
        if value is None:
            yield (
                f"sizing: buckling under {load} is not computed: the wall of {wall:.3g} mm is too thin for the mesh; "
                "compare the stress with the classical value 0.6 E t/R"
            )
        elif value < 1.0 and (name == "transverse" or factor is None or factor >= 1.0):
            yield (
                f"sizing: the wall of {wall:.3g} mm buckles at {value:.2g} times {load}: the margin against yield does "
                "not apply; use a thicker wall (sizing.wall)"
            )
    edge = entries["wall_margins"]["surface"]
    if edge is not None and edge < 0.0:
        yield (
            f"sizing: with the wall of {wall:.3g} mm the margin of the surface stress in the whole tube is {edge:.2g}, "
            "because the wall bends at its clamped edge; to size for this stress, use sizing.reading: surface"
        )
    structure = entries["mandrel_mass_kg"] + sizing.coil_mass
    if entries["end_cap_mass_kg"] > structure:
        yield (
            f"sizing: the end cap ({entries['end_cap_mass_kg']:.3g} kg) is heavier than mandrel and coil "
            f"({structure:.3g} kg); check sizing.length and sizing.mandrel_outer_diameter"
        )
    radius = 0.5 * sizing.mandrel_outer_diameter - 5e-4 * wall
    if 1e-3 * wall / radius > THIN_LIMIT:
        yield (
            f"sizing: the wall of {wall:.3g} mm exceeds {THIN_LIMIT:g} of its radius: stresses of shell theory are "
            "rough; check them with solid elements"
        )


def _material(sizing: Sizing) -> str:
    """Constants of the material, and which of them are defaults."""
    defaults = [key for key in ("E", "nu", "rho", "yield_stress") if key not in sizing.model_fields_set]
    text = (
        f"E {sizing.E / 1e9:g} GPa, nu {sizing.nu:g}, density {sizing.rho:g} kg/m^3, "
        f"yield stress {sizing.yield_stress / 1e6:g} MPa"
    )
    return f"{text}; defaults: {', '.join(defaults)}" if defaults else text


def _or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def summarise_sizing(dataset: xr.Dataset) -> dict[str, Any]:
    """Walls of the readings, and the places of their largest stresses; other entries are attributes."""

    def listed(name: str) -> dict[str, Any]:
        values = dataset[name].values
        if values.dtype.kind in "fi":
            return {key: _or_none(float(value)) for key, value in zip(READINGS, values, strict=True)}
        return {key: str(value) or None for key, value in zip(READINGS, values, strict=True)}

    found = {
        "peak_stress_pa": listed("peak_stress"), "peak_stress_z_m": listed("peak_z"),
        "peak_stress_theta_rad": listed("peak_theta"), "peak_stress_surface": listed("peak_surface"),
    }  # fmt: skip
    return ({"wall_thickness_m": listed("wall_thickness")} if dataset.attrs["searched"] else {}) | found


def estimate_sizing(case: SizingCase) -> dict[str, Any]:
    """Number of DOFs per wave number and approximate computing time."""
    dofs = 5 * (2 * case.mesh.axial + 1)
    return {"dofs": dofs, "estimated_seconds": 3.0 + 1.2e-3 * dofs}


ANALYSIS = Analysis(
    name="sizing",
    sentence="Wall of a mandrel for a margin against yield, with buckling loads and ratios.",
    sections=("sizing",),
    run=run_sizing,
    summary=(summarise_sizing,),
    figures=(figure("margin", "margin"),),
    variables={
        "mandrel_thickness, reading": ("margin",),
        "reading": ("wall_thickness", "peak_stress", "peak_z", "peak_theta", "peak_surface"),
    },
    plots=("margin",),
    estimate=estimate_sizing,
)
