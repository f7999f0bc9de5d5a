"""Slip of a solid coil in three dimensions: a .vtu file, and a picture rendered by pyvista."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from wroll_fem.mesh.point_grid import coil_cells, coil_grid
from wroll_fem.plotting import style
from wroll_fem.plotting.coil_slip import grid_of, level_colours, levels_to_draw, points_of
from wroll_fem.plotting.mode_shapes import _cropped, _pyvista, _render
from wroll_fem.typing import FloatArray

_FIELDS = ("slip_onset", "shear_resultant", "shear_rz", "shear_rt", "friction_capacity")
STUCK = "#DDDDDD"
"""Colour of points that do not slip."""
_HEXAHEDRON = 12
_NEVER = 1e9  # g; replaces infinity, which the file formats of viewers do not have


def _ends(dataset: xr.Dataset) -> tuple[tuple[float, float], tuple[float, float]]:
    attrs = dataset.attrs
    return (float(attrs["mandrel_radius_m"]), float(attrs["coil_outer_radius_m"])), (0.0, float(attrs["length_m"]))


def _finding(onset: float, top: float, dataset: xr.Dataset) -> str:
    share = 100 * float(dataset["slipping_volume_fraction"].values[-1])
    if share > 0.0:
        return f"Slip starts above {onset:.3g} g; at {top:g} g {share:.2g} % of the coil slips"
    return f"No slip up to {top:g} g" + (f"; it would start above {onset:.3g} g" if np.isfinite(onset) else "")


def write_coil_vtu(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write the coil as a .vtu file: one hexahedron around each quadrature point, with the values at that point.

    Fields: shear components and resultant at 1 g (Pa), friction capacity (Pa), slip onset (g; 1e9 where the shear
    stress is zero), and for each excitation level whether the point slips. Points that do not form a grid are written
    as vertices.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        If the Dataset lacks a field.
    """
    style.require(dataset, (*_FIELDS, "amplitude_g"), "slip map of the coil")
    values = {name: dataset[name].values for name in _FIELDS}
    for g in dataset["amplitude_g"].values:
        values[f"slips_at_{g:g}_g"] = (values["slip_onset"] < g).astype(np.int8)
    values["slip_onset"] = np.minimum(values["slip_onset"], _NEVER)
    points = points_of(dataset)
    grid = coil_grid(points)
    if grid is None:
        theta, z, r = points.T
        where = np.stack([r * np.cos(theta), r * np.sin(theta), z], axis=1)
        return style.write_mesh(
            meshio.Mesh(where, [("vertex", np.arange(len(where))[:, None])], point_data=values), path
        )
    nodes, cells = coil_cells(grid, *_ends(dataset))
    data = {name: [array] for name, array in values.items()}
    return style.write_mesh(meshio.Mesh(nodes, [("hexahedron", cells)], cell_data=data), path)


def _along_x(dataset: xr.Dataset) -> bool:
    return str(dataset.attrs.get("excitation_direction", "x")) == "x"


def _levels(dataset: xr.Dataset) -> FloatArray:
    levels = dataset["amplitude_g"].values
    return np.asarray(levels[levels_to_draw(levels)])


def level_names(dataset: xr.Dataset) -> dict[str, str]:
    """Legend of `cut_coil`: text -> colour, from the lowest excitation level to "no slip"."""
    levels = _levels(dataset)
    names = [f"slips at {g:g} g" for g in levels] + [f"no slip up to {levels[-1]:g} g"]
    return dict(zip(names, [*level_colours(levels.size)[::-1], STUCK], strict=True))


def cut_coil(
    dataset: xr.Dataset, top: float, along: str | None = None
) -> tuple[list[tuple[Any, dict[str, Any]]], float]:
    """Half of the roll up to height ``top`` (m), with the coil coloured by excitation level.

    Each coil cell has the colour of the lowest excitation level at which it slips.

    The cutting plane contains the axis and the direction ``along``, "x" or "y". By default it is that of the
    excitation, where the plane shows the largest axial shear.

    Returns
    -------
    meshes, height
        pyvista meshes with their options for `add_mesh`, and the height (m) of the uppermost cell border.

    Raises
    ------
    InputError
        When the points do not form a grid, or pyvista is missing.
    """
    levels = _levels(dataset)
    values = np.searchsorted(levels, dataset["slip_onset"].values, side="right").astype(float)
    colours = ListedColormap(list(level_names(dataset).values()))
    options = {"cmap": colours, "clim": (-0.5, levels.size + 0.5), "ambient": 0.45}
    return cut_roll(dataset, top, along or ("x" if _along_x(dataset) else "y"), values, options)


def cut_roll(
    dataset: xr.Dataset, top: float, along: str, values: FloatArray, options: dict[str, Any]
) -> tuple[list[tuple[Any, dict[str, Any]]], float]:
    """Half of the roll up to height ``top`` (m), cut along "x" or "y"; ``values`` (n_points,) colour the coil.

    ``options`` are those of `add_mesh` for the coil. For the meshes, the height and the errors see `cut_coil`.
    """
    pv = _pyvista()
    radii, ends = _ends(dataset)
    nodes, cells = coil_cells(grid_of(dataset), radii, ends)
    coil = pv.UnstructuredGrid({_HEXAHEDRON: cells}, nodes)
    coil["values"] = values
    tube = pv.CylinderStructured(
        radius=np.array([0.9, 1.0]) * radii[0], height=ends[1], center=(0, 0, 0.5 * ends[1]), direction=(0, 0, 1),
        theta_resolution=96,
    )  # fmt: skip
    metal: dict[str, Any] = {"color": "#9A9A9A", "ambient": 0.4}
    normal = (0, 1, 0) if along == "x" else (-1, 0, 0)
    part = coil.extract_cells(np.flatnonzero(nodes[cells][:, :, 2].min(axis=1) < top - 1e-9))
    half = part.clip(normal=normal, origin=(0, 0, 0), crinkle=True, invert=False)
    height = float(part.bounds[5])
    stub = tube.clip(normal=(0, 0, 1), origin=(0, 0, height)) if height < ends[1] else tube
    half_tube = stub.clip(normal=normal, origin=(0, 0, 0), invert=False)
    edges = half.extract_feature_edges(boundary_edges=True, manifold_edges=False)
    drawn = [(half, {"scalars": "values", **options}), (half_tube, metal)]
    return [*drawn, (edges, {"color": "#555555", "line_width": 1.5})], height


def draw_pictures(figure: Figure, panels: list[Axes], pictures: Mapping[str, np.ndarray], dataset: xr.Dataset) -> None:
    """Draw rendered pictures (rows, columns, colours) under their headings, and the legend of the excitation levels."""
    for ax, (heading, picture) in zip(panels, pictures.items(), strict=True):
        ax.imshow(picture)
        ax.set_title(heading, fontsize=9)
        ax.axis("off")
    keys = [Patch(facecolor=colour, label=name) for name, colour in level_names(dataset).items()]
    figure.legend(handles=keys, loc="outside lower center", ncol=4, fontsize=8, frameon=False)


def plot_slip_in_coil(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Render half of the coil, in its whole length and near the root.

    Each cell is coloured by the lowest excitation level at which it slips.

    Parameters
    ----------
    dataset
        Results of `modal_transient` on a grid of points.
    path
        PNG to write; parent folders are created.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        When the points do not form a grid, or pyvista is missing.
    """
    (_, outer), ends = _ends(dataset)
    view = (0.25, -1.0, 0.30) if _along_x(dataset) else (1.0, 0.25, 0.30)
    crown = max(2.2 * outer, 1.15 * float(dataset["slip_zone_height"].values[-1]))
    root = min(crown, ends[1])
    pictures = {}
    for heading, top in (("whole coil", ends[1]), (f"cut along the excitation, lowest {1e3 * root:.0f} mm", root)):
        meshes, top = cut_coil(dataset, top)
        extent = max(top, 2.0 * outer)
        pictures[heading] = _cropped([_render(meshes, np.array([0.0, 0.0, 0.5 * top]), view, extent)])[0]
    figure = Figure(figsize=(style.WIDTH, 5.4), dpi=style.DPI, layout="constrained")
    widths = [picture.shape[1] / picture.shape[0] for picture in pictures.values()]
    draw_pictures(figure, list(figure.subplots(1, 2, width_ratios=widths)), pictures, dataset)
    figure.suptitle(
        _finding(float(dataset["slip_onset"].min()), float(dataset["amplitude_g"][-1]), dataset), fontsize=10
    )
    return style.write_figure(figure, path)
