"""Three-dimensional pictures of mode shapes, rendered by pyvista without a window."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from wroll_fem.errors import InputError
from wroll_fem.plotting import style
from wroll_fem.typing import FloatArray

_VTK_QUAD9 = 28


def has_display() -> bool:
    """Whether a display is available on which a window can open."""
    return sys.platform in ("win32", "darwin") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _pyvista() -> ModuleType:
    """Import pyvista; without a display, set it up for off-screen rendering."""
    if not has_display():
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    try:
        import pyvista
    except ImportError as error:
        raise InputError(
            f"pictures in three dimensions need pyvista ({error})", remedy='install it: pip install "wroll-fem[view]"'
        ) from error
    return pyvista


def _render(
    meshes: Sequence[tuple[Any, dict[str, Any]]], centre: FloatArray, direction: Sequence[float], extent: float
) -> npt.NDArray[np.uint8]:
    """Picture (rows, columns, 3) of meshes on white; each mesh comes with its options for pyvista's `add_mesh`."""
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
    """Crop all pictures to the common bounding box of their contents, so that they share one scale."""
    seen = np.argwhere(np.any([(picture < 250).any(axis=2) for picture in pictures], axis=0))
    if seen.size == 0:
        return pictures
    (top, left), (bottom, right) = seen.min(axis=0), seen.max(axis=0)
    return [picture[top : bottom + 1, left : right + 1] for picture in pictures]


def _deformed(points: FloatArray, cells: npt.NDArray[np.int64], shapes: FloatArray) -> list[npt.NDArray[np.uint8]]:
    """Render the structure deformed by each of the shapes (k, n, 3), with its undeformed edges in grey."""
    used = np.unique(cells)
    extent = float(np.ptp(points[used], axis=0).max())
    kinds = np.full(len(cells), _VTK_QUAD9, dtype=np.uint8)
    grid = _pyvista().UnstructuredGrid(np.insert(cells, 0, cells.shape[1], axis=1).ravel(), kinds, points)
    rest = grid.extract_feature_edges(boundary_edges=True, feature_edges=False, manifold_edges=False)
    if rest.n_points == 0:  # a closed surface has no boundary edges: draw its sharp edges instead
        rest = grid.extract_feature_edges(
            60.0, boundary_edges=False, non_manifold_edges=False, feature_edges=True, manifold_edges=False
        )
    options = {"scalars": "size", "cmap": "viridis", "clim": (0.0, 1.0), "smooth_shading": True, "ambient": 0.35}
    pictures = []
    for shape in shapes:
        length = np.linalg.norm(shape, axis=1)
        largest = float(length[used].max()) or 1.0
        deformed = grid.copy()
        deformed.points = points + 0.12 * extent / largest * shape
        deformed["size"] = length / largest
        skin = deformed.extract_surface(nonlinear_subdivision=2, algorithm="dataset_surface")
        parts = [(skin, options), (rest.copy(), {"color": "#777777", "line_width": 2.0})]
        pictures.append(_render(parts, np.asarray(grid.center), (0.5, -1.0, 0.45), extent))
    return pictures


def plot_mode_shapes(
    points: FloatArray,
    cells: npt.NDArray[np.int64],
    shapes: FloatArray,
    titles: Sequence[str],
    path: str | os.PathLike[str],
    *,
    columns: int = 5,
) -> Path:
    r"""Render mode shapes side by side; the colour shows the displacement divided by its largest value.

    Parameters
    ----------
    points
        (n, 3) coordinates of the nodes, m.
    cells
        (m, 9) node numbers in VTK_BIQUADRATIC_QUAD order.
    shapes
        (k, n, 3) displacements of any scale.
    titles
        k titles, for example "1  bending\n148.2 Hz".
    path
        PNG file to write; parent folders are created.
    columns
        Largest number of pictures per row.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        If the arrays do not match, or pyvista is missing.

    Notes
    -----
    The largest displacement is drawn as 12 % of the structure's largest extent. Nodes that no cell uses are ignored.
    """
    _pyvista()
    points, shapes = np.asarray(points, dtype=np.float64), np.asarray(shapes, dtype=np.float64)
    if shapes.ndim != 3 or shapes.shape[1:] != points.shape or len(titles) != len(shapes) or len(shapes) == 0:
        raise InputError(
            f"{len(titles)} titles, shapes {shapes.shape} and points {points.shape} do not match",
            remedy="pass (k, n, 3) shapes, (n, 3) points and k titles, k >= 1",
        )
    columns = min(columns, len(shapes))
    rows = -(-len(shapes) // columns)
    figure = Figure(figsize=(style.WIDTH, 0.7 + 2.5 * rows), dpi=style.DPI, layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in panels:
        ax.axis("off")
    for ax, picture, text in zip(panels, _cropped(_deformed(points, cells, shapes)), titles, strict=False):
        ax.imshow(picture)
        ax.set_title(text, fontsize=9)
    scale = ScalarMappable(Normalize(0.0, 1.0), "viridis")
    bar = figure.colorbar(scale, ax=list(panels), location="bottom", shrink=0.5, aspect=35, pad=0.02)
    bar.set_label("Displacement / largest displacement (–); grey: undeformed edges")
    return style.write_figure(figure, path)
