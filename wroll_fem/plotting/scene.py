"""Interactive three-dimensional scene of the slip (pyvista)."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import xarray as xr

from wroll_fem.plotting import style
from wroll_fem.plotting.coil_slip_space import cut_coil, level_names
from wroll_fem.plotting.cylinder import slip_surface
from wroll_fem.plotting.mode_shapes import _pyvista, has_display
from wroll_fem.plotting.slip import in_small_unit, over_wraps


def jupyter_backend() -> str:
    """Notebook backend of pyvista: "trame" (interactive) if it is installed and a display exists, else "static"."""
    return "trame" if has_display() and find_spec("trame") is not None else "static"


def slip_scene(dataset: xr.Dataset, interface: int = 0, *, top: float | None = None) -> Any:
    """Three-dimensional scene of the slip in a coil or on an interface.

    A coil is cut in half, and each cell is coloured by the lowest excitation level at which it slips. An interface is
    coloured by its accumulated slip.

    Parameters
    ----------
    dataset
        Results of `modal_transient`, or of a history with interfaces.
    interface
        Index of the interface; 0 is the innermost.
    top
        Height (m) up to which a coil is shown; the whole coil if None.

    Returns
    -------
    pyvista.Plotter
        Call ``scene.show(jupyter_backend=jupyter_backend())`` in a notebook; elsewhere ``scene.show()`` opens a window.

    Raises
    ------
    InputError
        When the Dataset contains no slip, its points do not form a grid, or pyvista is missing.
    """
    coil = "slip_onset" in dataset
    style.require(dataset, ("slip_onset",) if coil else ("cumulative_slip",), "scene of the slip")
    pv = _pyvista()
    scene = pv.Plotter(off_screen=not has_display(), window_size=(1100, 700))
    scene.set_background("white")
    if coil:
        for mesh, options in cut_coil(dataset, float(dataset.attrs["length_m"]) if top is None else top)[0]:
            scene.add_mesh(mesh, show_scalar_bar=False, **options)
        *slips, (never, _) = level_names(dataset).items()
        scene.add_legend([list(entry) for entry in slips], bcolor=None, face="r", size=(0.22, 0.25), loc="upper right")
        text = f"Grey: {never}"
    else:
        points, cells, fields = slip_surface(dataset, interface)
        slip, unit = in_small_unit(fields["cumulative_slip"])
        kind = pv.CellType.QUAD if cells.shape[1] == 4 else pv.CellType.TRIANGLE
        mesh = pv.UnstructuredGrid({kind: cells}, points)
        mesh["slip"] = slip
        # no scalar bar: VTK's formatting of its numbers ends a process that has loaded dolfinx (two C++ string layouts)
        scene.add_mesh(mesh, scalars="slip", cmap=style.SLIP_MAP, show_scalar_bar=False, ambient=0.4)
        text = f"Accumulated slip: 0 (dark) to {slip.max():.3g} {unit} (yellow){over_wraps(dataset, interface)}"
    scene.add_text(text, font_size=10, color="black")
    scene.camera_position = "xz"
    scene.camera.elevation = 20.0
    scene.camera.azimuth = 15.0
    scene.enable_parallel_projection()
    scene.reset_camera()
    return scene
