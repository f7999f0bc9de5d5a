"""Pictures and files in three dimensions: slip on the cylinder, mode shapes (pyvista, off-screen)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.plotting.slip import in_small_unit, interface_name
from wroll_fem.results import label
from wroll_fem.slip import cylinder_cells, interface_radius, raster, slipping_area_fraction, surface

FloatArray = npt.NDArray[np.float64]
_FIELDS = ("cumulative_slip", "max_slip", "slipped", "peak_slip_hoop", "peak_slip_axial", "pressure")
_VTK_QUAD9 = 28


def _pyvista() -> ModuleType:
    """Import pyvista set up for rendering without a display."""
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    try:
        import pyvista
    except ImportError as error:
        raise InputError(
            f"pictures in three dimensions need pyvista ({error})", remedy='install it: pip install "wroll-fem[view]"'
        ) from error
    return pyvista


def _target(path: str | os.PathLike[str]) -> Path:
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    return target


def slip_surface(
    dataset: xr.Dataset, interface: int
) -> tuple[FloatArray, npt.NDArray[np.int64], dict[str, FloatArray]]:
    """Return an interface as a surface in space.

    Returns
    -------
    points, cells, fields
        (n, 3) Cartesian m, (m, 4) quads or (m, 3) triangles, and name -> (n,) of the slip fields the results hold.
    """
    names = [name for name in _FIELDS if name in dataset]
    points = surface(dataset, interface, *names)
    radius = interface_radius(dataset, interface)
    xyz = np.stack([radius * np.cos(points.theta), radius * np.sin(points.theta), points.z], axis=1)
    return xyz, cylinder_cells(points, radius), points.values


def write_slip_vtu(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write all interfaces with their slip fields as one .vtu file (ParaView, pyvista).

    Parameters
    ----------
    dataset
        Per-point data over (`interface`, `point`).
    path
        Target; parents are made.

    Returns
    -------
    Path
        The file written. Point data: the slip fields in SI and `interface` (0 innermost).

    Raises
    ------
    InputError
        When the Dataset holds no interface.
    """
    import meshio

    count = dataset.sizes.get("interface", 0)
    if count == 0:
        raise InputError("the results hold no interface", remedy="run an analysis with interfaces")
    parts = [slip_surface(dataset, k) for k in range(count)]
    sizes = [part[0].shape[0] for part in parts]
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    cells = [
        ("quad" if part[1].shape[1] == 4 else "triangle", part[1] + start)
        for part, start in zip(parts, starts, strict=True)
    ]
    data = {name: np.concatenate([part[2][name] for part in parts]) for name in parts[0][2]}
    data["interface"] = np.repeat(np.arange(count, dtype=float), sizes)
    target = _target(path)
    meshio.Mesh(np.concatenate([part[0] for part in parts]), cells, point_data=data).write(target, file_format="vtu")
    return target


def _render(
    meshes: Sequence[tuple[Any, dict[str, Any]]], centre: FloatArray, direction: Sequence[float], extent: float
) -> npt.NDArray[np.uint8]:
    """Picture (rows, columns, 3) of meshes with their `add_mesh` options on white."""
    plotter = _pyvista().Plotter(off_screen=True, window_size=(1000, 1000))
    try:
        plotter.set_background("white")
        for mesh, options in meshes:
            plotter.add_mesh(mesh, show_scalar_bar=False, **options)
        plotter.camera.focal_point = centre
        plotter.camera.position = centre + 8.0 * extent * np.asarray(direction) / np.linalg.norm(direction)
        plotter.camera.up = (0.0, 0.0, 1.0)
        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = 0.75 * extent
        plotter.enable_anti_aliasing("ssaa")
        picture = np.asarray(plotter.screenshot(return_img=True))
    finally:
        plotter.close()
    return picture


def _cropped(pictures: list[npt.NDArray[np.uint8]]) -> list[npt.NDArray[np.uint8]]:
    """Crop all pictures to the one box that holds whatever is not white in any: same scale in each."""
    seen = np.argwhere(np.any([(picture < 250).any(axis=2) for picture in pictures], axis=0))
    if seen.size == 0:
        return pictures
    (top, left), (bottom, right) = seen.min(axis=0), seen.max(axis=0)
    return [picture[top : bottom + 1, left : right + 1] for picture in pictures]


def _cylinder_mesh(dataset: xr.Dataset, interface: int, quantity: str) -> tuple[Any, float, str]:
    """Fine mesh of the interface coloured by `quantity` (nan where it stuck), its largest value and the unit."""
    pv = _pyvista()
    points = surface(dataset, interface, quantity, "slipped")
    radius = interface_radius(dataset, interface)
    theta, z, values = raster(points, quantity, radius=radius)
    slipped = raster(points, "slipped", radius=radius)[2]
    shown, unit = in_small_unit(values)
    if quantity == "cumulative_slip":
        shown = np.where(slipped >= 0.5, shown, np.nan)
    angle, height = np.meshgrid(theta, z)
    grid = pv.StructuredGrid(radius * np.cos(angle), radius * np.sin(angle), height)
    grid["value"] = shown.ravel(order="F")
    return grid, float(np.nanmax(shown, initial=0.0)) or 1.0, unit


def plot_slip_on_cylinder(
    dataset: xr.Dataset, path: str | os.PathLike[str], interface: int = 0, quantity: str = "cumulative_slip"
) -> Path:
    """Render an interface with its slip in space, from the excitation direction and from across.

    Parameters
    ----------
    dataset
        Per-point data over (`interface`, `point`): `quantity`, `slipped`, `theta_rad`, `z_m`, `area`.
    path
        PNG to write; parents are made.
    interface
        0 is the innermost.
    quantity
        "cumulative_slip" (grey where the interface stuck) or another length of the field table.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        When pyvista is missing, or the Dataset lacks a field or the interface.
    """
    mesh, largest, unit = _cylinder_mesh(dataset, interface, quantity)
    extent = float(np.ptp(mesh.points, axis=0).max())
    centre = np.asarray(mesh.center)
    options = {
        "scalars": "value", "cmap": "viridis", "clim": (0.0, largest), "nan_color": "#D2D2D2",
        "smooth_shading": True, "ambient": 0.6, "diffuse": 0.42, "specular": 0.0,
    }  # fmt: skip
    direction = dataset.attrs.get("excitation_direction", "x")
    faces, across = ("90°", "0°") if direction == "y" else ("0°", "90°")
    along, over = (1.0, 0.0, 0.25), (0.0, 1.0, 0.25)
    if direction == "y":
        along, over = over, along
    known = direction in ("x", "y")  # a structure from a file does not say
    faces = f"along the excitation ({faces})" if known else f"from {faces}"
    across = f"from across ({across})" if known else f"from {across}"
    views = {f"seen {faces}": along, "seen from 45°": (1.0, 1.0, 0.35), f"seen {across}": over}
    figure = Figure(figsize=(style.WIDTH, 5.2), dpi=style.DPI, layout="constrained")
    panels = figure.subplots(1, len(views))
    pictures = [_render([(mesh.copy(), options)], centre, direction, extent) for direction in views.values()]
    for ax, heading, picture in zip(panels, views, _cropped(pictures), strict=True):
        ax.imshow(picture)
        ax.set_title(heading, fontsize=9)
        ax.axis("off")
    scale = ScalarMappable(Normalize(0.0, largest), "viridis")
    bar = figure.colorbar(scale, ax=list(panels), location="bottom", shrink=0.6, aspect=35, pad=0.02)
    grey = "; grey: never slipped" if quantity == "cumulative_slip" else ""
    bar.set_label(label(quantity, unit) + grey)
    fraction = float(slipping_area_fraction(dataset).isel(interface=interface))
    found = f"Nothing slipped between {interface_name(interface)}"
    if fraction > 0.0:
        most = f"{style.three_digits(largest)} {unit}"
        share = f"{100 * fraction:.0f} % of the area slipped"
        found = f"Between {interface_name(interface)}, {share}; longest slip path {most}"
    figure.suptitle(found, fontsize=10)
    target = _target(path)
    figure.savefig(target)
    return target


def plot_mode_shapes(
    points: FloatArray,
    cells: npt.NDArray[np.int64],
    shapes: FloatArray,
    titles: Sequence[str],
    path: str | os.PathLike[str],
    *,
    columns: int = 5,
) -> Path:
    r"""Render deformed mode shapes side by side, coloured by displacement over its largest value.

    Parameters
    ----------
    points
        (n, 3) m.
    cells
        (m, 9) node numbers in VTK_BIQUADRATIC_QUAD order.
    shapes
        (k, n, 3) displacements of any scale.
    titles
        k titles, for example "1  bending\n148.2 Hz".
    path
        PNG to write; parents are made.
    columns
        Pictures per row.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For arrays that do not match, or when pyvista is missing.

    Notes
    -----
    The largest displacement is drawn as 12 % of the structure's largest extent. Nodes that no cell uses are ignored.
    """
    pv = _pyvista()
    points, shapes = np.asarray(points, dtype=np.float64), np.asarray(shapes, dtype=np.float64)
    if shapes.ndim != 3 or shapes.shape[1:] != points.shape or len(titles) != len(shapes) or len(shapes) == 0:
        raise InputError(
            f"{len(titles)} titles and shapes {shapes.shape} for points {points.shape}",
            remedy="pass (k, n, 3) shapes, (n, 3) points and k titles, k >= 1",
        )
    used = np.unique(cells)
    extent = float(np.ptp(points[used], axis=0).max())
    kinds = np.full(len(cells), _VTK_QUAD9, dtype=np.uint8)
    grid = pv.UnstructuredGrid(np.insert(cells, 0, cells.shape[1], axis=1).ravel(), kinds, points)
    rest = grid.extract_feature_edges(boundary_edges=True, feature_edges=False, manifold_edges=False)
    options = {"scalars": "size", "cmap": "viridis", "clim": (0.0, 1.0), "smooth_shading": True, "ambient": 0.35}
    columns = min(columns, len(shapes))
    rows = -(-len(shapes) // columns)
    figure = Figure(figsize=(style.WIDTH, 0.7 + 2.5 * rows), dpi=style.DPI, layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in panels:
        ax.axis("off")
    pictures = []
    for shape in shapes:
        length = np.linalg.norm(shape, axis=1)
        largest = float(length[used].max()) or 1.0
        deformed = grid.copy()
        deformed.points = points + 0.12 * extent / largest * shape
        deformed["size"] = length / largest
        skin = deformed.extract_surface(nonlinear_subdivision=2, algorithm="dataset_surface")
        edges = {"color": "#777777", "line_width": 2.0}
        parts = [(skin, options), (rest.copy(), edges)]
        pictures.append(_render(parts, np.asarray(grid.center), (0.5, -1.0, 0.45), extent))
    for ax, picture, text in zip(panels, _cropped(pictures), titles, strict=False):
        ax.imshow(picture)
        ax.set_title(text, fontsize=9)
    scale = ScalarMappable(Normalize(0.0, 1.0), "viridis")
    bar = figure.colorbar(scale, ax=list(panels), location="bottom", shrink=0.5, aspect=35, pad=0.02)
    bar.set_label("Displacement over its largest (–); grey rings: at rest")
    target = _target(path)
    figure.savefig(target)
    return target
