"""Shell meshes of the roll by gmsh, made exactly symmetric, with matching nodes; check of the geometry of any mesh.

The axis of the roll is z and the base lies at z = 0. The mandrel and every coil layer are meshed as tubes on their
mid-surfaces. All tubes have the same divisions, so the nodes of one tube are radial scalings of those of any other, in
the same order. The nodes are mirrored about the x-z plane.
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
    from wroll_fem.case.roll import RollSections

_MATCH_TOLERANCE = 1e-6  # relative deviation of a user's mesh from the geometry of the case


def part_name(index: int) -> str:
    """Name of shell `index`, counted from the inside: "mandrel" for 0, otherwise "layer_01", "layer_02", ..."""
    return "mandrel" if index == 0 else f"layer_{index:02d}"


def shell_layout(roll: RollSections) -> list[tuple[str, float, float]]:
    """Name, mid-surface radius (m) and thickness (m) of each shell of a case, innermost first."""
    outer, thickness = 0.5 * roll.geometry.mandrel_outer_diameter, roll.geometry.mandrel_thickness
    layout = [("mandrel", outer - 0.5 * thickness, thickness)]
    if roll.coil.model in ("layers", "bonded"):
        t_layer = roll.coil.total_thickness / roll.coil.layers
        layout += [(part_name(k), outer + (k - 0.5) * t_layer, t_layer) for k in range(1, roll.coil.layers + 1)]
    return layout


def axial_stations(length: float, divisions: int, grading: float = 1.0) -> FloatArray:
    """Heights of the element borders along the roll; the element sizes form a geometric progression.

    Parameters
    ----------
    length
        Length of the roll, m.
    divisions
        Number of elements.
    grading
        Ratio of the height of the topmost element to that of the lowest one.

    Returns
    -------
    (divisions + 1,) heights above the base, m.
    """
    ratio = grading ** (1.0 / (divisions - 1)) if divisions > 1 else 1.0
    heights = ratio ** np.arange(divisions)
    return length * np.concatenate([[0.0], np.cumsum(heights) / heights.sum()])


def roll_stations(roll: RollSections) -> FloatArray:
    """Heights of the element borders of the mandrel, m, with a border at each end of the coil and at each wall row.

    The coil has `mesh.axial` elements, those of a margin are at most twice as high as the next one of the coil. Near a
    clamped annulus there are more (`annulus_borders`).
    """
    low, high = roll.coil_span
    stations = low + axial_stations(high - low, roll.mesh.axial, roll.mesh.grading)
    if low > 0.0:
        count = int(np.ceil(0.5 * low / (stations[1] - stations[0])))
        stations = np.concatenate([np.linspace(0.0, low, count + 1)[:-1], stations])
    if high < roll.geometry.length:
        above = roll.geometry.length - high
        count = int(np.ceil(0.5 * above / (stations[-1] - stations[-2])))
        stations = np.concatenate([stations, np.linspace(high, roll.geometry.length, count + 1)[1:]])
    near = [low + z for z in annulus_borders(roll.clamped_width, stations[1] - stations[0])]
    heights = [*near, *(row.z for row in roll.mandrel.wall or [])]
    return with_borders(stations, heights, keep=(0.0, low, high, roll.geometry.length))


def annulus_borders(width: float, size: float) -> list[float]:
    """Distances of element borders from the inner edge of a coil that is clamped on an annulus of ``width``, m.

    The stress is singular at both edges of the annulus, and decays within a few widths. The elements are half as long
    as the annulus is wide, and double in length up to the length ``size`` of the regular elements. Without an annulus
    (width 0) there are none.
    """
    count = int(np.ceil(np.log2(2.0 * size / width))) if width > 0.0 else 0
    return [0.5 * width * 2.0**k for k in range(count)]


SNAP = 0.3
"""Distance, relative to the height of an element, at which its border moves to a given height; else it is divided."""


def with_borders(stations: FloatArray, heights: Sequence[float], keep: Sequence[float] = ()) -> FloatArray:
    """Element borders (m, ascending) with a border at each of ``heights``; both ends and those at ``keep`` stay."""
    borders = stations.copy()
    for z in heights:
        nearest = int(np.abs(borders - z).argmin())
        if np.isclose(borders[nearest], z, rtol=1e-9, atol=0.0) or not borders[0] < z < borders[-1]:
            continue
        after = int(np.searchsorted(borders, z))
        size = borders[after] - borders[after - 1]
        held = (
            nearest in (0, len(borders) - 1)
            or np.isclose(borders[nearest], [*keep, *heights], rtol=1e-9, atol=0.0).any()
        )
        if abs(borders[nearest] - z) < SNAP * size and not held:
            borders[nearest] = z
        else:
            borders = np.insert(borders, after, z)
    return borders


def build_mesh(roll: RollSections) -> CylinderMesh:
    """Shell mesh of a case: read from `roll.mesh.file` if given, otherwise generated by gmsh.

    Raises
    ------
    InputError
        If a user's mesh lacks groups, has cells of another type or does not match the geometry of the case; if the
        number of elements around the circumference is odd; or if the case uses Fourier elements.
    """
    if roll.mesh.discretisation == "fourier":
        raise InputError(
            "Fourier elements have no three-dimensional mesh and no matrices of the whole roll",
            key="mesh.discretisation", remedy="use three_dimensional",
        )  # fmt: skip
    layout = shell_layout(roll)
    if roll.mesh.file is not None:
        mesh = read_mesh(roll.mesh.file, required=[name for name, _, _ in layout])
        check_geometry(mesh, layout, roll.geometry.length, str(roll.mesh.file))
        return mesh
    stations = roll_stations(roll)
    first, last = (int(np.abs(stations - end).argmin()) for end in roll.coil_span)
    on_coil = stations[first : last + 1]
    tubes = [(name, radius, on_coil if name != "mandrel" else stations) for name, radius, _ in layout]
    return _make_tubes(tubes, roll.mesh.circumferential)


def check_geometry(mesh: CylinderMesh, layout: Sequence[tuple[str, float, float]], length: float, source: str) -> None:
    """Check that a user's mesh has the mid-surfaces and the length of the case.

    Parameters
    ----------
    mesh
        The user's mesh.
    layout
        Name, mid-surface radius (m) and thickness (m) of each shell, as `shell_layout` returns them.
    length
        Length of the roll, m.
    source
        Name of the mesh file, for the messages.

    Raises
    ------
    InputError
        If the nodes of a shell are off its mid-surface radius, its ends are off z = 0 or z = `length`, or the vertices
        of two shells do not match.
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
                remedy="mesh the mid-surfaces of the case's geometry in metres, with z as the axis",
            )
        for end, height in (("base", 0.0), ("tip", length)):
            off = np.abs(part.nodes[part.groups[end], 2] - height).max()
            if off > _MATCH_TOLERANCE * length:
                raise InputError(
                    f"ring {name}_{end} is up to {off:.3g} m off z = {height:.9g} m",
                    key="mesh.file",
                    file=source,
                    remedy="place the base at z = 0 and the tip at z = geometry.length, in metres",
                )
        vertices = canonical_vertices(part)[1]
        if reference is None:
            reference = vertices
        elif reference.shape != vertices.shape or np.abs(reference[:, :2] - vertices[:, :2]).max() > 1e-6:
            raise InputError(
                f"the vertices of {name} do not match those of {layout[0][0]}",
                key="mesh.file",
                file=source,
                remedy="use the same number of elements around the circumference and along the axis on every shell",
            )


def make_cylinders(
    shells: Sequence[tuple[str, float]], length: float, circumferential: int, axial: int, grading: float = 1.0
) -> CylinderMesh:
    """Mesh concentric tubes with order-2 quads and matching nodes.

    Parameters
    ----------
    shells
        Name and mid-surface radius (m) of each tube, innermost first.
    length
        Length of the roll, m.
    circumferential, axial
        Number of elements around the circumference (even) and along the axis.
    grading
        Ratio of the height of the topmost element to that of the lowest one.

    Returns
    -------
    CylinderMesh
        Mesh whose tubes are exact radial scalings of each other, with nodes at theta = 0.

    Raises
    ------
    InputError
        If `circumferential` is odd or below 4.
    RuntimeError
        If gmsh places nodes off the expected positions.
    """
    stations = axial_stations(length, axial, grading)
    return _make_tubes([(name, radius, stations) for name, radius in shells], circumferential)


def _make_tubes(tubes: Sequence[tuple[str, float, FloatArray]], circumferential: int) -> CylinderMesh:
    """Mesh concentric tubes; name, radius (m) and element borders (m) of each. See `make_cylinders`."""
    if circumferential < 4 or circumferential % 2:
        raise InputError(
            f"the number of elements around the circumference, {circumferential}, is odd or below 4",
            key="mesh.circumferential",
            remedy="use an even number of at least 4, so that the nodes are mirrored about the x-z plane",
        )
    with gmsh_model("cylinders"):
        for name, radius, stations in tubes:
            low, height = float(stations[0]), float(stations[-1] - stations[0])
            circle = gmsh.model.occ.addCircle(0.0, 0.0, low, radius)
            shares = list((stations[1:] - low) / height)
            swept = gmsh.model.occ.extrude([(1, circle)], 0, 0, height, [1] * len(shares), shares, recombine=True)
            gmsh.model.occ.synchronize()
            gmsh.model.mesh.setTransfiniteCurve(circle, circumferential + 1)
            tip, surface = swept[0][1], swept[1][1]
            for dim, tag, suffix in ((2, surface, ""), (1, circle, "_base"), (1, tip, "_tip")):
                gmsh.model.addPhysicalGroup(dim, [tag], name=name + suffix)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        raw = extract_mesh("gmsh")
    return _snap(raw, {name: radius for name, radius, _ in tubes}, tubes[0][2], circumferential)


def _snap(mesh: CylinderMesh, radii: dict[str, float], stations: FloatArray, circumferential: int) -> CylinderMesh:
    """Correct rounding errors of the nodes, so that tubes are exact scalings of each other and exactly symmetric."""
    nodes = mesh.nodes.copy()
    levels = np.sort(np.concatenate([stations, 0.5 * (stations[1:] + stations[:-1])]))
    for name, radius in radii.items():
        own = np.unique(mesh.cells[mesh.groups[name]])
        x, y, z = mesh.nodes[own].T
        step = np.rint(np.arctan2(y, x) * circumferential / np.pi).astype(int)  # node spacing is pi / circumferential
        # the sine is exactly zero on the symmetry plane, and equal and opposite at mirrored nodes
        cos, sin = np.cos(np.pi * np.abs(step) / circumferential), np.sin(np.pi * np.abs(step) / circumferential)
        sin[np.abs(step) % circumferential == 0] = 0.0
        level = levels[np.abs(levels[None, :] - z[:, None]).argmin(axis=1)]
        nodes[own] = np.column_stack([radius * cos, radius * np.sign(step) * sin, level])
    shift = float(np.abs(nodes - mesh.nodes).max())
    if shift > 1e-6 * stations[-1]:
        raise RuntimeError(f"gmsh placed nodes {shift:.2e} m off their expected positions")
    return CylinderMesh(nodes, mesh.cells, mesh.groups)
