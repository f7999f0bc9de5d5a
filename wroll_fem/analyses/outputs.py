"""What a run leaves behind: summary, fields, figures; everything from the Dataset alone."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ..modes import main_bending
from ..slip import has_surface

if TYPE_CHECKING:
    from ..case import Case

_READINGS = (
    "f_n_hz",
    "zeta",
    "zeta_method",
    "peak_transmissibility",
    "half_power_low_hz",
    "half_power_high_hz",
    "skewness",
)
_COUNTS = (
    "dofs",
    "interface_points",
    "reduced_coordinates",
    "reduction_error_estimate",
    "training_time_s",
    "reduction_tip_error_estimate",
    "folds",
    "branch_points",
    "f_stuck_hz",
    "f_largest_amplitude_hz",
    "zeta_max",
    "tip_amplitude_at_zeta_max_m",
    "base_acceleration_at_zeta_max_m_s2",
    "memory_change",
    "steps",
    "step_cuts",
    "newton_iterations_mean",
    "solver_time_s",
    "mass_total_kg",
)
_WINDING = (
    "pressure_mandrel_pa",
    "capacity_mandrel_pa",
    "mandrel_stiffness_pa",
    "pressure_mandrel_error_estimate",
    "pressure_mandrel_wrap_grid_pa",
    "capacity_mandrel_wrap_grid_pa",
    "hoop_bound_pa",
    "hoop_stress_min_pa",
    "tension_stress_pa",
    "tension_n",
    "outer_radius_m",
)


def energy_balance_error(dataset: xr.Dataset) -> float:
    """|input - kinetic - strain - contact - friction - modulation - numerical| / largest input, at its worst time.

    Dimensionless; every term is computed on its own (the scheme's dissipation from its closed form), so this
    sees unconverged steps, lost slip and wrong bookkeeping.
    """
    stored = dataset["kinetic_energy"] + dataset["strain_energy"] + dataset["contact_energy"]
    spent = dataset["friction_energy"] + dataset["pressure_modulation_work"] + dataset["numerical_dissipation"]
    for name in ("viscous_energy", "impact_dissipation"):
        if name in dataset:
            spent = spent + dataset[name]
    gap = np.abs((dataset["input_work"] - stored - spent).values)
    scale = float(np.abs(dataset["input_work"].values).max())
    return float(gap.max() / scale) if scale > 0 else 0.0


def summarise(dataset: xr.Dataset, case: Case) -> dict[str, Any]:
    """Flat summary in SI, the unit in the name; lists run over interfaces (inner first) or modes."""
    attrs = dataset.attrs
    summary: dict[str, Any] = {"analysis": case.analysis}
    summary |= {key: attrs[key] for key in (*_READINGS, *_COUNTS) if key in attrs}
    summary |= {key: value for key, value in attrs.items() if str(key).startswith("steady_")}
    if "pressure" in dataset:
        area, pressure = dataset["area"], dataset["pressure"]
        mean = (pressure * area).sum("point") / area.sum("point")
        summary["interface_pressure_mean_pa"] = mean.values.tolist()
    summary |= {key: attrs[key] for key in _WINDING if key in attrs}
    if "external_pressure" in dataset:
        summary["external_pressure_pa"] = dataset["external_pressure"].values.tolist()
    if case.preload.kind == "winding_tension" and case.coil.model == "layers":
        from ..winding.interface import target_pressures

        summary["winding_pressure_pa"] = target_pressures(case).tolist()
    if "frequency_disparity" in dataset:
        from .design_map import summarise_design_map

        summary |= summarise_design_map(dataset)
    if "omega_stuck" in dataset:
        from .two_dof import summarise_two_dof

        return summary | summarise_two_dof(dataset)
    if "input_work" in dataset:
        last = dataset.isel(time=-1)
        names = ("friction_energy", "input_work", "numerical_dissipation", "pressure_modulation_work")
        summary |= {f"{name}_j": float(last[name]) for name in (*names, "impact_dissipation") if name in last}
        summary["energy_balance_error"] = energy_balance_error(dataset)
    if "input_work_per_cycle" in dataset:
        summary |= _work_per_cycle(dataset)
    if "cumulative_slip" in dataset:
        from ..slip import slipping_area_fraction

        summary["max_slip_m"] = float(dataset["max_slip"].max())
        summary["slipping_area_fraction"] = slipping_area_fraction(dataset).values.tolist()
    if "slip_onset" in dataset:
        from .modal_transient import slip_summary

        summary |= slip_summary(dataset)
    if "mode_frequency" in dataset:
        fraction = dataset["effective_mass_fraction"]
        if "component" in fraction.dims:
            fraction = fraction.sel(component=case.excitation.direction)
        if "mode_kind" in dataset:
            summary["mode_kinds"] = [str(kind) for kind in dataset["mode_kind"].values]
            index = main_bending(summary["mode_kinds"], fraction.values)
            if index is not None:
                summary["bending_hz"] = float(dataset["mode_frequency"].values[index])
        summary["modes_hz"] = dataset["mode_frequency"].values.tolist()
        summary["effective_mass_fraction"] = fraction.values.ravel().tolist()
    return summary


def _work_per_cycle(dataset: xr.Dataset) -> dict[str, Any]:
    """Work of a period where the response, or the damping of a backbone, is largest."""
    if "modal_damping" in dataset:
        at = int(dataset["modal_damping"].values.argmax())
    else:
        at = int(np.hypot(dataset["transmissibility_real"].values, dataset["transmissibility_imag"].values).argmax())
    names = [f"{part}_work_per_cycle" for part in ("input", "friction", "modulation", "viscous")]
    found: dict[str, Any] = {f"{name}_j": float(dataset[name].values[at]) for name in names}
    return found | {"energy_balance_error": dataset.attrs.get("energy_balance_error")}


def write_fields(dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    """Write .vtu files: slip.vtu (all interfaces), slip_<step>.vtu for kept fields, mode_shapes.vtu."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    if "pressure" in dataset and all(has_surface(dataset, k) for k in range(dataset.sizes["interface"])):
        from ..plotting import write_slip_vtu

        written.append(write_slip_vtu(dataset, folder / "slip.vtu"))
        if "snapshot_time" in dataset.coords:
            for number in range(dataset.sizes["snapshot_time"]):
                step = (number + 1) * case.output.every
                kept = dataset.isel(snapshot_time=number)
                written.append(write_slip_vtu(kept, folder / f"slip_{step:08d}.vtu"))
    if "slip_onset" in dataset:
        from ..plotting.coil_slip_space import write_coil_vtu

        written.append(write_coil_vtu(dataset, folder / "coil_slip.vtu"))
    if "mode_shape" in dataset:
        written.append(_write_modes(dataset, folder / "mode_shapes.vtu"))
    return written


def _write_modes(dataset: xr.Dataset, path: Path) -> Path:
    import meshio

    shapes = {
        f"mode_{k + 1:02d}_{float(f):.1f}Hz_{kind}": shape
        for k, (f, kind, shape) in enumerate(
            zip(
                dataset["mode_frequency"].values, dataset["mode_kind"].values, dataset["mode_shape"].values, strict=True
            )
        )
    }
    cells = [("quad9", dataset["cell_nodes"].values)]
    if "solid_cell_nodes" in dataset:
        cells.append(("hexahedron27", dataset["solid_cell_nodes"].values))
    meshio.Mesh(dataset["node_position"].values, cells, point_data=shapes).write(path, file_format="vtu")
    return path


def write_figures(dataset: xr.Dataset, case: Case, folder: Path) -> list[Path]:
    """Draw what the results hold.

    Pictures of mode shapes need pyvista and are left out without it; slip maps need points that span a cylinder.
    """
    from .. import plotting

    folder.mkdir(parents=True, exist_ok=True)
    drawn: list[tuple[str, Callable[..., Any], dict[str, Any]]] = []
    if "stable" in dataset:
        drawn.append(("transmissibility", plotting.plot_harmonic_response, {}))
    elif "transmissibility_real" in dataset:
        drawn.append(("transmissibility", plotting.plot_transmissibility, {}))
    if "modal_damping" in dataset:
        drawn.append(("backbone", plotting.plot_backbone, {}))
    if "tip_acceleration" in dataset:
        drawn.append(("response", plotting.plot_response, {}))
        drawn.append(("energy_ledger", plotting.plot_energy_ledger, {}))
    if "cumulative_slip" in dataset:
        for number in filter(partial(has_surface, dataset), range(dataset.sizes["interface"])):
            drawn.append((f"slip_map_{number + 1:02d}", plotting.plot_slip_map, {"interface": number}))
            drawn.append((f"peak_slip_{number + 1:02d}", plotting.plot_peak_slip_vectors, {"interface": number}))
    elif "pressure" in dataset:
        for number in filter(partial(has_surface, dataset), range(dataset.sizes["interface"])):
            drawn.append((f"pressure_{number + 1:02d}", plotting.plot_pressure_map, {"interface": number}))
    if "slip_onset" in dataset:
        drawn += _of_the_coil(dataset)
    if "mode_frequency" in dataset:
        drawn.append(("modes", plotting.plot_modes, {}))
    if "omega_stuck" in dataset:
        drawn += [("two_dof", plotting.plot_two_dof, {}), ("two_dof_readings", plotting.plot_two_dof_readings, {})]
    if "zeta_max" in dataset:
        drawn.append(("two_dof_design_space", plotting.plot_two_dof_design_space, {}))
    if "wrap_pressure_pa" in dataset:
        drawn.append(("winding", plotting.plot_winding, {}))
    if "frequency_disparity" in dataset:
        drawn.append(("design_map", plotting.plot_design_map, {}))
    paths = [plotting.save_figure(draw(dataset, **options), folder / f"{name}.png") for name, draw, options in drawn]
    return paths + _draw_in_space(dataset, folder)


def _of_the_coil(dataset: xr.Dataset) -> list[tuple[str, Callable[..., Any], dict[str, Any]]]:
    from ..plotting import coil_slip

    drawn: list[tuple[str, Callable[..., Any], dict[str, Any]]] = [
        ("steady_response", coil_slip.plot_steady_response, {}),
        ("shear_distribution", coil_slip.plot_shear_distribution, {}),
    ]
    if coil_slip.has_grid(dataset):
        drawn.append(("root_section", coil_slip.plot_root_sections, {}))
        drawn.append(("slip_zone", coil_slip.plot_slip_zone, {}))
    return drawn


def _draw_in_space(dataset: xr.Dataset, folder: Path) -> list[Path]:
    from .. import plotting

    if "mode_shape" in dataset and find_spec("pyvista") is not None:
        count = min(10, dataset.sizes["mode"])
        titles = [
            f"{float(f):.1f} Hz  {kind}"
            for f, kind in zip(dataset["mode_frequency"].values, dataset["mode_kind"].values, strict=True)
        ]
        return [
            plotting.plot_mode_shapes(
                dataset["node_position"].values,
                dataset["cell_nodes"].values,
                dataset["mode_shape"].values[:count],
                titles[:count],
                folder / "mode_shapes.png",
            )
        ]
    if "slip_onset" in dataset:
        from ..plotting.coil_slip import has_grid
        from ..plotting.coil_slip_space import plot_slip_in_coil

        wanted = find_spec("pyvista") is not None and has_grid(dataset)
        return [plot_slip_in_coil(dataset, folder / "slip_in_coil.png")] if wanted else []
    if "cumulative_slip" in dataset and has_surface(dataset, 0) and float(dataset["cumulative_slip"].max()) > 0:
        return [plotting.plot_slip_on_cylinder(dataset, folder / "slip_on_cylinder.png")]
    return []
