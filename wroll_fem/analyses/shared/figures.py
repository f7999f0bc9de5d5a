"""Shared figures (.png) and fields (.vtu) of analyses; matplotlib and pyvista are imported on use."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import xarray as xr

from wroll_fem.results.interface_slip import has_surface


def figure(stem: str, name: str, *, needs: str = "", without: str = "") -> Callable[[xr.Dataset, Path], list[Path]]:
    """Return a function that draws a figure of `wroll_fem.plot` and saves it.

    Parameters
    ----------
    stem
        Name of the file without .png.
    name
        Name of the figure.
    needs
        Variable that the figure needs; without it, the figure is not drawn.
    without
        Dimension with which the figure is not drawn.
    """

    def part(dataset: xr.Dataset, folder: Path) -> list[Path]:
        drawn = (not needs or needs in dataset) and (not without or without not in dataset.dims)
        return [_save(stem, name, dataset, folder)] if drawn else []

    return part


def _save(stem: str, name: str, dataset: xr.Dataset, folder: Path, **options: Any) -> Path:
    from wroll_fem.plotting import names

    return names.save(getattr(names, name)(dataset, **options), folder / f"{stem}.png")


def _surfaces(dataset: xr.Dataset) -> list[int]:
    """Indices of the interfaces that can be drawn as a map, because their points span a cylinder (`has_surface`)."""
    count = dataset.sizes["interface"] if "pressure" in dataset else 0
    return [number for number in range(count) if has_surface(dataset, number)]


def _at_one_level(dataset: xr.Dataset) -> xr.Dataset:
    """Results at the highest of several levels."""
    return dataset.isel(level=-1) if "level" in dataset.dims else dataset


def slip_maps(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the slip map and the vectors of the largest relative displacement for every interface, slip in a coil."""
    dataset = _at_one_level(dataset)
    kinds = (("slip_map", "slip_map"), ("peak_slip", "peak_slip_vectors"))
    return _slip_between_wraps(dataset, folder) + [
        _save(f"{stem}_{number + 1:02d}", function, dataset, folder, interface=number)
        for number in _surfaces(dataset)
        for stem, function in kinds
    ]


def _slip_between_wraps(dataset: xr.Dataset, folder: Path) -> list[Path]:
    from wroll_fem.plotting.wrap_slip import has_wraps

    return [_save("wrap_slip", "wrap_slip", dataset, folder)] if has_wraps(dataset) else []


def pressure_maps(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the pressure on every interface."""
    return [
        _save(f"pressure_{number + 1:02d}", "pressure_map", dataset, folder, interface=number)
        for number in _surfaces(dataset)
    ]


def slip_in_space(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the slip of the innermost interface on the roll, if there is slip."""
    from wroll_fem.plotting.names import slip_on_cylinder

    dataset = _at_one_level(dataset)
    if 0 not in _surfaces(dataset) or not float(dataset["cumulative_slip"].max()) > 0:
        return []
    return [slip_on_cylinder(dataset, folder / "slip_on_cylinder.png")]


def _mode_values(dataset: xr.Dataset) -> tuple[list[float], list[int], list[str]]:
    """Frequency or buckling load factor of each mode, with the number of decimals and the unit for display."""
    name, digits, unit = ("load_factor", 3, "x preload") if "load_factor" in dataset else ("mode_frequency", 1, "Hz")
    values = dataset[name].values.tolist()
    return values, [digits] * len(values), [unit] * len(values)


def mode_shapes(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the first ten mode shapes; nothing is drawn for matrices from a file, which come without a mesh."""
    from wroll_fem.plotting.names import mode_shapes as draw

    if "mode_shape" not in dataset or find_spec("pyvista") is None:
        return []
    first = dataset.isel(mode=slice(10))
    values = zip(*_mode_values(first), first["mode_kind"].values, strict=True)
    titles = [f"{value:.{digits}f} {unit}  {kind}" for value, digits, unit, kind in values]
    nodes, cells, shapes = (first[name].values for name in ("node_position", "cell_nodes", "mode_shape"))
    return [draw(nodes, cells, shapes, titles, folder / "mode_shapes.png")]


def coil_sections(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the shear stress at the root and the slip zone, if the points of the coil form a grid."""
    from wroll_fem.plotting.coil_slip import has_grid

    kinds = (("root_section", "root_sections"), ("slip_zone", "slip_zone"))
    return [_save(*kind, dataset, folder) for kind in kinds] if has_grid(dataset) else []


def slip_work(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw slip zone and slip work of a coil whose wraps slide: over radius and height, near the root, and in space.

    Nothing is drawn if its points form no grid.
    """
    from wroll_fem.plotting.coil_slip import has_grid

    if not has_grid(dataset):
        return []
    drawn = [_save(name, name, dataset, folder) for name in ("slip_work", "slip_work_sections")]
    if find_spec("pyvista") is None:
        return drawn
    from wroll_fem.plotting.names import slip_work_in_coil

    return [*drawn, slip_work_in_coil(dataset, folder / "slip_work_in_coil.png")]


def coil_in_space(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the slip zone in a cutaway coil, if its points form a grid."""
    from wroll_fem.plotting.coil_slip import has_grid
    from wroll_fem.plotting.names import slip_in_coil

    wanted = find_spec("pyvista") is not None and has_grid(dataset)
    return [slip_in_coil(dataset, folder / "slip_in_coil.png")] if wanted else []


def write_slip(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Write slip.vtu (all interfaces), and slip_<step>.vtu for stored fields."""
    dataset = _at_one_level(dataset)
    if "pressure" not in dataset or len(_surfaces(dataset)) < dataset.sizes["interface"]:
        return []
    from wroll_fem.plotting.names import write_slip_vtu

    written = [write_slip_vtu(dataset, folder / "slip.vtu")]
    for number in range(dataset.sizes.get("snapshot_time", 0)):
        step = (number + 1) * int(dataset.attrs["output_every"])
        written.append(write_slip_vtu(dataset.isel(snapshot_time=number), folder / f"slip_{step:08d}.vtu"))
    return written


def write_coil(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Write coil_slip.vtu: shear stress, friction capacity and slip onset in the coil."""
    from wroll_fem.plotting.coil_slip_space import write_coil_vtu

    return [write_coil_vtu(dataset, folder / "coil_slip.vtu")]


def write_modes(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Write mode_shapes.vtu; matrices from a file have none."""
    if "mode_shape" not in dataset:
        return []
    import meshio

    names = zip(*_mode_values(dataset), dataset["mode_kind"].values, strict=True)
    shapes = {
        f"mode_{k:02d}_{value:.{digits}f}{unit.replace(' ', '_')}_{kind}": shape
        for k, ((value, digits, unit, kind), shape) in enumerate(
            zip(names, dataset["mode_shape"].values, strict=True), start=1
        )
    }
    cells = [("quad9", dataset["cell_nodes"].values)]
    if "solid_cell_nodes" in dataset:
        cells.append(("hexahedron27", dataset["solid_cell_nodes"].values))
    path = folder / "mode_shapes.vtu"
    meshio.Mesh(dataset["node_position"].values, cells, point_data=shapes).write(path, file_format="vtu")
    return [path]
