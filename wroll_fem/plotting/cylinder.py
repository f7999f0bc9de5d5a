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

from wroll_fem.errors import InputError
from wroll_fem.plotting.slip import interface_name
from wroll_fem.results import label
from wroll_fem.slip import cylinder_cells, interface_radius, slipping_area_fraction, surface

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


def plot_slip_on_cylinder(
    dataset: xr.Dataset, path: str | os.PathLike[str], interface: int = 0, quantity: str = "cumulative_slip"
) -> Path:
    """Render an interface with its slip in space, seen from the excitation direction, slightly above.

    Parameters
    ----------
    dataset
        Per-point data over (`interface`, `point`).
    path
        PNG to write; parents are made.
    interface
        0 is the innermost.
    quantity
        Length to colour by, shown in micrometres.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        When pyvista is missing, or the Dataset lacks the field or the interface.

    Notes
    -----
    Two views: the face at theta = 0 (excitation direction) and the side at theta = 90 degrees.
    """
    pv = _pyvista()
    xyz, cells, fields = slip_surface(dataset, interface)
    if quantity not in fields:
        raise InputError(f"the results hold no {quantity}", remedy=f"choose one of {', '.join(fields)}")
    mesh = pv.PolyData(xyz, faces=np.insert(cells, 0, cells.shape[1], axis=1).ravel())
    name = label(quantity, "µm")
    mesh[name] = 1e6 * fields[quantity]
    largest = float(np.max(mesh[name])) or 1.0
    height, radius = float(np.ptp(xyz[:, 2])), interface_radius(dataset, interface)
    middle = np.array([0.0, 0.0, float(xyz[:, 2].mean())])
    plotter = pv.Plotter(off_screen=True, shape=(1, 2), window_size=(1100, 820), border=False)
    for column, (heading, direction) in enumerate(
        (("Excitation side, 0°", (1.0, 0.0, 0.22)), ("Across, 90°", (0.0, 1.0, 0.22)))
    ):
        plotter.subplot(0, column)
        plotter.set_background("white")
        bar = {"title": name, "color": "black", "fmt": "%.3g", "n_labels": 5, "width": 0.76, "height": 0.07,
               "position_x": 0.12, "position_y": 0.03, "title_font_size": 20, "label_font_size": 17}  # fmt: skip
        plotter.add_mesh(
            mesh.copy(), scalars=name, cmap="viridis", clim=(0.0, largest), smooth_shading=True, specular=0.1,
            ambient=0.35, show_scalar_bar=column == 0, scalar_bar_args=bar,
        )  # fmt: skip
        edge = pv.Disc(center=(0.0, 0.0, float(xyz[:, 2].min())), inner=1.0 * radius, outer=1.35 * radius, c_res=96)
        plotter.add_mesh(edge, color="#BBBBBB")
        plotter.add_text(heading, position=(0.3, 0.9), viewport=True, color="black", font_size=13)
        plotter.camera.focal_point = middle - [0.0, 0.0, 0.09 * height]
        plotter.camera.position = middle + 6.0 * height * np.asarray(direction)
        plotter.camera.up = (0.0, 0.0, 1.0)
        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = 0.68 * max(height, 2.0 * radius)
    fraction = float(slipping_area_fraction(dataset).isel(interface=interface))
    plotter.subplot(0, 0)
    text = f"Between {interface_name(interface)}: {100 * fraction:.0f} % slipped, at most {largest:.3g} µm"
    plotter.add_text(text, position=(0.03, 0.955), viewport=True, color="black", font_size=13)
    return _screenshot(plotter, path)


def _screenshot(plotter: Any, path: str | os.PathLike[str]) -> Path:
    target = _target(path)
    try:
        plotter.screenshot(str(target))
    finally:
        plotter.close()
    return target


def plot_mode_shapes(
    points: FloatArray,
    cells: npt.NDArray[np.int64],
    shapes: FloatArray,
    titles: Sequence[str],
    path: str | os.PathLike[str],
    *,
    columns: int = 4,
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
    size = float(np.ptp(points, axis=0).max())
    grid = pv.UnstructuredGrid(
        np.insert(cells, 0, cells.shape[1], axis=1).ravel(), np.full(len(cells), _VTK_QUAD9, dtype=np.uint8), points
    )
    used = np.unique(cells)
    columns = min(columns, len(shapes))
    rows = -(-len(shapes) // columns)
    plotter = pv.Plotter(off_screen=True, shape=(rows, columns), window_size=(290 * columns, 400 * rows), border=False)
    name = "displacement over its largest (-)"
    for k in range(rows * columns):
        plotter.subplot(*divmod(k, columns))
        plotter.set_background("white")
        if k >= len(shapes):
            continue
        length = np.linalg.norm(shapes[k], axis=1)
        largest = float(length[used].max()) or 1.0
        deformed = grid.copy()
        deformed.points = points + 0.12 * size / largest * shapes[k]
        deformed[name] = length / largest
        skin = deformed.extract_surface(nonlinear_subdivision=2, algorithm="dataset_surface")
        plotter.add_mesh(
            skin, scalars=name, cmap="viridis", clim=(0.0, 1.0), smooth_shading=True, split_sharp_edges=True,
            ambient=0.3, show_scalar_bar=False,
        )  # fmt: skip
        rest = grid.extract_feature_edges(boundary_edges=True, feature_edges=False, manifold_edges=False)
        plotter.add_mesh(rest, color="#888888", line_width=1.5)
        plotter.add_text(titles[k], position="upper_edge", color="black", font_size=9)
        plotter.camera_position = "xz"
        centre = np.asarray(grid.center)
        plotter.camera.focal_point = centre
        plotter.camera.position = centre + size * np.array([2.6, -4.6, 2.0])
        plotter.camera.up = (0.0, 0.0, 1.0)
        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = 0.72 * size
    return _screenshot(plotter, path)
