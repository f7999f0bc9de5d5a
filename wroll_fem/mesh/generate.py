"""Meshes of the wound roll: concentric mid-surfaces of order-2 quads with matching nodes (gmsh).

The roll's axis is z, the base lies at z = 0. Each shell (the mandrel and every coil layer) is a
tube on its mid-surface; all tubes have the same divisions, so their nodes are radial scalings of
each other in the same order, and the nodes are mirrored about the x-z plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import gmsh
import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.mesh.files import extract_mesh, gmsh_model, read_mesh
from wroll_fem.mesh.shells import CylinderMesh, canonical_vertices
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import Case

_MATCH_TOLERANCE = 1e-6  # of the radius or length: a user's own mesh against the case's geometry


def part_name(index: int) -> str:
    """Name of the shell `index`: 0 is the mandrel, k > 0 the layer k, counted from the inside."""
    return "mandrel" if index == 0 else f"layer_{index:02d}"


def shell_layout(case: Case) -> list[tuple[str, float, float]]:
    """Name, mid-surface radius (m) and thickness (m) of each shell of a case, inner first."""
    outer, thickness = 0.5 * case.geometry.mandrel_outer_diameter, case.geometry.mandrel_thickness
    layout = [("mandrel", outer - 0.5 * thickness, thickness)]
    if case.coil.model in ("layers", "bonded"):
        t_layer = case.coil.total_thickness / case.coil.layers
        layout += [(part_name(k), outer + (k - 0.5) * t_layer, t_layer) for k in range(1, case.coil.layers + 1)]
    return layout


def axial_stations(length: float, divisions: int, grading: float = 1.0) -> FloatArray:
    """Heights (divisions + 1,) in m of the element borders, in geometric progression away from the root.

    `grading` is the height of the topmost element over that of the root element.
    """
    ratio = grading ** (1.0 / (divisions - 1)) if divisions > 1 else 1.0
    heights = ratio ** np.arange(divisions)
    return length * np.concatenate([[0.0], np.cumsum(heights) / heights.sum()])


def build_mesh(case: Case) -> CylinderMesh:
    """Mesh of a case: read from `case.mesh.file` if given, else made by gmsh.

    Raises
    ------
    InputError
        If a user's own mesh lacks groups, has other cells or does not fit the case's geometry, or if the case works in
        harmonics around the axis.
    """
    if case.mesh.discretisation == "fourier":
        raise InputError(
            "harmonics around the axis have no mesh of the roll, and no matrices of all harmonics together",
            key="mesh.discretisation", remedy="use three_dimensional for that",
        )  # fmt: skip
    layout = shell_layout(case)
    if case.mesh.file is not None:
        mesh = read_mesh(case.mesh.file, required=[name for name, _, _ in layout])
        check_geometry(mesh, layout, case.geometry.length, str(case.mesh.file))
        return mesh
    return make_cylinders(
        [(name, radius) for name, radius, _ in layout],
        case.geometry.length,
        case.mesh.circumferential,
        case.mesh.axial,
        case.mesh.grading,
    )


def check_geometry(mesh: CylinderMesh, layout: Sequence[tuple[str, float, float]], length: float, source: str) -> None:
    """Compare a user's own mesh with the mid-surfaces and the length of the case.

    Raises
    ------
    InputError
        If a shell's nodes are off its mid-surface radius, its ends off z = 0 or z = `length`, or
        facing surfaces do not have the same vertices.
    """
    reference: FloatArray | None = None
    for name, radius, _ in layout:
        part = mesh.part(name)
        off = np.abs(np.hypot(part.nodes[:, 0], part.nodes[:, 1]) - radius).max()
        if off > _MATCH_TOLERANCE * radius:
            raise InputError(
                f"nodes of {name} are up to {off:.3g} m off its mid-surface radius {radius:.9g} m",
                key="mesh.file",
                file=source,
                remedy="mesh the mid-surfaces of the case's geometry, axis z, in metres",
            )
        for end, height in (("base", 0.0), ("tip", length)):
            off = np.abs(part.nodes[part.groups[end], 2] - height).max()
            if off > _MATCH_TOLERANCE * length:
                raise InputError(
                    f"ring {name}_{end} is up to {off:.3g} m off z = {height:.9g} m",
                    key="mesh.file",
                    file=source,
                    remedy="the base lies at z = 0, the tip at z = geometry.length, in metres",
                )
        vertices = canonical_vertices(part)[1]
        if reference is None:
            reference = vertices
        elif reference.shape != vertices.shape or np.abs(reference[:, :2] - vertices[:, :2]).max() > 1e-6:
            raise InputError(
                f"the vertices of {name} do not face those of {layout[0][0]}",
                key="mesh.file",
                file=source,
                remedy="use the same divisions around and along on every shell",
            )


def make_cylinders(
    shells: Sequence[tuple[str, float]], length: float, circumferential: int, axial: int, grading: float = 1.0
) -> CylinderMesh:
    """Concentric tubes of order-2 quads by gmsh, with matching nodes.

    Parameters
    ----------
    shells
        (name, mid-surface radius in m), inner first.
    length
        Length of the roll, m.
    circumferential, axial
        Number of elements around (even) and along.
    grading
        Height of the topmost element over that of the root element.

    Returns
    -------
    CylinderMesh
        Nodes are exact radial scalings of each other, one of them at theta = 0.
    """
    if circumferential < 4 or circumferential % 2:
        raise InputError(
            f"{circumferential} elements around the circumference",
            key="mesh.circumferential",
            remedy="use an even number of at least 4, so that nodes are mirrored about the x-z plane",
        )
    stations = axial_stations(length, axial, grading)
    with gmsh_model("cylinders"):
        for name, radius in shells:
            circle = gmsh.model.occ.addCircle(0.0, 0.0, 0.0, radius)
            swept = gmsh.model.occ.extrude(
                [(1, circle)], 0, 0, length, [1] * axial, list(stations[1:] / length), recombine=True
            )
            gmsh.model.occ.synchronize()
            gmsh.model.mesh.setTransfiniteCurve(circle, circumferential + 1)
            tip, surface = swept[0][1], swept[1][1]
            for dim, tag, suffix in ((2, surface, ""), (1, circle, "_base"), (1, tip, "_tip")):
                gmsh.model.addPhysicalGroup(dim, [tag], name=name + suffix)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        raw = extract_mesh("gmsh")
    return _snap(raw, dict(shells), stations, circumferential)


def _snap(mesh: CylinderMesh, radii: dict[str, float], stations: FloatArray, circumferential: int) -> CylinderMesh:
    """Move the nodes by rounding errors, so that shells are exact scalings and exactly mirrored."""
    nodes = mesh.nodes.copy()
    levels = np.sort(np.concatenate([stations, 0.5 * (stations[1:] + stations[:-1])]))
    for name, radius in radii.items():
        own = np.unique(mesh.cells[mesh.groups[name]])
        x, y, z = mesh.nodes[own].T
        step = np.rint(np.arctan2(y, x) * circumferential / np.pi).astype(int)  # node spacing is pi / circumferential
        # the sine of a multiple of pi is exactly zero on the symmetry plane, and mirrored nodes mirror exactly
        cos, sin = np.cos(np.pi * np.abs(step) / circumferential), np.sin(np.pi * np.abs(step) / circumferential)
        sin[np.abs(step) % circumferential == 0] = 0.0
        level = levels[np.abs(levels[None, :] - z[:, None]).argmin(axis=1)]
        nodes[own] = np.column_stack([radius * cos, radius * np.sign(step) * sin, level])
    shift = float(np.abs(nodes - mesh.nodes).max())
    if shift > 1e-6 * stations[-1]:
        raise RuntimeError(f"gmsh placed nodes {shift:.2e} m off the expected grid of the cylinders")
    return CylinderMesh(nodes, mesh.cells, mesh.groups)
