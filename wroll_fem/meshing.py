"""Meshes of the wound roll: concentric mid-surfaces of order-2 quads with matching nodes (gmsh).

The roll's axis is z, the base lies at z = 0. Each shell (the mandrel and every coil layer) is a
tube on its mid-surface; all tubes have the same divisions, so their nodes are radial scalings of
each other in the same order, and the nodes are mirrored about the x-z plane.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import gmsh
import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from wroll_fem.errors import InputError

if TYPE_CHECKING:
    from wroll_fem.case import Case

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_QUAD9, _LINE3 = 10, 8  # gmsh element types
_MATCH_TOLERANCE = 1e-6  # of the radius or length: a user's own mesh against the case's geometry


@dataclass(frozen=True)
class CylinderMesh:
    """Concentric shells as order-2 quads.

    Attributes
    ----------
    nodes
        (n_nodes, 3) Cartesian coordinates, m.
    cells
        (n_cells, 9) node numbers in gmsh's quad9 order (the same as VTK_BIQUADRATIC_QUAD).
    groups
        Cell numbers of the shells "mandrel", "layer_01", ...; node numbers of their end rings
        "mandrel_base", "mandrel_tip", "layer_01_base", "layer_01_tip", ...
    """

    nodes: FloatArray
    cells: IntArray
    groups: dict[str, IntArray]

    @property
    def parts(self) -> list[str]:
        """Names of the shells, inner first."""
        return sorted((n for n in self.groups if not n.endswith(("_base", "_tip"))), key=lambda n: (n != "mandrel", n))

    def part(self, name: str) -> CylinderMesh:
        """Mesh of one shell with its own compact node numbering; groups "base" and "tip" hold ring nodes."""
        cells = self.cells[self.groups[name]]
        used = np.unique(cells)
        renumber = np.full(len(self.nodes), -1, np.int64)
        renumber[used] = np.arange(len(used))
        rings = {end: renumber[self.groups[f"{name}_{end}"]] for end in ("base", "tip")}
        groups = {name: np.arange(len(cells))} | {end: ring[ring >= 0] for end, ring in rings.items()}
        return CylinderMesh(self.nodes[used], renumber[cells], groups)


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
        If a user's own mesh lacks groups, has other cells or does not fit the case's geometry.
    """
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
    with _gmsh_model("cylinders"):
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
        raw = _extract("gmsh")
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


def start_gmsh() -> None:
    """Initialize gmsh; what it writes to stderr is passed on without one false alarm.

    The PETSc inside gmsh's wheel takes Open MPI 5, whose ROMIO holds a few of MPICH's names, for a second MPI and
    says that nothing will run correctly. Meshing does not use it.
    """
    terminal = os.dup(2)
    with tempfile.TemporaryFile() as said:
        os.dup2(said.fileno(), 2)
        try:
            gmsh.initialize([], readConfigFiles=False, interruptible=False)
        finally:
            os.dup2(terminal, 2)
            os.close(terminal)
            said.seek(0)
            os.write(2, b"".join(line for line in said if b"against both OpenMPI and MPICH" not in line))


@contextlib.contextmanager
def _gmsh_model(name: str) -> Iterator[None]:
    """Open a fresh gmsh model without terminal output; leave gmsh as it was found."""
    started = not gmsh.isInitialized()
    if started:
        start_gmsh()
    previous = None if started else gmsh.model.getCurrent()
    terminal = gmsh.option.getNumber("General.Terminal")
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add(name)
    try:
        yield
    finally:
        gmsh.model.remove()
        gmsh.option.setNumber("General.Terminal", terminal)
        if started:
            gmsh.finalize()
        elif previous is not None:
            gmsh.model.setCurrent(previous)


def _extract(source: str, required: Sequence[str] = ()) -> CylinderMesh:
    """Cells and groups of the current gmsh model; nodes that no quad uses (arc centres) are left out."""
    found = {gmsh.model.getPhysicalName(dim, tag): (dim, tag) for dim, tag in gmsh.model.getPhysicalGroups()}
    wanted = [name for part in required for name in (part, f"{part}_base", f"{part}_tip")] or list(found)
    missing = [name for name in wanted if name not in found]
    if missing:
        lacks = f"group{'s' * (len(missing) > 1)} {', '.join(missing)}"
        raise InputError(
            f"mesh lacks the {lacks} (it has: {', '.join(found) or 'none'})",
            key="mesh.file",
            file=source,
            remedy="name the surfaces (physical surfaces) and their end rings (physical curves) like that",
        )
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    cells: list[IntArray] = []
    groups: dict[str, IntArray] = {}
    count = 0
    for name in wanted:
        dim, group = found[name]
        expected = 1 if name.endswith(("_base", "_tip")) else 2
        if dim != expected:
            raise InputError(
                f"group {name} has dimension {dim} instead of {expected}",
                key="mesh.file",
                file=source,
                remedy="shells are physical surfaces, their ends physical curves",
            )
        own = _group_elements(dim, group, name, source)
        if dim == 2:
            groups[name] = np.arange(count, count + len(own))
            count += len(own)
            cells.append(own)
        else:
            groups[name] = np.unique(own)
    all_cells = np.concatenate(cells)
    used = np.unique(all_cells)
    order = np.argsort(tags)
    nodes = coordinates.reshape(-1, 3)[order[np.searchsorted(tags, used, sorter=order)]]
    for name, members in groups.items():
        if name.endswith(("_base", "_tip")):
            groups[name] = np.searchsorted(used, members)
    return CylinderMesh(nodes, np.searchsorted(used, all_cells), groups)


def _group_elements(dim: int, group: int, name: str, source: str) -> IntArray:
    """(n, nodes per element) node tags of the elements of a physical group, which must be quad9 or line3."""
    wanted = _QUAD9 if dim == 2 else _LINE3
    blocks = []
    for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, group):
        types, _, node_tags = gmsh.model.mesh.getElements(dim, entity)
        for kind, own in zip(types, node_tags, strict=True):
            kind_name, _, _, per_element, _, _ = gmsh.model.mesh.getElementProperties(kind)
            if kind != wanted:
                raise InputError(
                    f"group {name} holds cells of type {kind_name}",
                    key="mesh.file",
                    file=source,
                    remedy="shells need 9-node quads (gmsh: recombine, Mesh.ElementOrder = 2, no incomplete elements)",
                )
            blocks.append(np.asarray(own, np.int64).reshape(-1, per_element))
    if not blocks:
        raise InputError(f"group {name} holds no elements", key="mesh.file", file=source, remedy="mesh it and save it")
    return np.concatenate(blocks)


def read_mesh(path: str | Path, required: Sequence[str] = ("mandrel",)) -> CylinderMesh:
    """Read a .msh file whose physical groups follow the names of `CylinderMesh`.

    Parameters
    ----------
    path
        File in a format that gmsh reads (.msh 2.2 or 4.1).
    required
        Shells that must be there, each with its "_base" and "_tip" ring.

    Raises
    ------
    InputError
        If the file is missing or unreadable, lacks groups, or holds cells other than 9-node quads.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError("mesh file does not exist", key="mesh.file", file=str(path), remedy="give an existing .msh")
    with _gmsh_model("read"):
        before = set(gmsh.model.list())
        try:
            gmsh.merge(str(path))
        except Exception as error:  # gmsh raises bare Exception for every failure
            raise InputError(
                f"gmsh cannot read the mesh ({error})", key="mesh.file", file=str(path), remedy="save it as .msh 4.1"
            ) from error
        if set(gmsh.model.list()) != before:
            raise RuntimeError(f"reading {path} changed the list of gmsh models")
        return _extract(str(path), required)


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


def canonical_vertices(part: CylinderMesh) -> tuple[IntArray, FloatArray]:
    """Corner vertices of a shell in the order in which contact points are counted.

    Returns
    -------
    vertices : (n,) node numbers, sorted by z, then theta.
    points : (n, 3) theta in (-pi, pi] rad, z in m, r in m.
    """
    vertices = np.unique(part.cells[:, :4])
    x, y, z = part.nodes[vertices].T
    theta = np.arctan2(y, x)
    theta[theta < -np.pi + 1e-6] = np.pi
    by_height = np.argsort(z, kind="stable")
    level = np.empty(len(z), np.int64)  # heights that differ by rounding errors only are one level
    level[by_height] = np.cumsum(np.diff(z[by_height], prepend=z.min()) > 1e-7 * np.ptp(z))
    order = np.lexsort((theta, level))
    return vertices[order], np.column_stack([theta, z, np.hypot(x, y)])[order]


def mirror_nodes(nodes: FloatArray) -> IntArray | None:
    """For each node the node mirrored about the x-z plane, or None if the mesh is not symmetric."""
    distance, partner = cKDTree(nodes).query(nodes * np.array([1.0, -1.0, 1.0]))
    if distance.max() > 1e-7 * np.abs(nodes).max():
        return None
    return np.asarray(partner, np.int64)


def write_mesh(mesh: CylinderMesh, folder: str | Path, name: str = "mesh") -> list[Path]:
    """Write `name`.msh (gmsh 4.1, named groups) and `name`.vtu (for ParaView) to a folder; returns the paths."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    msh, vtu = folder / f"{name}.msh", folder / f"{name}.vtu"
    _write_msh(mesh, msh)
    _write_vtu(mesh, vtu)
    return [msh, vtu]


def _write_msh(mesh: CylinderMesh, path: Path) -> None:
    with _gmsh_model("write"):
        for tag, name in enumerate(mesh.parts, start=1):
            cells = mesh.cells[mesh.groups[name]]
            own = np.unique(cells)
            gmsh.model.addDiscreteEntity(2, tag)
            gmsh.model.mesh.addNodes(2, tag, own + 1, mesh.nodes[own].ravel())
            gmsh.model.mesh.addElementsByType(tag, _QUAD9, [], cells.ravel() + 1)
            gmsh.model.addPhysicalGroup(2, [tag], tag, name=name)
            for ring, end in ((2 * tag - 1, "base"), (2 * tag, "tip")):
                edges = ring_edges(cells, mesh.groups[f"{name}_{end}"])
                gmsh.model.addDiscreteEntity(1, ring)
                gmsh.model.mesh.addElementsByType(ring, _LINE3, [], edges.ravel() + 1)
                gmsh.model.addPhysicalGroup(1, [ring], ring, name=f"{name}_{end}")
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.write(str(path))


def ring_edges(cells: IntArray, ring: IntArray) -> IntArray:
    """(n, 3) edges [end, end, middle] of the quads whose three nodes all lie on a ring."""
    edges = np.concatenate([cells[:, [i, (i + 1) % 4, 4 + i]] for i in range(4)])
    return edges[np.isin(edges, ring).all(axis=1)]


def _write_vtu(mesh: CylinderMesh, path: Path) -> None:
    import meshio

    shell = np.zeros(len(mesh.cells), np.int32)
    for index, name in enumerate(mesh.parts):
        shell[mesh.groups[name]] = index
    meshio.Mesh(mesh.nodes, [("quad9", mesh.cells)], cell_data={"shell": [shell]}).write(str(path))
